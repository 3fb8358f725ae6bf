#include "fluid/fluid_cut.h"

#include <algorithm>
#include <cmath>

#include "fluid/fluid_equations.h"

namespace psim {

using kernels::kTileFloats;
using kernels::kTilePitch;
using kernels::tile_node;
using S = FluidSolver;

namespace {

constexpr float kSmall = 8;          // squares: the area of a shape that is no wider is made right
constexpr float kTiny = 1.5f;        // squares: a shape that is no wider is spread over nine of them
constexpr float kOnSurface = 1e-3f;  // squares: what is nearer to a surface counts as on it

float spline(float t) {
  t = std::fabs(t);
  return t < 0.5f ? 0.75f - t * t : t < 1.5f ? 0.5f * (1.5f - t) * (1.5f - t) : 0.0f;
}

}  // namespace

FluidCut::FluidCut(FluidGrid& grid, std::size_t tile, const FluidSpace& space, FluidBodies& bodies)
    : grid_(grid),
      t_(tile),
      tile_(grid.tiles[tile]),
      space_(space),
      bodies_(bodies),
      solids_(bodies.at(tile)),
      side_x_(static_cast<float>(space.cell_x / 2)),
      side_y_(static_cast<float>(space.cell_y / 2)) {}

void FluidCut::run() {
  for (const S::Field f : {S::kOpenU, S::kOpenV, S::kSeen}) std::fill_n(grid_.field(f, t_), kTileFloats, 1.0f);
  for (const S::Field f : {S::kSolidU, S::kSolidV}) std::fill_n(grid_.field(f, t_), kTileFloats, 0.0f);
  if (solids_.empty()) return;
  for (std::uint32_t k = 0; k < solids_.size(); ++k) cover(k);
  if (covers_.empty()) return;
  for (Cover& c : covers_) {
    const float all = total(c.a, c.b);
    if (all > 1) c.share /= all;
  }
  for (auto* squares : {&total_, &kernel_}) {
    for (float& all : *squares) all = std::min(all, 1.0f);
  }
  end_at_walls();
  find_middles();
  see();
  open_faces();
  make_rows();
}

void FluidCut::add_cover(const Cover& c) {
  covers_.push_back(c);
  total_[square(c.a, c.b)] += c.share;
  Most& most = most_[square(c.a, c.b)];
  if (c.share > most.share) most = {c.share, c.solid};
}

void FluidCut::cover_tiny(std::uint32_t k, const FluidSolid& s) {
  const float x = (s.low_x + s.high_x) / 2 / side_x_, y = (s.low_y + s.high_y) / 2 / side_y_;
  const auto i = static_cast<std::int32_t>(std::floor(x)), j = static_cast<std::int32_t>(std::floor(y));
  for (std::int32_t b = std::max(j - 1, kFirst); b <= std::min(j + 1, kFirst + kSide - 1); ++b) {
    for (std::int32_t a = std::max(i - 1, kFirst); a <= std::min(i + 1, kFirst + kSide - 1); ++a) {
      const float w = spline(x - static_cast<float>(a) - 0.5f) * spline(y - static_cast<float>(b) - 0.5f);
      const float share = w * s.area / (side_x_ * side_y_);
      if (share > 0) add_cover({k, a, b, share});
      kernel_[square(a, b)] += share;
    }
  }
}

void FluidCut::cover(std::uint32_t k) {
  const FluidSolid& s = solids_[k];
  const float wide = (s.high_x - s.low_x) / side_x_, high = (s.high_y - s.low_y) / side_y_;
  if (wide <= kTiny && high <= kTiny) return cover_tiny(k, s);
  constexpr float kKernel = 1.5f;  // squares: how far a kernel reaches
  const float half = (side_x_ + side_y_) / 2;
  const auto from = [](float low, float side) {
    return static_cast<std::int32_t>(std::floor(std::max(low / side - kKernel, static_cast<float>(4 * kFirst))));
  };
  const auto to = [](float high_side, float side) {
    return static_cast<std::int32_t>(std::floor(std::min(high_side / side + kKernel, static_cast<float>(2 * kSide))));
  };
  const auto share_at = [&](float d, Place2 out) {
    return d > half ? 0.0f : d < -half ? 1.0f : share_within(d, out, side_x_, side_y_);
  };
  const std::int32_t a0 = from(s.low_x, side_x_), a1 = to(s.high_x, side_x_), b0 = from(s.low_y, side_y_),
                     b1 = to(s.high_y, side_y_);
  float right = 1;
  if (wide <= kSmall && high <= kSmall) {
    float sum = 0;
    for (std::int32_t b = b0; b <= b1; ++b) {
      for (std::int32_t a = a0; a <= a1; ++a) {
        Place2 out;
        const float d = s.distance(middle_of(a, b), out);
        sum += share_at(d, out);
      }
    }
    if (sum > 0) right = s.area / (sum * side_x_ * side_y_);
  }
  for (std::int32_t b = std::max(b0, kFirst); b <= std::min(b1, kFirst + kSide - 1); ++b) {
    for (std::int32_t a = std::max(a0, kFirst); a <= std::min(a1, kFirst + kSide - 1); ++a) {
      Place2 out;
      const float d = s.distance(middle_of(a, b), out), share = right * share_at(d, out);
      kernel_[square(a, b)] += right * (1 - share_below(d / half, 1));
      if (share > 0) add_cover({k, a, b, share});
    }
  }
}

// Squares beyond the walls of the world belong to the walls, not to bodies.
void FluidCut::end_at_walls() {
  if (space_.boundary != Boundary::walls) return;
  constexpr float kNext = 0.125f;  // of what lies within the walls, the next square beyond sees so much at most
  const auto beyond = [](std::int32_t first, std::int32_t k, float wide) {
    const float middle = (static_cast<float>(2 * kernels::kTile * first + k) + 0.5f) / 2;
    return std::max(1 - middle, middle - (1 + wide));  // cells
  };
  for (std::int32_t b = kFirst; b < kFirst + kSide; ++b) {
    for (std::int32_t a = kFirst; a < kFirst + kSide; ++a) {
      const float far = std::max(beyond(tile_.x, a, space_.wide), beyond(tile_.y, b, space_.high));
      if (far <= 0) continue;
      float& sees = kernel_[square(a, b)];
      sees = far < 0.5f ? std::min(sees, kNext) : 0.0f;
    }
  }
}

void FluidCut::find_middles() {
  const float cell = 2 * std::max(side_x_, side_y_);
  for (std::int32_t j = -1; j <= tile_.high; ++j) {
    for (std::int32_t i = -1; i <= tile_.wide; ++i) {
      Middle& m = middles_[tile_node(i, j)];
      const Place2 at{(2 * static_cast<float>(i) + 1) * side_x_, (2 * static_cast<float>(j) + 1) * side_y_};
      for (std::uint32_t k = 0; k < solids_.size(); ++k) {
        if (!solids_[k].is_near(at, cell)) continue;
        Place2 out;
        const float d = solids_[k].distance(at, out);
        if (d < m.distance) m = {d, out, at, k};
      }
      m.at = way_out(at, m);
    }
  }
}

// Where a point within thin shapes comes out: by the nearest way, and, if that leads into another one, on from there.
Place2 FluidCut::way_out(Place2 at, const Middle& nearest) const {
  constexpr int kMostShapes = 2;
  const float apart = 2 * kOnSurface * side_x_;
  Middle in = nearest;
  for (int k = 0; k < kMostShapes && in.distance < apart && solids_[in.solid].thin; ++k) {
    at = {at.x + (apart - in.distance) * in.out.x, at.y + (apart - in.distance) * in.out.y};
    in.distance = kFar;
    for (std::uint32_t other = 0; other < solids_.size(); ++other) {
      Place2 out;
      if (!solids_[other].thin || !solids_[other].is_near(at, 0)) continue;
      if (const float d = solids_[other].distance(at, out); d < in.distance) in = {d, out, at, other};
    }
  }
  return at;
}

// Whether nothing goes through the face between the cells n and m, since a thin shape separates them: it lies between where
// their middles are or come out. `solid` gets the shape.
bool FluidCut::closes(std::size_t n, std::size_t m, std::uint32_t& solid) const {
  const Middle &a = middles_[n], &b = middles_[m];
  const bool a_in = a.distance < 0, b_in = b.distance < 0;
  if ((a_in && !solids_[a.solid].thin) || (b_in && !solids_[b.solid].thin)) return false;
  if (std::min(a.distance, b.distance) > side_x_ + side_y_) return false;
  for (std::uint32_t k = 0; k < solids_.size(); ++k) {
    if (!solids_[k].thin || !passes(solids_[k], a.at, b.at, kOnSurface * side_x_)) continue;
    solid = k;
    return true;
  }
  return false;
}

// Whether so little is open of the face between the cells n and m that the equations take it as closed. What is left of it
// then belongs to the shape that takes most of a square at it: that bears the pressure on the whole face. `a` and `b`: the
// first square of n.
bool FluidCut::is_shut(std::size_t n, std::size_t m, std::int32_t a, std::int32_t b, float open,
                       std::uint32_t& solid) const {
  if (!(open > 0) || (open >= kLeastOpen && sees_[n] >= kLeastSeen && sees_[m] >= kLeastSeen)) return false;
  const bool across = n - m == 1;
  Most most;
  for (const std::int32_t side : {-1, 0}) {
    for (const std::int32_t along : {0, 1}) {
      const Most& here = most_[across ? square(a + side, b + along) : square(a + along, b + side)];
      if (here.share > most.share) most = here;
    }
  }
  solid = most.solid;
  return most.share > 0;
}

void FluidCut::open_faces() {
  float *open_u = grid_.field(S::kOpenU, t_), *open_v = grid_.field(S::kOpenV, t_);
  for (std::int32_t j = 0; j <= tile_.high; ++j) {
    for (std::int32_t i = 0; i <= tile_.wide; ++i) {
      const std::size_t n = tile_node(i, j);
      const std::int32_t a = 2 * i, b = 2 * j;
      const auto face = [&](std::size_t m, float share, bool across, Place2 at, float& all, float& open) {
        std::uint32_t solid = 0;
        if (closes(n, m, solid) || is_shut(n, m, a, b, 1 - share, solid)) {
          closed_.push_back({across, n, at, solids_[solid].body, 1 - share});
          share = 1;
        }
        all = share;
        open = 1 - share;
      };
      const float x = static_cast<float>(a) * side_x_, y = static_cast<float>(b) * side_y_;
      if (j < tile_.high) {
        const float share = ((total(a - 1, b) + total(a, b)) + (total(a - 1, b + 1) + total(a, b + 1))) / 4;
        face(n - 1, share, true, {x, y + side_y_}, share_u_[n], open_u[n]);
      }
      if (i < tile_.wide) {
        const float share = ((total(a, b - 1) + total(a + 1, b - 1)) + (total(a, b) + total(a + 1, b))) / 4;
        face(n - kTilePitch, share, false, {x + side_x_, y}, share_v_[n], open_v[n]);
      }
    }
  }
}

// What the kernel of each cell sees that is open. It is a sum of the kernels of 4 x 4 squares.
void FluidCut::see() {
  constexpr float kParts[4] = {0.125f, 0.375f, 0.375f, 0.125f};
  float *seen = grid_.field(S::kSeen, t_), *fine = grid_.field(S::kFine, t_);
  for (std::int32_t j = -1; j <= tile_.high; ++j) {
    for (std::int32_t i = -1; i <= tile_.wide; ++i) {
      float solid = 0;
      for (std::int32_t b = 0; b < 4; ++b) {
        for (std::int32_t a = 0; a < 4; ++a)
          solid += kParts[a] * kParts[b] * kernel_[square(2 * i + a - 1, 2 * j + b - 1)];
      }
      sees_[tile_node(i, j)] = 1 - solid;
      if (i >= 0 && j >= 0 && i < tile_.wide && j < tile_.high) seen[tile_node(i, j)] = 1 - solid;
    }
  }
  for (std::int32_t b = 0; b < 2 * tile_.high; ++b) {
    for (std::int32_t a = 0; a < 2 * tile_.wide; ++a) fine[kernels::fine_node(a, b)] += kernel_[square(a, b)];
  }
}

void FluidCut::make_rows() {
  // Covers come in the order of the shapes, which is that of the bodies.
  for (std::size_t first = 0; first < covers_.size();) {
    std::size_t end = first;
    const std::uint32_t body = solids_[covers_[first].solid].body;
    while (end < covers_.size() && solids_[covers_[end].solid].body == body) ++end;
    add_body(first, end);
    first = end;
  }
  for (const auto& [field, share] : {std::pair{S::kSolidU, &share_u_}, std::pair{S::kSolidV, &share_v_}}) {
    float* speed = grid_.field(field, t_);
    for (std::size_t n = 0; n < kTileFloats; ++n) {
      if ((*share)[n] > 0) speed[n] /= (*share)[n];
    }
  }
}

// The rows of a body, which some of the covers are of.
void FluidCut::add_body(std::size_t first, std::size_t end) {
  const FluidSolid& any = solids_[covers_[first].solid];
  const std::uint32_t number = any.body;
  for (auto* a : {&su_, &sv_, &mu_, &mv_}) a->fill(0);
  const auto reaches = [&](std::int32_t i, std::int32_t j) {
    return i >= 0 && j >= 0 && i <= tile_.wide && j <= tile_.high;
  };
  for (std::size_t k = first; k < end; ++k) {
    const Cover& c = covers_[k];
    const FluidSolid& s = solids_[c.solid];
    const Place2 at = middle_of(c.a, c.b);
    const float quarter = c.share / 4;
    if (const std::int32_t i = (c.a + 1) >> 1, j = c.b >> 1; reaches(i, j)) {
      su_[tile_node(i, j)] += quarter;
      mu_[tile_node(i, j)] += quarter * (at.y - s.centre_y);
    }
    if (const std::int32_t i = c.a >> 1, j = (c.b + 1) >> 1; reaches(i, j)) {
      sv_[tile_node(i, j)] += quarter;
      mv_[tile_node(i, j)] += quarter * (at.x - s.centre_x);
    }
  }
  for (const ClosedFace& f : closed_) {
    if (f.body != number) continue;
    (f.across ? su_ : sv_)[f.node] += f.rest;
    (f.across ? mu_ : mv_)[f.node] += f.rest * (f.across ? f.at.y - any.centre_y : f.at.x - any.centre_x);
  }
  const FluidBody& body = bodies_.body(number);
  const auto vx = static_cast<float>(body.velocity.x), vy = static_cast<float>(body.velocity.y),
             spin = static_cast<float>(body.spin);
  float *speed_u = grid_.field(S::kSolidU, t_), *speed_v = grid_.field(S::kSolidV, t_);
  FluidBodies::Tile& tile = bodies_.tiles_[t_];
  FluidBodies::Run run;
  run.body = number;
  run.first = static_cast<std::uint32_t>(tile.rows.size());
  const float wide = 2 * side_x_, high = 2 * side_y_;
  for (std::int32_t j = 0; j < tile_.high; ++j) {
    for (std::int32_t i = 0; i < tile_.wide; ++i) {
      const std::size_t n = tile_node(i, j), right = n + 1, above = n + kTilePitch;
      speed_u[n] += su_[n] * vx - mu_[n] * spin;
      speed_v[n] += sv_[n] * vy + mv_[n] * spin;
      // Nothing goes through walls.
      const WallsBeside walls = walls_beside(space_, tile_, i, j);
      const auto side = [](bool wall, float a) { return wall ? 0.0f : a; };
      const float x = high * (side(walls.right, su_[right]) - side(walls.left, su_[n]));
      const float y = wide * (side(walls.above, sv_[above]) - side(walls.below, sv_[n]));
      const float turn = wide * (side(walls.above, mv_[above]) - side(walls.below, mv_[n])) -
                         high * (side(walls.right, mu_[right]) - side(walls.left, mu_[n]));
      if (x != 0 || y != 0 || turn != 0) tile.rows.push_back({static_cast<std::uint32_t>(n), x, y, turn});
    }
  }
  run.end = static_cast<std::uint32_t>(tile.rows.size());
  if (run.end != run.first) tile.runs.push_back(run);
}

}  // namespace psim
