#include "fluid/fluid_viscosity.h"

#include <algorithm>
#include <cmath>

#include "fluid/fluid_equations.h"

namespace psim {

using kernels::kTileFloats;
using kernels::kTilePitch;
using kernels::tile_node;
using S = FluidSolver;

namespace {

struct Names {
  S::Field speed, valid, slope, drag, open, solid, push, mass;
};
constexpr Names names_of(Component of) {
  return of == Component::u
             ? Names{S::kU, S::kValidU, S::kSlopeX, S::kDragU, S::kOpenU, S::kSolidU, S::kGainU, S::kMassU}
             : Names{S::kV, S::kValidV, S::kSlopeY, S::kDragV, S::kOpenV, S::kSolidV, S::kGainV, S::kMassV};
}

constexpr float kMostlyTaken = 0.5f;  // share of a face that is open: with less, it moves as the body does
constexpr float kLeastWay = 0.5f;     // cells: a surface counts as no nearer to a face
constexpr double kHeldStiffer = 1.5;  // where something holds the fluid, theta is that of flows so much stiffer

// Finds the velocity, m/s, that the pressure of the last step gives to faces in this one. Viscosity acts on velocities that have
// it: else it would see water at rest fall in every step, and hold it back where something stands.
void find_push(FluidGrid& grid, std::size_t t, const Names& names, std::size_t back, float per_cell) {
  grid.pull_near(S::kPressure, t);
  const float *pressure = grid.field(S::kPressure, t), *slope = grid.field(names.slope, t);
  float* push = grid.field(names.push, t);
  std::fill_n(push, kTileFloats, 0.0f);
  for (std::int32_t j = 0; j < grid.tiles[t].high; ++j) {
    for (std::int32_t i = 0; i < grid.tiles[t].wide; ++i) {
      const std::size_t n = tile_node(i, j);
      push[n] = -slope[n] * per_cell * (pressure[n] - pressure[n - back]);
    }
  }
}

}  // namespace

double Viscosity::theta() const {
  const double stiffest = (held ? kHeldStiffer : 1) * 4 * (by_x + by_y);  // of the fastest decay, by a step
  return stiffest <= 2 ? 0.5 : 1 - 1 / stiffest;
}

namespace {

// The equations of one tile.
class ViscousTile {
 public:
  ViscousTile(FluidGrid& grid, std::size_t t, const FluidSpace& space, const Viscosity& by, Component of,
              FluidBodies& bodies, std::vector<FluidHold>& holds)
      : grid_(grid),
        t_(t),
        space_(space),
        by_(by),
        is_u_(of == Component::u),
        names_(names_of(of)),
        solids_(bodies.any() ? bodies.at(t) : std::span<FluidSolid>()),
        bodies_(bodies.any()),
        holds_(holds) {}

  float run() {
    holds_.clear();
    for (const S::Field f : {names_.valid, names_.slope, names_.mass, S::kVolume, S::kFill}) grid_.pull_near(f, t_);
    for (const S::Field f : {names_.open, names_.solid}) {
      if (bodies_) grid_.pull_cross(f, t_);
    }
    for (const S::Field f : {S::kLinkX, S::kLinkY, S::kDiagonal, S::kReciprocal, S::kUneven, S::kEven}) {
      std::fill_n(grid_.field(f, t_), kTileFloats, 0.0f);
    }
    find_push(grid_, t_, names_, is_u_ ? 1 : kTilePitch, is_u_ ? by_.per_x : by_.per_y);
    const auto kx = static_cast<float>(by_.by_x * by_.theta()), ky = static_cast<float>(by_.by_y * by_.theta());
    const FluidTile& tile = grid_.tiles[t_];
    float largest = 0;
    for (std::int32_t j = 0; j <= tile.high; ++j) {
      for (std::int32_t i = 0; i <= tile.wide; ++i) {
        const std::size_t n = tile_node(i, j);
        if (!moves(n)) continue;
        if (moves(n - 1)) grid_.field(S::kLinkX, t_)[n] = kx * density_between(n, n - 1);
        if (moves(n - kTilePitch)) grid_.field(S::kLinkY, t_)[n] = ky * density_between(n, n - kTilePitch);
        if (i != tile.wide && j != tile.high) largest = std::max(largest, add_face(i, j, kx, ky));
      }
    }
    return largest;
  }

 private:
  bool moves(std::size_t n) const {
    return at(names_.valid, n) != 0 && at(names_.slope, n) > 0 && at(names_.mass, n) > 0;
  }
  // The density at a face, by that of the first fluid. Beside walls and bodies the kernel of the face finds less: they count as
  // full of what is beside them.
  float density_of(std::size_t n) const {
    constexpr float kLeastSeenShare = 0.25f;
    const auto sees = [&](std::size_t m) { return 1 - (at(S::kFill, m) - at(S::kVolume, m)); };
    return at(names_.mass, n) / std::max((sees(n) + sees(n - (is_u_ ? 1 : kTilePitch))) / 2, kLeastSeenShare);
  }
  // Two faces exchange momentum by the harmonic mean of their densities, so that one gains what the other loses. A nearly
  // empty face is dragged at most twice as much as a full one.
  float density_between(std::size_t n, std::size_t m) const {
    const float a = density_of(n), b = density_of(m);
    return 2 * a * b / (a + b);
  }
  float at(S::Field f, std::size_t n) const { return grid_.field(f, t_)[n]; }

  // The equation of a face, times its density. Returns its speed times that.
  float add_face(std::int32_t i, std::int32_t j, float kx, float ky) {
    const std::size_t n = tile_node(i, j);
    held_ = 0;
    const WallsBeside walls = walls_beside(space_, grid_.tiles[t_], i, j);
    const float across = link(i, j, i - 1, j, kx, walls.left, !is_u_) + link(i, j, i + 1, j, kx, walls.right, !is_u_);
    const float upright = link(i, j, i, j - 1, ky, walls.below, is_u_) + link(i, j, i, j + 1, ky, walls.above, is_u_);
    const float diagonal = across + upright;
    const float now = at(names_.speed, n) + at(names_.push, n), density = density_of(n);
    grid_.field(S::kDiagonal, t_)[n] = density + diagonal;
    grid_.field(S::kReciprocal, t_)[n] = 1 / (density + diagonal);
    grid_.field(S::kUneven, t_)[n] = density * now + held_;
    grid_.field(S::kEven, t_)[n] = now;
    return density * std::fabs(now);
  }

  // Returns what the face (i, j) adds to the diagonal of the face (from_i, from_j) beside it. A wall beside that one is half a
  // cell away, before or behind it a whole one.
  float link(std::int32_t from_i, std::int32_t from_j, std::int32_t i, std::int32_t j, float k, bool wall, bool along) {
    const std::size_t n = tile_node(from_i, from_j), m = tile_node(i, j);
    const float density = density_of(n);
    if (bodies_ && at(names_.valid, m) == 0 && at(names_.open, m) < kMostlyTaken) {
      return hold(n, place_of(from_i, from_j), place_of(i, j), k, at(names_.solid, m));
    }
    if (moves(m)) return k * density_between(n, m);
    return density * (at(names_.valid, m) != 0 ? k : wall ? (along ? 2 * k : k) : 0.0f);
  }

  // A body that takes the face at `behind` holds the face n, which lies at `from`: its surface lies between the two.
  float hold(std::size_t n, Place2 from, Place2 behind, float k, float drawn) {
    const Near out = nearest(from), in = nearest(behind);
    const FluidSolid* solid = in.solid;
    const float density = density_of(n);
    if (solid == nullptr) {
      held_ += density * k * drawn;
      return density * k;
    }
    const float all = out.distance - in.distance;
    const float way = in.distance < 0 && all > 0 ? std::max(out.distance / all, kLeastWay) : 1;
    const float rate = density * (k / way);
    held_ += rate * drawn;
    const float arm = is_u_ ? solid->centre_y - behind.y : behind.x - solid->centre_x;
    holds_.push_back({static_cast<std::uint32_t>(n), solid->body, rate, drawn, arm});
    return rate;
  }

  // The shape whose surface is the nearest, and how far that is, m; below 0 within.
  struct Near {
    const FluidSolid* solid = nullptr;
    float distance = 0;
  };
  Near nearest(Place2 at) const {
    Near found;
    for (const FluidSolid& s : solids_) {
      Place2 out;
      const float distance = s.distance(at, out);
      if (found.solid == nullptr || distance < found.distance) found = {&s, distance};
    }
    return found;
  }
  Place2 place_of(std::int32_t i, std::int32_t j) const {
    const auto place = [](std::int32_t a, double half, double cell) { return static_cast<float>((a + half) * cell); };
    return {place(i, is_u_ ? 0 : 0.5, space_.cell_x), place(j, is_u_ ? 0.5 : 0, space_.cell_y)};
  }

  FluidGrid& grid_;
  std::size_t t_;
  const FluidSpace& space_;
  const Viscosity& by_;
  bool is_u_;
  Names names_;
  std::span<FluidSolid> solids_;
  bool bodies_;
  std::vector<FluidHold>& holds_;
  float held_ = 0;  // what bodies beside a face give to its right side
};

}  // namespace

float make_viscous_equations(FluidGrid& grid, std::size_t t, const FluidSpace& space, const Viscosity& by, Component of,
                             FluidBodies& bodies, std::vector<FluidHold>& holds) {
  return ViscousTile(grid, t, space, by, of, bodies, holds).run();
}

// Calls visit(hold, tile) for all holds of bodies that can be moved, tile by tile.
template <class Each>
void HeldBodies::each(const Each& visit) const {
  for (std::size_t t = 0; t < holds_.size(); ++t) {
    for (const FluidHold& h : holds_[t]) {
      const FluidBody& b = bodies_.body(h.body);
      if (b.inv_mass > 0 || b.inv_inertia > 0) visit(h, t);
    }
  }
}

HeldBodies::Motion HeldBodies::solve(std::size_t body, double speed, double spin) const {
  const FluidBody& b = bodies_.body(body);
  const Body& s = sums_[body];
  const double a11 = 1 + b.inv_mass * s.k, a12 = b.inv_mass * s.arm, a21 = b.inv_inertia * s.arm;
  const double a22 = 1 + b.inv_inertia * s.square, below = a11 * a22 - a12 * a21;
  return {(a22 * speed - a12 * spin) / below, (a11 * spin - a21 * speed) / below};
}

void HeldBodies::begin(FluidGrid& grid) {
  sums_.assign(bodies_.count(), Body());
  each([&](const FluidHold& h, std::size_t) {
    const double k = cell_ * static_cast<double>(h.rate), arm = static_cast<double>(h.arm);
    Body& s = sums_[h.body];
    s.k += k;
    s.arm += k * arm;
    s.square += k * arm * arm;
    any_ = true;
  });
  for (std::size_t k = 0; k < sums_.size() && any_; ++k) {
    const FluidBody& b = bodies_.body(k);
    sums_[k].base = solve(k, of_ == Component::u ? b.velocity.x : b.velocity.y, b.spin);
  }
  each([&](const FluidHold& h, std::size_t t) {
    grid.field(S::kUneven, t)[h.node] += h.rate * (static_cast<float>(sums_[h.body].base.at(h.arm)) - h.drawn);
  });
}

// Sums up, for each body, the momentum that the faces would give to it if they had the speeds of this field.
void HeldBodies::sum(const FluidGrid& grid, std::size_t field) {
  for (Body& s : sums_) s.gain = {};
  each([&](const FluidHold& h, std::size_t t) {
    const double push = cell_ * static_cast<double>(h.rate) * static_cast<double>(grid.field(field, t)[h.node]);
    sums_[h.body].gain.speed += push;
    sums_[h.body].gain.spin += push * static_cast<double>(h.arm);
  });
}

double HeldBodies::apply(FluidGrid& grid, std::size_t x, std::size_t change) {
  sum(grid, x);
  double product = 0;
  for (std::size_t k = 0; k < sums_.size(); ++k) {
    const FluidBody& b = bodies_.body(k);
    const Motion gain = sums_[k].gain;
    sums_[k].gain = solve(k, b.inv_mass * gain.speed, b.inv_inertia * gain.spin);
    product += gain.speed * sums_[k].gain.speed + gain.spin * sums_[k].gain.spin;
  }
  each([&](const FluidHold& h, std::size_t t) {
    grid.field(change, t)[h.node] -= h.rate * static_cast<float>(sums_[h.body].gain.at(h.arm));
  });
  return -product / cell_;
}

void HeldBodies::bear(FluidGrid& grid, const Viscosity& by) {
  sum(grid, S::kEven);
  for (std::size_t k = 0; k < sums_.size(); ++k) {
    const FluidBody& b = bodies_.body(k);
    Body& s = sums_[k];
    const Motion now = solve(k, b.inv_mass * s.gain.speed, b.inv_inertia * s.gain.spin);
    const double speed = s.base.speed + now.speed, spin = s.base.spin + now.spin;
    const double push = (s.gain.speed - s.k * speed - s.arm * spin) / by.theta();
    const double turn = (s.gain.spin - s.arm * speed - s.square * spin) / by.theta();
    if (push == 0 && turn == 0) continue;
    bodies_.drag(static_cast<std::uint32_t>(k), of_ == Component::u ? Vec2{push, 0} : Vec2{0, push}, turn);
  }
}

void drag_faces(FluidGrid& grid, std::size_t t, const Viscosity& by, Component of) {
  const Names names = names_of(of);
  const float *diagonal = grid.field(S::kDiagonal, t), *found = grid.field(S::kEven, t);
  float *speed = grid.field(names.speed, t), *drag = grid.field(names.drag, t);
  const float* push = grid.field(names.push, t);
  const auto per_theta = static_cast<float>(1 / by.theta());
  for (std::size_t n = 0; n < kTileFloats; ++n) {
    drag[n] = diagonal[n] > 0 ? (found[n] - (speed[n] + push[n])) * per_theta : 0;
    if (diagonal[n] > 0) speed[n] += drag[n];
  }
}

}  // namespace psim
