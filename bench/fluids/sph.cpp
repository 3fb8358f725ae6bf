#include "sph.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace psim::fluids {
namespace {

SphConstants constants_of(const Flow& flow, const SphSettings& s) {
  const double h = s.reach * flow.spacing / 2, sound = s.sound * flow.speed;
  SphConstants k{SphKernel(2 * h), 0, 0, 0, 0, 0, 0, 0, 0};
  k.mass = static_cast<float>(kDensity * flow.spacing * flow.spacing);
  k.sound = static_cast<float>(sound);
  k.gravity_x = static_cast<float>(flow.gravity.x), k.gravity_y = static_cast<float>(flow.gravity.y);
  k.viscosity = static_cast<float>(flow.viscosity);
  k.artificial = static_cast<float>(s.alpha * h * sound);
  k.diffusion = static_cast<float>(s.delta * h * sound);
  k.background = static_cast<float>(kDensity * sound * sound);
  return k;
}

double longest_step_of(const Flow& flow, const SphSettings& s) {
  const double h = s.reach * flow.spacing / 2;
  double step = s.courant * h / ((s.sound + 1) * flow.speed);
  if (flow.viscosity > 0) step = std::min(step, 0.125 * h * h / flow.viscosity);
  const double g = std::hypot(flow.gravity.x, flow.gravity.y);
  return g > 0 ? std::min(step, 0.25 * std::sqrt(h / g)) : step;
}

bool processor_serves() {
#if defined(__GNUC__) && defined(__x86_64__)
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
  return true;
#endif
}

}  // namespace

Sph::Sph(const Flow& flow, const SphSettings& settings)
    : bounds_(flow.bounds),
      transport_(flow.boundary == Boundary::periodic),
      grid_(flow, settings.reach * flow.spacing),
      constants_(constants_of(flow, settings)),
      longest_step_(longest_step_of(flow, settings)) {
  if (!processor_serves()) throw std::runtime_error("smoothed particles need a processor with AVX2");
  const double sound = settings.sound * flow.speed;
  for (std::size_t k = 0; k < flow.places.size(); ++k) {
    const Vec2 place = flow.places[k], velocity = flow.velocities.empty() ? Vec2{} : flow.velocities[k];
    const double strain = flow.pressure ? flow.pressure(place) / (kDensity * sound * sound) : 0;
    particles_.push_back({place.x - bounds_.xmin, place.y - bounds_.ymin, velocity.x, velocity.y, 0, 0, strain, 0, 0, 0,
                          0, static_cast<std::uint32_t>(k)});
  }
  rates_.resize(particles_.size());
  move(0);
  find_forces();
}

void Sph::step(double dt) {
  for (SphParticle& p : particles_) {
    p.vx += dt / 2 * p.ax, p.vy += dt / 2 * p.ay;
    p.drift_x = dt / 2 * p.shift_x, p.drift_y = dt / 2 * p.shift_y;
  }
  if (transport_) {
    move(dt);
  } else {
    // Density is taken over the step with the rate at its middle.
    move(dt / 2);
    find_volumes();
    sum_strain_rates(grid_, constants_, rates_);
    for (std::size_t k = 0; k < particles_.size(); ++k) particles_[k].strain += dt * static_cast<double>(rates_[k]);
    move(dt / 2);
  }
  find_forces();
  for (SphParticle& p : particles_) p.vx += dt / 2 * p.ax, p.vy += dt / 2 * p.ay;
}

void Sph::move(double dt) {
  for (SphParticle& p : particles_) p.x += dt * (p.vx + p.drift_x), p.y += dt * (p.vy + p.drift_y);
  if (grid_.stale(particles_)) grid_.sort(particles_);
  grid_.load(particles_);
}

void Sph::find_volumes() {
  SphColumns& c = grid_.columns;
  const float at_rest = constants_.mass / static_cast<float>(kDensity);
  for (const std::uint32_t i : grid_.slot) c.volume[i] = at_rest / (1 + c.strain[i]);
}

// Pressures of the fluid from its strains, of the walls from the fluid beside them.
void Sph::find_pressures() {
  find_volumes();
  SphColumns& c = grid_.columns;
  for (const std::uint32_t i : grid_.slot) c.pressure[i] = constants_.background * c.strain[i];
  grid_.load_copies();
  sum_wall_pressures(grid_, constants_);
}

void Sph::find_forces() {
  if (transport_) {
    sum_strains(grid_, constants_, rates_);
    for (std::size_t k = 0; k < particles_.size(); ++k) {
      grid_.columns.strain[grid_.slot[k]] = rates_[k];
      particles_[k].strain = static_cast<double>(rates_[k]);
    }
    find_pressures();
    sum_transport_forces(grid_, constants_, particles_);
  } else {
    find_pressures();
    sum_forces(grid_, constants_, particles_);
  }
}

void Sph::sum_densities(std::vector<float>& strains) const {
  strains.resize(particles_.size());
  sum_strains(grid_, constants_, strains);
}

void Sph::look(std::vector<Particle>& out) const {
  out.resize(particles_.size());
  const double stiffness = static_cast<double>(constants_.background);
  for (const SphParticle& p : particles_) {
    out[p.id] = {{p.x + bounds_.xmin, p.y + bounds_.ymin}, {p.vx, p.vy}, stiffness * p.strain};
  }
}

}  // namespace psim::fluids
