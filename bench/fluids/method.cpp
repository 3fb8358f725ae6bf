#include "method.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <stdexcept>

#include "psim/psim.h"

namespace psim::fluids {
namespace {

// Of the calling thread.
double worked_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

class PsimMotion final : public Motion {
 public:
  PsimMotion(const Flow& flow, double step) : step_(step) {
    std::string error;
    // Water at rest is measured as it moves, not as it lies still.
    world_ = World::create(
        {.bounds = flow.bounds, .boundary = flow.boundary, .gravity = flow.gravity, .dt = step, .sleeping = false}, {},
        error);
    if (!world_) throw std::runtime_error(error);
    const FluidId fluid =
        world_->add_fluid({.spacing = flow.spacing, .density = kDensity, .viscosity = flow.viscosity}, error);
    if (fluid == kNoFluid || !world_->add_particles(fluid, flow.places, flow.velocities, error)) {
      throw std::runtime_error(error);
    }
    dt = step;
  }

  void look(std::vector<Particle>& out) const override {
    std::vector<FluidParticleState> states;
    world_->fluid_particles(states);
    out.clear();
    for (const FluidParticleState& s : states) out.push_back({s.position, s.velocity, s.pressure});
  }

 private:
  void run(double frame) override {
    const long steps = std::lround(frame / step_);
    for (long k = 0; k < steps; ++k) world_->step();
  }

  double step_;
  std::unique_ptr<World> world_;
};

class SphMotion final : public Motion {
 public:
  SphMotion(const Flow& flow, const SphSettings& settings) : sph_(flow, settings) {}

  void look(std::vector<Particle>& out) const override { sph_.look(out); }

 private:
  void run(double frame) override {
    const int steps = static_cast<int>(std::ceil(frame / sph_.longest_step()));
    dt = frame / steps;
    for (int k = 0; k < steps; ++k) sph_.step(dt);
  }

  bool sum() override {
    sph_.sum_densities(sums_);
    return true;
  }

  Sph sph_;
  std::vector<float> sums_;
};

}  // namespace

void Motion::advance(double frame) {
  const double before = worked_s();
  run(frame);
  seconds += worked_s() - before;
  simulated += frame;
}

double Motion::time_of_sum() {
  double least = 0;
  for (int k = 0; k < 5; ++k) {
    const double before = worked_s();
    if (!sum()) return 0;
    const double spent = worked_s() - before;
    least = k == 0 ? spent : std::min(least, spent);
  }
  return least;
}

double Motion::energy() const {
  std::vector<Particle> particles;
  look(particles);
  double sum = 0;
  for (const Particle& p : particles) sum += p.velocity.x * p.velocity.x + p.velocity.y * p.velocity.y;
  return kDensity / 2 * sum;
}

std::unique_ptr<Motion> begin(const Method& method, const Flow& flow, double frame) {
  if (method.engine == "psim") return std::make_unique<PsimMotion>(flow, frame / method.steps);
  return std::make_unique<SphMotion>(flow, method.sph);
}

}  // namespace psim::fluids
