#include "fluid/fluids.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/sort_keys.h"
#include "fluid/fluid_equations.h"
#include "fluid/fluid_faces.h"
#include "fluid/fluid_mixture.h"
#include "fluid/fluid_tension.h"
#include "fluid/fluid_transfer.h"
#include "fluid/fluid_viscosity.h"

namespace psim {

using kernels::kTile;
using kernels::kTileFloats;
using kernels::tile_node;
using S = FluidSolver;

namespace {

// How particles take part (docs/decisions/036-fluids.md).
constexpr float kHistory = 1.0f / 3, kCalming = 0.05f, kSpreading = 0.2f;
constexpr float kFullStrain =
    0.05f;  // of a step: with less, particles spread less, so that water at rest stays at rest
// What is left of the equations' right sides is at most this share of the largest.
constexpr float kPressureTolerance = 1e-4f, kEvenTolerance = 1e-2f, kDragTolerance = 1e-5f;
constexpr int kMostIterations = 100;
// Water crosses at most so many cells in a part of a step, or fewer where the mean error of the density is larger than this.
constexpr double kMostCells = 7, kFewerCells = 4, kUnevenMean = 0.015;
constexpr int kMostParts = 8;       // of a step
constexpr double kMostTurn = 0.45;  // rad, of waves of surface tension in a part
// They calm particles in proportion to it: what neighbours do not have in common would feed them.
constexpr double kCalmingByTurn = 2;

// The speed of the fastest capillary waves that the grid shows, rad/s: those of four cells, less what smoothing takes.
double fastest_wave(double tension, double density, const FluidSpace& space) {
  constexpr double kQuarterTurn = 1.5707963267948966, kLeft = 0.3;
  const double k = kQuarterTurn / std::min(space.cell_x, space.cell_y);
  return std::sqrt(kLeft * tension / density * k * k * k);
}

}  // namespace

void Fluids::add(std::uint32_t fluid, Vec2 place, Vec2 velocity) {
  stir();
  fastest_ = std::max({fastest_, static_cast<float>(std::fabs(velocity.x)), static_cast<float>(std::fabs(velocity.y))});
  particles_.add((place.x - space_.left) / space_.cell_x, (place.y - space_.bottom) / space_.cell_y, velocity, fluid,
                 space_);
}

void Fluids::step(double dt, Vec2 gravity, const SolidFinder* finder, bool may_rest, int most_parts) {
  if (kinds_.empty()) return;
  if (!may_rest) stir();
  at_rest_ = stays_at_rest(gravity, finder);
  iterations_ = 0;
  if (at_rest_) return;
  bodies_.begin(finder, kinds_[0].density, dt);
  const int parts = std::min(parts_of(dt, gravity), most_parts > 0 ? most_parts : kMostParts);
  for (int k = 0; k < parts; ++k) {
    dt_ = dt / parts;
    bodies_.begin_part();
    if (particles_.size() > 0) step_part(gravity, k == 0 ? dt : 0);
    bodies_.bear(solver_.grid(), S::kPressure, dt_);
  }
  bodies_.finish();
  last_ = {parts, static_cast<double>(near_.size()), static_cast<double>(with_equations_.size()) * iterations_ / parts,
           bodies_.any()};
  if (may_rest) note_calm(dt, gravity);
}

// A step is taken in parts if water moves far in it: where it is stopped, cells would get too full in one. The fastest
// waves of surface tension turn by less than kMostTurn in a part.
int Fluids::parts_of(double dt, Vec2 gravity) const {
  const double most = error_mean_ > kUnevenMean ? kFewerCells : kMostCells;
  const double speed = double{fastest_} + dt * std::max(std::fabs(gravity.x), std::fabs(gravity.y));
  const double cells = speed * dt / std::min(space_.cell_x, space_.cell_y);
  const double turn = tension_ > 0 ? dt * fastest_wave(tension_, least_density_, space_) : 0;
  const double parts = std::max(cells / most, turn / kMostTurn);
  return parts < kMostParts ? std::max(1, static_cast<int>(std::ceil(parts))) : kMostParts;
}

FluidWork Fluids::work(double dt, Vec2 gravity) const {
  if (particles_.size() == 0 || rests_) return {};
  FluidWork work = last_;
  if (work.tiles == 0) {  // before the first step: tiles that are full of particles, and some iterations
    constexpr double kFullTile = 4 * kTile * kTile, kIterations = 8;
    work.tiles = static_cast<double>(particles_.size()) / kFullTile + 1;
    work.passes = kIterations * work.tiles;
  }
  work.parts = parts_of(dt, gravity);
  return work;
}

void Fluids::step_part(Vec2 gravity, double bodies_moved) {
  FluidGrid& grid = solver_.grid();
  const auto f = [](double a) { return static_cast<float>(a); };
  const double turn = tension_ > 0 ? dt_ * fastest_wave(tension_, least_density_, space_) : 0;
  const float calming = std::min(1.0f, kCalming + f(kCalmingByTurn * turn));
  motion_ = {f(dt_),           f(gravity.x),         f(gravity.y),         kHistory,
             calming,          kSpreading,           1 / kFullStrain,      f(space_.cell_x),
             f(space_.cell_y), f(1 / space_.cell_x), f(1 / space_.cell_y), volume_.data(),
             mass_.data()};
  keep_pressure();
  particles_.move(space_, motion_, kernels_, grid, pool_, bodies_, f(bodies_moved));
  solver_.each_tile([&](std::size_t t) {
    scatter_particles(grid, t, particles_, kernels_, motion_);
    if (densities_) scatter_volumes(grid, t, particles_, volume_);
  });
  solver_.each_tile([&](std::size_t t) {
    sum_up(grid, t);
    if (densities_) find_lightness(grid, t);
    fill_walls(grid, t, space_);
  });
  bodies_.look(grid, space_, dt_, double{kHistory}, pool_);
  find_wet();
  meet_bodies();
  if (viscosity_ > 0) drag();
  solve();
  move_with_grid();
}

// Most tiles of spray have no full cell, so that the work on equations is left out there.
void Fluids::find_wet() {
  FluidGrid& grid = solver_.grid();
  wet_.resize(grid.size());
  solver_.each_tile([&](std::size_t t) {
    wet_[t] = (bodies_.any() && !bodies_.at(t).empty()) || has_full_cell(grid, t, space_) ? 1 : 0;
  });
  with_equations_.clear();
  near_.clear();
  for (std::uint32_t t = 0; t < grid.size(); ++t) {
    if (wet_[t] != 0) with_equations_.push_back(t);
    const auto is_wet = [&](std::uint32_t n) { return n != FluidTile::kNone && wet_[n] != 0; };
    grid.tiles[t].dry = std::ranges::none_of(grid.tiles[t].near, is_wet);
    if (!grid.tiles[t].dry) near_.push_back(t);
  }
  grid.activate(with_equations_);
  solver_.each_of(near_, [&](std::size_t t) { recall_pressure(t); });
}

void Fluids::meet_bodies() {
  if (!bodies_.any()) return;
  FluidGrid& grid = solver_.grid();
  solver_.each_tile([&](std::size_t t) { bodies_.draw(grid, t, space_); });
  solver_.each_tile([&](std::size_t t) { grid.pull_ring(S::kVolume, t); });
  solver_.each_of(near_, [&](std::size_t t) { find_shares(grid, t, space_); });
}

// Particles take what the grid has gained.
void Fluids::move_with_grid() {
  FluidGrid& grid = solver_.grid();
  largest_.assign(grid.size(), 0);
  solver_.each_of(near_, [&](std::size_t t) { largest_[t] = correct_faces(grid, t, space_); });
  fastest_ = *std::max_element(largest_.begin(), largest_.end());
  solver_.each_of(near_, [&](std::size_t t) { pull_faces(grid, t, viscosity_ > 0); });
  solver_.each_of(near_, [&](std::size_t t) { extend_faces(grid, t, viscosity_ > 0); });
  if (bodies_.any()) {
    solver_.each_of(near_, [&](std::size_t t) { find_slip(grid, t); });
    solver_.each_of(near_, [&](std::size_t t) { set_slip(grid, t); });
  }
  hits_.resize(grid.size());
  solver_.each_tile([&](std::size_t t) {
    const FluidTile& tile = grid.tiles[t];
    const std::span<const FluidSolid> solids = bodies_.at(t);
    std::vector<Place2> from;
    for (std::uint32_t k = 0; k < tile.count && !solids.empty(); ++k) {
      const kernels::FluidParticle& p = particles_.data()[tile.first + k];
      from.push_back({p.x, p.y});
    }
    gather_particles(grid, t, particles_, kernels_, motion_, viscosity_ > 0);
    hits_[t].clear();
    if (!solids.empty()) particles_.keep_out(tile, solids, from, mass_.data(), space_, bodies_, hits_[t]);
  });
  for (const std::vector<FluidHits>& hits : hits_) bodies_.take_hits(hits, space_.cell_x * space_.cell_y);
}

// The pressure of a step is the first guess of the next one, in the same cells.
void Fluids::keep_pressure() {
  const FluidGrid& grid = solver_.grid();
  old_keys_.clear();
  old_pressure_.reserve_loosely(grid.size() * kTileFloats);
  for (std::size_t t = 0; t < grid.size(); ++t) {
    if (grid.tiles[t].dry) continue;
    const float* diagonal = grid.field(S::kDiagonal, t);
    if (std::none_of(diagonal, diagonal + kTileFloats, [](float d) { return d > 0; })) continue;
    std::copy_n(grid.field(S::kPressure, t), kTileFloats, old_pressure_.data() + old_keys_.size() * kTileFloats);
    old_keys_.push_back(grid.keys[t]);
  }
}

void Fluids::recall_pressure(std::size_t t) {
  FluidGrid& grid = solver_.grid();
  const auto at = std::ranges::lower_bound(old_keys_, grid.keys[t]);
  float* pressure = grid.field(S::kPressure, t);
  if (at != old_keys_.end() && *at == grid.keys[t]) {
    const auto old = static_cast<std::size_t>(at - old_keys_.begin());
    std::copy_n(old_pressure_.data() + old * kTileFloats, kTileFloats, pressure);
  } else {
    std::fill_n(pressure, kTileFloats, 0.0f);
  }
}

void Fluids::drag() {
  FluidGrid& grid = solver_.grid();
  const Viscosity by = {.by_x = dt_ * viscosity_ / (space_.cell_x * space_.cell_x),
                        .by_y = dt_ * viscosity_ / (space_.cell_y * space_.cell_y),
                        .per_x = static_cast<float>(1 / space_.cell_x),
                        .per_y = static_cast<float>(1 / space_.cell_y),
                        .held = bodies_.any() || space_.boundary == Boundary::walls};
  solver_.each_of(near_, [&](std::size_t t) { make_equations(grid, t, space_, bodies_.any(), densities_); });
  grid.activate(near_);  // faces beside a full cell may be those of the next tile
  largest_.assign(grid.size(), 0);
  std::vector<std::vector<FluidHold>> holds(grid.size());  // by tile
  const double cell = kinds_[0].density * space_.cell_x * space_.cell_y;
  for (const Component of : {Component::u, Component::v}) {
    solver_.each_of(near_, [&](std::size_t t) {
      largest_[t] = make_viscous_equations(grid, t, space_, by, of, bodies_, holds[t]);
    });
    HeldBodies held(holds, of, bodies_, cell);
    held.begin(grid);
    solver_.coarsen(space_);
    solver_.solve(S::kEven, S::kUneven, kDragTolerance * *std::max_element(largest_.begin(), largest_.end()),
                  kMostIterations, held.any() ? &held : nullptr);
    solver_.each_of(near_, [&](std::size_t t) { drag_faces(grid, t, by, of); });
    held.bear(grid, by);
  }
  grid.activate(with_equations_);
}

// Pressure at the surface, in kShiftV. Returns whether there is some.
bool Fluids::draw_together() {
  if (!(tension_ > 0)) return false;
  FluidGrid& grid = solver_.grid();
  const double density = kinds_[0].density;
  // Particles keep a share of what pressure gave; the history would give the same again.
  const double jump = (1 - double{kHistory}) * dt_ * steady_tension() / density;
  const SurfaceTension by = {static_cast<float>(jump), kinds_.size() > 1, static_cast<float>(space_.cell_x),
                             static_cast<float>(space_.cell_y)};
  if (by.by_fluid) {
    solver_.each_tile([&](std::size_t t) { scatter_amount(grid, t, particles_, tensions_, Nodes::middle, S::kWay); });
    solver_.each_tile([&](std::size_t t) { add_spills(grid, t, S::kWay); });
  }
  solver_.each_of(near_, [&](std::size_t t) { show_shares(grid, t, space_, bodies_.any()); });
  solver_.each_of(near_, [&](std::size_t t) { smooth_share(grid, t, S::kGainU, S::kShiftU); });
  solver_.each_of(near_, [&](std::size_t t) { smooth_share(grid, t, S::kShiftU, S::kShiftV); });
  if (bodies_.any()) {
    solver_.each_of(near_, [&](std::size_t t) { find_slopes(grid, t, by); });
    pull_bodies(grid, near_, bodies_);
  }
  solver_.each_of(near_, [&](std::size_t t) { find_curvature(grid, t, by); });
  solver_.each_of(near_, [&](std::size_t t) { find_surface_pressure(grid, t, by); });
  return true;
}

// The largest surface tension, or less where even parts of a step are too long for the waves that it makes.
double Fluids::steady_tension() const {
  const double turn = dt_ * fastest_wave(tension_, least_density_, space_);
  return turn <= kMostTurn ? tension_ : tension_ * (kMostTurn / turn) * (kMostTurn / turn);
}

void Fluids::solve() {
  FluidGrid& grid = solver_.grid();
  const bool tension = draw_together();
  surveys_.assign(grid.size(), FluidSurvey());
  solver_.each_of(near_, [&](std::size_t t) {
    surveys_[t] = make_equations(grid, t, space_, bodies_.any(), densities_, tension);
    // In a cell without an equation pressure is that of the surface, or none.
    const float *diagonal = grid.field(S::kDiagonal, t), *known = grid.field(S::kShiftV, t);
    float* pressure = grid.field(S::kPressure, t);
    for (std::size_t n = 0; n < kTileFloats; ++n) {
      if (diagonal[n] <= 0) {
        pressure[n] = tension ? known[n] : 0;
      } else {
        surveys_[t].pressure += double{pressure[n]};
      }
    }
    std::fill_n(grid.field(S::kEven, t), kTileFloats, 0.0f);
  });
  FluidSurvey all;
  for (const FluidSurvey& s : surveys_) {
    all.error += s.error;
    all.worst = std::max(all.worst, s.worst);
    all.cells += s.cells;
    all.largest = std::max(all.largest, s.largest);
    all.largest_even = std::max(all.largest_even, s.largest_even);
    all.uneven += s.uneven;
    all.pressure += s.pressure;
    all.full += s.full;
    all.surface = all.surface || s.surface;
  }
  if (!all.surface && all.full > 0) {
    // Nothing bounds the means there: one of the displacement asks for what cannot be, and that of the pressure would grow.
    const auto uneven = static_cast<float>(all.uneven / all.full),
               pressure = static_cast<float>(all.pressure / all.full);
    solver_.each_of(near_, [&](std::size_t t) {
      take_mean_out(grid, t, S::kUneven, uneven);
      take_mean_out(grid, t, S::kPressure, pressure);
    });
  }
  if (bodies_.any()) {
    if (!all.surface) bodies_.close_surfaces(grid);
    largest_.assign(grid.size(), 0);
    solver_.each_of(near_, [&](std::size_t t) { largest_[t] = bodies_.add_motion(grid, t); });
    all.largest = *std::max_element(largest_.begin(), largest_.end());
  }
  error_mean_ = all.cells == 0 ? 0 : all.error / all.cells;
  error_max_ = static_cast<double>(all.worst);
  solver_.coarsen(space_);
  const int first = solver_.solve(S::kPressure, S::kRight, kPressureTolerance * all.largest, kMostIterations,
                                  bodies_.any_moving() ? &bodies_ : nullptr);
  if (bodies_.any()) {
    // The coarser levels only guess, and stay those of the pressure.
    solver_.each_of(near_, [&](std::size_t t) {
      if (!bodies_.at(t).empty()) soften(grid, t);
    });
  }
  const int second = solver_.solve(S::kEven, S::kUneven, kEvenTolerance * all.largest_even, kMostIterations);
  iterations_ += static_cast<std::uint32_t>(first + second);
}

FluidCounts Fluids::counts() const {
  FluidCounts c;
  c.particles = particles_.size();
  for (std::size_t k = 0; k < particles_.size(); ++k) {
    const kernels::FluidParticle& p = particles_.data()[k];
    const FluidKind& kind = kinds_[p.fluid];
    const Vec2 v = {double{p.u}, double{p.v}};
    c.kinetic += 0.5 * kind.density * kind.spacing * kind.spacing * (v.x * v.x + v.y * v.y);
  }
  c.density_error_mean = error_mean_;
  c.density_error_max = error_max_;
  c.iterations = iterations_;
  return c;
}

double Fluids::pressure_unit() const { return dt_ > 0 ? kinds_[0].density / dt_ / (1 - double{kHistory}) : 0; }

std::uint64_t Fluids::hash(std::uint64_t before) const {
  struct Moving {
    Vec2 place, velocity;
  };
  std::vector<Moving> seen;
  std::vector<std::uint64_t> order;  // of ids, with places in `seen`
  seen.reserve(particles_.size());
  order.reserve(particles_.size());
  particles_.each(solver_.grid(), [&](const kernels::FluidParticle& p, const FluidTile& tile, std::uint32_t) {
    order.push_back(std::uint64_t{p.id} << 32 | seen.size());
    seen.push_back({FluidParticles::place_of(p, tile, space_), {double{p.u}, double{p.v}}});
  });
  sort_by_upper_half(order);
  std::uint64_t hash = before;
  const auto mix = [&hash](std::uint64_t value) { hash = mixed(hash * 0x9E3779B97F4A7C15u + value); };
  // Adding zero makes -0 the same as 0. All NaN are alike.
  const auto mix_number = [&mix](double value) {
    mix(value == value ? std::bit_cast<std::uint64_t>(value + 0.0) : 0x7FF8000000000000u);
  };
  for (const std::uint64_t key : order) {
    const Moving& p = seen[key & 0xFFFFFFFFu];
    mix(key >> 32);
    for (const double value : {p.place.x, p.place.y, p.velocity.x, p.velocity.y}) mix_number(value);
  }
  for (const FluidEmitter& e : taps_.emitters) {
    mix(e.id);
    for (const double value : {e.desc.speed, e.age, e.rows}) mix_number(value);
  }
  return hash;
}

void Fluids::clear() {
  kinds_.clear();
  volume_.clear();
  mass_.clear();
  tensions_.clear();
  viscosity_ = tension_ = least_density_ = 0;
  densities_ = false;
  particles_.clear();
  taps_ = {};
  bodies_.clear();
  space_ = FluidSpace();
  solver_.grid().lay({}, space_, 0);
  dt_ = error_mean_ = error_max_ = 0;
  fastest_ = 0;
  stir();
  at_rest_ = false;
  last_ = {};
  iterations_ = 0;
}

}  // namespace psim
