#include "fixtures.h"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "psim/scene.h"

namespace psim::bench {

double Random::uniform(double low, double high) {
  std::uint64_t z = (state_ += 0x9E3779B97F4A7C15u);
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return low + (high - low) * static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

Placement scene_placement(const char* scene, std::uint32_t n) {
  std::string error;
  const auto made = make_builtin(scene, n, 1, error);
  auto placed = made ? place_group(made->groups.front(), error) : std::nullopt;
  if (!placed) throw std::runtime_error(error);
  Placement p{std::move(placed->x), std::move(placed->y), std::move(placed->vx), std::move(placed->vy),
              made->world.bounds};
  p.vx.resize(p.x.size());
  p.vy.resize(p.x.size());
  return p;
}

Discs::Discs(const Placement& p, std::uint32_t spare) : lattice(p.bounds, false), count(p.size()) {
  const std::size_t total = kernels::round_up_block(kernels::round_up_block(count) + spare);
  for (Column<std::int32_t>* c : {&pos, &built}) c->reserve(2 * total);
  for (Column<float>* c : {&vel, &vel0, &disp}) c->reserve(2 * total);
  for (Column<float>* c : {&radius, &reach, &rim_speed, &rim_speed0, &event_time, &rim_way}) c->reserve(total);
  linked.reserve(total);
  for (std::uint32_t i = 0; i < count; ++i) {
    const LatticePoint at = lattice.to_lattice({p.x[i], p.y[i]});
    const std::size_t r = 2 * std::size_t{i};
    pos[r] = built[r] = at.x;
    pos[r + 1] = built[r + 1] = at.y;
    disp[r] = at.dx;
    disp[r + 1] = at.dy;
    vel[r] = vel0[r] = static_cast<float>(p.vx[i]);
    vel[r + 1] = vel0[r + 1] = static_cast<float>(p.vy[i]);
    radius[i] = static_cast<float>(kRadius);
    reach[i] = static_cast<float>(1.1 * kRadius);
  }
}

std::uint32_t Discs::blocks() const {
  return static_cast<std::uint32_t>(kernels::round_up_block(count) / kernels::kBlock);
}

kernels::BodyView Discs::view() {
  kernels::BodyView v;
  v.pos = pos.data();
  v.vel = vel.data();
  v.vel0 = vel0.data();
  v.disp = disp.data();
  v.rim_speed = rim_speed.data();
  v.rim_speed0 = rim_speed0.data();
  v.event_time = event_time.data();
  v.rim_way = rim_way.data();
  v.linked = linked.data();
  return v;
}

// Soft contacts with the solver's ratios: frequency 0.16 / h, damping ratio 10.
kernels::ContactParams contact_params(const Lattice& lattice) {
  const double omega = 2 * 3.14159265358979323846 * 0.16 / kStep;
  const double a1 = 2 * 10 + kStep * omega;
  const double a2 = kStep * omega * a1;
  const double a3 = 1 / (1 + a2);
  kernels::ContactParams p;
  p.h = static_cast<float>(kStep);
  p.inv_h = static_cast<float>(1 / kStep);
  p.pitch_x = static_cast<float>(lattice.pitch_x());
  p.pitch_y = static_cast<float>(lattice.pitch_y());
  p.soft_rate = static_cast<float>(a2 * a3 * omega / a1);
  p.soft_mass = static_cast<float>(a2 * a3);
  p.soft_impulse = static_cast<float>(a3);
  p.push = 3;
  p.refresh = 0.02f * static_cast<float>(kRadius);
  p.warm = 1;
  return p;
}

kernels::StreamParams stream_params(const Lattice& lattice) {
  kernels::StreamParams p;
  p.h = static_cast<float>(kStep);
  p.coast = static_cast<float>(4 * kStep);
  p.pitch_x = static_cast<float>(lattice.pitch_x());
  p.pitch_y = static_cast<float>(lattice.pitch_y());
  p.inv_pitch_x = 1 / p.pitch_x;
  p.inv_pitch_y = 1 / p.pitch_y;
  p.speed_limit2 = 1e12f;
  return p;
}

void Saved::keep(Column<float>& column, std::size_t n) {
  parts_.push_back({column.data(), std::vector<float>(column.data(), column.data() + n)});
}

void Saved::restore() const {
  for (const Part& part : parts_) std::copy(part.values.begin(), part.values.end(), part.column);
}

}  // namespace psim::bench
