// Fluids that lie still, and the bodies in them.
#include <algorithm>
#include <bit>
#include <cmath>

#include "base/sort_keys.h"
#include "fluid/fluids.h"

namespace psim {

using kernels::kTile;

namespace {

// Water is calm while nothing in it is faster than the first share of sqrt(gravity spacing), and all on the mean (rms) no
// faster than the second. It rests if it was calm for so many seconds, and for as long as half a period of its slowest wave:
// all waves stand still twice in a period. What is viscous creeps: of it no more than kViscous of these speeds is calm.
constexpr double kCalmFastest = 0.1, kCalmMean = 0.02, kRestTime = 0.5, kViscous = 0.1;

}  // namespace

void FluidBodies::look_again(const SolidFinder* finder, std::span<const std::uint64_t> keys, const FluidSpace& space,
                             WorkerPool& pool) {
  begin_part();
  finder_ = finder != nullptr && finder->any() ? finder : nullptr;
  if (finder_ != nullptr) find(keys, space, pool);
}

std::optional<std::uint64_t> FluidBodies::surroundings() {
  std::uint64_t hash = 0;
  const auto mix = [&hash](std::uint64_t value) { hash = mixed(hash * 0x9E3779B97F4A7C15u + value); };
  for (const FluidBody& b : bodies_) {
    if (b.moves) return std::nullopt;
    mix(std::uint64_t{b.id} << 32 | b.generation);
  }
  for (std::size_t t = 0; t < solids_.size(); ++t) {
    for (const FluidSolid& s : solids_.at(t)) {
      mix(t);
      mix(std::uint64_t{s.body} << 32 | s.order);
      mix(std::bit_cast<std::uint32_t>(s.radius));
      for (std::size_t k = 0; k < static_cast<std::size_t>(s.count); ++k) {
        mix(std::uint64_t{std::bit_cast<std::uint32_t>(s.x[k])} << 32 | std::bit_cast<std::uint32_t>(s.y[k]));
      }
    }
  }
  return hash;
}

void FluidBodies::lay_down(std::uint32_t id) {
  const auto at = std::ranges::lower_bound(forces_, id, {}, &FluidForce::id);
  if (at == forces_.end() || at->id != id) return;
  at->asleep = true;
  at->stir_force = {};
  at->stir_torque = 0;
  at->rest_force = at->force;
  at->rest_torque = at->torque;
}

void FluidBodies::forget_impulses() {
  for (FluidForce& f : forces_) f.impulse = {}, f.spin_impulse = 0;
}

// Half a period of the slowest wave that may be in the box of all tiles, s: of shallow water, 2 length / sqrt(g depth).
double Fluids::half_a_wave(double gravity) const {
  const FluidGrid& grid = solver_.grid();
  std::int32_t left = 0, right = 0, low = 0, high = 0;
  for (std::size_t t = 0; t < grid.size(); ++t) {
    const FluidTile& tile = grid.tiles[t];
    left = t == 0 ? tile.x : std::min(left, tile.x);
    right = t == 0 ? tile.x : std::max(right, tile.x);
    low = t == 0 ? tile.y : std::min(low, tile.y);
    high = t == 0 ? tile.y : std::max(high, tile.y);
  }
  const double wide = kTile * space_.cell_x * (right - left + 1.0), tall = kTile * space_.cell_y * (high - low + 1.0);
  return std::max(wide, tall) / std::sqrt(gravity * std::min(wide, tall));
}

bool Fluids::stays_at_rest(Vec2 gravity, const SolidFinder* finder) {
  if (!rests_) return false;
  bodies_.look_again(finder, solver_.grid().keys, space_, pool_);
  if (gravity == calm_gravity_ && bodies_.surroundings() == calm_among_) return true;
  stir();
  return false;
}

// The water lies still from now on.
void Fluids::lay_down() {
  rests_ = true;
  bodies_.forget_impulses();
  for (std::size_t k = 0; k < particles_.size(); ++k) {
    kernels::FluidParticle& p = particles_.data()[k];
    p.u = p.v = p.ux = p.uy = p.vx = p.vy = 0;
  }
}

void Fluids::note_calm(double dt, Vec2 gravity) {
  const double g = std::max(std::fabs(gravity.x), std::fabs(gravity.y));
  const double unit = g * kinds_[0].spacing * (viscosity_ > 0 ? kViscous * kViscous : 1);
  const double limit = kCalmFastest * kCalmFastest * unit;
  double fastest = double{fastest_} * double{fastest_}, sum = 0;  // of squares
  for (std::size_t k = 0; k < particles_.size() && fastest < limit; ++k) {
    const Vec2 v{double{particles_.data()[k].u}, double{particles_.data()[k].v}};
    fastest = std::max(fastest, dot(v, v));
    sum += dot(v, v);
  }
  const bool slow = fastest < limit && sum < kCalmMean * kCalmMean * unit * static_cast<double>(particles_.size());
  const std::optional<std::uint64_t> among = slow ? bodies_.surroundings() : std::nullopt;
  const bool same = among == calm_among_ && gravity == calm_gravity_;
  calm_ = among && same ? calm_ + dt : 0;
  calm_among_ = among.value_or(0);
  calm_gravity_ = gravity;
  if (calm_ >= kRestTime && calm_ >= half_a_wave(g)) lay_down();
}

}  // namespace psim
