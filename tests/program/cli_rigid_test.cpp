// Scenes of rigid bodies on the command line: pictures, foreign files, scenes of fixed size.
#include <string>

#include "cli_runner.h"

namespace psim::test {
namespace {

constexpr std::string_view kShapes = R"({"psim": 1,
  "world": {"bounds": [-10, -10, 10, 10], "boundary": "open"},
  "bodies": [
    {"position": [0, -5], "type": "static", "shape": {"box": {"size": [16, 1]}}},
    {"name": "box", "position": [-6, 0], "shape": {"box": {"size": [1, 2], "radius": 0.2}}},
    {"name": "stone", "position": [-3, 0], "shape": {"polygon": {"vertices": [[0, 0], [1, 0], [0, 1]]}}},
    {"position": [0, 0], "shape": {"capsule": {"p1": [0, -1], "p2": [0, 1], "radius": 0.4}}},
    {"position": [3, 0], "shape": {"segment": {"p1": [0, -1], "p2": [0, 1]}}},
    {"position": [6, 0], "type": "kinematic", "angular_velocity": 1,
     "shape": {"chain": {"vertices": [[-1, 0], [0, 1], [1, 0]], "loop": true}}},
    {"position": [0, 5], "type": "static", "sensor": true, "shape": {"disc": {"radius": 1}}}],
  "joints": [{"type": "rope", "a": "box", "b": "stone"}]})";

TEST(CliRigid, EveryShapeRunsAndIsPainted) {
  const ScratchFolder folder;
  const std::string scene = folder.write("shapes.json", kShapes), image = folder.file("i.png");
  const Outcome outcome = run_psim({"--scene", scene, "--frames", "20", "--image", image});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(read_file(image).substr(1, 3), "PNG");
}

TEST(CliRigid, ForeignScenesSayWhatIsLeftOut) {
  const ScratchFolder folder;
  const std::string scene = folder.write("level.rube", R"({"gravity": 0, "body": [
    {"type": 2, "position": 0, "fixture": [{"density": 1, "circle": {"radius": 1}}]},
    {"type": 0, "position": {"x": 9, "y": 0}, "fixture": [{"circle": {"radius": 1}}]}],
    "joint": [{"type": "gear", "bodyA": 0, "bodyB": 1}]})");
  const Outcome outcome = run_psim({"--scene", scene, "--frames", "2"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("level.rube: joint[0]: a gear joint is left out\n"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.out.find("scene level  2 bodies"), std::string::npos) << outcome.out;
}

TEST(CliRigid, BadShapesAreRefusedInOneLine) {
  const ScratchFolder folder;
  const std::string scene = folder.write("bad.json", R"({"psim": 1, "world": {"bounds": [0, 0, 9, 9]}, "bodies": [
{"position": [1, 1], "shape": {"polygon": {"vertices": [[0, 0], [2, 0], [2, 2], [1, 0.5], [0, 2]]}}}]})");
  expect_refused(run_psim({"--scene", scene}), {"bad.json:2:", "polygon", "convex"});
}

TEST(CliRigid, SceneOfFixedSizeRefusesAnother) {
  expect_refused(run_psim({"--scene", "card_house", "--particles", "41"}), {"always has 40"});
}

}  // namespace
}  // namespace psim::test
