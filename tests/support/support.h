// Worlds and scenes in one line, for the tests. Public API only. A world that cannot be made is a
// broken test: it throws, and GoogleTest reports it.
#pragma once

#include <gtest/gtest.h>
#include <psim/psim.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "reference/pairs.h"

namespace psim::test {

inline constexpr double kG = 9.81;
inline constexpr double kPi = std::numbers::pi;
inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInf = std::numeric_limits<double>::infinity();

inline std::vector<Isa> available_isas() {
  std::vector<Isa> isas;
  for (const Isa isa : kAllIsas) {
    if (isa_available(isa)) isas.push_back(isa);
  }
  return isas;
}

/// Same numbers with every compiler and library (splitmix64).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t bits() {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
  }
  double uniform(double low, double high) { return low + (high - low) * static_cast<double>(bits() >> 11) * 0x1p-53; }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(bits() % n); }
  bool chance(double p) { return uniform(0, 1) < p; }
  /// Normal distribution, by Box and Muller.
  double normal() { return std::sqrt(-2 * std::log(uniform(1e-300, 1))) * std::cos(uniform(0, 2 * kPi)); }

 private:
  std::uint64_t state_;
};

// ---- worlds -----------------------------------------------------------------------------------

inline Material material(double restitution, double friction = 0, double density = 1) {
  return {density, restitution, friction};
}

inline WorldDesc walled(Bounds bounds, Vec2 gravity = {0, -kG}, Material wall = {}) {
  WorldDesc desc;
  desc.bounds = bounds;
  desc.boundary = Boundary::walls;
  desc.gravity = gravity;
  desc.wall = wall;
  return desc;
}

inline WorldDesc periodic(double width, double height) {
  WorldDesc desc;
  desc.bounds = {0, 0, width, height};
  desc.boundary = Boundary::periodic;
  desc.gravity = {0, 0};
  return desc;
}

/// Open, and so large that nothing leaves.
inline WorldDesc unbounded(double half = 100, Vec2 gravity = {0, -kG}) {
  WorldDesc desc;
  desc.bounds = {-half, -half, half, half};
  desc.boundary = Boundary::open;
  desc.gravity = gravity;
  return desc;
}

inline std::unique_ptr<World> make(const WorldDesc& desc, Isa isa = best_isa(), int threads = 1) {
  std::string error;
  auto world = World::create(desc, RunOptions{isa, threads}, error);
  if (!world) throw std::runtime_error("World::create: " + error);
  return world;
}

// ---- bodies -----------------------------------------------------------------------------------

inline BodyDesc disc(Vec2 position, Vec2 velocity = {}, double radius = 0.5, Material m = {}) {
  BodyDesc body;
  body.shape = DiscShape{radius};
  body.position = position;
  body.velocity = velocity;
  body.material = m;
  return body;
}

inline BodyDesc static_disc(Vec2 position, double radius, Material m = {}) {
  BodyDesc body = disc(position, {}, radius, m);
  body.type = BodyType::static_body;
  return body;
}

inline BodyDesc segment(Vec2 p1, Vec2 p2, Material m = {}) {
  BodyDesc body;
  body.type = BodyType::static_body;
  body.shape = SegmentShape{p1, p2};
  body.material = m;
  return body;
}

inline BodyDesc chain(std::vector<Vec2> vertices, bool loop = false, Material m = {}) {
  BodyDesc body;
  body.type = BodyType::static_body;
  body.shape = ChainShape{std::move(vertices), loop};
  body.material = m;
  return body;
}

/// Level ground through y = 0.
inline BodyDesc ground(Material m = {}, double half = 100) { return segment({-half, 0}, {half, 0}, m); }

inline BodyId add(World& world, const BodyDesc& body) {
  std::string error;
  const BodyId id = world.add_body(body, error);
  if (id == kNoBody) throw std::runtime_error("World::add_body: " + error);
  return id;
}

inline BodyState state(const World& world, BodyId id) {
  const auto body = world.body(id);
  if (!body) throw std::runtime_error("no such body");
  return *body;
}

/// Columns of discs that share a material, to add in bulk.
struct Discs {
  std::vector<double> x, y, radius, vx, vy;
  Material m;

  std::size_t size() const { return x.size(); }
  void push(double px, double py, double r, double ux = 0, double uy = 0) {
    x.push_back(px);
    y.push_back(py);
    radius.push_back(r);
    vx.push_back(ux);
    vy.push_back(uy);
  }
  /// Somewhere in a region. Numbers are drawn one after the other: compilers evaluate arguments in different orders.
  void push(Random& random, Bounds in, double r) {
    const double py = random.uniform(in.ymin, in.ymax), px = random.uniform(in.xmin, in.xmax);
    push(px, py, r);
  }
};

inline std::uint32_t add(World& world, const Discs& discs) {
  DiscBatch batch;
  batch.x = discs.x;
  batch.y = discs.y;
  batch.radius = discs.radius;
  batch.vx = discs.vx;
  batch.vy = discs.vy;
  batch.material = discs.m;
  std::uint32_t first = 0;
  std::string error;
  if (world.add_discs(batch, first, error) != discs.size()) {
    throw std::runtime_error("World::add_discs: " + error);
  }
  return first;
}

/// n discs on a lattice over the region, each moved by up to `jitter` of the free gap, with
/// velocities uniform in +-speed on each axis.
inline Discs lattice(std::size_t n, Bounds region, double radius, double speed, Material m, double jitter = 0.5,
                     std::uint64_t seed = 1) {
  Random random(seed);
  const double width = region.xmax - region.xmin, height = region.ymax - region.ymin;
  const auto columns = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(n) * width / height)));
  const std::size_t rows = (n + columns - 1) / columns;
  const double dx = width / static_cast<double>(columns);
  const double dy = height / static_cast<double>(rows);
  if (std::min(dx, dy) < 2 * radius) throw std::runtime_error("lattice too tight");
  Discs discs;
  discs.m = m;
  for (std::size_t k = 0; k < n; ++k) {
    const double jx = jitter * (0.5 * dx - radius), jy = jitter * (0.5 * dy - radius);
    const double px = region.xmin + (static_cast<double>(k % columns) + 0.5) * dx;
    const double py = region.ymin + (static_cast<double>(k / columns) + 0.5) * dy;
    const double v = random.uniform(-speed, speed), u = random.uniform(-speed, speed);
    const double y = py + random.uniform(-jy, jy), x = px + random.uniform(-jx, jx);
    discs.push(x, y, radius, u, v);
  }
  return discs;
}

/// A gas of n discs of radius 0.5, at `packing`, in walls with the discs' own material.
inline std::unique_ptr<World> gas_in_walls(std::size_t n, double packing, Material m, double speed = 10,
                                           Isa isa = best_isa(), int threads = 1) {
  const double side = std::sqrt(static_cast<double>(n) * kPi * 0.25 / packing);
  auto world = make(walled({0, 0, side, side}, {0, 0}, m), isa, threads);
  add(*world, lattice(n, {0, 0, side, side}, 0.5, speed, m));
  return world;
}

inline std::unique_ptr<World> gas_in_period(std::size_t n, double packing, Material m, double speed = 10,
                                            Isa isa = best_isa(), int threads = 1) {
  const double side = std::sqrt(static_cast<double>(n) * kPi * 0.25 / packing);
  auto world = make(periodic(side, side), isa, threads);
  add(*world, lattice(n, {0, 0, side, side}, 0.5, speed, m));
  return world;
}

/// n discs of radius 0.5 let go as a loose lattice in a bin that they fill about square.
inline std::unique_ptr<World> pile(std::size_t n, Material m = {}, Isa isa = best_isa(), int threads = 1) {
  const double columns = std::ceil(std::sqrt(static_cast<double>(n)));
  const double width = columns * 1.02 + 1;
  auto world = make(walled({0, 0, width, 4 * width}, {0, -kG}, m), isa, threads);
  add(*world, lattice(n, {0.5, 0.5, width - 0.5, 0.5 + columns * 1.02}, 0.5, 0, m));
  return world;
}

// ---- running and looking ----------------------------------------------------------------------

inline void run(World& world, int frames) {
  for (int k = 0; k < frames; ++k) world.step();
}

/// As many frames as make up the time.
inline void run_seconds(World& world, double seconds) {
  run(world, static_cast<int>(std::lround(seconds / world.desc().dt)));
}

inline std::vector<std::uint64_t> hashes(World& world, int frames) {
  std::vector<std::uint64_t> all;
  for (int k = 0; k < frames; ++k) {
    world.step();
    all.push_back(world.state_hash());
  }
  return all;
}

inline double energy(const World& world) {
  const Diagnostics d = world.diagnostics();
  return d.kinetic + d.potential;
}

inline bool all_finite(World& world) {
  const PublishedState s = world.published();
  for (std::size_t k = 0; k < s.id.size(); ++k) {
    if (!std::isfinite(s.x[k] + s.y[k] + s.angle[k] + s.vx[k] + s.vy[k] + s.omega[k])) return false;
  }
  return true;
}

/// Depth of every overlap: discs with each other (periodic or not), and with the four walls.
inline std::vector<double> penetrations(World& world) {
  const WorldDesc& desc = world.desc();
  const PublishedState s = world.published();
  reference::Periods periods;
  if (desc.boundary == Boundary::periodic) {
    periods = {desc.bounds.xmax - desc.bounds.xmin, desc.bounds.ymax - desc.bounds.ymin};
  }
  std::vector<double> depths;
  for (const auto& pair : reference::pairs_closer_than(s.x, s.y, s.radius, 0, periods)) {
    if (s.radius[pair.a] > 0 && s.radius[pair.b] > 0) depths.push_back(-pair.gap);
  }
  if (desc.boundary == Boundary::walls) {
    const Bounds b = desc.bounds;
    for (std::size_t k = 0; k < s.id.size(); ++k) {
      if (s.type[k] != BodyType::dynamic_body) continue;
      for (const double gap : {s.x[k] - b.xmin, b.xmax - s.x[k], s.y[k] - b.ymin, b.ymax - s.y[k]}) {
        if (gap < s.radius[k]) depths.push_back(s.radius[k] - gap);
      }
    }
  }
  std::sort(depths.begin(), depths.end());
  return depths;
}

inline double deepest(World& world) {
  const auto depths = penetrations(world);
  return depths.empty() ? 0 : depths.back();
}

inline double quantile(const std::vector<double>& sorted, double q) {
  if (sorted.empty()) return 0;
  return sorted[static_cast<std::size_t>(q * static_cast<double>(sorted.size() - 1))];
}

inline double rms_speed(World& world) {
  const PublishedState s = world.published();
  double sum = 0;
  std::size_t n = 0;
  for (std::size_t k = 0; k < s.id.size(); ++k) {
    if (s.type[k] != BodyType::dynamic_body) continue;
    sum += s.vx[k] * s.vx[k] + s.vy[k] * s.vy[k];
    ++n;
  }
  return n ? std::sqrt(sum / static_cast<double>(n)) : 0;
}

/// |sum of momenta| / sum of |momenta|, for discs of one mass.
inline double relative_momentum(World& world) {
  const PublishedState s = world.published();
  double px = 0, py = 0, sum = 0;
  for (std::size_t k = 0; k < s.id.size(); ++k) {
    px += s.vx[k];
    py += s.vy[k];
    sum += std::hypot(s.vx[k], s.vy[k]);
  }
  return sum > 0 ? std::hypot(px, py) / sum : 0;
}

/// Centre of every dynamic body inside the bounds.
inline bool all_inside(World& world) {
  const Bounds b = world.desc().bounds;
  const PublishedState s = world.published();
  for (std::size_t k = 0; k < s.id.size(); ++k) {
    if (s.type[k] != BodyType::dynamic_body) continue;
    if (!(s.x[k] >= b.xmin && s.x[k] <= b.xmax && s.y[k] >= b.ymin && s.y[k] <= b.ymax)) {
      return false;
    }
  }
  return true;
}

}  // namespace psim::test
