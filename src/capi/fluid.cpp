// Fluids.
#include "convert.h"
#include "structs.h"

using namespace psim::capi;

psim_result psim_world_add_fluid(psim_world* world, const psim_fluid_desc* desc, uint32_t* fluid) {
  return guarded(world, __func__, [&](psim::World&, const Call& call) -> psim_result {
    psim_fluid_desc given;
    if (const psim_result r = read(call, "desc", desc, given); r != PSIM_OK) return r;
    std::string error;
    const psim::FluidId id = world->changed([&](auto& w) {
      return w.add_fluid({given.spacing, given.density, given.viscosity}, error);
    });
    if (id == psim::kNoFluid) return call.fail(PSIM_ERROR_ARGUMENT, error);
    if (fluid != nullptr) *fluid = id;
    return PSIM_OK;
  });
}

psim_result psim_world_add_particles(psim_world* world, uint32_t fluid, const psim_vec2* positions,
                                     const psim_vec2* velocities, size_t count) {
  return guarded(world, __func__, [&](psim::World&, const Call& call) -> psim_result {
    if (count != 0 && positions == nullptr) return call.fail(PSIM_ERROR_ARGUMENT, "positions must not be NULL");
    if (count > psim::kMostParticles) {  // before memory is taken for the copies
      return call.fail(PSIM_ERROR_ARGUMENT,
                       "a world has at most " + std::to_string(psim::kMostParticles) + " particles");
    }
    const auto copy = [&](const psim_vec2* from) {
      std::vector<psim::Vec2> to;
      to.reserve(count);
      for (std::size_t k = 0; k < count; ++k) to.push_back(to_cpp(from[k]));
      return to;
    };
    const std::vector<psim::Vec2> places = copy(positions);
    const std::vector<psim::Vec2> speeds = velocities != nullptr ? copy(velocities) : std::vector<psim::Vec2>();
    std::string error;
    if (world->changed([&](auto& w) { return w.add_particles(fluid, places, speeds, error); })) return PSIM_OK;
    return call.fail(PSIM_ERROR_ARGUMENT, error);
  });
}

psim_result psim_world_fluid_particles(psim_world* world, const psim_fluid_particle** particles, size_t* count) {
  return guarded(world, __func__, [&](const psim::World& w, const Call& call) -> psim_result {
    if (particles == nullptr || count == nullptr) {
      return call.fail(PSIM_ERROR_ARGUMENT, "the list and its count must not be NULL");
    }
    std::vector<psim::FluidParticleState> seen;
    w.fluid_particles(seen);
    world->particles.clear();
    world->particles.reserve(seen.size());
    for (const psim::FluidParticleState& p : seen) {
      world->particles.push_back({p.id, p.fluid, to_c(p.position), to_c(p.velocity), p.density, p.pressure});
    }
    *particles = world->particles.data();
    *count = world->particles.size();
    return PSIM_OK;
  });
}

psim_result psim_world_fluid_report(const psim_world* world, psim_fluid_report* report) {
  return guarded(world, __func__, [&](const psim::World& w, const Call& call) -> psim_result {
    if (const psim_result r = check_output(call, "report", report); r != PSIM_OK) return r;
    const psim::FluidReport f = w.fluid_report();
    write(psim_fluid_report{sizeof(psim_fluid_report), f.iterations, f.particles, f.kinetic, f.density_error_mean,
                            f.density_error_max},
          report);
    return PSIM_OK;
  });
}
