// What a scene will take. Bodies count as estimate_memory_bytes() has them, with the pairs that a packing of discs has; what
// lies closer than that has more pairs, and pairs of shapes take more. Pairs are counted by cells: bodies of about one size
// in cells of twice their diameter, and each body asks the cells of its own size and of all larger ones.
#include <bit>
#include <cmath>
#include <cstdint>
#include <map>
#include <unordered_map>
#include <vector>

#include "base/elementary.h"
#include "base/sort_keys.h"
#include "check/survey.h"
#include "place/fluid_places.h"

namespace psim {
namespace {

constexpr double kPackedPairs = 3;       // a body: what estimate_memory_bytes() has room for
constexpr double kPairBytes = 170;       // of discs: two tables, a contact, room to grow
constexpr double kShapePairBytes = 650;  // if one of the two is no disc
constexpr double kJointBytes = 700;
constexpr std::uint64_t kParticleBytes = 400;  // of a fluid, with its share of the grid
constexpr double kAlike = 0.6,
                 kLarger = 0.7;  // share of a cell's bodies that are near, of the same and of a larger size

struct Cell {
  std::uint32_t discs = 0, shapes = 0;
};

// The bodies that move, of radii from 2^exponent m up to twice that.
struct Size {
  double side = 0;                                // m, of a cell
  std::unordered_map<std::uint64_t, Cell> cells;  // for look-up only

  std::uint64_t key(const PlacedBody& b) const {
    const auto number = [this](double v) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(lesser(greater(v / side, -1e15), 1e15))));
    };
    return mixed(number(b.x)) ^ number(b.y);
  }
};

}  // namespace

SceneForecast forecast(const Scene& scene) {
  SceneForecast sum;
  sum.bodies = scene.body_count();
  const Survey survey = look_at(scene);
  std::map<int, Size> sizes;
  const auto size_of = [](const PlacedBody& b) { return std::ilogb(greater(b.radius, 1e-9)); };
  for (const PlacedBody& b : survey.bodies) {
    if (!b.moves) continue;
    Size& size = sizes[size_of(b)];
    size.side = std::ldexp(4.0, size_of(b));
    Cell& cell = size.cells[size.key(b)];
    (b.hulls ? cell.shapes : cell.discs) += 1;
  }
  double discs = 0, shapes = 0;
  for (const PlacedBody& b : survey.bodies) {
    if (!b.moves) continue;
    for (auto size = sizes.find(size_of(b)); size != sizes.end(); ++size) {
      const auto found = size->second.cells.find(size->second.key(b));
      if (found == size->second.cells.end()) continue;
      const bool alike = size->first == size_of(b);
      const double share = alike ? kAlike : kLarger;
      const Cell& cell = found->second;
      const double with_discs = share * cell.discs, with_shapes = share * cell.shapes;
      (b.hulls ? shapes : discs) += with_discs - (alike ? share : 0);
      shapes += with_shapes;
    }
  }
  auto joints = static_cast<double>(scene.joints.size());
  for (const GroupDesc& group : scene.groups) {  // a node of a net has two links, or four
    if (group.links) joints += (group.links->diagonals ? 4 : 2) * static_cast<double>(group.count);
  }
  const double packed = kPackedPairs * static_cast<double>(sum.bodies);
  sum.pairs = static_cast<std::uint64_t>(discs + shapes);
  sum.bytes =
      estimate_memory_bytes(sum.bodies) + static_cast<std::uint64_t>(kPairBytes * greater(discs + shapes - packed, 0) +
                                                                     kShapePairBytes * shapes + kJointBytes * joints);
  for (const SceneFluid& fluid : scene.fluids) sum.bytes += kParticleBytes * count_particles(fluid);
  return sum;
}

}  // namespace psim
