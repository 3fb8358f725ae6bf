// The narrow phase of discs (ContactStore::find_gaps): a kernel computes pairs of discs, StaticGeometry the contacts
// with walls, segments and fixed discs, one by one in double precision.
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "base/elementary.h"
#include "contacts/contact_store.h"

namespace psim {
namespace {

constexpr double kSideways = 0.1;  // share of the radius: how far a disc may be pushed beyond its own motion in a step

// The contacts of one body with walls and fixed shapes. Edges of which one may take over from another within the step
// are added to `loose`.
class StaticGeometry {
 public:
  StaticGeometry(const Surroundings& s, const Walls& walls, float refresh, double dt, StaticLanes& c, StripEdges& edges)
      : b_(s.bodies),
        statics_(s.statics),
        lattice_(s.lattice),
        walls_(walls),
        c_(c),
        edges_(edges.near),
        loose_(edges.loose),
        refresh_(refresh),
        dt_(dt) {}

  /// Sees to all contacts of one body.
  void body(std::span<const StaticPair> list) {
    edges_.clear();
    bool inside = false;
    for (const StaticPair& pair : list) one(pair);
    const Vec2 way = dt_ * b_.velocity(list[0].body);
    for (NearEdge& near : edges_) {
      meet(near, way);
      inside |= is_inside(near);
    }
    if (inside) keep_nearest_faces();
    for (const NearEdge& near : edges_) put(near, list[0].body);
    for (const NearEdge& near : edges_) {
      if (dt_ > 0) hand_over(near);
    }
  }

 private:
  void one(const StaticPair& pair) {
    const float r = b_.radius[pair.body];
    if (pair.shape < kWallLeft) {
      const StaticShape& s = statics_[pair.shape];
      const Vec2 from_p = lattice_.way(s.p, centre_of(pair));
      if (s.segment) return near(pair, s, from_p, r);
      round(pair.contact, from_p, s.radius + r);
      if (s.asleep) yield(pair.contact, pair.body, s);
      return;
    }
    const Walls::Face wall = walls_.face(pair.shape, centre_of(pair), lattice_);
    face(pair.contact, wall.nx, wall.ny, static_cast<float>(wall.height) - r, r);
  }

  // Makes the contact as soft as it was when both sides moved. Both bodies are at rest, so that the normal lasts.
  void yield(std::uint32_t at, std::uint32_t body, const StaticShape& s) {
    if (c_.gap[at] < 0) {
      c_.gap[at] *= yield_of_sleeper(b_.properties(s.owner).inv_mass, b_.properties(b_.id[body]).inv_mass);
    }
    c_.refresh[at] = std::numeric_limits<float>::infinity();
  }

  void near(const StaticPair& pair, const StaticShape& s, Vec2 from_p, float r) {
    const Vec2 u = lattice_.way(s.p, s.q);
    const double length = length_of(u), side = cross(u, from_p);  // left of p->q is positive
    Vec2 along = 1 / length * u;
    const std::uint32_t at = pair.contact;
    const Vec2 old{static_cast<double>(c_.nx[at]), static_cast<double>(c_.ny[at])};
    bool right = side < 0 || s.face;
    // A disc that its neighbours press through a thin segment still counts on the side from which it came.
    if (c_.impulse[at] > 0 && !s.face && cross(u, old) != 0) right = cross(u, old) < 0;
    if (right) along = -1 * along;
    NearEdge& n = edges_.emplace_back(NearEdge{at, &s, -1 * from_p, u - from_p, {}, {}, old});
    n.edge = {along, cross(along, from_p), 0, 0, static_cast<double>(r + s.radius), {}, {}};
    const double to_p = dot(along, n.p), to_q = dot(along, n.q);
    n.edge.begin = lesser(to_p, to_q);
    n.edge.end = greater(to_p, to_q);
  }

  // Finds what the body meets of an edge.
  void meet(NearEdge& near, Vec2 way) {
    const double room = kMarginFrames * length_of(way) + kSideways * near.edge.radius;
    const double far = room + near.edge.radius;  // along the line: others may press the body onto it
    near.loose = std::fabs(near.edge.height) < far && (near.edge.begin > -room || near.edge.end < room);
    if (near.loose) {
      const auto corner = [&](double to, EdgeCorner& of, bool end) {
        if (std::fabs(to) < far) of = corner_of(near, end);
      };
      corner(near.edge.begin, near.edge.before, false);
      corner(near.edge.end, near.edge.after, true);
    }
    near.contact = meet_edge(near.edge, {}, way, 0);
  }

  // What lies beyond an end of an edge: of all edges there the one that rises most on the side of the body.
  EdgeCorner corner_of(const NearEdge& of, bool end) const {
    const Vec2 out = end ? of.edge.along : -1 * of.edge.along, up{-of.edge.along.y, of.edge.along.x};
    const Vec2 corner = (end ? of.edge.end : of.edge.begin) * of.edge.along - of.edge.height * up;
    const double same = 1e-5 * of.edge.radius + 4 * lattice_.pitch_x();
    EdgeCorner best;
    double most = -3;
    for (const NearEdge& other : edges_) {
      if (&other == &of || other.shape->radius != of.shape->radius) continue;
      if (std::fabs(cross(other.edge.along, corner) + other.edge.height) > 2 * same) continue;  // not on its line
      if (distance_to(other, corner) > same) continue;
      for (const Vec2 far : {other.p, other.q}) {
        const Vec2 way = far - corner;
        const double length = length_of(way);
        if (!(length > same)) continue;
        const double cosine = dot(out, way) / length, sine = dot(up, way) / length;
        // An edge of a polygon has one side, which must be that of the body.
        const Vec2 outside{other.q.y - other.p.y, other.p.x - other.q.x}, left{-way.y, way.x};
        if (other.shape->face && dot(outside, left) * (end ? 1 : -1) < 0) continue;
        const bool back = cosine < -0.9999;
        if (back && !(other.shape->face && of.shape->face)) continue;  // the same line again
        const double rise = back ? 2 : sine > 0 ? 1 - cosine : cosine - 1;
        if (rise <= most) continue;
        most = rise;
        best = {static_cast<float>(cosine), static_cast<float>(back ? 1 : sine), static_cast<float>(length),
                &other < &of};
      }
    }
    return best;
  }

  // Some edges of a polygon have the centre of a disc on their inner side. None of them counts if another edge has it
  // outside; else the nearest one counts, through which the disc leaves.
  void keep_nearest_faces() {
    for (std::size_t begin = 0, end = 0; begin < edges_.size(); begin = end) {
      const std::uint32_t owner = edges_[begin].shape->owner;  // the edges of a polygon follow each other
      while (end < edges_.size() && edges_[end].shape->owner == owner) ++end;
      for (std::size_t k = begin; k < end; ++k) {
        NearEdge& near = edges_[k];
        if (!is_inside(near)) continue;
        for (std::size_t n = begin; n < end; ++n) {
          const NearEdge& other = edges_[n];
          if (n == k || !other.shape->face) continue;
          const double mine = near.edge.height, height = other.edge.height;
          if (height < mine || (height == mine && n > k)) continue;
          near.contact.kind = EdgeContact::nothing;
          near.loose = false;
          break;
        }
      }
    }
  }

  static bool is_inside(const NearEdge& near) {
    const bool far = near.edge.height < -near.edge.radius;  // the disc does not come round the corner in this step
    return near.shape->face && near.edge.height < 0 && (far || near.contact.kind == EdgeContact::face);
  }

  // Writes the contact with an edge into its lane.
  void put(const NearEdge& near, std::uint32_t body) {
    c_.rsum[near.lane] = static_cast<float>(near.edge.radius);
    const float nx = c_.nx[near.lane], ny = c_.ny[near.lane];
    put_edge(near.contact, c_, near.lane);
    if (!(dt_ > 0)) {  // a look between two steps changes nothing for the next one
      c_.nx[near.lane] = nx;
      c_.ny[near.lane] = ny;
    }
    if (near.shape->asleep) return yield(near.lane, body, *near.shape);
    if (near.loose) loose_.push_back({near.lane, near.edge});
  }

  // The load that an edge bore goes to the edge that the body came to.
  void hand_over(const NearEdge& from) {
    const std::uint32_t at = from.lane;
    if (from.contact.kind != EdgeContact::nothing || !(c_.impulse[at] > 0)) return;
    const NearEdge* best = nullptr;
    double most = 0.5;
    for (const NearEdge& near : edges_) {
      const double likeness = dot(near.contact.normal, from.old_normal);
      if (near.contact.kind == EdgeContact::nothing || likeness <= most) continue;
      most = likeness;
      best = &near;
    }
    const auto give = [&](Column<float>& of) {
      if (best != nullptr) of[best->lane] += of[at];
      of[at] = 0;
    };
    if (best != nullptr && !(c_.impulse[best->lane] > 0)) c_.impulse[best->lane] = 0;  // it was open
    give(c_.impulse);
    if (!c_.friction.empty()) give(c_.friction);
  }

  void face(std::uint32_t at, float nx, float ny, float gap, float r) {
    c_.nx[at] = nx;
    c_.ny[at] = ny;
    c_.gap[at] = gap;
    c_.base_x[at] = c_.base_y[at] = 0;
    c_.rsum[at] = r;
    c_.refresh[at] = std::numeric_limits<float>::infinity();
  }

  void round(std::uint32_t at, Vec2 base, float radius) {
    const double far = length_of(base);
    c_.nx[at] = far > 0 ? static_cast<float>(base.x / far) : 0.0f;
    c_.ny[at] = far > 0 ? static_cast<float>(base.y / far) : 1.0f;
    c_.gap[at] = static_cast<float>(far) - radius;
    c_.base_x[at] = static_cast<float>(base.x);
    c_.base_y[at] = static_cast<float>(base.y);
    c_.rsum[at] = radius;
    c_.refresh[at] = refresh_;
  }

  LatticePoint centre_of(const StaticPair& pair) const {
    const std::size_t i = pair.body;
    return {b_.pos[2 * i], b_.pos[2 * i + 1], 0, 0};
  }

  static double distance_to(const NearEdge& edge, Vec2 point) {
    const Vec2 u = edge.q - edge.p, a = point - edge.p;
    return length_of(a - lesser(greater(dot(a, u) / dot(u, u), 0), 1) * u);
  }

  const BodyStore& b_;
  const StaticShapes& statics_;
  const Lattice& lattice_;
  const Walls& walls_;
  StaticLanes& c_;
  std::vector<NearEdge>& edges_;
  std::vector<LooseEdge>& loose_;
  float refresh_;
  double dt_;
};

}  // namespace

void ContactStore::find_gaps(const Walls& walls, float refresh, double dt, const PairTable& table) {
  solved_.load();
  const kernels::BodyView bodies = solved_.view();
  const kernels::ContactView lanes = pairs.view();
  kernels::ContactParams p;
  p.pitch_x = static_cast<float>(s_.lattice.pitch_x());
  p.pitch_y = static_cast<float>(s_.lattice.pitch_y());
  edges_.resize(table.strips.size());
  s_.pool.run(table.strips.size(), [&](std::size_t index) {
    const ContactBlocks& blocks = table.strips[index].blocks;
    if (blocks.begin != blocks.end) s_.kernels.prepare(bodies, lanes, p, blocks.begin, blocks.end);
    edges_[index].loose.clear();
    StaticGeometry geometry(s_, walls, refresh, dt, fixed, edges_[index]);
    std::span<const StaticPair> list = table.static_contacts[index];
    while (!list.empty()) {
      std::size_t of_body = 1;
      while (of_body < list.size() && list[of_body].body == list[0].body) ++of_body;
      geometry.body(list.first(of_body));
      list = list.subspan(of_body);
    }
  });
  any_loose_ = std::ranges::any_of(edges_, [](const StripEdges& of) { return !of.loose.empty(); });
}

}  // namespace psim
