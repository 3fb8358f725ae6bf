// Fluids: what they are made of, their particles in the order of the tiles, and the fields of the last step that the
// next one begins with or that the host may ask for.
#include <algorithm>
#include <cmath>

#include "base/sort_keys.h"
#include "fluid/fluids.h"
#include "psim/fluid.h"
#include "psim/limits.h"
#include "state/describe_calls.h"

namespace psim {

static auto fields(FluidKind& k) { return std::tie(k.spacing, k.density, k.viscosity, k.tension); }

// Whether a tile of the grid may have this key: its cells are in the world and can be counted in 32 bits.
static bool is_tile(std::uint64_t key, const FluidSpace& space) {
  constexpr std::int32_t kFarthest = 1 << 26;
  const std::int32_t x = column_of(key), y = row_of(key);
  if (space.boundary == Boundary::open) return std::abs(x) < kFarthest && std::abs(y) < kFarthest;
  return x >= 0 && y >= 0 && x <= (space.cells_x - 1) / kernels::kTile && y <= (space.cells_y - 1) / kernels::kTile;
}

void FluidParticles::describe(Archive& a, FluidGrid& grid, const FluidSpace& space, std::size_t kinds) {
  using P = kernels::FluidParticle;
  std::vector<std::uint64_t> keys = grid.keys;
  std::vector<std::uint32_t> counts;
  for (const FluidTile& tile : grid.tiles) counts.push_back(tile.count);
  values(a, count_, next_id_);
  a.packed(keys);
  a.packed(counts, std::uint64_t{count_} + 1);
  a.packed(added_);
  if (a.loading()) {
    a.require(counts.size() == keys.size() && added_.size() <= count_ && next_id_ >= count_);
    a.require(count_ <= kMostParticles && a.fits(count_));
    for (std::size_t t = 0; t < keys.size(); ++t) {
      a.require(is_tile(keys[t], space) && (t == 0 || keys[t - 1] < keys[t]));
    }
    for (const std::uint64_t key : added_) a.require(is_tile(key, space));
    if (!a.ok()) return clear();
    grid.lay(keys, space, 0);
    list_.reserve(count_);
    std::uint64_t first = 0;
    for (std::size_t t = 0; t < grid.size(); ++t) {
      grid.tiles[t].first = static_cast<std::uint32_t>(first);
      grid.tiles[t].count = counts[t];
      first += counts[t];
    }
    a.require(first + added_.size() == count_);
    if (!a.ok()) return clear();
  }
  columns(a, std::span(list_.data(), count_), &P::x, &P::y, &P::u, &P::v, &P::push_x, &P::push_y, &P::ux, &P::uy,
          &P::vx, &P::vy, &P::id, &P::fluid);
  if (!a.loading() || !a.ok()) return;
  std::vector<std::uint32_t> ids(count_);
  for (std::size_t k = 0; k < count_; ++k) {
    const P& p = list_[k];
    a.require(p.fluid < kinds && p.id < next_id_);
    ids[k] = p.id;
  }
  psim::sort_keys(ids.begin(), ids.end());
  a.require(std::adjacent_find(ids.begin(), ids.end()) == ids.end());
}

static auto fields(FluidForce& f) {
  return std::tie(f.id, f.generation, f.force, f.torque, f.slow, f.asleep, f.stir_force, f.stir_torque, f.rest_force,
                  f.rest_torque);
}

// What a step needs of the one before: forces. Impulses have been given.
void FluidBodies::describe(Archive& a) {
  values(a, forces_);
  if (!a.loading()) return;
  for (std::size_t k = 0; k < forces_.size(); ++k) {
    a.require(k == 0 || forces_[k - 1].id < forces_[k].id);
    a.require(std::isfinite(forces_[k].force.x) && std::isfinite(forces_[k].force.y) &&
              std::isfinite(forces_[k].torque));
  }
}

static auto fields(FluidEmitter& e) { return std::tie(e.id, e.desc, e.age, e.rows, e.emitted); }
static auto fields(FluidDrain& d) { return std::tie(d.id, d.region); }

static void describe_taps(Archive& a, FluidTaps& t, std::size_t fluids, const Bounds& bounds) {
  values(a, t.emitters, t.drains, t.next_emitter, t.next_drain, t.emitted, t.drained, t.withheld);
  if (!a.loading()) return;
  a.require(t.emitters.size() <= kMostEmitters && t.drains.size() <= kMostDrains);
  for (std::size_t k = 0; k < t.emitters.size() && a.ok(); ++k) {
    const FluidEmitter& e = t.emitters[k];
    a.require(e.id < t.next_emitter && (k == 0 || t.emitters[k - 1].id < e.id));
    a.require(check_emitter(e.desc, fluids, bounds).empty());
    a.require(e.age >= 0 && std::isfinite(e.age) && e.rows >= 0 && e.rows < 1 && e.emitted <= e.desc.limit);
  }
  for (std::size_t k = 0; k < t.drains.size() && a.ok(); ++k) {
    const FluidDrain& d = t.drains[k];
    a.require(d.id < t.next_drain && (k == 0 || t.drains[k - 1].id < d.id) && check_drain(d.region).empty());
  }
  if (!a.ok()) t = {};
}

void Fluids::describe_kinds(Archive& a, const Bounds& bounds, Boundary boundary) {
  std::vector<FluidKind> kinds = kinds_;
  Vec2 corner{space_.left, space_.bottom};
  values(a, kinds, corner);
  if (!a.loading()) return;
  clear();
  a.require(std::fabs(corner.x) <= 2 * limits::kCoordinate.max && std::fabs(corner.y) <= 2 * limits::kCoordinate.max);
  for (const FluidKind& kind : kinds) {
    a.require(check_fluid(kind, kinds[0], bounds, boundary).empty());
    if (!a.ok()) return;
    if (kinds_.empty()) begin(fluid_space(bounds, boundary, 2 * kind.spacing, corner));
    add_kind(kind);
  }
}

void Fluids::describe(Archive& a, const Bounds& bounds, Boundary boundary) {
  describe_kinds(a, bounds, boundary);
  if (!a.ok()) return;
  describe_taps(a, taps_, kinds_.size(), bounds);  // drains need no fluid
  if (!a.ok() || kinds_.empty()) return;
  FluidGrid& grid = solver_.grid();
  particles_.describe(a, grid, space_, kinds_.size());
  values(a, dt_, error_mean_, error_max_, iterations_, fastest_, calm_, rests_, calm_gravity_, calm_among_, last_.parts,
         last_.tiles, last_.passes, last_.bodies);
  bodies_.describe(a);
  a.require(dt_ >= 0 && dt_ <= limits::kTimeStep.max && fastest_ >= 0 && calm_ >= 0 && last_.tiles >= 0 &&
            last_.passes >= 0);
  for (std::size_t t = 0; t < grid.size() && a.ok(); ++t) {
    for (const auto f : {FluidSolver::kPressure, FluidSolver::kDiagonal, FluidSolver::kError}) {
      float* field = grid.field(f, t);
      if (grid.tiles[t].dry) std::fill_n(field, kernels::kTileFloats, 0.0f);
      a.packed(kernels::kTileFloats, [&](std::size_t n) -> float& { return field[n]; });
    }
  }
  if (!a.ok()) clear();
}

}  // namespace psim
