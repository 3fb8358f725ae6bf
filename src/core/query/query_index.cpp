#include "query/query_index.h"

#include <cmath>

#include "base/rotor.h"
#include "query/publish.h"

namespace psim {
namespace {

// Puts the pieces of bodies into a grid.
class Filler {
 public:
  Filler(const QuerySource& source, QueryIndex::Part& part, std::size_t room) : source_(source), part_(part) {
    part_.grid.begin(source.period, room);
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
    const Lattice& lattice = source_.lattice;
    const Vec2 p = place(lattice, s.p.x, s.p.y, s.p.dx, s.p.dy);
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
    piece.way = place(lattice, wrap_sub(s.q.x, s.p.x), wrap_sub(s.q.y, s.p.y), s.q.dx, s.q.dy);
    piece.way.x -= static_cast<double>(s.p.dx);
    piece.way.y -= static_cast<double>(s.p.dy);
    round(s.owner, piece, p);
  }

  static Vec2 place(const Lattice& lattice, std::int32_t x, std::int32_t y, float dx, float dy) {
    return {x * lattice.pitch_x() + static_cast<double>(dx), y * lattice.pitch_y() + static_cast<double>(dy)};
  }

 private:
  // Adds a piece with its origin at `at`. Its item is the circle about the middle of its box.
  void round(std::uint32_t id, QueryPiece piece, Vec2 at) {
    const Outline o = QueryIndex::outline(source_, piece, {});
    Vec2 low = o.v[0], high = o.v[0];
    for (std::int32_t k = 1; k < o.count; ++k) {
      low = {std::fmin(low.x, o.v[k].x), std::fmin(low.y, o.v[k].y)};
      high = {std::fmax(high.x, o.v[k].x), std::fmax(high.y, o.v[k].y)};
    }
    const Vec2 middle{low.x / 2 + high.x / 2, low.y / 2 + high.y / 2};
    double reach = 0;
    for (std::int32_t k = 0; k < o.count; ++k) {
      const double x = o.v[k].x - middle.x, y = o.v[k].y - middle.y;
      reach = std::fmax(reach, std::sqrt(x * x + y * y));
    }
    piece.at = {-middle.x, -middle.y};
    const auto number = static_cast<std::uint32_t>(part_.pieces.size());
    part_.pieces.push_back(piece);
    part_.grid.add(
        {at.x + middle.x, at.y + middle.y, static_cast<float>((reach + o.radius) * (1 + 0x1p-22)), id, number});
  }

  const QuerySource& source_;
  QueryIndex::Part& part_;
};

void fill_moving(const QuerySource& source, QueryIndex::Part& part) {
  const BodyStore& b = source.bodies;
  Filler filler(source, part, b.count + source.frozen.size());
  for (std::size_t i = 0; i < b.count; ++i) {
    const std::uint32_t id = b.id[i];
    if (id == kNoSlot) continue;
    const Vec2 at = Filler::place(source.lattice, b.pos[2 * i], b.pos[2 * i + 1], b.disp[2 * i], b.disp[2 * i + 1]);
    const std::uint32_t kind = source.all_discs ? 0 : b.properties(id).kind;
    if (kind == 0 || b.kinds[kind].hull_count == 0) {
      filler.disc(id, at, b.radius[i]);
    } else {
      filler.hulls(id, b.kinds[kind], at, b.angle.empty() ? 0 : b.angle[i]);
    }
  }
  for (const BodyState& s : source.frozen) {
    const Vec2 centre = source.lattice.centre();
    Vec2 at{s.x - centre.x, s.y - centre.y};
    const BodyKind& kind = b.kind(s.id.index);
    if (kind.hull_count == 0) {
      filler.disc(s.id.index, at, static_cast<float>(s.radius));
      continue;
    }
    const SineCosine q = sine_cosine(std::isfinite(s.angle) ? s.angle : 0);
    const double x = static_cast<double>(kind.centre_x), y = static_cast<double>(kind.centre_y);
    at = {at.x + (q.cosine * x - q.sine * y), at.y + (q.sine * x + q.cosine * y)};
    filler.hulls(s.id.index, kind, at, s.angle);
  }
  part.grid.build();
}

void fill_sleeping(const QuerySource& source, QueryIndex::Part& part) {
  const BodyStore& b = source.bodies;
  Filler filler(source, part, source.sleepers.size());
  for (const Sleeper& s : source.sleepers) {
    const Vec2 at = Filler::place(source.lattice, s.at.x, s.at.y, s.at.dx, s.at.dy);
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

void fill_fixed(const QuerySource& source, QueryIndex::Part& part) {
  const StaticShapes& statics = source.statics;
  Filler filler(source, part, statics.size());
  for (std::uint32_t k = 0; k < statics.size(); ++k) {
    if (statics[k].alive && !statics[k].face && !statics[k].asleep) filler.fixed(statics[k], k);
  }
  const Vec2 centre = source.lattice.centre();
  for (const FixedBody& body : source.fixed) {
    const BodyKind& kind = source.bodies.kind(body.id);
    if (!kind.sensor) continue;
    filler.hulls(body.id, kind, {body.x - centre.x, body.y - centre.y}, body.angle);
  }
  part.grid.build();
}

}  // namespace

Outline QueryIndex::outline(const QuerySource& source, const QueryPiece& piece, Vec2 centre) {
  const Vec2 at{centre.x + piece.at.x, centre.y + piece.at.y};
  switch (piece.kind) {
    case QueryPiece::kHull:
      return outline_of(source.bodies.hulls[piece.hull], piece.way, at);
    case QueryPiece::kWholeStatic:
      return outline_of(source.statics.hull(source.statics[piece.hull]), piece.way, at);
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

Outline QueryIndex::outline(const QuerySource& source, const Part& part, const QueryItem& item, Vec2 at) {
  if (item.piece != kDisc) return outline(source, part.pieces[item.piece], at);
  Outline disc;
  disc.count = 1;
  disc.radius = static_cast<double>(item.radius);
  disc.v[0] = at;
  return disc;
}

const QueryIndex::Part& QueryIndex::made(const QuerySource& source, std::atomic<bool>& ready, Part& part,
                                         Fill fill) const {
  if (ready.load(std::memory_order_acquire)) return part;
  const std::lock_guard<std::mutex> lock(making_);
  if (!ready.load(std::memory_order_relaxed)) {
    fill(source, part);
    ready.store(true, std::memory_order_release);
  }
  return part;
}

const QueryIndex::Part& QueryIndex::moving(const QuerySource& source) const {
  return made(source, moving_ready_, moving_, fill_moving);
}

const QueryIndex::Part& QueryIndex::sleeping(const QuerySource& source) const {
  return made(source, sleeping_ready_, sleeping_, fill_sleeping);
}

const QueryIndex::Part& QueryIndex::fixed(const QuerySource& source) const {
  return made(source, fixed_ready_, fixed_, fill_fixed);
}

std::size_t QueryIndex::bytes() const {
  const std::lock_guard<std::mutex> lock(making_);
  return moving_.grid.bytes() + sleeping_.grid.bytes() + fixed_.grid.bytes() +
         (moving_.pieces.capacity() + sleeping_.pieces.capacity() + fixed_.pieces.capacity()) * sizeof(QueryPiece);
}

}  // namespace psim
