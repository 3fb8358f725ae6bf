// The viewer without its window: camera, input scripts, what it remembers of frames, the thread that steps.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "builtin/samples.h"
#include "model/body_columns.h"
#include "model/camera.h"
#include "model/catalogue.h"
#include "model/frame_log.h"
#include "model/history.h"
#include "model/input_script.h"
#include "model/scene_tree.h"
#include "model/sim_thread.h"
#include "output/user_error.h"
#include "small_scene.h"

namespace psim::view {
namespace {

TEST(ViewCamera, FitShowsAllAndZoomKeepsThePointUnderTheCursor) {
  Camera camera;
  camera.fit({-10, 0, 30, 20}, 800, 600);
  const Bounds shown = camera.shown();
  EXPECT_LE(shown.xmin, -10);
  EXPECT_GE(shown.xmax, 30);
  EXPECT_LE(shown.ymin, 0);
  EXPECT_GE(shown.ymax, 20);
  const Vec2 before = camera.to_world(123, 456);
  camera.zoom_at(123, 456, 3);
  const Vec2 after = camera.to_world(123, 456);
  EXPECT_NEAR(after.x, before.x, 1e-9);
  EXPECT_NEAR(after.y, before.y, 1e-9);
  const Vec2 back = camera.to_screen(before);
  EXPECT_NEAR(back.x, 123, 1e-9);
  EXPECT_NEAR(back.y, 456, 1e-9);
  camera.fit({-10, 0, 30, 20}, 800, 600, 300);
  EXPECT_GE(camera.to_screen({-10, 0}).x, 300);
  EXPECT_LE(camera.to_screen({30, 0}).x, 800);
}

TEST(ViewScript, LinesAreReadInOrder) {
  const auto lines = parse_script(
      "# what follows is a click\n3 move 10 20.5\n\n3 down left\n"
      "9 up right # let go\n9 wheel -2\n10 key Space\n11 shot a.png\n"
      "12 quit\n",
      "s");
  ASSERT_EQ(lines.size(), 7u);
  EXPECT_EQ(lines[0].action, ScriptAction::move);
  EXPECT_EQ(lines[0].y, 20.5);
  EXPECT_EQ(lines[2].button, 1);
  EXPECT_EQ(lines[3].x, -2);
  EXPECT_EQ(lines[4].word, "Space");
  EXPECT_EQ(lines[6].frame, 12u);
}

TEST(ViewScript, MistakesAreNamedWithTheirLine) {
  for (const char* text :
       {"1 key A\nx key A", "1 key A\n2 jump", "1 key A\n2 down up", "1 key A\n2 move 3", "1 key A\n2 wheel a",
        "1 key A\n2 quit now", "5 key A\n4 key B", "1 key A\n2 key", "1 key A\n2 shot a.jpg"}) {
    try {
      parse_script(text, "file");
      ADD_FAILURE() << text;
    } catch (const cli::UserError& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with("file:2: ")) << error.what();
    }
  }
}

TEST(ViewCatalogue, KnowsKindsAndMasses) {
  Scene scene = small_scene();
  scene.bodies.push_back(scene.bodies.back());  // the same box once more
  BodyDesc capsule;
  capsule.shape = CapsuleShape{{-1, 0}, {1, 0}, 0.5};
  scene.bodies.push_back(capsule);
  BodyDesc wall;
  wall.type = BodyType::static_body;
  wall.shape = SegmentShape{{0, 0}, {1, 0}};
  scene.bodies.push_back(wall);
  const Catalogue catalogue(scene);
  EXPECT_EQ(catalogue.kinds().size(), 4u);  // disc, box, capsule, segment
  EXPECT_NEAR(catalogue.mass(0, 1), std::numbers::pi, 1e-9);
  EXPECT_NEAR(catalogue.mass(3, 0), 6, 1e-9);
  EXPECT_EQ(catalogue.look(3), catalogue.look(4));
  EXPECT_NEAR(catalogue.mass(5, 0), 2 + std::numbers::pi / 4, 1e-6);
  EXPECT_NE(catalogue.look(6) & kStaticBit, 0u);
  EXPECT_TRUE(catalogue.kind(6).line);
}

// Values of a frame are those of its own step; a restart and a new scene begin with none.
TEST(ViewFrameLog, KnowsEveryFrameOfTheRun) {
  Simulation simulation = make_simulation();
  FrameLog log;
  Status status;
  const auto note = [&] {
    status.steps.clear();
    simulation.tell(status);
    log.note(status);
  };
  note();
  ASSERT_EQ(log.frames().size(), 1u);
  EXPECT_FALSE(log.frames().front().step);
  std::vector<std::uint64_t> hashes{status.hash};
  for (int frame = 1; frame <= 9; ++frame) {
    simulation.step();
    if (frame == 5) continue;  // two steps in one status
    note();
    hashes.push_back(status.hash);
  }
  ASSERT_EQ(log.frames().size(), 10u);
  ASSERT_NE(log.find(7), nullptr);
  EXPECT_EQ(log.find(7)->frame, 7u);
  EXPECT_EQ(log.find(7)->hash, hashes[6]);
  EXPECT_EQ(log.find(5)->hash, std::nullopt);
  EXPECT_EQ(log.hashed(5)->frame, 4u);
  EXPECT_EQ(log.find(10), nullptr);
  EXPECT_GT(log.find(5)->step->awake, 0u);
  simulation.set_settings(told(simulation).settings);  // the run goes on
  simulation.step();
  note();
  EXPECT_EQ(log.frames().size(), 11u);
  simulation.step();
  simulation.restart();
  note();
  EXPECT_EQ(log.frames().size(), 1u);
  EXPECT_EQ(log.hashed(100)->frame, 0u);
  EXPECT_EQ(log.hashed(100)->hash, hashes[0]);
  simulation.step();
  note();
  simulation.load("galton");
  note();
  EXPECT_EQ(log.frames().size(), 1u);
  EXPECT_EQ(status.hash_frame, 0u);
}

TEST(ViewThread, StepsOfAnOldRunAreNotTold) {
  SimThread thread(std::make_unique<Simulation>(small_scene(), best_isa(), 1), true);
  for (int k = 0; k < 3; ++k) thread.advance();
  thread.post([](Simulation& s) { s.restart(); });
  thread.advance();
  const Status status = thread.status();
  EXPECT_EQ(status.frame, 1u);
  EXPECT_EQ(status.steps.size(), 1u);
}

TEST(ViewThread, LockstepTakesOneStepACallAndNoneInAPause) {
  SimThread thread(std::make_unique<Simulation>(small_scene(), best_isa(), 1), true);
  Status status = thread.status();
  EXPECT_EQ(status.frame, 0u);
  ASSERT_TRUE(status.still);
  EXPECT_EQ(status.still->id.size(), 4u);
  for (int k = 0; k < 3; ++k) thread.advance();
  status = thread.status();
  EXPECT_EQ(status.frame, 3u);
  EXPECT_EQ(status.steps.size(), 3u);
  EXPECT_FALSE(status.still);
  ASSERT_NE(status.world->latest_snapshot(), nullptr);
  EXPECT_EQ(status.world->latest_snapshot()->frame, 3u);
  thread.post([](Simulation& s) { s.paused = true; });
  thread.advance();
  EXPECT_EQ(thread.status().frame, 3u);
  thread.post([](Simulation& s) { s.single_step(); });
  thread.advance();
  thread.advance();
  EXPECT_EQ(thread.status().frame, 4u);
}

TEST(ViewThread, KeepsToTheClock) {
  SimThread thread(std::make_unique<Simulation>(small_scene(), best_isa(), 1), false);
  const auto begin = std::chrono::steady_clock::now();
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  const std::uint64_t frame = thread.status().frame;
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  EXPECT_GT(frame, 0u);
  EXPECT_LE(static_cast<double>(frame), 60 * seconds + 4);
}

TEST(ViewColumns, LookUpsFollowTheSnapshotAfterRemovals) {
  Simulation simulation = make_simulation();
  simulation.erase({0, -9}, 0.1);
  simulation.step();
  const Status status = told(simulation);
  BodyColumns columns;
  columns.set(*status.world->latest_snapshot(), status.catalogue);
  ASSERT_EQ(columns.size(), 3u);
  EXPECT_EQ(columns.row_of(0), 0u);
  EXPECT_EQ(columns.row_of(1), 3u);  // it has none
  EXPECT_EQ(columns.row_of(3), 2u);
  EXPECT_EQ(columns.looks()[2], status.catalogue->look(3));
  EXPECT_NEAR(columns.place(2, 1).x, 12, 1e-3);
}

// Each name of the list is one leaf, whatever it is; a file of a built-in scene has the line of that scene.
TEST(ViewSceneTree, HasEachNameOnce) {
  std::vector<std::string> names = {"my.json", "scenes/galton.json"};
  for (const BuiltinScene& scene : builtin_scenes()) names.emplace_back(scene.name);
  const std::vector<SceneTopic> tree = scene_tree(names);
  std::vector<int> leaves(names.size());
  for (const SceneTopic& topic : tree) {
    EXPECT_FALSE(topic.leaves.empty()) << topic.name;
    for (const SceneLeaf& leaf : topic.leaves) {
      ++leaves.at(leaf.index);
      EXPECT_TRUE(names[leaf.index].ends_with(leaf.label));
    }
  }
  EXPECT_EQ(leaves, std::vector<int>(names.size(), 1));
  ASSERT_EQ(tree.back().name, "Files");
  ASSERT_EQ(tree.back().leaves.size(), 2u);
  EXPECT_EQ(tree.back().leaves[0].look_for, "");
  EXPECT_EQ(tree.back().leaves[1].look_for, look_for("galton"));
  EXPECT_EQ(scene_tree({"galton"}).size(), 1u);  // no empty topics
}

TEST(ViewHistory, KeepsTheNewestFrames) {
  History history;
  Snapshot snapshot;
  const auto none = std::make_shared<const std::vector<Vec2>>(), one = std::make_shared<const std::vector<Vec2>>(1);
  for (std::uint64_t frame = 0; frame < 700; ++frame) {
    snapshot.frame = frame;
    history.record(snapshot, frame < 690 ? none : one);
  }
  EXPECT_EQ(history.size(), 600u);
  EXPECT_EQ(history.at(0).frame, 699u);
  EXPECT_EQ(history.at(599).frame, 100u);
  EXPECT_EQ(history.wells(9), one);
  EXPECT_EQ(history.wells(10), none);
}

}  // namespace
}  // namespace psim::view