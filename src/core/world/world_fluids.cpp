// Fluids of a world: what the host adds and is told.
#include <vector>

#include "base/range_text.h"
#include "psim/limits.h"
#include "world/world_impl.h"

namespace psim {
namespace {

// One line of what is wrong with particles, or empty.
std::string check_particles(const Owners& w, FluidId fluid, std::span<const Vec2> positions,
                            std::span<const Vec2> velocities) {
  if (fluid >= w.fluids.kinds().size()) return "there is no such fluid";
  if (!velocities.empty() && velocities.size() != positions.size()) {
    return "there are " + std::to_string(velocities.size()) + " velocities for " + std::to_string(positions.size()) +
           " particles: one each, or none";
  }
  const std::size_t before = w.fluids.size();
  if (positions.size() > FluidParticles::kMostIds - w.fluids.ids()) return "the world has no ids for more particles";
  if (positions.size() > kMostParticles - before) {
    return "a world has at most " + std::to_string(kMostParticles) + " particles, not " +
           std::to_string(before + positions.size());
  }
  const Bounds& b = w.desc.bounds;
  RangeCheck check;
  for (const Vec2& at : positions) {
    check("a particle's x", at.x, {b.xmin, b.xmax})("a particle's y", at.y, {b.ymin, b.ymax});
    if (!check.error.empty()) return check.error;
  }
  for (const Vec2& v : velocities) {
    check("a particle's velocity", v, limits::kVelocity);
    if (!check.error.empty()) return check.error;
  }
  return {};
}

}  // namespace

FluidId World::add_fluid(const FluidDesc& d, std::string& error) try {
  const FloatSettings settings;
  Owners& w = impl_->settled();
  const FluidKind kind{d.spacing, d.density, d.viscosity, d.surface_tension};
  const bool first = w.fluids.kinds().empty();
  error = check_fluid(kind, first ? kind : w.fluids.kinds()[0], w.desc.bounds, w.desc.boundary);
  if (!error.empty()) return kNoFluid;
  if (first) w.fluids.begin(fluid_space(w.desc.bounds, w.desc.boundary, 2 * d.spacing, {}));
  return w.fluids.add_kind(kind);
} catch (const std::bad_alloc&) {
  say_no_room(*impl_, "the fluid", error);
  return impl_->ran_out(kNoFluid);
}

bool World::add_particles(FluidId fluid, std::span<const Vec2> positions, std::span<const Vec2> velocities,
                          std::string& error) try {
  const FloatSettings settings;
  Owners& w = impl_->settled();
  error = check_particles(w, fluid, positions, velocities);
  if (!error.empty()) return false;
  if (positions.empty()) return true;
  w.fluids.make_room(positions.size());
  w.fluids.lay_corner(w.desc.bounds, positions[0]);
  for (std::size_t k = 0; k < positions.size(); ++k) {
    w.fluids.add(fluid, positions[k], velocities.empty() ? Vec2{} : velocities[k]);
  }
  return true;
} catch (const std::bad_alloc&) {
  say_no_room(*impl_, "the particles", error);
  return impl_->ran_out(false);
}

void World::fluid_particles(std::vector<FluidParticleState>& out) const try {
  const FloatSettings settings;
  impl_->fluids.look(out);
} catch (const std::bad_alloc&) {
  out.clear();
  ran_out_of_memory() = true;
}

FluidReport World::fluid_report() const {
  const FloatSettings settings;
  const FluidCounts c = impl_->fluids.counts();
  const FluidTaps& taps = impl_->fluids.taps();
  return {c.particles,  c.kinetic,    c.density_error_mean, c.density_error_max,
          c.iterations, taps.emitted, taps.drained,         taps.withheld};
}

}  // namespace psim
