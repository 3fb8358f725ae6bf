// What an engine offers to be measured: a model in, bodies out, a frame at a time. One file an
// engine; engines.cpp lists them.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "engines/model.h"
#include "psim/isa.h"
#include "psim/world.h"

namespace psim::accuracy {

/// How an engine is asked to run. A frame is `steps` calls of the engine, each divided by the engine
/// itself into `substeps`.
struct Setting {
  std::string curve;                ///< what is not h or iterations: integrator, variant, contact setting
  double frame = 1.0 / kFrameRate;  ///< s
  int steps = 1;
  int substeps = 1;
  int iterations = 1;  ///< solver iterations a substep
  int position_iterations = 0;
  double slop = 0;    ///< m, overlap that the engine leaves alone
  bool bare = false;  ///< Box2D 2.4: corners without the skin that it gives them, for boxes only
  std::string integrator;
  Isa isa = best_isa();
  int threads = 1;
  bool continuous = true;  ///< Box2D: what is fast for its size is stopped at fixed bodies
  bool hashed = false;     ///< Chipmunk: broad phase by hashed cells instead of a tree
  bool sleeping = false;   ///< bodies at rest may be left out, by the engine's own rules
  bool is_default = false;

  bool is_machine_variant() const { return isa != best_isa() || threads != 1; }
  int divisions() const { return steps * substeps; }
  double h() const { return frame / divisions(); }
};

/// What two bodies that touch press on each other with, over the engine's last step.
struct Load {
  std::size_t a = 0, b = 0;  ///< ids, a < b
  double force = 0;          ///< N, along the normal, all points of the contact together
};

/// A scene at work in one engine.
class Simulation {
 public:
  virtual ~Simulation() = default;

  /// One frame. This is what is timed.
  virtual void advance() = 0;
  /// Every body in id order; fewer rows if the engine lost one.
  virtual void read(std::vector<BodyState>& bodies) = 0;
  virtual void set_velocity(std::size_t body, Vec2 velocity, double omega) = 0;
  /// Constraint rows touched in the last frame, each once a pass.
  virtual double row_visits() const = 0;
  /// From now on `virial` adds up normal impulse x distance of the centres over contacts of discs.
  virtual void watch_impulses() {}
  virtual double virial() const { return 0; }  ///< N s m
  /// Pairs of bodies that touch; walls of the world are left out.
  virtual std::vector<Load> loads() { return {}; }
};

enum class Effort { quick, full };

/// Small scenes cost microseconds a frame and are swept over everything; large ones sparsely.
enum class Scale { small, large };

struct Engine {
  std::string name;
  std::string version;
  std::string absent;                                ///< why it is not here and what would bring it; empty if it is
  std::function<std::string(const Model&)> refuses;  ///< why it cannot run a scene; empty if it can
  std::function<std::unique_ptr<Simulation>(const Model&, const Setting&)> make;
  std::function<std::vector<Setting>(Effort, Scale)> settings;
};

/// One that is not built in, and why.
Engine absent_engine(std::string name, std::string version, std::string why);

/// All of them, psim first, those not built in included.
std::vector<Engine> all_engines();

/// Threads that this process may run on at once.
int usable_threads();

Engine psim_engine();
Engine box2d24_engine();
Engine box2d3_engine();
Engine chipmunk_engine();

}  // namespace psim::accuracy
