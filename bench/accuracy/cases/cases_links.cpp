// Bodies on many joints in motion: planks on rods and ropes, chains with heavy ends, the modes of a hanging chain, double
// pendulums of unlike masses.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "cases/case.h"
#include "structures.h"

namespace psim::accuracy {
namespace {

/// It collides with nothing.
BodyDesc plank(Vec2 position, Vec2 size, double mass) {
  BodyDesc body = box(position, size, material(0), mass);
  body.filter.mask = 0;
  return body;
}

BodyDesc ghost_peg(Vec2 position) {
  BodyDesc body = peg(position);
  body.filter.mask = 0;
  return body;
}

Vec2 anchor(Run& run, std::size_t body, Vec2 at) {
  const BodyState& s = run.body(body);
  const double c = std::cos(s.angle), d = std::sin(s.angle);
  return {s.x + c * at.x - d * at.y, s.y + d * at.x + c * at.y};
}

/// The widest gap of the scene's pins, m.
double widest_gap(Run& run) {
  double widest = 0;
  for (const SceneJoint& j : run.model().scene.joints) {
    const Vec2 a = anchor(run, j.a, j.joint.anchor_a), b = anchor(run, j.b, j.joint.anchor_b);
    widest = std::max(widest, std::hypot(b.x - a.x, b.y - a.y));
  }
  return widest;
}

// ---- planks -----------------------------------------------------------------------------------

constexpr double kStiffness = 1000;  // N/m, of springs

/// Of all bodies and springs.
double whole_energy(Run& run) {
  double sum = energy(run);
  for (const SceneJoint& j : run.model().scene.joints) {
    if (j.joint.type != JointType::spring) continue;
    const Vec2 a = anchor(run, j.a, j.joint.anchor_a), b = anchor(run, j.b, j.joint.anchor_b);
    const double stretch = std::hypot(b.x - a.x, b.y - a.y) - *j.joint.length;
    sum += 0.5 * j.joint.stiffness * stretch * stretch;
  }
  return sum;
}

/// Three planks of 1 x 0.3 m and 2 kg, tied end to end by what is 0.1 m long, let go level.
Case planks(JointType type, const std::string& name, Effort effort) {
  const double seconds = effort == Effort::quick ? 10 : 60;
  Case c;
  c.name = name;
  c.shows = "three planks tied end to end by " + name + " of 0.1 m, let go level: energy gained in a minute" +
            (type == JointType::rope ? "" : ", and how far it is off at its end");
  c.quantities = {{name + "-gain", "of m g L", "analytic", {{4, 1e-5}}}};
  if (type == JointType::distance) c.quantities.push_back({name + "-energy", "of m g L", "analytic", {{4, 4e-4}}});
  if (type == JointType::spring) c.quantities.push_back({name + "-energy", "of m g L", "analytic", {}});
  c.scale = Scale::large;
  c.timed_seconds = 0.5;
  c.scene = [type] {
    Scene scene = open_scene(50);
    scene.bodies = {ghost_peg({0, 0})};
    for (std::size_t k = 0; k < 3; ++k) {
      scene.bodies.push_back(plank({0.6 + 1.1 * static_cast<double>(k), 0}, {1, 0.3}, 2));
      JointDesc& joint = join(scene, type, k, k + 1, {k > 0 ? 0.5 : 0, 0}, {-0.5, 0}).joint;
      joint.length = 0.1;
      if (type == JointType::spring) joint.stiffness = kStiffness;
    }
    return scene;
  };
  c.measure = [seconds, type](Run& run) -> std::vector<double> {
    const double unit = 2 * kGravity * (0.6 + 1.7 + 2.8), start = whole_energy(run);
    double gained = 0;
    for (int frame = 0; frame < seconds * kFrameRate; ++frame) {
      run.frame();
      gained = std::max(gained, (whole_energy(run) - start) / unit);
    }
    std::vector<double> errors = {gained};
    if (type != JointType::rope) errors.push_back(std::abs(whole_energy(run) - start) / unit);
    return errors;
  };
  return c;
}

// ---- chains with a heavy end ------------------------------------------------------------------

/// Hangs down, the end moving to the side at 3 m/s.
Scene loaded_chain(int links, double load) {
  Scene scene = open_scene(200);
  scene.bodies = {ghost_peg({0, 0})};
  for (int k = 0; k < links; ++k) scene.bodies.push_back(plank({0, -0.5 - k}, {0.1, 0.9}, 1));
  BodyDesc end = disc({0, -0.5 - links}, {3, 0}, material(0));
  end.mass = load;
  end.filter.mask = 0;
  scene.bodies.push_back(end);
  for (std::size_t k = 0; k <= static_cast<std::size_t>(links); ++k) {
    join(scene, JointType::revolute, k, k + 1, {0, k > 0 ? -0.5 : 0}, {0, 0.5});
  }
  return scene;
}

Case gap(int links, int load) {
  const std::string n = std::to_string(links), m = std::to_string(load), name = "chain-gap-" + n + "-" + m;
  Case c;
  c.name = name;
  c.shows = n + " links of 1 m and 1 kg on pins, " + m + " kg at the end, pushed aside: the widest gap of a pin in 5 s";
  c.quantities = {{name, "m", "analytic", {{4, links * load < 100'000 ? 1e-6 : 3e-5}}}};
  c.scale = Scale::large;
  c.timed_seconds = 0.5;
  c.scene = [links, load] { return loaded_chain(links, load); };
  c.measure = [](Run& run) -> std::vector<double> {
    double widest = 0;
    for (int frame = 0; frame < 5 * kFrameRate; ++frame) {
      run.frame();
      widest = std::max(widest, widest_gap(run));
    }
    return {widest};
  };
  return c;
}

// ---- modes of a hanging chain -----------------------------------------------------------------

constexpr int kMasses = 20, kModes = 3, kSwings = 10;
constexpr double kLength = 1, kSway = 1e-3;

// A chain a mode, bent as it.
Scene swaying_chains() {
  Scene scene = open_scene(50);
  const std::vector<double> modes = reference::laguerre_zeros(kMasses, kModes);
  for (int mode = 0; mode < kModes; ++mode) {
    const double x = 2.0 * (mode - 1);
    scene.bodies.push_back(ghost_peg({x, 0}));
    double y = 0, before = 0;
    for (int k = 1; k <= kMasses; ++k) {
      const double off = kSway * reference::laguerre(kMasses - k, modes[static_cast<std::size_t>(mode)]);
      const double link = kLength / kMasses;
      y -= std::sqrt(link * link - (off - before) * (off - before));
      before = off;
      BodyDesc mass = disc({x + off, y}, {0, 0}, material(0), 0.01);
      mass.mass = 1;
      mass.fixed_rotation = true;
      mass.filter.mask = 0;
      scene.bodies.push_back(mass);
      const std::size_t last = scene.bodies.size() - 1;
      join(scene, JointType::distance, last - 1, last).joint.length = link;
    }
  }
  return scene;
}

/// Of the lowest mass: the time of so many swings there and back, by its passes through the middle.
std::vector<double> measure_modes(Run& run) {
  const std::vector<double> modes = reference::laguerre_zeros(kMasses, kModes);
  std::vector<double> first(kModes, 0), last(kModes, 0), before(kModes, kSway);
  std::vector<int> passes(kModes, 0);
  for (int frame = 0; frame < 20 * kFrameRate; ++frame) {
    run.frame();
    for (std::size_t mode = 0; mode < kModes; ++mode) {
      const double off = run.body((mode + 1) * (kMasses + 1) - 1).x - 2.0 * (static_cast<double>(mode) - 1);
      if (off * before[mode] < 0 && passes[mode] <= 2 * kSwings) {
        last[mode] = run.time() - off / (off - before[mode]) / kFrameRate;
        if (passes[mode]++ == 0) first[mode] = last[mode];
      }
      before[mode] = off;
    }
  }
  double off = 0;
  for (std::size_t mode = 0; mode < kModes; ++mode) {
    if (passes[mode] <= 2 * kSwings) throw Failed("a chain came to rest");
    const double truth = 2 * std::numbers::pi / std::sqrt(modes[mode] * kGravity * kMasses / kLength);
    off = std::max(off, std::abs((last[mode] - first[mode]) / (kSwings * truth) - 1));
  }
  return {off};
}

Case modes() {
  Case c;
  c.name = "chain-modes";
  c.shows = "a chain of 20 masses, 1 m, sways in each of its three slowest modes: ten periods";
  c.quantities = {{"chain-modes-period", "relative", "analytic", {}}};
  c.scale = Scale::large;
  c.timed_seconds = 0.5;
  c.scene = swaying_chains;
  c.measure = measure_modes;
  return c;
}

// ---- double pendulums -------------------------------------------------------------------------

Case unlike_pendulums(Effort effort) {
  const double seconds = effort == Effort::quick ? 10 : 60;
  Case c;
  c.name = "pendulum-1000";
  c.shows = "double pendulums on rods, 1 kg under 1000 kg and 1000 kg under 1 kg, let go level: energy over a minute";
  c.quantities = {{"pendulum-1000-energy", "of m g L", "analytic", {}}};
  c.scale = Scale::large;
  c.timed_seconds = 0.5;
  c.scene = [] {
    Scene scene = open_scene(50);
    for (const double x : {-5.0, 5.0}) {
      scene.bodies.push_back(ghost_peg({x, 0}));
      for (int k = 1; k <= 2; ++k) {
        BodyDesc mass = disc({x + k, 0}, {0, 0}, material(0), 0.01);
        mass.mass = (x < 0) == (k == 1) ? 1000 : 1;
        mass.fixed_rotation = true;
        mass.filter.mask = 0;
        scene.bodies.push_back(mass);
        join(scene, JointType::distance, scene.bodies.size() - 2, scene.bodies.size() - 1);
      }
    }
    return scene;
  };
  // Each pendulum for itself, by what it weighs a metre lower.
  c.measure = [seconds](Run& run) -> std::vector<double> {
    double off = 0;
    for (int frame = 0; frame < seconds * kFrameRate; ++frame) {
      run.frame();
      for (const std::size_t first : {1u, 4u}) {
        double sum = 0, unit = 0;
        for (std::size_t k = first; k < first + 2; ++k) {
          const BodyState& s = run.body(k);
          const BodyDesc& start = run.model().bodies[k];
          sum += start.mass * (0.5 * (s.vx * s.vx + s.vy * s.vy) + kGravity * s.y);
          unit += start.mass * kGravity * static_cast<double>(k - first + 1);
        }
        off = std::max(off, std::abs(sum) / unit);
      }
    }
    return {off};
  };
  return c;
}

}  // namespace

std::vector<Case> link_cases(Effort effort) {
  std::vector<Case> cases = {planks(JointType::distance, "rods", effort), planks(JointType::rope, "ropes", effort),
                             planks(JointType::spring, "springs", effort)};
  for (const int links : {20, 100}) {
    for (const int load : {1, 100, 1000}) cases.push_back(gap(links, load));
  }
  cases.push_back(modes());
  cases.push_back(unlike_pendulums(effort));
  return cases;
}

}  // namespace psim::accuracy
