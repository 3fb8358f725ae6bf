#include "query/body_parts.h"

#include <cmath>
#include <string>
#include <utility>

#include "base/rotor.h"
#include "psim/limits.h"
#include "query/query_grid.h"

namespace psim {
namespace {

ShapePart told(const PartProperties& has) {
  ShapePart part;
  part.restitution = wide(has.surface.restitution);
  part.friction = wide(has.surface.friction);
  part.tangent_speed = wide(has.surface.tangent_speed);
  part.rolling_resistance = wide(has.surface.rolling_resistance);
  part.filter = has.filter;
  part.sensor = has.sensor != 0;
  part.one_way = Vec2{has.one_way_x, has.one_way_y};
  part.pre_solve = has.pre_solve != 0;
  part.user_data = has.user_data();
  return part;
}

// The parts of one body as they come. Lines that follow one another become chains.
class Teller {
 public:
  Teller(const Observed& world, std::uint32_t id)
      : world_(world),
        id_(id),
        properties_(world.bodies.properties(id)),
        kind_(world.bodies.kinds[properties_.kind]),
        state_(world.state_of(id)) {}

  std::vector<ShapePart> tell() {
    if (kind_.hull_count == 0 && properties_.radius > 0) {
      add(part_of(0), DiscShape{wide(properties_.radius)}, {});
    } else {
      if (is_static_) tell_pieces();
      tell_hulls();
      end_line();
    }
    if (properties_.type() == BodyType::dynamic_body) find_density();
    return std::move(parts_);
  }

 private:
  // A line of no thickness that may go on.
  struct Line {
    bool open = false, joins = false;
    std::uint32_t part = 0;
    PartProperties has;
    Vec2 position;
    std::vector<Vec2> vertices;
    LatticePoint begin, end;  // of fixed pieces
  };

  void add(const PartProperties& has, PartShape shape, Vec2 position) {
    end_line();
    ShapePart& part = parts_.emplace_back(told(has));
    part.shape = std::move(shape);
    part.position = position;
  }

  void end_line() {
    if (!std::exchange(line_.open, false)) return;
    std::vector<Vec2>& v = line_.vertices;
    const bool loop = v.size() > 3 && line_.joins;
    ShapePart& part = parts_.emplace_back(told(line_.has));
    part.position = line_.position;
    if (loop) v.pop_back();
    if (v.size() == 2) {
      part.shape = SegmentShape{v[0], v[1]};
    } else {
      part.shape = ChainShape{std::move(v), loop, {}};
    }
  }

  // A line that goes `way` from `position`. It goes on where the one before ended, if `follows`; `joins`: it ends where that
  // one began.
  void add_line(std::uint32_t part, const PartProperties& has, Vec2 position, Vec2 way, bool follows, bool joins) {
    if (line_.open && follows && line_.part == part && line_.has == has && !line_.joins) {
      line_.vertices.push_back(line_.vertices.back() + way);
      line_.joins = joins;
      return;
    }
    end_line();
    line_ = {true, false, part, has, position, {{}, way}, {}, {}};
  }

  // What a part has, in the frame of the body.
  PartProperties part_of(std::uint32_t part) const {
    PartProperties has = world_.bodies.part_of(properties_, part);
    if (is_static_) turn_one_way({&has, 1}, -state_.angle);
    return has;
  }

  void tell_pieces() {
    const PieceRun run = pieces_of(world_, id_);
    const SineCosine back = sine_cosine(-state_.angle);
    for (std::uint32_t k = run.first; k < run.end; ++k) {
      const StaticShape& s = world_.statics[k];
      if (s.face) continue;  // of a polygon, which comes as a whole
      const PartProperties has = part_of(s.part);
      const Vec2 p = way_from(world_, state_, s.p);
      if (s.whole) {
        add_polygon(has, world_.statics.hull(s), back, p);
      } else if (!s.segment) {
        add(has, DiscShape{wide(s.radius)}, turned(back, p));
      } else if (s.radius > 0) {
        add(has, CapsuleShape{{}, turned(back, world_.lattice.way(s.p, s.q)), wide(s.radius)}, turned(back, p));
      } else {
        const bool follows = s.p == line_.end, joins = s.q == line_.begin;
        add_line(s.part, has, turned(back, p), turned(back, world_.lattice.way(s.p, s.q)), follows, joins);
        if (line_.vertices.size() == 2) line_.begin = s.p;
        line_.end = s.q;
      }
    }
  }

  // A hull of three vertices or more about `at`.
  void add_polygon(const PartProperties& has, const Hull& hull, SineCosine turn, Vec2 at) {
    PolygonShape polygon;
    polygon.radius = wide(hull.radius);
    for (int k = 0; k < hull.count; ++k) polygon.vertices.push_back(turned(turn, hull.vertex(k) - hull.vertex(0)));
    add(has, std::move(polygon), turned(turn, at + hull.vertex(0)));
  }

  void tell_hulls() {
    const Vec2 centre{kind_.centre_x, kind_.centre_y};
    const bool chains = properties_.type() == BodyType::kinematic_body;
    Vec2 begin, end;  // of the line
    for (std::uint32_t k = 0; k < kind_.hull_count; ++k) {
      const Hull& hull = world_.bodies.hulls[kind_.first_hull + k];
      const PartProperties has = part_of(world_.bodies.part_of_hull(properties_, k));
      const Vec2 first = hull.vertex(0), last = hull.vertex(hull.count - 1), at = centre + first;
      if (hull.count == 1) {
        add(has, DiscShape{wide(hull.radius)}, at);
      } else if (hull.count > 2) {
        add_polygon(has, hull, {}, centre);
      } else if (hull.radius > 0) {
        add(has, CapsuleShape{{}, last - first, wide(hull.radius)}, at);
      } else {
        add_line(0, has, at, last - first, chains && first == end, last == begin);
        if (line_.vertices.size() == 2) begin = first;
        end = last;
      }
    }
  }

  // The mean of all parts: nobody knows that of each.
  void find_density() {
    HullSet hulls;
    std::string error;
    if (!make_hulls(CompoundShape{parts_}, true, hulls, error)) return;
    const double density = wide(properties_.mass) / hulls.mass.area;
    if (!limits::kDensity.contains(density)) return;
    for (ShapePart& part : parts_) part.density = density;
  }

  const Observed& world_;
  const std::uint32_t id_;
  const BodyProperties& properties_;
  const BodyKind& kind_;
  const BodyState state_;
  const bool is_static_ = properties_.type() == BodyType::static_body;
  std::vector<ShapePart> parts_;
  Line line_;
};

}  // namespace

PieceRun pieces_of(const Observed& world, std::uint32_t id) {
  const BodyInfo& info = world.bodies.info[id];
  if (info.place == Place::disabled) {
    const DisabledBody& body = world.population.disabled[info.slot];
    return {body.first_shape, body.first_shape + body.pieces};
  }
  const std::uint32_t first = world.population.fixed[info.slot].first_shape;
  std::uint32_t end = first;
  while (end < world.statics.size() && world.statics[end].alive && world.statics[end].owner == id) ++end;
  return {first, end};
}

Vec2 way_from(const Observed& world, const BodyState& body, const LatticePoint& point) {
  return nearest_copy(world.lattice.to_world(point) - Vec2{body.x, body.y}, world.period());
}

std::vector<ShapePart> parts_of(const Observed& world, std::uint32_t id) { return Teller(world, id).tell(); }

}  // namespace psim
