// Fluids.
#include "convert.h"
#include "psim/limits.h"
#include "structs.h"

using namespace psim::capi;

namespace {

psim_fluid_amount amount_of(const psim::FluidAmount& from) {
  return {from.particles, from.mass, to_c(from.mean_velocity)};
}

psim_result not_there(const Call& call, const char* what, std::uint32_t id) {
  return call.fail(PSIM_ERROR_STALE_ID, std::string("there is no ") + what + " " + std::to_string(id));
}

}  // namespace

psim_result psim_world_add_fluid(psim_world* world, const psim_fluid_desc* desc, uint32_t* fluid) {
  return guarded(world, __func__, [&](psim::World&, const Call& call) -> psim_result {
    psim_fluid_desc given;
    if (const psim_result r = read(call, "desc", desc, given); r != PSIM_OK) return r;
    std::string error;
    const psim::FluidId id = world->changed([&](auto& w) {
      return w.add_fluid({given.spacing, given.density, given.viscosity, given.surface_tension}, error);
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
                            f.density_error_max, f.emitted, f.drained, f.withheld},
          report);
    return PSIM_OK;
  });
}

psim_result psim_world_add_emitter(psim_world* world, const psim_emitter_desc* desc, uint32_t* emitter) {
  return guarded(world, __func__, [&](psim::World&, const Call& call) -> psim_result {
    psim_emitter_desc given;
    if (const psim_result r = read(call, "desc", desc, given); r != PSIM_OK) return r;
    psim::EmitterDesc to;
    to.fluid = given.fluid;
    to.from = to_cpp(given.from);
    to.to = to_cpp(given.to);
    to.speed = given.speed;
    to.start = given.start;
    to.end = given.end;
    to.limit = given.limit;
    std::string error;
    const psim::EmitterId id = world->changed([&](auto& w) { return w.add_emitter(to, error); });
    if (id == psim::kNoEmitter) return call.fail(PSIM_ERROR_ARGUMENT, error);
    if (emitter != nullptr) *emitter = id;
    return PSIM_OK;
  });
}

psim_result psim_world_remove_emitter(psim_world* world, uint32_t emitter) {
  return guarded(world, __func__, [&](psim::World&, const Call& call) -> psim_result {
    if (world->changed([&](auto& w) { return w.remove_emitter(emitter); })) return PSIM_OK;
    return not_there(call, "emitter", emitter);
  });
}

psim_result psim_world_set_emitter_speed(psim_world* world, uint32_t emitter, double speed) {
  return guarded(world, __func__, [&](psim::World&, const Call& call) -> psim_result {
    if (!psim::limits::kVelocity.contains(speed)) {
      return call.fail(PSIM_ERROR_ARGUMENT, "speed must be from -1e6 to 1e6");
    }
    if (world->changed([&](auto& w) { return w.set_emitter_speed(emitter, speed); })) return PSIM_OK;
    return not_there(call, "emitter", emitter);
  });
}

psim_result psim_world_add_drain(psim_world* world, psim_bounds region, uint32_t* drain) {
  return guarded(world, __func__, [&](psim::World&, const Call& call) -> psim_result {
    std::string error;
    const psim::Bounds to = to_cpp(region);
    const psim::DrainId id = world->changed([&](auto& w) { return w.add_drain(to, error); });
    if (id == psim::kNoDrain) return call.fail(PSIM_ERROR_ARGUMENT, error);
    if (drain != nullptr) *drain = id;
    return PSIM_OK;
  });
}

psim_result psim_world_remove_drain(psim_world* world, uint32_t drain) {
  return guarded(world, __func__, [&](psim::World&, const Call& call) -> psim_result {
    if (world->changed([&](auto& w) { return w.remove_drain(drain); })) return PSIM_OK;
    return not_there(call, "drain", drain);
  });
}

psim_result psim_world_fluid_in(const psim_world* world, psim_bounds region, uint32_t fluid,
                                psim_fluid_amount* amount) {
  return guarded(world, __func__, [&](const psim::World& w, const Call& call) -> psim_result {
    if (amount == nullptr) return call.fail(PSIM_ERROR_ARGUMENT, "amount must not be NULL");
    *amount = amount_of(w.fluid_in(to_cpp(region), fluid));
    return PSIM_OK;
  });
}

psim_result psim_world_fluid_in_sensor(const psim_world* world, psim_body_id body, uint32_t fluid,
                                       psim_fluid_amount* amount) {
  return guarded(world, __func__, [&](const psim::World& w, const Call& call) -> psim_result {
    if (amount == nullptr) return call.fail(PSIM_ERROR_ARGUMENT, "amount must not be NULL");
    const auto found = w.fluid_in_sensor(to_cpp(body), fluid);
    if (!found) return not_there(call, "body", body.index);
    *amount = amount_of(*found);
    return PSIM_OK;
  });
}

psim_result psim_world_fluid_load(const psim_world* world, psim_body_id body, psim_vec2* force, double* torque) {
  return guarded(world, __func__, [&](const psim::World& w, const Call& call) -> psim_result {
    if (force == nullptr || torque == nullptr) {
      return call.fail(PSIM_ERROR_ARGUMENT, "force and torque must not be NULL");
    }
    const auto load = w.fluid_load(to_cpp(body));
    if (!load) return not_there(call, "body", body.index);
    *force = to_c(load->force);
    *torque = load->torque;
    return PSIM_OK;
  });
}
