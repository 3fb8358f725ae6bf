// Shapes that are solid from one side (BodyDesc::one_way). A body that comes against their direction meets them; any other
// one goes through, until it is apart from them again.
#include "manifolds/manifold_look.h"

namespace psim {
namespace {

constexpr double kComes = Manifolds::kSolidSide, kStays = 0;  // a body that lies there may roll over an edge
constexpr float kPlacedDeep = 0.1f;  // share of the inner radius: a body that is put there no deeper lies on the side

}  // namespace

Vec2 Manifolds::one_way_of(const PairName& pair, bool of_b) const {
  const BodyStore& b = s_.bodies;
  if (!of_b && pair.of_wall()) return {};
  const std::uint32_t id = of_b ? pair.id_b : pair.id_a;
  if (!of_b && pair.of_piece()) return b.one_way_of(b.kind(id), s_.statics[pair.shape].part);
  const Vec2 way = b.one_way_of(b.kind(id), of_b ? pair.part_b : pair.part_a);
  if (way == Vec2{}) return {};
  const Rotor q = rotor(of_b ? pair.b : pair.a);
  return turned({q.s, q.c}, way);
}

// Whether the bodies of a pair, whose hulls were just looked at, go through each other.
bool Manifolds::Look::go_through(ManifoldPair& pair, const Stand& now) const {
  const Vec2 way_a = manifolds.one_way_of(pair, false), way_b = manifolds.one_way_of(pair, true);
  if (way_a == Vec2{} && way_b == Vec2{}) return false;
  const ManifoldPair::Crossing before = std::exchange(pair.crossing, ManifoldPair::kUnknown);
  const Manifold& m = pair.manifold;
  if (m.count == 0) return false;
  const Vec2 n{m.nx, m.ny};
  const auto on_side = [&](double least) {
    return (way_a == Vec2{} || dot(n, way_a) > least) && (way_b == Vec2{} || -dot(n, way_b) > least);
  };
  float gap = m.point[0].gap;
  if (m.count == 2) gap = std::min(gap, m.point[1].gap);
  bool meets = false;
  if (before == ManifoldPair::kMeets || before == ManifoldPair::kNew) {
    meets = on_side(kStays);
  } else if (gap > 0) {
    meets = on_side(kComes);
  } else {
    meets = before == ManifoldPair::kUnknown && gap > -kPlacedDeep * now.inner && on_side(kComes);
  }
  pair.crossing = meets ? ManifoldPair::kMeets : ManifoldPair::kPasses;
  return !meets;
}

// What the host decided of a pair that asks and is near. Whether it does not go through each other by what the sides are.
bool Manifolds::Look::is_let_through(ManifoldPair& pair) const {
  if (!params.asking || !manifolds.asks(pair)) return false;
  pair.crossing = ManifoldPair::kUnknown;
  if (pair.manifold.count == 0) return false;
  const Decision* const d = manifolds.decisions_.find(name_of(pair, statics));
  pair.crossing = d == nullptr ? ManifoldPair::kNew : d->through ? ManifoldPair::kPasses : ManifoldPair::kMeets;
  return pair.crossing == ManifoldPair::kPasses;
}

// What goes through has no contact, and what has none resists no rolling.
void Manifolds::Look::see_surfaces(ManifoldPair& pair, const Stand& now) const {
  if (go_through(pair, now) || is_let_through(pair)) pair.manifold.count = 0;
  if (pair.manifold.count == 0) pair.roll = 0;
}

}  // namespace psim
