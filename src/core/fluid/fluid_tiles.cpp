#include "fluid/fluid_tiles.h"

#include <algorithm>
#include <cmath>

namespace psim {

using kernels::kTile;
using kernels::kTileFloats;
using kernels::kTilePitch;
using kernels::tile_node;

namespace {

// Cells of a period: a whole number, so that a row of tiles ends with none that is narrower than four cells.
std::int32_t cells_of_period(double length, double cell) {
  const auto fits = [](std::int32_t n) { return n >= 4 && (n % kTile == 0 || n % kTile >= 4); };
  const auto near = static_cast<std::int32_t>(std::nearbyint(length / cell));
  for (std::int32_t d = 0;; ++d) {
    if (fits(near - d)) return near - d;
    if (fits(near + d)) return near + d;
  }
}

// Between walls a halo takes two nodes of the tile after it, so that none may have a single one: then there is one cell more,
// beyond the wall.
std::int32_t whole_tiles(std::int32_t cells) { return cells % kTile == 1 ? cells + 1 : cells; }

std::int32_t at_level(std::int32_t cells, std::int32_t level) {
  for (; level > 0; --level) cells = (cells + 1) / 2;
  return cells;
}
std::int32_t tiles_of(std::int32_t cells) { return (cells + kTile - 1) / kTile; }

}  // namespace

FluidSpace fluid_space(const Bounds& bounds, Boundary boundary, double cell, Vec2 corner) {
  FluidSpace s;
  s.boundary = boundary;
  s.cell_x = s.cell_y = cell;
  const double width = bounds.xmax - bounds.xmin, height = bounds.ymax - bounds.ymin;
  s.left = bounds.xmin;
  s.bottom = bounds.ymin;
  if (boundary == Boundary::periodic) {
    s.cells_x = cells_of_period(width, cell);
    s.cells_y = cells_of_period(height, cell);
    s.cell_x = width / s.cells_x;
    s.cell_y = height / s.cells_y;
  } else if (boundary == Boundary::walls) {
    const auto whole = [](double n) { return std::fabs(n - std::nearbyint(n)) < 1e-3 ? std::nearbyint(n) : n; };
    const double wide = whole(width / cell), high = whole(height / cell);
    s.cells_x = whole_tiles(static_cast<std::int32_t>(std::ceil(wide)) + 2);
    s.cells_y = whole_tiles(static_cast<std::int32_t>(std::ceil(high)) + 2);
    s.wide = static_cast<float>(wide);
    s.high = static_cast<float>(high);
    s.left -= cell;
    s.bottom -= cell;
  } else {
    s.left = corner.x;
    s.bottom = corner.y;
  }
  return s;
}

std::uint64_t neighbour_key(const FluidSpace& space, std::int32_t level, std::int32_t x, std::int32_t y, bool& there) {
  there = true;
  if (space.boundary != Boundary::open) {
    const std::int32_t nx = tiles_of(at_level(space.cells_x, level)), ny = tiles_of(at_level(space.cells_y, level));
    if (space.boundary == Boundary::periodic) {
      x = (x % nx + nx) % nx;
      y = (y % ny + ny) % ny;
    } else {
      there = x >= 0 && y >= 0 && x < nx && y < ny;
    }
  }
  return tile_key(x, y);
}

std::uint32_t FluidGrid::find(std::uint64_t key) const {
  const auto at = std::ranges::lower_bound(keys, key);
  return at != keys.end() && *at == key ? static_cast<std::uint32_t>(at - keys.begin()) : FluidTile::kNone;
}

std::size_t FluidGrid::bytes() const {
  std::size_t all = 0;
  for (const Column<float>& chunk : chunks_) all += chunk.bytes();
  return all;
}

void FluidGrid::lay(const std::vector<std::uint64_t>& of, const FluidSpace& space, std::int32_t level) {
  while (chunks_.size() * kChunk < of.size()) {  // first: without memory the old tiles stay
    Column<float> chunk(meter_);
    chunk.reserve(kChunk * fields_ * kTileFloats);
    chunks_.push_back(std::move(chunk));
  }
  keys = of;
  active.clear();
  tiles.assign(keys.size(), FluidTile());
  const std::int32_t cells_x = at_level(space.cells_x, level), cells_y = at_level(space.cells_y, level);
  const bool ends = space.boundary != Boundary::open;
  for (std::size_t t = 0; t < keys.size(); ++t) {
    FluidTile& tile = tiles[t];
    tile.x = static_cast<std::int32_t>(static_cast<std::uint32_t>(keys[t]) ^ 0x80000000u);
    tile.y = static_cast<std::int32_t>(static_cast<std::uint32_t>(keys[t] >> 32) ^ 0x80000000u);
    tile.wide = ends ? std::min(kTile, cells_x - kTile * tile.x) : kTile;
    tile.high = ends ? std::min(kTile, cells_y - kTile * tile.y) : kTile;
    for (std::int32_t k = 0; k < 9; ++k) {
      bool there = true;
      const std::uint64_t key = neighbour_key(space, level, tile.x + k % 3 - 1, tile.y + k / 3 - 1, there);
      tile.near[k] = there ? find(key) : FluidTile::kNone;
    }
  }
}

namespace {

// Copies a rectangle of nodes of another field, or zeros.
void copy_nodes(float* to, std::int32_t i, std::int32_t j, const float* from, std::int32_t from_i, std::int32_t from_j,
                std::int32_t wide, std::int32_t high) {
  for (std::int32_t b = 0; b < high; ++b) {
    float* row = to + tile_node(i, j + b);
    if (from == nullptr) {
      std::fill_n(row, wide, 0.0f);
    } else if (wide == kTile) {  // the compiler knows how long it is
      std::copy_n(from + tile_node(from_i, from_j + b), kTile, row);
    } else {
      std::copy_n(from + tile_node(from_i, from_j + b), wide, row);
    }
  }
}

void copy_column(float* to, std::int32_t i, const float* from, std::int32_t from_i, std::int32_t high) {
  for (std::int32_t j = 0; j < high; ++j) to[tile_node(i, j)] = from == nullptr ? 0 : from[tile_node(from_i, j)];
}

}  // namespace

template <class There>
void FluidGrid::pull_four(std::size_t f, std::size_t tile, const There& there) {
  const FluidTile& t = tiles[tile];
  float* to = field(f, tile);
  const auto near = [&](int k) {
    const std::uint32_t n = t.near[k];
    return n != FluidTile::kNone && there(tiles[n]) ? &tiles[n] : nullptr;
  };
  const FluidTile *left = near(3), *right = near(5), *below = near(1), *above = near(7);
  const auto of = [&](int k, const FluidTile* n) { return n == nullptr ? nullptr : field(f, t.near[k]); };
  copy_column(to, -1, of(3, left), left == nullptr ? 0 : left->wide - 1, t.high);
  copy_column(to, t.wide, of(5, right), 0, t.high);
  copy_nodes(to, 0, -1, of(1, below), 0, below == nullptr ? 0 : below->high - 1, t.wide, 1);
  copy_nodes(to, 0, t.high, of(7, above), 0, 0, t.wide, 1);
}

void FluidGrid::pull_cross(std::size_t f, std::size_t tile) {
  pull_four(f, tile, [](const FluidTile&) { return true; });
}

void FluidGrid::pull_active(std::size_t f, std::size_t tile) {
  pull_four(f, tile, [](const FluidTile& t) { return t.active; });
}

void FluidGrid::pull_near(std::size_t f, std::size_t tile) {
  pull_four(f, tile, [](const FluidTile& t) { return !t.dry; });
}

void FluidGrid::clear_halo(std::size_t f, std::size_t tile) {
  const FluidTile& t = tiles[tile];
  if (t.wide < kTile) copy_column(field(f, tile), t.wide, nullptr, 0, t.high);
  if (t.high < kTile) copy_nodes(field(f, tile), 0, t.high, nullptr, 0, 0, t.wide, 1);
}

void FluidGrid::activate(const std::vector<std::uint32_t>& these) {
  for (const std::uint32_t t : active) tiles[t].active = false;
  active.assign(these.begin(), these.end());
  for (const std::uint32_t t : active) tiles[t].active = true;
}

void FluidGrid::pull_ring(std::size_t f, std::size_t tile, std::size_t of_near, std::size_t of_dry) {
  const FluidTile& t = tiles[tile];
  float* to = field(f, tile);
  for (int k = 0; k < 9; ++k) {
    if (k == 4) continue;
    const int dx = k % 3 - 1, dy = k / 3 - 1;
    const FluidTile* n = t.near[k] == FluidTile::kNone ? nullptr : &tiles[t.near[k]];
    const std::size_t of = n != nullptr && n->dry ? of_dry : of_near;
    if (of == kNothing) n = nullptr;
    const std::int32_t wide = dx < 0 ? 1 : dx > 0 ? 2 : t.wide, high = dy < 0 ? 1 : dy > 0 ? 2 : t.high;
    copy_nodes(to,
               dx < 0   ? -1
               : dx > 0 ? t.wide
                        : 0,
               dy < 0   ? -1
               : dy > 0 ? t.high
                        : 0,
               n != nullptr ? field(of, t.near[k]) : nullptr, dx < 0 && n != nullptr ? n->wide - 1 : 0,
               dy < 0 && n != nullptr ? n->high - 1 : 0, wide, high);
  }
}

}  // namespace psim
