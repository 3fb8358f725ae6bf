// Every engine that is built in gets the same scene and gives it back: motion, contacts, mixing rules,
// joints, filters. Limits are wide: no engine is accurate here, but none may get another scene.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "comparison.h"
#include "engines.h"
#include "errors.h"

namespace psim::peers::test {
namespace {

using namespace accuracy;
using Watched = accuracy::Run;  // GoogleTest has a Run, too

std::vector<Engine> present() {
  std::vector<Engine> engines = peers::all_engines();
  std::erase_if(engines, [](const Engine& e) { return !e.absent.empty(); });
  return engines;
}

Setting usual(const Engine& engine) {
  const auto all = settings_of(engine);
  return std::ranges::find(all, true, &NamedSetting::recommended)->setting;
}

/// Runs the scene in every engine that takes it and hands over what came out.
template <class F>
void in_every_engine(const Scene& scene, int frames, const F& check) {
  const Model model = make_model(scene);
  for (const Engine& engine : present()) {
    if (!engine.refuses(model).empty()) continue;
    SCOPED_TRACE(engine.name);
    Watched run(model, engine.make(model, usual(engine)));
    for (int k = 0; k < frames; ++k) run.advance();
    check(run);
  }
}

bool takes(const char* name, const Scene& scene) {
  const Model model = make_model(scene);
  for (const Engine& engine : present()) {
    if (engine.name == name) return engine.refuses(model).empty();
  }
  return true;  // not built in
}

BodyDesc rectangle(double x0, double y0, double x1, double y1) {
  BodyDesc body;
  body.shape = PolygonShape{{{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}, 0};
  return body;
}

TEST(PeerEngines, HaveARecommendedSettingAndNoNameTwice) {
  for (const Engine& engine : peers::all_engines()) {
    const auto all = settings_of(engine);
    EXPECT_TRUE(std::ranges::any_of(all, &NamedSetting::recommended)) << engine.name;
    for (const NamedSetting& s : all) {
      EXPECT_EQ(std::ranges::count(all, s.name, &NamedSetting::name), 1) << s.name;
    }
  }
}

TEST(PeerEngines, BodiesFallFreely) {
  Scene scene = open_scene(100);
  scene.bodies = {disc({0, 0}, {2, 0}, material(0)), box({5, 0}, {1, 2}, material(0))};
  scene.bodies[1].angular_velocity = 1;
  in_every_engine(scene, 60, [](Watched& run) {
    const double exact = -0.5 * kGravity;
    for (const BodyState& s : run.bodies()) {
      EXPECT_NEAR(s.y, exact, kGravity / kFrameRate);  // a frame's speed: explicit or implicit
      EXPECT_NEAR(s.vy, -kGravity, 1e-3);
    }
    EXPECT_NEAR(run.body(0).x, 2, 1e-4);
    EXPECT_NEAR(run.body(1).angle, 1, 1e-3);
    EXPECT_NEAR(run.body(1).omega, 1, 1e-4);
  });
}

TEST(PeerEngines, GiveBackThePlacesThatTheyGot) {
  Scene scene = open_scene(100, {0, 0});
  BodyDesc moving = rectangle(1, 0, 3, 1), turned = rectangle(-1, 2, 0, 3);
  moving.position = {1, 2};
  moving.angle = 0.5;
  turned.position = {-20, 3};
  turned.angle = -1;
  turned.type = BodyType::kinematic_body;
  scene.bodies = {moving, turned, floor_box(material(0))};
  scene.bodies[2].position.y = -20;
  in_every_engine(scene, 0, [&](Watched& run) {
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(run.body(k).x, scene.bodies[k].position.x, 1e-5);
      EXPECT_NEAR(run.body(k).y, scene.bodies[k].position.y, 1e-5);
      EXPECT_NEAR(run.body(k).angle, scene.bodies[k].angle, 1e-5);
    }
  });
}

TEST(PeerEngines, KinematicBodiesTurnAboutTheirPlaceAndPush) {
  Scene scene = open_scene(100, {0, 0});
  BodyDesc bar = rectangle(2, -0.25, 6, 0.25);
  bar.type = BodyType::kinematic_body;
  bar.angular_velocity = 1;
  scene.bodies = {bar, disc({4, 2}, {0, 0}, material(0))};
  in_every_engine(scene, 60, [](Watched& run) {
    EXPECT_NEAR(run.body(0).x, 0, 1e-3);
    EXPECT_NEAR(run.body(0).angle, 1, 0.02);
    EXPECT_LT(overlaps(run).empty() ? 0 : overlaps(run).back(), 0.12);
    EXPECT_GT(std::hypot(run.body(1).vx, run.body(1).vy), 2);
  });
}

TEST(PeerEngines, DiscsAndBoxesRestOnBoxesAndWalls) {
  Scene scene = walled_scene(20, 10, material(0, 0.5), {0, -kGravity});
  scene.bodies = {disc({3, 0.5}, {0, 0}, material(0, 0.5)), box({6, 0.5}, {1, 1}, material(0, 0.5)),
                  box({6, 1.5}, {1, 1}, material(0, 0.5)), box({10, 0.5}, {2, 1}, material(0, 0.5)),
                  disc({10, 1.5}, {0, 0}, material(0, 0.5))};
  in_every_engine(scene, 120, [&](Watched& run) {
    for (std::size_t k = 0; k < scene.bodies.size(); ++k) {
      EXPECT_NEAR(run.body(k).x, scene.bodies[k].position.x, 0.02) << k;
      EXPECT_NEAR(run.body(k).y, scene.bodies[k].position.y, 0.1) << k;
    }
    EXPECT_LT(rms_speed(run), 0.05);
  });
}

TEST(PeerEngines, PolygonsRestOnTheirSides) {
  Scene scene = walled_scene(20, 10, material(0, 0.5), {0, -kGravity});
  BodyDesc triangle;
  triangle.shape = PolygonShape{{{-1, 0}, {1, 0}, {0, 1.5}}, 0};
  triangle.position = {5, 0};
  triangle.material = material(0, 0.5);
  scene.bodies = {floor_box(material(0, 0.5), 5), triangle};
  scene.bodies[0].position = {5, 0.5};
  scene.bodies[1].position.y = 1;
  in_every_engine(scene, 120, [](Watched& run) {
    EXPECT_NEAR(run.body(1).y, 1, 0.03);
    EXPECT_NEAR(run.body(1).angle, 0, 0.02);
  });
  EXPECT_FALSE(takes("ode", scene) && !takes("psim", scene));
}

TEST(PeerEngines, RestitutionMixesByMaximum) {
  Scene scene = open_scene(100);
  scene.bodies = {floor_box(material(0)), disc({0, 2.5}, {0, 0}, material(1))};
  in_every_engine(scene, 90, [](Watched& run) {  // up again after 1.28 s
    EXPECT_GT(energy(run) / (mass_of(run.model().bodies[1]) * kGravity), 2.0);
  });
}

TEST(PeerEngines, FrictionMixesByGeometricMean) {
  Scene scene = open_scene(100);
  scene.bodies = {floor_box(material(0, 0.25)), box({0, 0.5}, {2, 1}, material(0, 1))};
  scene.bodies[1].velocity = {5, 0};
  in_every_engine(scene, 90, [](Watched& run) {  // v^2 / (2 mu g), mu = 0.5
    EXPECT_NEAR(run.body(1).x, 25 / kGravity, 0.15);
  });
}

TEST(PeerEngines, PinsAndRodsHold) {
  Scene scene = open_scene(100);
  scene.bodies = {peg({0, 0}), box({1, 0}, {2, 0.2}, material(0)), box({3, 0}, {2, 0.2}, material(0))};
  join(scene, JointType::revolute, 0, 1, {}, {-1, 0});
  join(scene, JointType::revolute, 1, 2, {1, 0}, {-1, 0});
  in_every_engine(scene, 120, [](Watched& run) { EXPECT_LT(joint_gap(run), 0.1); });

  Scene rods = open_scene(100);
  rods.bodies = {peg({0, 0}), disc({2, 0}, {0, 0}, material(0))};
  join(rods, JointType::distance, 0, 1);
  in_every_engine(rods, 120, [](Watched& run) {
    EXPECT_LT(joint_gap(run), 0.05);
    EXPECT_LT(run.body(1).y, 0.2);
  });
}

TEST(PeerEngines, FiltersKeepBodiesApart) {
  Scene scene = open_scene(100, {0, 0});
  BodyDesc group = disc({0, 0}, {1, 0}, material(0));
  group.filter.group = -1;
  BodyDesc masked = disc({0, 5}, {1, 0}, material(0));
  masked.filter = {2, ~std::uint32_t{2}, 0};
  BodyDesc plain = disc({0, 10}, {1, 0}, material(0));
  for (BodyDesc body : {group, masked, plain}) {
    scene.bodies.push_back(body);
    body.position.x = 2;
    body.velocity = {};
    scene.bodies.push_back(body);
  }
  in_every_engine(scene, 120, [](Watched& run) {
    EXPECT_NEAR(run.body(0).x, 2, 1e-3);
    EXPECT_NEAR(run.body(2).x, 2, 1e-3);
    EXPECT_LT(run.body(4).x, 1.9);  // it met the other
  });
}

TEST(PeerEngines, RefuseByNameWhatTheyLack) {
  const auto refusals = [](const Scene& scene) {
    const Model model = make_model(scene);
    std::map<std::string, std::string> all;
    for (const Engine& engine : present()) all[engine.name] = engine.refuses(model);
    EXPECT_EQ(all["psim"], "");
    return all;
  };
  Scene scene = open_scene(100);
  scene.bodies = {disc({0, 0}, {0, 0}, material(0)), disc({2, 0}, {0, 0}, material(0))};
  join(scene, JointType::weld, 0, 1);
  for (const auto& [engine, what] : refusals(scene)) {
    const bool has_welds = engine == "psim" || engine.starts_with("box2d") || engine == "chipmunk";
    EXPECT_EQ(what, has_welds ? "" : "weld") << engine;
  }
  scene.joints[0].joint.type = JointType::distance;
  auto all = refusals(scene);
  if (all.contains("bullet")) {
    EXPECT_EQ(all["bullet"], "rod");
  }
  if (all.contains("ode")) {
    EXPECT_EQ(all["ode"], "");
  }
  scene.joints.clear();
  scene.bodies.push_back(segment({-1, -5}, {1, -5}, material(0)));
  all = refusals(scene);
  if (all.contains("bullet")) {
    EXPECT_EQ(all["bullet"], "segment");
  }
  if (all.contains("box2d")) {
    EXPECT_EQ(all["box2d"], "");
  }
  scene.bodies.back().shape = CapsuleShape{{-1, 0}, {1, 0}, 0.5};
  for (const auto& [engine, what] : refusals(scene)) {
    EXPECT_EQ(what, engine == "psim" ? "" : "capsule") << engine;
  }
  for (const auto& [engine, what] : refusals(periodic_scene(20, 20))) {
    EXPECT_EQ(what, engine == "psim" ? "" : "periodic world") << engine;
  }
}

TEST(PeerScenes, AreTakenByPsimAndSmallWhenQuick) {
  for (const Comparison& c : all_comparisons()) {
    const Model model = make_model(c.scene(Size::quick));
    EXPECT_GT(model.bodies.size(), 5u) << c.name;
    EXPECT_LT(model.bodies.size(), 1000u) << c.name;
    EXPECT_GT(c.frames, 0) << c.name;
  }
}

}  // namespace
}  // namespace psim::peers::test
