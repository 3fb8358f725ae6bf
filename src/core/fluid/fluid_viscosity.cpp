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
  S::Field speed, valid, slope, drag, open, solid, push;
};
constexpr Names names_of(Component of) {
  return of == Component::u ? Names{S::kU, S::kValidU, S::kSlopeX, S::kDragU, S::kOpenU, S::kSolidU, S::kGainU}
                            : Names{S::kV, S::kValidV, S::kSlopeY, S::kDragV, S::kOpenV, S::kSolidV, S::kGainV};
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
    for (const S::Field f : {names_.valid, names_.slope}) grid_.pull_near(f, t_);
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
        if (moves(n - 1)) grid_.field(S::kLinkX, t_)[n] = kx;
        if (moves(n - kTilePitch)) grid_.field(S::kLinkY, t_)[n] = ky;
        if (i != tile.wide && j != tile.high) largest = std::max(largest, add_face(i, j, kx, ky));
      }
    }
    return largest;
  }

 private:
  bool moves(std::size_t n) const { return at(names_.valid, n) != 0 && at(names_.slope, n) > 0; }
  float at(S::Field f, std::size_t n) const { return grid_.field(f, t_)[n]; }

  // The equation of a face. Returns its speed.
  float add_face(std::int32_t i, std::int32_t j, float kx, float ky) {
    const std::size_t n = tile_node(i, j);
    held_ = 0;
    const WallsBeside walls = walls_beside(space_, grid_.tiles[t_], i, j);
    const float across = link(i, j, i - 1, j, kx, walls.left, !is_u_) + link(i, j, i + 1, j, kx, walls.right, !is_u_);
    const float upright = link(i, j, i, j - 1, ky, walls.below, is_u_) + link(i, j, i, j + 1, ky, walls.above, is_u_);
    const float diagonal = across + upright;
    const float now = at(names_.speed, n) + at(names_.push, n);
    grid_.field(S::kDiagonal, t_)[n] = 1 + diagonal;
    grid_.field(S::kReciprocal, t_)[n] = 1 / (1 + diagonal);
    grid_.field(S::kUneven, t_)[n] = now + held_;
    grid_.field(S::kEven, t_)[n] = now;
    return std::fabs(now);
  }

  // Returns what the face (i, j) adds to the diagonal of the face (from_i, from_j) beside it. A wall beside that one is half a
  // cell away, before or behind it a whole one.
  float link(std::int32_t from_i, std::int32_t from_j, std::int32_t i, std::int32_t j, float k, bool wall, bool along) {
    const std::size_t m = tile_node(i, j);
    if (bodies_ && at(names_.valid, m) == 0 && at(names_.open, m) < kMostlyTaken) {
      return hold(tile_node(from_i, from_j), place_of(from_i, from_j), place_of(i, j), k, at(names_.solid, m));
    }
    return moves(m) || at(names_.valid, m) != 0 ? k : wall ? (along ? 2 * k : k) : 0.0f;
  }

  // A body that takes the face at `behind` holds the face n, which lies at `from`: its surface lies between the two.
  float hold(std::size_t n, Place2 from, Place2 behind, float k, float drawn) {
    const Near out = nearest(from), in = nearest(behind);
    const FluidSolid* solid = in.solid;
    if (solid == nullptr) {
      held_ += k * drawn;
      return k;
    }
    const float all = out.distance - in.distance;
    const float way = in.distance < 0 && all > 0 ? std::max(out.distance / all, kLeastWay) : 1;
    const float rate = k / way;
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

// A body's speed along the component, and its spin.
struct Motion {
  double speed = 0, spin = 0;
  double at(float arm) const { return speed + spin * static_cast<double>(arm); }
};
Motion motion_of(const FluidBody& b, Component of) {
  return {of == Component::u ? b.velocity.x : b.velocity.y, b.spin};
}

// Calls each(hold, mass, tile), the mass of the face in kg, for all holds of bodies that can be moved, tile by tile.
template <class Each>
void each_hold(const FluidGrid& grid, std::span<const std::vector<FluidHold>> holds, Component of,
               const FluidBodies& bodies, double cell, const Each& each) {
  const S::Field mass = of == Component::u ? S::kMassU : S::kMassV;
  for (std::size_t t = 0; t < holds.size(); ++t) {
    for (const FluidHold& h : holds[t]) {
      const FluidBody& b = bodies.body(h.body);
      if (b.inv_mass > 0 || b.inv_inertia > 0) each(h, cell * static_cast<double>(grid.field(mass, t)[h.node]), t);
    }
  }
}

}  // namespace

float make_viscous_equations(FluidGrid& grid, std::size_t t, const FluidSpace& space, const Viscosity& by, Component of,
                             FluidBodies& bodies, std::vector<FluidHold>& holds) {
  return ViscousTile(grid, t, space, by, of, bodies, holds).run();
}

// (M + K) v' = M v + sum k m u with K = sum k m of the holds, for the speed and the spin of each body.
void expect_bodies(FluidGrid& grid, std::span<std::vector<FluidHold>> holds, Component of, const FluidBodies& bodies,
                   double cell) {
  struct Sum {
    double k = 0, arm = 0, square = 0, gain = 0, turn = 0;  // of k m, and of k m (u - v)
  };
  std::vector<Sum> sums(bodies.count());
  each_hold(grid, holds, of, bodies, cell, [&](const FluidHold& h, double mass, std::size_t t) {
    const double k = static_cast<double>(h.rate) * mass, arm = static_cast<double>(h.arm);
    const double lag =
        static_cast<double>(grid.field(S::kEven, t)[h.node]) - motion_of(bodies.body(h.body), of).at(h.arm);
    Sum& s = sums[h.body];
    s = {s.k + k, s.arm + k * arm, s.square + k * arm * arm, s.gain + k * lag, s.turn + k * arm * lag};
  });
  std::vector<Motion> expected(sums.size());
  for (std::size_t k = 0; k < sums.size(); ++k) {
    const FluidBody& b = bodies.body(static_cast<std::uint32_t>(k));
    const Sum& s = sums[k];
    // Times the inverse masses, which may be 0.
    const double a11 = 1 + b.inv_mass * s.k, a12 = b.inv_mass * s.arm, a21 = b.inv_inertia * s.arm;
    const double a22 = 1 + b.inv_inertia * s.square, r1 = b.inv_mass * s.gain, r2 = b.inv_inertia * s.turn;
    const double below = a11 * a22 - a12 * a21;
    const Motion now = motion_of(b, of);
    expected[k] = {now.speed + (a22 * r1 - a12 * r2) / below, now.spin + (a11 * r2 - a21 * r1) / below};
  }
  for (std::size_t t = 0; t < holds.size(); ++t) {
    for (FluidHold& h : holds[t]) {
      const FluidBody& b = bodies.body(h.body);
      if (!(b.inv_mass > 0) && !(b.inv_inertia > 0)) continue;
      const auto speed = static_cast<float>(expected[h.body].at(h.arm));
      grid.field(S::kUneven, t)[h.node] += h.rate * (speed - h.drawn);
      h.drawn = speed;
    }
  }
}

void drag_bodies(const FluidGrid& grid, std::span<const std::vector<FluidHold>> holds, const Viscosity& by,
                 Component of, FluidBodies& bodies, double cell) {
  std::vector<Motion> gains(bodies.count());  // N s and N m s
  each_hold(grid, holds, of, bodies, cell, [&](const FluidHold& h, double mass, std::size_t t) {
    const double lag = static_cast<double>(grid.field(S::kEven, t)[h.node] - h.drawn);
    const double push = static_cast<double>(h.rate) / by.theta() * mass * lag;
    gains[h.body].speed += push;
    gains[h.body].spin += push * static_cast<double>(h.arm);
  });
  for (std::size_t k = 0; k < gains.size(); ++k) {
    const auto [push, turn] = gains[k];
    if (push != 0 || turn != 0) {
      bodies.drag(static_cast<std::uint32_t>(k), of == Component::u ? Vec2{push, 0} : Vec2{0, push}, turn);
    }
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
