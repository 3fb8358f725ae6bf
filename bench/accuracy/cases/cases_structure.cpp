// Structures and machines of joints: a truss, a bridge, cantilevers, an elastic chain, a ring under pressure, a crank
// with its slider.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "cases/case.h"
#include "structures.h"

namespace psim::accuracy {
namespace {

constexpr double kPi = std::numbers::pi;

BodyDesc without_contacts(BodyDesc body) {
  body.filter.mask = 0;
  return body;
}

BodyDesc node(Vec2 position) {
  BodyDesc body = disc(position, {0, 0}, material(0), 0.01);
  body.mass = 1;
  body.fixed_rotation = true;
  return without_contacts(body);
}

BodyDesc plank(Vec2 position, Vec2 size, double mass) {
  return without_contacts(box(position, size, material(0), mass));
}

/// How far the body that went furthest down is below its start.
double deepest_sag(Run& run) {
  double sag = 0;
  for (std::size_t k = 0; k < run.bodies().size(); ++k) {
    sag = std::max(sag, run.model().bodies[k].position.y - run.body(k).y);
  }
  return sag;
}

// ---- a truss ----------------------------------------------------------------------------------

constexpr std::size_t kBays = 12;

// Body 2 k is node k of the lower chord, body 2 k + 1 that above it. The left end is pinned, the right one hangs on a
// long rod, so every rod is determined by statics.
Scene truss() {
  Scene scene = open_scene(50);
  for (std::size_t k = 0; k <= kBays; ++k) {
    const double x = static_cast<double>(k) - 0.5 * kBays;
    scene.bodies.push_back(k == 0 ? without_contacts(peg({x, 0})) : node({x, 0}));
    scene.bodies.push_back(node({x, 1}));
    if (k > 0) {
      join(scene, JointType::distance, 2 * k - 2, 2 * k);
      join(scene, JointType::distance, 2 * k - 1, 2 * k + 1);
      if (2 * k <= kBays) {
        join(scene, JointType::distance, 2 * k - 1, 2 * k);
      } else {
        join(scene, JointType::distance, 2 * k - 2, 2 * k + 1);
      }
    }
    join(scene, JointType::distance, 2 * k, 2 * k + 1);
  }
  scene.bodies.push_back(without_contacts(peg({0.5 * kBays, 10})));
  join(scene, JointType::distance, 2 * kBays, scene.bodies.size() - 1);
  return scene;
}

Case truss_case() {
  Case c;
  c.name = "truss";
  c.shows = "a truss of 12 bays of rods, 1 kg a node, held at its ends: how far any node sags in 10 s";
  c.quantities = {{"truss-sag", "m", "analytic", {{4, 1e-6}}}};
  c.scale = Scale::large;
  c.timed_seconds = 0.5;
  c.scene = truss;
  c.measure = [](Run& run) -> std::vector<double> {
    double sag = 0;
    for (int k = 0; k < 10 * kFrameRate; ++k) {
      run.frame();
      sag = std::max(sag, deepest_sag(run));
    }
    return {sag};
  };
  return c;
}

// ---- a bridge ---------------------------------------------------------------------------------

constexpr std::size_t kPlanks = 30;

Scene bridge() {
  Scene scene = open_scene(50);
  scene.bodies = {without_contacts(peg({-15, 0}))};
  for (std::size_t k = 0; k < kPlanks; ++k) {
    scene.bodies.push_back(plank({static_cast<double>(k) - 14.5, 0}, {1, 0.2}, 1));
  }
  scene.bodies.push_back(without_contacts(peg({15, 0})));
  for (std::size_t k = 0; k <= kPlanks; ++k) {
    join(scene, JointType::revolute, k, k + 1, {k > 0 ? 0.5 : 0, 0}, {k < kPlanks ? -0.5 : 0, 0});
  }
  return scene;
}

Case bridge_case() {
  Case c;
  c.name = "bridge";
  c.shows = "30 planks pinned in a level row without slack between two pegs: sag and motion after 5 s";
  c.quantities = {{"bridge-sag", "m", "analytic", {{4, 0.1}}}, {"bridge-speed", "m/s, rms", "analytic", {}}};
  c.scale = Scale::large;
  c.timed_seconds = 0.5;
  c.scene = bridge;
  c.measure = [](Run& run) -> std::vector<double> {
    run.seconds(5);
    return {deepest_sag(run), rms_speed(run)};
  };
  return c;
}

// ---- cantilevers ------------------------------------------------------------------------------

Case stiff_cantilever() {
  Case c;
  c.name = "cantilever";
  c.shows = "ten planks of 1 m welded to one another and to a peg: how far the tip sags in 5 s";
  c.quantities = {{"cantilever-sag", "of the length", "analytic", {{4, 1e-6}}}};
  c.scale = Scale::large;
  c.timed_seconds = 0.5;
  c.scene = [] {
    Scene scene = open_scene(50);
    scene.bodies = {without_contacts(peg({0, 0}))};
    for (std::size_t k = 0; k < 10; ++k) {
      scene.bodies.push_back(plank({static_cast<double>(k) + 0.5, 0}, {1, 0.1}, 1));
      join(scene, JointType::weld, k, k + 1, {k > 0 ? 0.5 : 0, 0}, {-0.5, 0});
    }
    return scene;
  };
  c.measure = [](Run& run) -> std::vector<double> {
    double sag = 0;
    for (int k = 0; k < 5 * kFrameRate; ++k) {
      run.frame();
      sag = std::max(sag, deepest_sag(run));
    }
    return {sag / 10};
  };
  return c;
}

constexpr std::array<double, 4> kBending = {1, 2, 5, 10};  // P L^2 / EI
constexpr int kElasticLinks = 10;
constexpr double kLink = 0.1, kLinkMass = 0.1, kTipMass = 1;  // m, kg, kg

double joint_stiffness(double bending) {
  const double length = kElasticLinks * kLink;
  return kTipMass * kGravity * length * length / bending / kLink;  // EI / link
}

reference::Cantilever cantilever(double bending) {
  return {kElasticLinks, kLink, joint_stiffness(bending), kLinkMass * kGravity, kTipMass * kGravity};
}

Scene soft_cantilevers() {
  Scene scene = open_scene(50);
  scene.world.linear_damping = 2;
  for (std::size_t n = 0; n < kBending.size(); ++n) {
    const double y = 3.0 * static_cast<double>(n);
    scene.bodies.push_back(without_contacts(peg({0, y})));
    for (int k = 0; k < kElasticLinks; ++k) {
      scene.bodies.push_back(plank({kLink * (k + 0.5), y}, {kLink, 0.04}, kLinkMass));
      const std::size_t last = scene.bodies.size() - 1;
      JointDesc& weld = join(scene, JointType::weld, last - 1, last, {k > 0 ? kLink / 2 : 0, 0}, {-kLink / 2, 0}).joint;
      weld.stiffness = joint_stiffness(kBending[n]);
      weld.damping = 0.02 * weld.stiffness;
    }
    scene.bodies.push_back(node({kElasticLinks * kLink, y}));
    const std::size_t tip = scene.bodies.size() - 1;
    join(scene, JointType::revolute, tip - 1, tip, {kLink / 2, 0}, {});
  }
  return scene;
}

Case soft_cantilever() {
  Case c;
  c.name = "elastica";
  c.shows = "cantilevers of ten soft welds with a weight at the tip, P L^2/EI = 1, 2, 5, 10: drop of the tip at rest";
  c.quantities = {{"elastica-drop", "of the length", "analytic", {}}};
  c.scale = Scale::large;
  c.timed_seconds = 0.5;
  c.scene = soft_cantilevers;
  c.measure = [](Run& run) -> std::vector<double> {
    run.seconds(20);
    double off = 0;
    for (std::size_t n = 0; n < kBending.size(); ++n) {
      const std::size_t tip = (n + 1) * (kElasticLinks + 2) - 1;
      const double drop = 3.0 * static_cast<double>(n) - run.body(tip).y;
      off = std::max(off, std::abs(drop - cantilever(kBending[n]).drop()) / (kElasticLinks * kLink));
    }
    return {off};
  };
  return c;
}

// ---- an elastic chain -------------------------------------------------------------------------

constexpr int kSprings = 20;
constexpr double kSpring = 0.6, kSpan = 10;
constexpr std::array<double, 2> kStretch = {10, 100};  // EA over the chain's weight

double stretch_load(double ratio) { return ratio * kSprings * kGravity; }

Scene elastic_chains() {
  Scene scene = open_scene(50);
  scene.world.linear_damping = 1.2;
  for (std::size_t n = 0; n < kStretch.size(); ++n) {
    const double y = 10 * static_cast<double>(n), half = 0.5 * kSpan;
    const double deep = std::sqrt(0.25 * kSprings * kSprings * kSpring * kSpring - half * half);
    for (int k = 0; k <= kSprings; ++k) {  // a V, taut
      const double along = 2.0 * k / kSprings;
      const Vec2 at{half * (along - 1), y - deep * std::min(along, 2 - along)};
      scene.bodies.push_back(k == 0 || k == kSprings ? without_contacts(peg(at)) : node(at));
      if (k == 0) continue;
      JointDesc& spring = join(scene, JointType::spring, scene.bodies.size() - 2, scene.bodies.size() - 1).joint;
      spring.length = kSpring;
      spring.stiffness = stretch_load(kStretch[n]) / kSpring;
    }
  }
  return scene;
}

Case elastic_chain() {
  Case c;
  c.name = "elastic-chain";
  c.shows = "20 springs, 12 m in all, hung up 10 m apart, EA 10 and 100 times the weight: sag after 30 s";
  c.quantities = {{"elastic-chain-sag", "m", "analytic", {}}};
  c.scale = Scale::large;
  c.timed_seconds = 0.5;
  c.scene = elastic_chains;
  c.measure = [](Run& run) -> std::vector<double> {
    run.seconds(30);
    double off = 0;
    for (std::size_t n = 0; n < kStretch.size(); ++n) {
      const double sag = 10 * static_cast<double>(n) - run.body(n * (kSprings + 1) + kSprings / 2).y;
      const double truth = reference::elastic_chain_sag(kSprings, kSpring, stretch_load(kStretch[n]), kGravity, kSpan);
      off = std::max(off, std::abs(sag - truth));
    }
    return {off};
  };
  return c;
}

// ---- a ring under pressure --------------------------------------------------------------------

constexpr int kNodes = 60;
constexpr double kPush = 1, kSwell = 0.1;  // m/s^2 outwards on 1 kg a node; p R / EA

// A well of exponent 0 that pushes: the same force outwards at any distance, as a pressure p has with p R kept.
Scene ring() {
  Scene scene = open_scene(50, {0, 0});
  scene.world.linear_damping = 2;
  scene.world.fields = {WellField{{0, 0}, -kPush, 0, 0, 0}};
  const double half = std::sin(kPi / kNodes);
  for (int k = 0; k < kNodes; ++k) {
    const double a = 2 * kPi * k / kNodes;
    scene.bodies.push_back(node({std::cos(a), std::sin(a)}));
  }
  for (std::size_t k = 0; k < kNodes; ++k) {
    JointDesc& spring = join(scene, JointType::spring, k, (k + 1) % kNodes).joint;
    spring.length = 2 * half;
    // The tension is the push over 2 sin(pi/n); it stretches by kSwell of the length.
    spring.stiffness = kPush / (2 * half) / (kSwell * 2 * half);
  }
  return scene;
}

Case ring_case() {
  Case c;
  c.name = "ring";
  c.shows = "an elastic ring of 60 masses pushed outwards, p R/EA = 0.1: its radius after 15 s";
  c.quantities = {{"ring-radius", "relative", "analytic", {}}};
  c.scale = Scale::large;
  c.timed_seconds = 0.5;
  c.scene = ring;
  c.measure = [](Run& run) -> std::vector<double> {
    run.seconds(15);
    double off = 0;
    for (const BodyState& s : run.bodies()) off = std::max(off, std::abs(std::hypot(s.x, s.y) / (1 + kSwell) - 1));
    return {off};
  };
  return c;
}

// ---- a crank with its slider ------------------------------------------------------------------

constexpr double kCrank = 0.5, kRod = 1.5, kTurning = 10;  // m, m, rad/s

Scene crank() {
  Scene scene = open_scene(50);
  BodyDesc wheel = without_contacts(disc({0, 0}, {0, 0}, material(0), 0.5));
  wheel.type = BodyType::kinematic_body;
  wheel.angular_velocity = kTurning;
  scene.bodies = {wheel, plank({kCrank + kRod / 2, 0}, {kRod, 0.1}, 1), plank({kCrank + kRod, 0}, {0.2, 0.2}, 1),
                  without_contacts(peg({0, 5}))};
  join(scene, JointType::revolute, 0, 1, {kCrank, 0}, {-kRod / 2, 0});
  join(scene, JointType::revolute, 1, 2, {kRod / 2, 0}, {0, 0});
  join(scene, JointType::prismatic, 3, 2, {0, -5}, {0, 0});
  return scene;
}

Case crank_case() {
  Case c;
  c.name = "crank";
  c.shows = "a crank of 0.5 m at 10 rad/s, a rod of 1.5 m, a slider: how far the slider is off its place within 10 s";
  c.quantities = {{"crank-slider", "of the crank", "analytic", {{4, 1e-6}}}};
  c.scale = Scale::large;
  c.timed_seconds = 0.5;
  c.scene = crank;
  c.measure = [](Run& run) -> std::vector<double> {
    double off = 0;
    for (int frame = 0; frame < 10 * kFrameRate; ++frame) {
      run.frame();
      const double angle = kTurning * run.time(), up = kCrank * std::sin(angle);
      const double truth = kCrank * std::cos(angle) + std::sqrt(kRod * kRod - up * up);
      off = std::max(off, std::hypot(run.body(2).x - truth, run.body(2).y) / kCrank);
    }
    return {off};
  };
  return c;
}

}  // namespace

std::vector<Case> structure_cases(Effort) {
  return {truss_case(),    bridge_case(), stiff_cantilever(), soft_cantilever(),
          elastic_chain(), ring_case(),   crank_case()};
}

}  // namespace psim::accuracy
