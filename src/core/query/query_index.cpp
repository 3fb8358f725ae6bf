#include "query/query_index.h"

#include <cmath>

#include "base/rotor.h"

namespace psim {
namespace {

// Puts the pieces of bodies into a grid.
class Filler {
 public:
  Filler(const Observed& world, QueryIndex::Part& part, std::size_t room) : world_(world), part_(part) {
    part_.grid.begin(world.period(), room);
    part_.pieces.clear();
  }

  void disc(std::uint32_t id, Vec2 at, float radius) { part_.grid.add({at.x, at.y, radius, id, QueryIndex::kDisc}); }

  // Adds the hulls of a body about its origin.
  void hulls(std::uint32_t id, const BodyKind& kind, Vec2 origin, double angle) {
    const SineCosine turn = sine_cosine(std::isfinite(angle) ? angle : 0);
    for (std::uint32_t k = 0; k < kind.hull_count; ++k) {
      QueryPiece piece;
      piece.kind = QueryPiece::kHull;
      piece.way = {turn.cosine, turn.sine};
      piece.hull = kind.first_hull + k;
      round(id, piece, origin);
    }
  }

  void fixed(const StaticShape& s, std::uint32_t number) {
    const Vec2 p = world_.from_centre(s.p);
    if (s.whole) {
      QueryPiece piece;
      piece.kind = QueryPiece::kWholeStatic;
      piece.way = {1, 0};
      piece.hull = number;
      return round(s.owner, piece, p);
    }
    if (!s.segment) return disc(s.owner, p, s.radius);
    QueryPiece piece;
    piece.kind = QueryPiece::kSegment;
    piece.radius = s.radius;
    piece.way = world_.from_centre({wrap_sub(s.q.x, s.p.x), wrap_sub(s.q.y, s.p.y), s.q.dx, s.q.dy});
    piece.way.x -= static_cast<double>(s.p.dx);
    piece.way.y -= static_cast<double>(s.p.dy);
    round(s.owner, piece, p);
  }

 private:
  // Adds a piece with its origin at `at`. Its item is the circle about the middle of its box.
  void round(std::uint32_t id, QueryPiece piece, Vec2 at) {
    const Outline o = QueryIndex::outline(world_, piece, {});
    const Box box = box_of(o);
    const Vec2 middle = box.middle();
    double reach = 0;
    for (std::int32_t k = 0; k < o.count; ++k) {
      reach = std::fmax(reach, length_of(o.v[k] - middle));
    }
    piece.at = {-middle.x, -middle.y};
    const auto number = static_cast<std::uint32_t>(part_.pieces.size());
    part_.pieces.push_back(piece);
    part_.grid.add(
        {at.x + middle.x, at.y + middle.y, static_cast<float>((reach + o.radius) * (1 + 0x1p-22)), id, number});
  }

  const Observed& world_;
  QueryIndex::Part& part_;
};

void fill_moving(const Observed& world, QueryIndex::Part& part) {
  const BodyStore& b = world.bodies;
  Filler filler(world, part, b.count + world.population.frozen.size());
  for (std::size_t i = 0; i < b.count; ++i) {
    const std::uint32_t id = b.id[i];
    if (id == kNoSlot) continue;
    const Vec2 at = world.from_centre(world.place(i));
    const std::uint32_t kind = world.population.traits.cornered == 0 ? 0 : b.properties(id).kind;
    if (kind == 0 || b.kinds[kind].hull_count == 0) {
      filler.disc(id, at, b.radius[i]);
    } else {
      filler.hulls(id, b.kinds[kind], at, b.angle.empty() ? 0 : b.angle[i]);
    }
  }
  for (const BodyState& s : world.population.frozen) {
    const Vec2 centre = world.lattice.centre();
    Vec2 at = Vec2{s.x, s.y} - centre;
    const BodyKind& kind = b.kind(s.id.index);
    if (kind.hull_count == 0) {
      filler.disc(s.id.index, at, static_cast<float>(s.radius));
      continue;
    }
    at = at + arm_of(kind, std::isfinite(s.angle) ? s.angle : 0);
    filler.hulls(s.id.index, kind, at, s.angle);
  }
  part.grid.build();
}

void fill_sleeping(const Observed& world, QueryIndex::Part& part) {
  const BodyStore& b = world.bodies;
  Filler filler(world, part, world.sleep.sleepers.list.size());
  for (const Sleeper& s : world.sleep.sleepers.list) {
    const Vec2 at = world.from_centre(s.at);
    const BodyProperties& properties = b.properties(s.id);
    const BodyKind& kind = b.kinds[properties.kind];
    if (kind.hull_count == 0) {
      filler.disc(s.id, at, properties.radius);
    } else {
      filler.hulls(s.id, kind, at, s.angle);
    }
  }
  part.grid.build();
}

void fill_fixed(const Observed& world, QueryIndex::Part& part) {
  const StaticShapes& statics = world.statics;
  Filler filler(world, part, statics.size());
  for (std::uint32_t k = 0; k < statics.size(); ++k) {
    if (statics[k].alive && !statics[k].face && !statics[k].asleep) filler.fixed(statics[k], k);
  }
  const Vec2 centre = world.lattice.centre();
  for (const FixedBody& body : world.population.fixed) {
    const BodyKind& kind = world.bodies.kind(body.id);
    if (!kind.sensor) continue;
    filler.hulls(body.id, kind, {body.x - centre.x, body.y - centre.y}, body.angle);
  }
  part.grid.build();
}

}  // namespace

Outline QueryIndex::outline(const Observed& world, const QueryPiece& piece, Vec2 centre) {
  const Vec2 at{centre.x + piece.at.x, centre.y + piece.at.y};
  switch (piece.kind) {
    case QueryPiece::kHull:
      return outline_of(world.bodies.hulls[piece.hull], piece.way, at);
    case QueryPiece::kWholeStatic:
      return outline_of(world.statics.hull(world.statics[piece.hull]), piece.way, at);
    case QueryPiece::kSegment:
      break;
  }
  Outline line;
  line.count = 2;
  line.radius = static_cast<double>(piece.radius);
  line.v[0] = at;
  line.v[1] = {at.x + piece.way.x, at.y + piece.way.y};
  return line;
}

Outline QueryIndex::outline(const Observed& world, const Part& part, const QueryItem& item, Vec2 at) {
  if (item.piece != kDisc) return outline(world, part.pieces[item.piece], at);
  Outline disc;
  disc.count = 1;
  disc.radius = static_cast<double>(item.radius);
  disc.v[0] = at;
  return disc;
}

const QueryIndex::Part& QueryIndex::part(const Observed& world, Who who) const {
  static constexpr void (*kFill[])(const Observed&, Part&) = {fill_moving, fill_sleeping, fill_fixed};
  if (ready_[who].load(std::memory_order_acquire)) return parts_[who];
  const std::lock_guard<std::mutex> lock(making_);
  if (!ready_[who].load(std::memory_order_relaxed)) {
    kFill[who](world, parts_[who]);
    ready_[who].store(true, std::memory_order_release);
  }
  return parts_[who];
}

std::size_t QueryIndex::bytes() const {
  const std::lock_guard<std::mutex> lock(making_);
  std::size_t sum = 0;
  for (const Part& part : parts_) sum += part.grid.bytes() + part.pieces.capacity() * sizeof(QueryPiece);
  return sum;
}

}  // namespace psim
