#include "model/fluid_look.h"

#include <utility>

namespace psim::view {

FluidPlaces take_fluids(const World& world, const Scene& scene) {
  if (scene.fluids.empty()) return {};
  auto look = std::make_shared<FluidLook>();
  look->fluids.resize(scene.fluids.size());
  for (std::size_t k = 0; k < scene.fluids.size(); ++k) look->fluids[k].spacing = scene.fluids[k].fluid.spacing;
  std::vector<FluidParticleState> particles;
  world.fluid_particles(particles);
  for (const FluidParticleState& p : particles) {
    if (p.fluid >= look->fluids.size()) continue;
    FluidRows& rows = look->fluids[p.fluid];
    rows.place.push_back(p.position);
    rows.velocity.push_back(p.velocity);
    rows.pressure.push_back(p.pressure);
    ++look->particles;
  }
  return look;
}

void carry_fluids(const FluidLook& look, Scene& scene) {
  for (std::size_t k = 0; k < scene.fluids.size() && k < look.fluids.size(); ++k) {
    const FluidRows& rows = look.fluids[k];
    FluidList list;
    for (std::size_t row = 0; row < rows.place.size(); ++row) {
      list.x.push_back(rows.place[row].x);
      list.y.push_back(rows.place[row].y);
      list.vx.push_back(rows.velocity[row].x);
      list.vy.push_back(rows.velocity[row].y);
    }
    scene.fluids[k].place = std::move(list);
  }
}

}  // namespace psim::view
