// Scenes with fluids, as a user runs them.
#include <nlohmann/json.hpp>

#include <cstdlib>

#include "cli_runner.h"

namespace psim::test {
namespace {

constexpr std::string_view kDam = R"({
  "psim": 1, "name": "dam",
  "world": {"bounds": [0, 0, 3, 2], "gravity": [0, -9.81]},
  "fluids": [{"region": [0, 0, 0.8, 1.6], "spacing": 0.04, "density": 1000}],
  "bodies": [{"shape": {"disc": {"radius": 0.2}}, "position": [2, 1]}]})";

class CliFluid : public ::testing::Test {
 protected:
  Outcome run(std::vector<std::string> more) {
    std::vector<std::string> arguments = {"--scene", scene_, "--frames", "20"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_psim(std::move(arguments));
  }
  ScratchFolder folder_;
  std::string scene_ = folder_.write("dam.json", kDam);
};

TEST_F(CliFluid, FluidStateHasARowPerParticleById) {
  const std::string file = folder_.file("f.csv");
  ASSERT_EQ(run({"--fluid-state", file}).status, 0);
  const auto lines = lines_of(read_file(file));
  ASSERT_EQ(lines.size(), 801u);
  EXPECT_EQ(lines[0], "id,x,y,vx,vy,density,pressure");
  for (std::size_t id = 0; id < 800; ++id) EXPECT_TRUE(lines[id + 1].starts_with(std::to_string(id) + ",")) << id;
}

TEST_F(CliFluid, ReportsTellOfFluidsWhereThereAreSome) {
  const auto json = nlohmann::json::parse(run({"--report", "json"}).out);
  const auto& fluid = json.at("fluid");
  EXPECT_EQ(fluid.at("particles"), 800);
  EXPECT_GT(fluid.at("kinetic").get<double>(), 0);
  EXPECT_LT(fluid.at("density_error_mean").get<double>(), 0.1);
  EXPECT_GE(fluid.at("density_error_max"), fluid.at("density_error_mean"));
  EXPECT_GT(fluid.at("iterations").get<int>(), 0);
  EXPECT_NE(run({}).out.find("Fluid: 800 particles"), std::string::npos);
  const std::string plain = folder_.write("plain.json", kSmallScene);
  const Outcome without = run_psim({"--scene", plain, "--frames", "2", "--report", "json"});
  EXPECT_FALSE(nlohmann::json::parse(without.out).contains("fluid"));
}

TEST_F(CliFluid, VerifySaveAndReplayKnowThem) {
  const Outcome verified = run({"--verify"});
  EXPECT_EQ(verified.status, 0) << verified.out << verified.err;
  const std::string state = folder_.file("s"), recording = folder_.file("r");
  ASSERT_EQ(run({"--save", state, "--record", recording}).status, 0);
  const auto hash = [](const Outcome& outcome) { return nlohmann::json::parse(outcome.out).at("state_hash"); };
  const Outcome whole = run_psim({"--scene", scene_, "--frames", "30", "--report", "json"});
  const Outcome rest = run_psim({"--scene", scene_, "--restore", state, "--frames", "10", "--report", "json"});
  EXPECT_EQ(hash(whole), hash(rest));
  EXPECT_EQ(run_psim({"--replay", recording}).status, 0);
}

TEST_F(CliFluid, PicturesShowThemAsChosen) {
  std::vector<std::string> pictures;
  for (const char* look : {"surface", "particles"}) {
    for (const char* colour : {"fluid", "speed", "pressure"}) {
      const std::string file = folder_.file("a.png");
      const Outcome outcome =
          run({"--image", file, "--image-size", "120x80", "--fluid-look", look, "--fluid-colour", colour});
      ASSERT_EQ(outcome.status, 0) << outcome.err;
      pictures.push_back(read_file(file));
      for (std::size_t k = 0; k + 1 < pictures.size(); ++k) EXPECT_NE(pictures[k], pictures.back()) << look << colour;
    }
  }
  const std::string file = folder_.file("b.png");
  ASSERT_EQ(run({"--image", file, "--image-size", "120x80", "--threads", "3"}).status, 0);
  EXPECT_EQ(read_file(file), pictures[0]) << "a surface in the colour of the fluid, on any number of threads";
}

TEST_F(CliFluid, ExplainNamesThem) {
  EXPECT_NE(run_psim({"--scene", scene_, "--explain"}).out.find("particles of fluids"), std::string::npos);
}

TEST_F(CliFluid, WhatIsWrongIsOneLine) {
  const std::string wrong = folder_.write("wrong.json", R"({"psim": 1, "world": {"bounds": [0, 0, 1000, 1000]},
  "fluids": [{"region": [0, 0, 1000, 1000], "spacing": 0.01}]})");
  expect_refused(run_psim({"--scene", wrong}), {"wrong.json:2:", "more than 10000000 particles"});
  expect_refused(run({"--fluid-state", ""}), {"--fluid-state"});
  expect_refused(run({"--verify", "--fluid-state", folder_.file("f.csv")}), {"--fluid-state"});
}

}  // namespace
}  // namespace psim::test
