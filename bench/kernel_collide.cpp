// Narrow phase of boxes: `size` pairs of unit boxes as they lie in a pile, each half a box beside the one
// below it, tilted by a hundredth of a radian and up to 1 % of a box apart or sunk. Elements are pairs.
//   CollideHulls       the kernel alone, over blocks that stand ready
//   NarrowPhaseBoxes   from hulls and places to manifolds, through batches as the engine does it
//   NarrowPhaseBoxes/one-by-one   the same by collide(), a pair at a time
// NarrowPhaseTriangles and NarrowPhaseHexagons do the same with polygons of 3 and 6 vertices.
#include <benchmark/benchmark.h>

#include <cmath>
#include <ctime>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "collide/collide.h"
#include "collide/collide_batch.h"
#include "fixtures.h"
#include "workload.h"

namespace psim::bench {
namespace {

using kernels::HullPairs;
using kernels::kBlock;

struct Place {
  Rotor qa, qb;
  float dx, dy;
};
constexpr float kMargin = 0.05f;  // m

// A regular polygon with a level lowest side, half a metre over it.
Hull polygon(int sides) {
  Hull hull;
  hull.count = sides;
  const double step = 2 * 3.14159265358979 / sides, radius = 0.5 / std::cos(0.5 * step);
  for (int k = 0; k < sides; ++k) {
    hull.x[k] = static_cast<float>(radius * std::sin((k - 0.5) * step));
    hull.y[k] = static_cast<float>(-radius * std::cos((k - 0.5) * step));
  }
  finish_hull(hull);
  return hull;
}

std::vector<Place> places(std::uint32_t n) {
  Random random(1);
  const auto rotor = [&] {
    const double angle = random.uniform(-0.01, 0.01);
    return Rotor{static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))};
  };
  std::vector<Place> out(n);
  for (Place& p : out) {
    p = {rotor(), rotor(), random.uniform(0, 1) < 0.5 ? -0.5f : 0.5f,
         static_cast<float>(1 + random.uniform(-0.01, 0.01))};
  }
  return out;
}

class Polygons : public Workload {
 public:
  Polygons(int sides, std::uint32_t n) : hull_(polygon(sides)), places_(places(n)), manifolds_(n) {
    elements = n;
    bytes = sizeof(Place) + sizeof(Manifold);
  }
  void pass(const kernels::KernelTable& k) override {
    const std::uint32_t kind = CollideBatch::kind_of(hull_, hull_);
    for (std::size_t first = 0; first < places_.size(); first += kBlock) {
      CollideBatch batch;
      for (std::size_t p = first; p < places_.size() && !batch.full(); ++p) {
        batch.add(hull_, places_[p].qa, hull_, places_[p].qb, places_[p].dx, places_[p].dy, kMargin);
      }
      batch.solve(k, kind);
      for (std::uint32_t l = 0; l < batch.count(); ++l) manifolds_[first + l] = batch.manifold(l);
    }
  }
  void one_by_one() {
    for (std::size_t p = 0; p < places_.size(); ++p) {
      manifolds_[p] = collide(hull_, places_[p].qa, hull_, places_[p].qb, places_[p].dx, places_[p].dy, kMargin);
    }
  }

 private:
  Hull hull_;
  std::vector<Place> places_;
  std::vector<Manifold> manifolds_;
};

class Hulls : public Workload {
 public:
  explicit Hulls(std::uint32_t n) : blocks_((n + kBlock - 1) / kBlock) {
    const std::vector<Place> all = places(n);
    for (std::size_t p = 0; p < blocks_.size() * kBlock; ++p) {
      HullPairs& c = blocks_[p / kBlock];
      const Place& place = all[p % n];
      const std::size_t l = p % kBlock;
      c.a[l] = c.b[l] = box_.x;
      c.vertices_a[l] = c.vertices_b[l] = 4;
      c.ac[l] = place.qa.c, c.as[l] = place.qa.s, c.bc[l] = place.qb.c, c.bs[l] = place.qb.s;
      c.dx[l] = place.dx, c.dy[l] = place.dy, c.margin[l] = kMargin;
    }
    elements = n;
    bytes = static_cast<double>(sizeof(HullPairs)) / kBlock;
  }
  void pass(const kernels::KernelTable& k) override {
    k.collide[1][2](blocks_.data(), 0, static_cast<std::uint32_t>(blocks_.size()));
  }

 private:
  Hull box_ = polygon(4);
  std::vector<HullPairs> blocks_;
};

}  // namespace

void register_collide_kernels() {
  register_kernel("CollideHulls", [](std::uint32_t n) { return std::make_unique<Hulls>(n); });
  const std::pair<const char*, int> shapes[] = {
      {"NarrowPhaseBoxes", 4}, {"NarrowPhaseTriangles", 3}, {"NarrowPhaseHexagons", 6}};
  for (const auto& [name, sides] : shapes) {
    register_kernel(name, [sides = sides](std::uint32_t n) { return std::make_unique<Polygons>(sides, n); });
    for (const std::uint32_t n : kSizes) {
      const std::string alone = name + std::string("/one-by-one/") + std::to_string(n);
      benchmark::RegisterBenchmark(alone.c_str(), [n, sides = sides](benchmark::State& state) {
        Polygons polygons(sides, n);
        polygons.one_by_one();
        const std::clock_t begin = std::clock();
        for (auto _ : state) polygons.one_by_one();
        const double spent = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
        state.counters["ns_per_element"] = 1e9 * spent / (static_cast<double>(state.iterations()) * n);
      })->Unit(benchmark::kMicrosecond);
    }
  }
}

}  // namespace psim::bench
