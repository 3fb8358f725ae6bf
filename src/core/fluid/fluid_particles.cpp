#include "fluid/fluid_particles.h"

#include <algorithm>
#include <cmath>

namespace psim {

using kernels::FluidParticle;
using kernels::kTile;

namespace {

/// Particles nearer than this to the edge of a tile, in cells, need the tile beside it.
constexpr float kNear = 2;
/// Longest way for which shapes are looked up, tiles.
constexpr float kFarthestLook = 4;

std::int32_t floor_div(std::int32_t a, std::int32_t b) { return a >= 0 ? a / b : -((b - 1 - a) / b); }

// A coordinate that is counted from the corner of tile `tile`: moved to the tile that it is in.
void to_tile(float& x, std::int32_t& tile, std::int32_t cells, bool wraps) {
  constexpr float kFarthest = 0x1p26f;  // cells in a step
  x = std::isnan(x) ? 0 : std::clamp(x, -kFarthest, kFarthest);
  const float whole = std::floor(x);
  std::int32_t cell = kTile * tile + static_cast<std::int32_t>(whole);
  float rest = x - whole;
  if (rest >= 1) rest = 0x1.fffffep-1f;
  if (wraps) cell = (cell % cells + cells) % cells;
  tile = floor_div(cell, kTile);
  x = static_cast<float>(cell - kTile * tile) + rest;
}

// Cells of a tile along an axis.
float width_of(std::int32_t tile, std::int32_t cells) {
  return static_cast<float>(cells > 0 ? std::min(kTile, cells - kTile * tile) : kTile);
}

}  // namespace

void FluidParticles::make_room(std::size_t n) {
  list_.reserve_loosely(count_ + n);
  sorted_.reserve(list_.capacity());
  tile_of_.reserve(list_.capacity());
  if (added_.capacity() - added_.size() < n) added_.reserve(added_.size() + std::max(n, added_.size()));
}

void FluidParticles::clear() {
  count_ = 0;
  next_id_ = 0;
  added_.clear();
}

void FluidParticles::add(double x, double y, Vec2 velocity, std::uint32_t fluid, const FluidSpace& space) {
  list_.reserve_loosely(count_ + 1);
  const auto tile_of = [](double at) { return static_cast<std::int32_t>(std::floor(at / kTile)); };
  std::int32_t tx = tile_of(x), ty = tile_of(y);
  FluidParticle p{};
  p.x = static_cast<float>(x - double{kTile} * tx);
  p.y = static_cast<float>(y - double{kTile} * ty);
  const bool wraps = space.boundary == Boundary::periodic;
  to_tile(p.x, tx, space.cells_x, wraps);
  to_tile(p.y, ty, space.cells_y, wraps);
  p.u = static_cast<float>(velocity.x);
  p.v = static_cast<float>(velocity.y);
  p.id = next_id_++;
  p.fluid = fluid;
  list_[count_++] = p;
  added_.push_back(tile_key(tx, ty));
}

namespace {

/// Particles keep so far from walls, cells.
constexpr float kApart = 0.125f;

// Where a particle went beyond a wall it comes back by as far, so that fast particles do not all end on one line.
void keep_between(float& x, float& speed, float low, float high) {
  if (x < low) {
    x = std::min(low + (low - x), high);
    speed = std::max(speed, 0.0f);
  } else if (x > high) {
    x = std::max(high - (x - high), low);
    speed = std::min(speed, 0.0f);
  }
}

// The tile that places of particles are counted from.
struct Home {
  std::int32_t x = 0, y = 0;
  float wide = 0, high = 0;
  bool near_wall = false;  // a place within it may be beyond a wall

  Home() = default;
  Home(std::uint64_t key, const FluidSpace& space)
      : x(column_of(key)), y(row_of(key)), wide(width_of(x, space.cells_x)), high(width_of(y, space.cells_y)) {
    const auto may = [](std::int32_t tile, float between) {
      const auto first = static_cast<float>(kTile * tile);
      return first < 1 + kApart || first + kTile > 1 + between - kApart;
    };
    near_wall = space.boundary == Boundary::walls && (may(x, space.wide) || may(y, space.high));
  }
  bool holds(const FluidParticle& p) const { return p.x >= 0 && p.x < wide && p.y >= 0 && p.y < high; }
};

// Keeps a particle within the walls of the world. `x`, `y`: the tile that its place is counted from.
void keep_within(const FluidSpace& space, std::int32_t x, std::int32_t y, FluidParticle& p) {
  const auto left = static_cast<float>(kTile * x), bottom = static_cast<float>(kTile * y);
  keep_between(p.x, p.u, 1 + kApart - left, 1 + space.wide - kApart - left);
  keep_between(p.y, p.v, 1 + kApart - bottom, 1 + space.high - kApart - bottom);
}

// The sides of a tile that a particle is near: bit k for FluidTile::near[k].
std::uint32_t sides_of(const FluidParticle& p, float wide, float high) {
  const bool left = p.x < kNear, right = p.x >= wide - kNear, below = p.y < kNear, above = p.y >= high - kNear;
  const std::uint32_t row = 2u | (left ? 1u : 0u) | (right ? 4u : 0u);
  return row << 3 | (below ? row : 0u) | (above ? row << 6 : 0u);
}

// Adds the keys of the tiles at these sides of a tile, but for those among the last ones: particles come tile by tile, so
// most keys would be there again and again.
constexpr std::ptrdiff_t kLastKeys = 16;
void note_tiles(std::uint64_t tile, std::uint32_t sides, const FluidSpace& space, std::vector<std::uint64_t>& keys) {
  for (std::int32_t k = 0; k < 9; ++k) {
    bool there = (sides >> k & 1) != 0;
    if (!there) continue;
    const std::uint64_t key = neighbour_key(space, 0, column_of(tile) + k % 3 - 1, row_of(tile) + k / 3 - 1, there);
    if (!there) continue;
    const auto last = keys.end() - std::min<std::ptrdiff_t>(std::ssize(keys), kLastKeys);
    if (std::find(last, keys.end(), key) == keys.end()) keys.push_back(key);
  }
}

void sort_keys(std::vector<std::uint64_t>& keys) {
  std::ranges::sort(keys);  // Total order: keys that are equal are the same.
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
}

std::size_t place_in(const std::vector<std::uint64_t>& keys, std::uint64_t key) {
  return static_cast<std::size_t>(std::ranges::lower_bound(keys, key) - keys.begin());
}

// Keeps a particle, which was at `from`, out of shapes, and within the walls of the world. `home` is the tile that its place
// is counted from.
void keep_out_of(const FluidBodies& bodies, std::span<const FluidSolid> solids, Place2 from, float dt,
                 const FluidSpace& space, const Home& home, const float* mass, FluidParticle& p,
                 std::vector<FluidHits>& hits) {
  const bool walls = space.boundary == Boundary::walls;
  const auto wide = static_cast<float>(space.cell_x), high = static_cast<float>(space.cell_y);
  const float cell = std::max(wide, high);
  Place2 at{p.x * wide, p.y * high}, speed{p.u, p.v};
  const bool changed =
      bodies.keep_out(solids, {from.x * wide, from.y * high}, dt, cell, at, speed, mass[p.fluid], hits);
  const auto put = [&] {
    p.x = at.x / wide;
    p.y = at.y / high;
    if (walls) keep_within(space, home.x, home.y, p);
  };
  if (!changed) {
    if (walls) keep_within(space, home.x, home.y, p);
    return;
  }
  p.u = speed.x;
  p.v = speed.y;
  put();
  at = {p.x * wide, p.y * high};
  bodies.slip_out(solids, cell, at);
  put();
}

}  // namespace

void FluidParticles::keep_out(const FluidTile& tile, std::span<const FluidSolid> solids, std::span<const Place2> from,
                              const float* mass, const FluidSpace& space, const FluidBodies& bodies,
                              std::vector<FluidHits>& hits) {
  const Home home(tile_key(tile.x, tile.y), space);
  for (std::uint32_t k = 0; k < tile.count; ++k) {
    keep_out_of(bodies, solids, from[k], 0, space, home, mass, list_[tile.first + k], hits);
  }
}

// Finds the shapes around the tiles that particles are in, as far as the fastest of them goes.
void FluidParticles::look_around(const FluidSpace& space, const kernels::FluidMotion& motion, WorkerPool& pool,
                                 FluidBodies& bodies) {
  float most = 0;
  for (std::size_t k = 0; k < count_; ++k) {
    const FluidParticle& p = list_[k];
    most = std::max(most, std::max(std::fabs(p.u), std::fabs(p.v)));
  }
  const float fall = std::max(std::fabs(motion.gravity_x), std::fabs(motion.gravity_y)) * motion.dt;
  const float reach = std::min(2 * motion.dt * (most + fall), kFarthestLook * kTile * motion.cell_x) + motion.cell_x;
  old_keys_.clear();
  for (const FluidTile& tile : old_tiles_) old_keys_.push_back(tile_key(tile.x, tile.y));
  old_keys_.insert(old_keys_.end(), added_.begin(), added_.end());
  sort_keys(old_keys_);
  bodies.look_around(old_keys_, space, reach, pool);
}

void FluidParticles::note_places(std::size_t begin, std::size_t end, std::vector<Place2>& places) const {
  places.clear();
  for (std::size_t k = begin; k < end; ++k) places.push_back({list_[k].x, list_[k].y});
}

// Moves the particles of a job, and notes the tile of each and the tiles that they are in or near.
void FluidParticles::move_chunk(std::size_t job, const FluidSpace& space, const kernels::FluidMotion& motion,
                                const kernels::KernelTable& kernels, FluidBodies& bodies, float bodies_moved) {
  const std::size_t begin = job * kChunk, end = std::min(count_, begin + kChunk), old = count_ - added_.size();
  const bool wraps = space.boundary == Boundary::periodic, walls = space.boundary == Boundary::walls;
  std::vector<std::uint64_t>& keys = chunks_[job].keys;
  keys.clear();
  std::uint64_t last = 0;
  float last_wide = 0, last_high = 0;
  std::uint32_t sides = 0;  // that particles of the tile `last` are near
  chunks_[job].hits.clear();
  if (bodies.there()) note_places(begin, end, chunks_[job].from);
  kernels.move_fluid(list_.data() + begin, end - begin, motion);
  std::uint32_t of = old_tile_[job];
  std::uint64_t from = 0;  // the tile that the particles were in
  Home home;
  std::span<FluidSolid> solids;
  for (std::size_t k = begin; k < end; ++k) {
    FluidParticle& p = list_[k];
    std::uint64_t was = from;
    if (k >= old) {
      was = added_[k - old];
    } else if (old_tiles_[of].first + old_tiles_[of].count <= k || k == begin) {
      while (old_tiles_[of].first + old_tiles_[of].count <= k) ++of;
      was = tile_key(old_tiles_[of].x, old_tiles_[of].y);
    }
    if (was != from) {
      from = was;
      home = Home(was, space);
      solids = bodies.there() ? bodies.around(place_in(old_keys_, was)) : std::span<FluidSolid>();
    }
    if (home.near_wall || (walls && !home.holds(p))) keep_within(space, home.x, home.y, p);
    if (!solids.empty()) {
      // Beyond a wall of the world a particle might pass a shape that leans against it, and come back behind it.
      keep_out_of(bodies, solids, chunks_[job].from[k - begin], bodies_moved, space, home, motion.mass, p,
                  chunks_[job].hits);
    }
    std::uint64_t key = from;
    if (!home.holds(p)) {
      std::int32_t tx = home.x, ty = home.y;
      to_tile(p.x, tx, space.cells_x, wraps);
      to_tile(p.y, ty, space.cells_y, wraps);
      key = tile_key(tx, ty);
    }
    tile_of_[k] = key;
    if (key != last) {
      note_tiles(last, sides, space, keys);
      sides = 0;
      last = key;
      last_wide = width_of(column_of(key), space.cells_x);
      last_high = width_of(row_of(key), space.cells_y);
    }
    sides |= sides_of(p, last_wide, last_high);
  }
  note_tiles(last, sides, space, keys);
  sort_keys(keys);
}

void FluidParticles::lay_tiles(const FluidSpace& space, FluidGrid& grid) {
  keys_.clear();
  for (const Chunk& chunk : chunks_) keys_.insert(keys_.end(), chunk.keys.begin(), chunk.keys.end());
  sort_keys(keys_);
  grid.lay(keys_, space, 0);
}

void FluidParticles::count_chunk(std::size_t job, const FluidGrid& grid) {
  std::vector<std::uint32_t>& counts = chunks_[job].counts;
  counts.assign(grid.size(), 0);
  std::uint64_t last = ~std::uint64_t{0};
  std::uint32_t at = 0;
  for (std::size_t k = job * kChunk; k < std::min(count_, (job + 1) * kChunk); ++k) {
    if (tile_of_[k] != last) {
      last = tile_of_[k];
      at = grid.find(last);
    }
    tile_of_[k] = at;
    ++counts[at];
  }
}

void FluidParticles::move(const FluidSpace& space, const kernels::FluidMotion& motion,
                          const kernels::KernelTable& kernels, FluidGrid& grid, WorkerPool& pool, FluidBodies& bodies,
                          float bodies_moved) {
  const std::size_t jobs = (count_ + kChunk - 1) / kChunk;
  sorted_.reserve(list_.capacity());
  tile_of_.reserve(list_.capacity());
  chunks_.resize(jobs);
  old_tiles_.assign(grid.tiles.begin(), grid.tiles.end());
  old_tile_.assign(jobs, 0);
  std::uint32_t tile = 0;
  for (std::size_t job = 0; job < jobs; ++job) {
    while (tile < old_tiles_.size() && old_tiles_[tile].first + old_tiles_[tile].count <= job * kChunk) ++tile;
    old_tile_[job] = tile;
  }
  if (bodies.there()) look_around(space, motion, pool, bodies);
  pool.run(jobs, [&](std::size_t job) { move_chunk(job, space, motion, kernels, bodies, bodies_moved); });
  for (const Chunk& chunk : chunks_) bodies.take_hits(chunk.hits, space.cell_x * space.cell_y);
  lay_tiles(space, grid);
  pool.run(jobs, [&](std::size_t job) { count_chunk(job, grid); });
  std::uint32_t first = 0;
  for (std::size_t t = 0; t < grid.size(); ++t) {
    grid.tiles[t].first = first;
    for (Chunk& chunk : chunks_) {
      const std::uint32_t n = chunk.counts[t];
      chunk.counts[t] = first;
      first += n;
    }
    grid.tiles[t].count = first - grid.tiles[t].first;
  }
  pool.run(jobs, [&](std::size_t job) {
    std::vector<std::uint32_t>& next = chunks_[job].counts;
    for (std::size_t k = job * kChunk; k < std::min(count_, (job + 1) * kChunk); ++k) {
      sorted_[next[tile_of_[k]]++] = list_[k];
    }
  });
  list_.swap(sorted_);
  added_.clear();
}

std::size_t FluidParticles::remove(const Bounds& box, bool within, FluidGrid& grid, const FluidSpace& space) {
  const auto goes = [&](Vec2 at) {
    const bool inside = at.x >= box.xmin && at.x <= box.xmax && at.y >= box.ymin && at.y <= box.ymax;
    return inside == within;
  };
  // Whether no particle of a tile can go.
  const auto stays = [&](const FluidTile& tile) {
    if (within) return beside(tile, box, space);
    FluidParticle corner{}, other{};
    other.x = other.y = static_cast<float>(kTile);
    return !goes(place_of(corner, tile, space)) && !goes(place_of(other, tile, space));
  };
  if (std::ranges::all_of(grid.tiles, [&](const FluidTile& tile) { return tile.count == 0 || stays(tile); })) return 0;
  std::uint32_t to = 0;
  for (FluidTile& tile : grid.tiles) {
    const std::uint32_t first = tile.first, end = first + tile.count;
    const bool all = stays(tile);
    tile.first = to;
    for (std::uint32_t k = first; k < end; ++k) {
      if (all || !goes(place_of(list_[k], tile, space))) list_[to++] = list_[k];
    }
    tile.count = to - tile.first;
  }
  const std::size_t removed = count_ - to;
  count_ = to;
  return removed;
}

}  // namespace psim
