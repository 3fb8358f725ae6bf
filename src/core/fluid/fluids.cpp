#include "fluid/fluids.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/range_text.h"
#include "base/sort_keys.h"
#include "fluid/fluid_equations.h"
#include "fluid/fluid_transfer.h"
#include "fluid/fluid_viscosity.h"
#include "psim/limits.h"

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

}  // namespace

std::string check_fluid(const FluidKind& kind, const FluidKind& first, const Bounds& bounds, Boundary boundary) {
  RangeCheck check;
  check("a fluid's spacing", kind.spacing, limits::kSpacing)("a fluid's density", kind.density, limits::kDensity);
  check("a fluid's viscosity", kind.viscosity, limits::kViscosity);
  if (!check.error.empty()) return check.error;
  if (kind.spacing > first.spacing) {
    return "a fluid's spacing must be at most that of the first fluid, " + exact_text(first.spacing) + " m, not " +
           exact_text(kind.spacing);
  }
  const double width = bounds.xmax - bounds.xmin, height = bounds.ymax - bounds.ymin;
  const bool open = boundary == Boundary::open;
  // Cells are counted in 32 bits, and within walls also in floats.
  const double most = open ? 0x1p29 : 0x1p23, least = open ? 0 : boundary == Boundary::walls ? 1 : 8;
  const double largest = std::max(width, height) / first.spacing, smallest = std::min(width, height) / first.spacing;
  if (largest <= most && smallest >= least) return {};
  return "a fluid's spacing must be " + exact_text(std::max(width, height) / most) +
         (least > 0 ? " to " + exact_text(std::min(width, height) / least) : " or more") +
         " m in a world of these bounds, not " + exact_text(first.spacing);
}

std::uint32_t Fluids::add_kind(const FluidKind& kind) {
  kinds_.reserve(kinds_.size() + 1);
  volume_.reserve(kinds_.size() + 1);
  mass_.reserve(kinds_.size() + 1);
  kinds_.push_back(kind);
  viscosity_ = std::max(viscosity_, kind.viscosity);
  const double share = kind.spacing * kind.spacing / (space_.cell_x * space_.cell_y);
  volume_.push_back(static_cast<float>(share));
  mass_.push_back(static_cast<float>(share * kind.density / kinds_[0].density));
  return static_cast<std::uint32_t>(kinds_.size() - 1);
}

void Fluids::add(std::uint32_t fluid, Vec2 place, Vec2 velocity) {
  particles_.add((place.x - space_.left) / space_.cell_x, (place.y - space_.bottom) / space_.cell_y, velocity, fluid,
                 space_);
}

void Fluids::step(double dt, Vec2 gravity, const SolidFinder* finder) {
  if (particles_.size() == 0) return bodies_.clear();
  FluidGrid& grid = solver_.grid();
  const auto f = [](double a) { return static_cast<float>(a); };
  motion_ = {f(dt),
             f(gravity.x),
             f(gravity.y),
             kHistory,
             kCalming,
             kSpreading,
             1 / kFullStrain,
             f(space_.cell_x),
             f(space_.cell_y),
             f(1 / space_.cell_x),
             f(1 / space_.cell_y),
             volume_.data(),
             mass_.data()};
  dt_ = dt;
  bodies_.begin(finder, kinds_[0].density);
  keep_pressure();
  particles_.move(space_, motion_, kernels_, grid, pool_, bodies_);
  recall_pressure();
  solver_.each_tile([&](std::size_t t) { scatter_particles(grid, t, particles_, kernels_, motion_); });
  solver_.each_tile([&](std::size_t t) {
    sum_up(grid, t);
    fill_walls(grid, t, space_);
  });
  meet_bodies();
  if (viscosity_ > 0) drag();
  solve();
  bodies_.bear(grid, S::kPressure, dt);
  move_with_grid();
}

void Fluids::meet_bodies() {
  bodies_.look(solver_.grid(), space_, dt_, double{kHistory}, pool_);
  if (!bodies_.any()) return;
  FluidGrid& grid = solver_.grid();
  solver_.each_tile([&](std::size_t t) { bodies_.draw(grid, t, space_); });
  solver_.each_tile([&](std::size_t t) { grid.pull_ring(S::kVolume, t); });
  solver_.each_tile([&](std::size_t t) { find_shares(grid, t, space_); });
}

// Particles take what the grid has gained.
void Fluids::move_with_grid() {
  FluidGrid& grid = solver_.grid();
  solver_.each_tile([&](std::size_t t) { correct_faces(grid, t, space_); });
  solver_.each_tile([&](std::size_t t) { pull_faces(grid, t, viscosity_ > 0); });
  solver_.each_tile([&](std::size_t t) { extend_faces(grid, t, viscosity_ > 0); });
  if (bodies_.any()) {
    solver_.each_tile([&](std::size_t t) { find_slip(grid, t); });
    solver_.each_tile([&](std::size_t t) { set_slip(grid, t); });
  }
  solver_.each_tile([&](std::size_t t) {
    const FluidTile& tile = grid.tiles[t];
    const std::span<const FluidSolid> solids = bodies_.at(t);
    std::vector<Place2> from;
    for (std::uint32_t k = 0; k < tile.count && !solids.empty(); ++k) {
      const kernels::FluidParticle& p = particles_.data()[tile.first + k];
      from.push_back({p.x, p.y});
    }
    gather_particles(grid, t, particles_, kernels_, motion_, viscosity_ > 0);
    if (!solids.empty()) particles_.keep_out(tile, solids, from, 0, space_, bodies_);
  });
}

// The pressure of a step is the first guess of the next one, in the same cells.
void Fluids::keep_pressure() {
  const FluidGrid& grid = solver_.grid();
  old_keys_.assign(grid.keys.begin(), grid.keys.end());
  old_pressure_.reserve_loosely(old_keys_.size() * kTileFloats);
  for (std::size_t t = 0; t < old_keys_.size(); ++t) {
    std::copy_n(grid.field(S::kPressure, t), kTileFloats, old_pressure_.data() + t * kTileFloats);
  }
}

void Fluids::recall_pressure() {
  FluidGrid& grid = solver_.grid();
  solver_.each_tile([&](std::size_t t) {
    const auto at = std::ranges::lower_bound(old_keys_, grid.keys[t]);
    float* pressure = grid.field(S::kPressure, t);
    if (at != old_keys_.end() && *at == grid.keys[t]) {
      const auto old = static_cast<std::size_t>(at - old_keys_.begin());
      std::copy_n(old_pressure_.data() + old * kTileFloats, kTileFloats, pressure);
    } else {
      std::fill_n(pressure, kTileFloats, 0.0f);
    }
  });
}

void Fluids::drag() {
  FluidGrid& grid = solver_.grid();
  const Viscosity by = {dt_ * viscosity_ / (space_.cell_x * space_.cell_x),
                        dt_ * viscosity_ / (space_.cell_y * space_.cell_y)};
  solver_.each_tile([&](std::size_t t) { make_equations(grid, t, space_, bodies_.any()); });
  largest_.resize(grid.size());
  for (const Component of : {Component::u, Component::v}) {
    solver_.each_tile(
        [&](std::size_t t) { largest_[t] = make_viscous_equations(grid, t, space_, by, of, bodies_.any()); });
    solver_.coarsen(space_);
    solver_.solve(S::kEven, S::kUneven, kDragTolerance * *std::max_element(largest_.begin(), largest_.end()),
                  kMostIterations);
    solver_.each_tile([&](std::size_t t) { drag_faces(grid, t, by, of); });
  }
}

void Fluids::solve() {
  FluidGrid& grid = solver_.grid();
  surveys_.resize(grid.size());
  solver_.each_tile([&](std::size_t t) {
    surveys_[t] = make_equations(grid, t, space_, bodies_.any());
    // A cell without an equation is a place without pressure.
    const float* diagonal = grid.field(S::kDiagonal, t);
    float* pressure = grid.field(S::kPressure, t);
    for (std::size_t n = 0; n < kTileFloats; ++n) {
      if (diagonal[n] <= 0) pressure[n] = 0;
    }
    std::fill_n(grid.field(S::kEven, t), kTileFloats, 0.0f);
    if (bodies_.any()) surveys_[t].largest = bodies_.add_motion(grid, t);
  });
  FluidSurvey all;
  for (const FluidSurvey& s : surveys_) {
    all.error += s.error;
    all.worst = std::max(all.worst, s.worst);
    all.cells += s.cells;
    all.largest = std::max(all.largest, s.largest);
    all.largest_even = std::max(all.largest_even, s.largest_even);
  }
  error_mean_ = all.cells == 0 ? 0 : all.error / all.cells;
  error_max_ = static_cast<double>(all.worst);
  solver_.coarsen(space_);
  const int first = solver_.solve(S::kPressure, S::kRight, kPressureTolerance * all.largest, kMostIterations,
                                  bodies_.any_moving() ? &bodies_ : nullptr);
  const int second = solver_.solve(S::kEven, S::kUneven, kEvenTolerance * all.largest_even, kMostIterations);
  iterations_ = static_cast<std::uint32_t>(first + second);
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

namespace {

// A field at a place in a tile by the kernel, from the full cells alone, of each what its value and its slope say.
double value_beside(const FluidGrid& grid, std::size_t tile, S::Field f, double x, double y) {
  constexpr double kFar = 2 * kTile;  // cells from the corner of the tile
  if (!(std::fabs(x) <= kFar && std::fabs(y) <= kFar)) return 0;
  const float *value = grid.field(f, tile), *diagonal = grid.field(S::kDiagonal, tile);
  const auto full = [&](std::size_t n) { return diagonal[n] > 0; };
  const auto slope = [&](std::size_t n, std::size_t step) {
    const bool after = full(n + step), before = full(n - step);
    const double next = after ? double{value[n + step]} - value[n] : 0,
                 last = before ? double{value[n]} - value[n - step] : 0;
    return after && before ? (next + last) / 2 : next + last;
  };
  const auto weight = [](double t) {
    t = std::fabs(t);
    return t < 0.5 ? 0.75 - t * t : t < 1.5 ? 0.5 * (1.5 - t) * (1.5 - t) : 0.0;
  };
  const auto ci = static_cast<std::int32_t>(std::floor(x)), cj = static_cast<std::int32_t>(std::floor(y));
  double sum = 0, weights = 0;
  for (std::int32_t j = cj - 1; j <= cj + 1; ++j) {
    for (std::int32_t i = ci - 1; i <= ci + 1; ++i) {
      if (i < 0 || j < 0 || i >= grid.tiles[tile].wide || j >= grid.tiles[tile].high) continue;
      const std::size_t n = tile_node(i, j);
      if (!full(n)) continue;
      const double dx = x - i - 0.5, dy = y - j - 0.5, w = weight(dx) * weight(dy);
      sum += w * (value[n] + dx * slope(n, 1) + dy * slope(n, static_cast<std::size_t>(kernels::kTilePitch)));
      weights += w;
    }
  }
  return weights > 0 ? sum / weights : 0;
}

}  // namespace

void Fluids::look(std::vector<Seen>& out) const {
  out.clear();
  out.reserve(particles_.size());
  const FluidGrid& grid = solver_.grid();
  const double pressure = dt_ > 0 ? kinds_[0].density / dt_ / (1 - double{kHistory}) : 0;
  particles_.each(grid, [&](const kernels::FluidParticle& p, const FluidTile& tile, std::uint32_t t) {
    const bool stepped = t != FluidTile::kNone;
    const double error = stepped ? value_beside(grid, t, S::kError, p.x, p.y) : 0;
    out.push_back({p.id,
                   p.fluid,
                   FluidParticles::place_of(p, tile, space_),
                   {double{p.u}, double{p.v}},
                   kinds_[p.fluid].density * (1 + error),
                   stepped ? pressure * value_beside(grid, t, S::kPressure, p.x, p.y) : 0});
  });
}

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
  psim::sort_keys(order.begin(), order.end());
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
  viscosity_ = 0;
  particles_.clear();
  taps_ = {};
  bodies_.clear();
  space_ = FluidSpace();
  solver_.grid().lay({}, space_, 0);
  dt_ = error_mean_ = error_max_ = 0;
  iterations_ = 0;
}

}  // namespace psim
