#include "engines.h"

#include <utility>

namespace psim::peers {
namespace {

NamedSetting substeps(int n) {
  NamedSetting s;
  s.name = std::to_string(n) + (n == 1 ? " substep" : " substeps");
  s.setting.substeps = n;
  s.setting.integrator = "verlet";
  s.recommended = n == 4;
  return s;
}

NamedSetting iterations(std::string name, int iterations, int steps) {
  NamedSetting s;
  s.name = std::move(name);
  if (steps > 1) s.name += " x " + std::to_string(steps) + " steps";
  s.setting.iterations = iterations;
  s.setting.steps = steps;
  return s;
}

std::vector<NamedSetting> psim_settings() {
  std::vector<NamedSetting> all;
  for (const int n : {1, 2, 4, 8}) all.push_back(substeps(n));
  if (isa_available(Isa::sse) && best_isa() != Isa::sse) {
    NamedSetting s = substeps(4);
    s.name += ", sse4.1";
    s.setting.isa = Isa::sse;
    s.recommended = false;
    all.push_back(s);
  }
  if (accuracy::usable_threads() > 1) {
    NamedSetting s = substeps(4);
    s.name += ", " + std::to_string(accuracy::usable_threads()) + " threads";
    s.setting.threads = accuracy::usable_threads();
    all.push_back(s);
  }
  return all;
}

// Its manual: 8 and 3, or fewer. Continuous collision is on by default and costs it much where many
// bodies lie on fixed ones; the other engines but psim have none by default.
std::vector<NamedSetting> box2d24_settings() {
  std::vector<NamedSetting> all;
  const auto add = [&](int velocity, int position, int steps, bool continuous) {
    NamedSetting s = iterations(std::to_string(velocity) + " + " + std::to_string(position) + " iterations" +
                                    (continuous ? ", continuous" : ""),
                                velocity, steps);
    s.setting.position_iterations = position;
    s.setting.continuous = continuous;
    s.recommended = velocity == 8 && steps == 1;
    all.push_back(s);
  };
  add(8, 3, 1, true);
  add(4, 2, 1, false);
  for (const int steps : {1, 2, 4}) add(8, 3, steps, false);
  return all;
}

// 10 iterations are its default. So is a slop of 0.1 units of length, fit for pixels; for metres Box2D's
// is taken. Its manual has hashed cells for many bodies of one size.
std::vector<NamedSetting> chipmunk_settings() {
  constexpr double kDefaultSlop = 0.1, kSlop = 0.005;  // m
  std::vector<NamedSetting> all;
  const auto add = [&](const char* name, double slop, bool hashed, int steps) {
    NamedSetting s = iterations(name, 10, steps);
    s.setting.slop = slop;
    s.setting.hashed = hashed;
    s.recommended = slop != kDefaultSlop && steps == 1;
    all.push_back(s);
  };
  add("10 iterations, slop 0.1", kDefaultSlop, false, 1);
  add("10 iterations, tree", kSlop, false, 1);
  for (const int steps : {1, 2, 4}) add("10 iterations", kSlop, true, steps);
  return all;
}

// The defaults; its manual has no others.
std::vector<NamedSetting> iterated(int usual) {
  std::vector<NamedSetting> all;
  for (const int steps : {1, 2}) {
    NamedSetting s = iterations(std::to_string(usual) + " iterations", usual, steps);
    s.recommended = steps == 1;
    all.push_back(s);
  }
  NamedSetting s = iterations(std::to_string(4 * usual) + " iterations", 4 * usual, 1);
  all.push_back(s);
  return all;
}

}  // namespace

#ifndef PSIM_WITH_BULLET
Engine bullet_engine() {
  return accuracy::absent_engine("bullet", "3", "not built in: apt install libbullet-dev, configure again");
}
#endif
#ifndef PSIM_WITH_ODE
Engine ode_engine() {
  return accuracy::absent_engine("ode", "0.16", "not built in: apt install libode-dev, configure again");
}
#endif

std::vector<Engine> all_engines() {
  std::vector<Engine> engines = accuracy::all_engines();
  engines.push_back(bullet_engine());
  engines.push_back(ode_engine());
  return engines;
}

std::vector<NamedSetting> settings_of(const Engine& engine) {
  if (engine.name == "psim") return psim_settings();
  if (engine.name == "box2d") return box2d24_settings();
  if (engine.name == "chipmunk") return chipmunk_settings();
  if (engine.name == "bullet") return iterated(10);
  if (engine.name == "ode") return iterated(20);
  std::vector<NamedSetting> all;
  for (const int n : {1, 2, 4, 8}) all.push_back(substeps(n));  // Box2D 3
  return all;
}

}  // namespace psim::peers
