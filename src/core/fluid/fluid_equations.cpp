#include "fluid/fluid_equations.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace psim {

using kernels::kTile;
using kernels::kTileFloats;
using kernels::kTilePitch;
using kernels::tile_node;
using S = FluidSolver;

namespace {

constexpr float kSolidSeen = 0.3f;    // and one that sees less than this is no surface for its neighbours
constexpr float kMostlySolid = 0.4f;  // a cell of which bodies leave less to be seen is as full as its neighbours
// A cell that is mostly solid counts as at least as full as its own kernel says, up to this share: a film along a wall may
// fill it and not the cells beside it. With their share alone the surface would seem to lie near its middle, and pressure
// would shoot the film up the wall.
constexpr float kOwnShare = 0.8f;
constexpr float kMostUneven = 0.5f;  // errors of the density are mended in steps of this
// By a cell, of pressure between a full cell and one that is not. Where the surface hardly slopes, both may lie within it.
constexpr float kLeastFall = 0.01f, kMostFall = 20;

// How far the middle of a cell lies within a flat surface, cells, by the share of fluid that its kernel sees.
class Depth {
 public:
  Depth() {
    for (std::size_t k = 0; k <= kSteps; ++k) {
      float low = -1.5f, high = 1.5f;
      for (int i = 0; i < 40; ++i) {
        const float middle = (low + high) / 2;
        (share_below(middle, 2) * kSteps < static_cast<float>(k) ? low : high) = middle;
      }
      at_[k] = low;
    }
  }
  float operator()(float share) const {
    if (!(share > 0)) return at_[0];
    if (share >= 1) return at_[kSteps];
    const float x = share * kSteps;
    const auto k = static_cast<std::size_t>(x);
    return at_[k] + (x - static_cast<float>(k)) * (at_[k + 1] - at_[k]);
  }

 private:
  static constexpr std::size_t kSteps = 256;
  std::array<float, kSteps + 1> at_{};
};

// Along one axis: how much is open between the walls of a world, the first of which is at 1.
struct Open {
  float wide;  // cells between the walls; 0: there are none
  float end = wide + 1;
  float face(std::int32_t i) const { return wide == 0 || (i > 1 && static_cast<float>(i) < end) ? 1.0f : 0.0f; }
  float cell(std::int32_t i) const {
    if (wide == 0) return 1;
    return i < 1 ? 0.0f : std::clamp(end - static_cast<float>(i), 0.0f, 1.0f);
  }
  // Returns how much of the kernel at a place lies between the walls. Its cells are `width` wide.
  float seen(float middle, float width) const {
    if (wide == 0) return 1;
    const float spacings = 2 * width;
    return share_below((end - middle) / width, spacings) + share_below((middle - 1) / width, spacings) - 1;
  }
};

// Along one axis, of the nodes of a tile: what cells see and how much of them is open, and which faces are.
struct Axis {
  std::array<float, kTilePitch> seen{}, cell{}, face{};
  std::array<float, 2 * kTile> fine{};  // what the nodes of the fine grid see

  Axis(const Open& open, std::int32_t first) {
    for (std::int32_t k = 0; k < kTilePitch; ++k) {
      const std::int32_t i = first + k - 1;
      const auto at = static_cast<std::size_t>(k);
      seen[at] = open.seen(static_cast<float>(i) + 0.5f, 1);
      cell[at] = open.cell(i);
      face[at] = open.face(i);
    }
    for (std::int32_t k = 0; k < 2 * kTile; ++k) {
      fine[static_cast<std::size_t>(k)] =
          open.seen(static_cast<float>(first) + 0.5f * static_cast<float>(k) + 0.25f, 0.5f);
    }
  }
};

class Setup {
 public:
  Setup(FluidGrid& grid, std::size_t tile, const FluidSpace& space, bool bodies, bool densities)
      : grid_(grid),
        t_(tile),
        tile_(grid.tiles[tile]),
        x_(Open{space.wide}, kTile * tile_.x),
        y_(Open{space.high}, kTile * tile_.y),
        wide_(static_cast<float>(space.cell_x)),
        high_(static_cast<float>(space.cell_y)),
        bodies_(bodies),
        densities_(densities) {}

  void find_shares() {
    look();
    look_into_bodies();
    std::copy_n(share_, kTileFloats, field(S::kShare));
  }

  void show_shares() {
    look();
    if (bodies_) take_shares();
    for (std::size_t n = 0; n < kTileFloats; ++n) {
      field(S::kGainU)[n] = std::min(share_[n], 1.0f);
      field(S::kGainV)[n] = seen_[n];
    }
  }

  FluidSurvey run(bool tension) {
    look();
    if (bodies_) take_shares();
    if (tension) grid_.pull_ring(S::kShiftV, t_, S::kShiftV, FluidGrid::kNothing);
    tension_ = tension;
    find_links();
    FluidSurvey survey;
    for (std::int32_t j = 0; j < tile_.high; ++j) {
      for (std::int32_t i = 0; i < tile_.wide; ++i) {
        field(S::kEdge)[tile_node(i, j)] = at_surface(i, j) ? 1.0f : 0.0f;
        if (full_[tile_node(i, j)]) make(i, j, survey);
      }
    }
    // Particles see walls as full of fluid, so that they are no surface.
    const float* volume = field(S::kVolume);
    for (std::int32_t j = 0; j < tile_.high; ++j) {
      for (std::int32_t i = 0; i < tile_.wide; ++i) {
        const std::size_t n = tile_node(i, j);
        field(S::kFill)[n] = volume[n] + (1 - seen_[n]);
      }
    }
    return survey;
  }

 private:
  float* field(S::Field f) { return grid_.field(f, t_); }
  static std::size_t at(std::int32_t k) { return static_cast<std::size_t>(k) + 1; }

  // Which cells are full, those of the halo among them.
  void look() {
    for (const S::Field f : {S::kU, S::kV, S::kVolume}) grid_.pull_ring(f, t_);
    for (const S::Field f : {S::kLinkX, S::kLinkY, S::kDiagonal, S::kReciprocal, S::kRight, S::kUneven, S::kError,
                             S::kSlopeX, S::kSlopeY, S::kValidU, S::kValidV}) {
      std::fill_n(field(f), kTileFloats, 0.0f);
    }
    if (bodies_) {
      for (const S::Field f : {S::kOpenU, S::kOpenV, S::kSeen}) grid_.pull_ring(f, t_);
    }
    if (densities_) {
      for (const S::Field f : {S::kLightU, S::kLightV}) grid_.pull_ring(f, t_);
    }
    const float *volume = field(S::kVolume), *left = field(S::kSeen);
    for (std::int32_t j = -1; j <= tile_.high + 1; ++j) {
      for (std::int32_t i = -1; i <= tile_.wide + 1; ++i) {
        const std::size_t n = tile_node(i, j);
        wall_[n] = x_.seen[at(i)] * y_.seen[at(j)];
        seen_[n] = bodies_ ? std::max(wall_[n] - (1 - left[n]), 0.0f) : wall_[n];
        cell_[n] = seen_[n] > kLeastSeen && x_.cell[at(i)] * y_.cell[at(j)] > 0;
        share_[n] = cell_[n] ? volume[n] / seen_[n] : 0;
        full_[n] = cell_[n] && share_[n] > kFullCell;
      }
    }
  }

  // The kernel of a cell that lies for the most part within bodies sees too little to say how full the cell is. It takes the
  // mean of its neighbours, unless it sees itself as fuller (kOwnShare).
  void look_into_bodies() {
    const float *open_u = field(S::kOpenU), *open_v = field(S::kOpenV);
    std::copy_n(share_, kTileFloats, own_);
    for (std::int32_t j = 0; j < tile_.high; ++j) {
      for (std::int32_t i = 0; i < tile_.wide; ++i) {
        const std::size_t n = tile_node(i, j);
        if (!is_deep(n)) continue;
        float sum = 0, weights = 0;
        const auto add = [&](std::size_t m, float open) {
          if (is_deep(m) || !cell_[m] || open < kLeastOpen) return;
          sum += open * own_[m];
          weights += open;
        };
        add(n - 1, open_u[n]);
        add(n + 1, open_u[n + 1]);
        add(n - kTilePitch, open_v[n]);
        add(n + kTilePitch, open_v[n + kTilePitch]);
        if (weights > 0) share_[n] = std::max(sum / weights, std::min(own_[n], kOwnShare));
      }
    }
  }
  void take_shares() {
    grid_.pull_ring(S::kShare, t_, S::kShare, FluidGrid::kNothing);
    const float* share = field(S::kShare);
    for (std::int32_t j = -1; j <= tile_.high + 1; ++j) {
      for (std::int32_t i = -1; i <= tile_.wide + 1; ++i) {
        const std::size_t n = tile_node(i, j);
        deep_[n] = is_deep(n);
        share_[n] = share[n];
        full_[n] = cell_[n] && share_[n] > kFullCell;
      }
    }
  }

  bool is_deep(std::size_t n) const { return seen_[n] < kMostlySolid * wall_[n]; }

  // The share of a face that bodies leave open.
  float open_u(std::size_t n) { return bodies_ ? opened(field(S::kOpenU)[n], n, n - 1) : 1.0f; }
  float open_v(std::size_t n) { return bodies_ ? opened(field(S::kOpenV)[n], n, n - kTilePitch) : 1.0f; }
  // How much speed a face gains by pressure, by what one of the first fluid does.
  float light(S::Field lightness, std::size_t n) { return densities_ ? field(lightness)[n] : 1.0f; }
  float opened(float share, std::size_t n, std::size_t m) {
    const auto seen = [&](std::size_t k) { return seen_[k] >= kLeastSeen * wall_[k]; };
    return share >= kLeastOpen && seen(n) && seen(m) ? share : 0.0f;
  }

  // Returns how steeply pressure falls from the full one of two neighbouring cells to the other one, by its pressure and a
  // cell. It is zero where the surface lies, which may be nearer than the other cell's middle (Gibou et al. 2002) or
  // beyond it: pressure changes as the depth does.
  float slope(std::size_t n, std::size_t m) const {
    static const Depth depth;
    if (full_[n] == full_[m]) return 1;
    const float in = depth(full_[n] ? share_[n] : share_[m]), out = depth(full_[n] ? share_[m] : share_[n]);
    return std::clamp(1 - out / in, kLeastFall, kMostFall);
  }

  void find_links() {
    const float by_x = high_ / wide_, by_y = wide_ / high_;
    for (std::int32_t j = 0; j <= tile_.high; ++j) {
      for (std::int32_t i = 0; i <= tile_.wide; ++i) {
        const std::size_t n = tile_node(i, j), left = n - 1, below = n - kTilePitch;
        const float open_x = open_u(n), open_y = open_v(n);
        const float face_x = x_.face[at(i)] * light(S::kLightU, n), face_y = y_.face[at(j)] * light(S::kLightV, n);
        if ((full_[n] || full_[left]) && open_x > 0) {
          field(S::kValidU)[n] = 1;
          field(S::kSlopeX)[n] = face_x * slope(n, left);
          if (full_[n] && full_[left]) field(S::kLinkX)[n] = face_x * open_x * by_x * y_.cell[at(j)];
        }
        if ((full_[n] || full_[below]) && open_y > 0) {
          field(S::kValidV)[n] = 1;
          field(S::kSlopeY)[n] = face_y * slope(n, below);
          if (full_[n] && full_[below]) field(S::kLinkY)[n] = face_y * open_y * by_y * x_.cell[at(i)];
        }
      }
    }
  }

  // Whether a cell or one beside it is not full, and no wall.
  bool at_surface(std::int32_t i, std::int32_t j) const {
    for (std::int32_t b = -1; b <= 1; ++b) {
      for (std::int32_t a = -1; a <= 1; ++a) {
        const std::size_t m = tile_node(i + a, j + b);
        if (!full_[m] && seen_[m] > kSolidSeen) return true;
      }
    }
    return false;
  }

  void make(std::int32_t i, std::int32_t j, FluidSurvey& survey) {
    const std::size_t n = tile_node(i, j), right_of = n + 1, above = n + kTilePitch;
    const float *sx = field(S::kSlopeX), *sy = field(S::kSlopeY), *u = field(S::kU), *v = field(S::kV);
    // What is open of its left, right, lower and upper face.
    const float left = y_.cell[at(j)] * open_u(n), right_open = y_.cell[at(j)] * open_u(right_of);
    const float lower = x_.cell[at(i)] * open_v(n), upper = x_.cell[at(i)] * open_v(above);
    const float diagonal = high_ / wide_ * (left * sx[n] + right_open * sx[right_of]) +
                           wide_ / high_ * (lower * sy[n] + upper * sy[above]);
    if (!(diagonal > 0)) return;
    field(S::kDiagonal)[n] = diagonal;
    field(S::kReciprocal)[n] = 1 / diagonal;
    const auto flow = [](const float* slope, const float* speed, std::size_t m) {
      return slope[m] > 0 ? speed[m] : 0.0f;
    };
    float right = -(high_ * (right_open * flow(sx, u, right_of) - left * flow(sx, u, n)) +
                    wide_ * (upper * flow(sy, v, above) - lower * flow(sy, v, n)));
    if (tension_) {
      const float* known = field(S::kShiftV);  // pressure at the surface
      const auto at_face = [&](std::size_t m) { return full_[m] ? 0.0f : known[m]; };
      right += high_ / wide_ * (left * sx[n] * at_face(n - 1) + right_open * sx[right_of] * at_face(right_of)) +
               wide_ / high_ * (lower * sy[n] * at_face(n - kTilePitch) + upper * sy[above] * at_face(above));
    }
    float error = field(S::kVolume)[n] / seen_[n] - 1;
    if (field(S::kEdge)[n] != 0) error = std::max(error, 0.0f);  // only what is too dense counts at a surface
    // Too little is seen of a deep cell to mend it.
    const float uneven = deep_[n] ? 0.0f : std::clamp(error, -kMostUneven, kMostUneven) * seen_[n] * wide_ * high_;
    field(S::kRight)[n] = right;
    field(S::kError)[n] = error;
    field(S::kUneven)[n] = uneven;
    if (!deep_[n]) {
      survey.error += static_cast<double>(std::fabs(error));
      survey.worst = std::max(survey.worst, std::fabs(error));
      ++survey.cells;
    }
    const auto surface = [&](const float* slope, std::size_t face, std::size_t m) {
      return slope[face] > 0 && !full_[m];
    };
    survey.surface = survey.surface || surface(sx, n, n - 1) || surface(sx, right_of, right_of) ||
                     surface(sy, n, n - kTilePitch) || surface(sy, above, above);
    survey.uneven += static_cast<double>(uneven);
    ++survey.full;
    survey.largest = std::max(survey.largest, std::fabs(right));
    survey.largest_even = std::max(survey.largest_even, std::fabs(uneven));
  }

  FluidGrid& grid_;
  std::size_t t_;
  const FluidTile& tile_;
  Axis x_, y_;
  float wide_, high_;  // of a cell, m
  bool tension_ = false;
  bool bodies_, densities_;
  float share_[kTileFloats] = {}, seen_[kTileFloats] = {}, wall_[kTileFloats], own_[kTileFloats];
  // Whether a cell is one: within the walls, and bodies leave something of it.
  bool cell_[kTileFloats] = {}, full_[kTileFloats], deep_[kTileFloats] = {};
};

}  // namespace

float share_below(float t, float spacings) {
  const auto kernel = [](float d) {
    d = std::fabs(d);
    return d < 0.5f ? 0.75f - d * d : d < 1.5f ? 0.5f * (1.5f - d) * (1.5f - d) : 0.0f;
  };
  if (t >= 2) return 1;
  float share = 0;
  for (int k = 0; k < 8; ++k) share += kernel(t - (0.5f + static_cast<float>(k)) / spacings);
  return share / spacings;
}

void find_shares(FluidGrid& grid, std::size_t tile, const FluidSpace& space) {
  Setup(grid, tile, space, true, false).find_shares();
}

bool has_full_cell(const FluidGrid& grid, std::size_t t, const FluidSpace& space) {
  const FluidTile& tile = grid.tiles[t];
  const Axis x(Open{space.wide}, kTile * tile.x), y(Open{space.high}, kTile * tile.y);
  const float* volume = grid.field(S::kVolume, t);
  for (std::int32_t j = 0; j < tile.high; ++j) {
    for (std::int32_t i = 0; i < tile.wide; ++i) {
      const float seen = x.seen[static_cast<std::size_t>(i) + 1] * y.seen[static_cast<std::size_t>(j) + 1];
      if (seen > kLeastSeen && volume[tile_node(i, j)] / seen > kFullCell) return true;
    }
  }
  return false;
}

void show_shares(FluidGrid& grid, std::size_t tile, const FluidSpace& space, bool bodies) {
  Setup(grid, tile, space, bodies, false).show_shares();
}

FluidSurvey make_equations(FluidGrid& grid, std::size_t tile, const FluidSpace& space, bool bodies, bool densities,
                           bool tension) {
  return Setup(grid, tile, space, bodies, densities).run(tension);
}

void soften(FluidGrid& grid, std::size_t tile) {
  constexpr float kSofter = 1e-4f;
  float *diagonal = grid.field(S::kDiagonal, tile), *reciprocal = grid.field(S::kReciprocal, tile);
  for (std::size_t n = 0; n < kTileFloats; ++n) {
    diagonal[n] *= 1 + kSofter;
    reciprocal[n] *= 1 / (1 + kSofter);
  }
}

void take_mean_out(FluidGrid& grid, std::size_t tile, FluidSolver::Field field, float mean) {
  const float* diagonal = grid.field(S::kDiagonal, tile);
  float* value = grid.field(field, tile);
  for (std::size_t n = 0; n < kTileFloats; ++n) value[n] = diagonal[n] > 0 ? value[n] - mean : 0;
}

void fill_walls(FluidGrid& grid, std::size_t t, const FluidSpace& space) {
  if (space.boundary != Boundary::walls) return;
  const FluidTile& tile = grid.tiles[t];
  const Axis x(Open{space.wide}, kTile * tile.x), y(Open{space.high}, kTile * tile.y);
  float* fine = grid.field(S::kFine, t);
  for (std::int32_t j = 0; j < 2 * tile.high; ++j) {
    for (std::int32_t i = 0; i < 2 * tile.wide; ++i) {
      fine[kernels::fine_node(i, j)] += 1 - x.fine[static_cast<std::size_t>(i)] * y.fine[static_cast<std::size_t>(j)];
    }
  }
}

WallsBeside walls_beside(const FluidSpace& space, const FluidTile& tile, std::int32_t i, std::int32_t j) {
  if (space.boundary != Boundary::walls) return {};
  const Open x{space.wide}, y{space.high};
  const std::int32_t column = kTile * tile.x + i, row = kTile * tile.y + j;
  return {x.cell(column - 1) == 0, x.cell(column + 1) == 0, y.cell(row - 1) == 0, y.cell(row + 1) == 0};
}

}  // namespace psim
