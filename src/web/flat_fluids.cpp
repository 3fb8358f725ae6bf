// Fluids for JavaScript: the particles of a world as columns.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "flat.h"
#include "handle.h"
#include "psim/fluid.h"

namespace {

/// The particles that were asked for last, of whichever world. All worlds of the module share the columns, because
/// JavaScript may look at them until its next call only. They keep the memory of the largest fluid.
struct Columns {
  std::vector<psim::FluidParticleState> particles;
  std::vector<std::uint32_t> id, fluid;
  std::vector<double> x, y, vx, vy, density, pressure;

  void fill() {
    const std::size_t count = particles.size();
    for (auto* column : {&id, &fluid}) column->resize(count);
    for (auto* column : {&x, &y, &vx, &vy, &density, &pressure}) column->resize(count);
    for (std::size_t k = 0; k < count; ++k) {
      const psim::FluidParticleState& p = particles[k];
      id[k] = p.id, fluid[k] = p.fluid;
      x[k] = p.position.x, y[k] = p.position.y, vx[k] = p.velocity.x, vy[k] = p.velocity.y;
      density[k] = p.density, pressure[k] = p.pressure;
    }
  }
};

}  // namespace

/// out: count, then the addresses of id, fluid, x, y, vx, vy, density, pressure, in the order of ids.
PSIM_FLAT int psim_flat_fluid_particles(const psim_world* world, std::uintptr_t* out) {
  static Columns columns;
  return psim::capi::guarded(
      world, "fluid_particles", [&](const psim::World& w, const psim::capi::Call&) -> psim_result {
        w.fluid_particles(columns.particles);
        columns.fill();
        *out++ = columns.particles.size();
        for (const auto* column : {&columns.id, &columns.fluid}) {
          *out++ = reinterpret_cast<std::uintptr_t>(column->data());
        }
        for (const auto* column :
             {&columns.x, &columns.y, &columns.vx, &columns.vy, &columns.density, &columns.pressure}) {
          *out++ = reinterpret_cast<std::uintptr_t>(column->data());
        }
        return PSIM_OK;
      });
}
