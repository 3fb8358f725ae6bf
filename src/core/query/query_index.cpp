#include "query/query_index.h"

#include <cmath>

#include "base/elementary.h"

namespace psim {
namespace {

// Puts the pieces of bodies into a grid.
struct Filler {
  const Observed& world;
  QueryIndex::Part& part;
  const Lattice& lattice = world.lattice;

  void moving() {
    const BodyStore& b = world.bodies;
    const std::vector<BodyState>& frozen = world.population.frozen;
    begin(b.count + frozen.size());
    for (std::size_t i = 0; i < b.count; ++i) {
      if (b.id[i] == kNoSlot) continue;
      const Vec2 at = lattice.from_centre(b.point(i));
      if (world.population.traits.cornered == 0) {
        disc(b.id[i], at, b.radius[i]);
      } else {
        body(b.id[i], at, b.angle_of(i));
      }
    }
    for (const BodyState& s : frozen) {
      const double angle = std::isfinite(s.angle) ? s.angle : 0;
      const Vec2 at = Vec2{s.x, s.y} - lattice.centre();
      body(s.id.index, at + arm_of(b.kind(s.id.index), angle), angle);
    }
  }

  void sleeping() {
    begin(world.sleep.sleepers.list.size());
    for (const Sleeper& s : world.sleep.sleepers.list) body(s.id, lattice.from_centre(s.at), s.angle);
  }

  // Static bodies, and their sensors, which have no static shapes.
  void fixed() {
    const StaticShapes& statics = world.statics;
    begin(statics.size());
    for (std::uint32_t k = 0; k < statics.size(); ++k) {
      if (statics[k].alive && !statics[k].face && !statics[k].asleep) shape(statics[k], k);
    }
    for (const FixedBody& f : world.population.fixed) {
      if (world.bodies.kind(f.id).hull_count != 0) body(f.id, Vec2{f.x, f.y} - lattice.centre(), f.angle);
    }
  }

 private:
  void begin(std::size_t room) {
    part.grid.begin(world.period(), room);
    part.pieces.clear();
  }

  void disc(std::uint32_t id, Vec2 at, float radius, std::uint32_t part_number = 0) {
    part.grid.add({at, radius, id, QueryIndex::kDisc, part_number});
  }

  // Adds a body about its centre.
  void body(std::uint32_t id, Vec2 at, double angle) {
    const BodyProperties& properties = world.bodies.properties(id);
    const BodyKind& kind = world.bodies.kinds[properties.kind];
    if (kind.hull_count == 0) return disc(id, at, properties.radius);
    const SineCosine turn = sine_cosine(angle);
    for (std::uint32_t k = 0; k < kind.hull_count; ++k) {
      piece({.body = id, .part = world.bodies.part_of_hull(properties, k)},
            {.way = {turn.cosine, turn.sine}, .hull = kind.first_hull + k, .kind = QueryPiece::kHull}, at);
    }
  }

  void shape(const StaticShape& s, std::uint32_t number) {
    const Vec2 p = lattice.from_centre(s.p);
    const QueryItem item{.body = s.owner, .part = s.part};
    if (s.whole) return piece(item, {.way = {1, 0}, .hull = number, .kind = QueryPiece::kWholeStatic}, p);
    if (!s.segment) return disc(s.owner, p, s.radius, s.part);
    Vec2 way = lattice.from_centre({wrap_sub(s.q.x, s.p.x), wrap_sub(s.q.y, s.p.y), s.q.dx, s.q.dy});
    way = way - Vec2{s.p.dx, s.p.dy};
    piece(item, {.way = way, .radius = s.radius, .kind = QueryPiece::kSegment}, p);
  }

  // Adds a piece with its origin at `at`. Its item, of which `item` names the body and its part, is the circle about the
  // middle of its box.
  void piece(QueryItem item, const QueryPiece& piece, Vec2 at) {
    item.piece = static_cast<std::uint32_t>(part.pieces.size());
    part.pieces.push_back(piece);
    const Outline o = QueryIndex::outline(world, part, item, {});
    const Vec2 middle = box_of(o).middle();
    double reach = 0;
    for (std::int32_t k = 0; k < o.count; ++k) reach = greater(length_of(o.v[k] - middle), reach);
    part.pieces.back().at = -1 * middle;
    item.at = at + middle;
    item.radius = static_cast<float>((reach + o.radius) * (1 + 0x1p-22));
    part.grid.add(item);
  }
};

}  // namespace

Outline QueryIndex::outline(const Observed& world, const Part& part, const QueryItem& item, Vec2 centre) {
  if (item.piece == kDisc) return {{centre}, 1, wide(item.radius)};
  const QueryPiece& piece = part.pieces[item.piece];
  const Vec2 at = centre + piece.at;
  if (piece.kind == QueryPiece::kSegment) return {{at, at + piece.way}, 2, wide(piece.radius)};
  const Hull& hull =
      piece.kind == QueryPiece::kHull ? world.bodies.hulls[piece.hull] : world.statics.hull(world.statics[piece.hull]);
  return outline_of(hull, {piece.way.y, piece.way.x}, at);
}

const QueryIndex::Part& QueryIndex::part(const Observed& world, Who who) const {
  static constexpr void (Filler::*kFill[])() = {&Filler::moving, &Filler::sleeping, &Filler::fixed};
  if (ready_[who].load(std::memory_order_acquire)) return parts_[who];
  const std::lock_guard<std::mutex> lock(making_);
  if (!ready_[who].load(std::memory_order_relaxed)) {
    (Filler{world, parts_[who]}.*kFill[who])();
    parts_[who].grid.build();
    ready_[who].store(true, std::memory_order_release);
  }
  return parts_[who];
}

std::size_t QueryIndex::bytes() const {
  const std::lock_guard<std::mutex> lock(making_);
  std::size_t sum = 0;
  for (const Part& part : parts_) sum += part.grid.bytes() + bytes_of(part.pieces);
  return sum;
}

}  // namespace psim
