// The narrow phase of discs (ContactStore::find_gaps): a kernel computes pairs of discs, StaticGeometry the contacts
// with walls, segments and fixed discs, one by one in double precision.
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "contacts/contact_store.h"

namespace psim {
namespace {

class StaticGeometry {
 public:
  StaticGeometry(const Surroundings& s, const Walls& walls, float refresh, StaticLanes& c)
      : b_(s.bodies), statics_(s.statics), lattice_(s.lattice), walls_(walls), c_(c), refresh_(refresh) {}

  /// Sees to all contacts of one body.
  void body(std::span<const StaticPair> list) {
    corners_ = inside_ = 0;
    for (const StaticPair& pair : list) one(pair);
    if (corners_ != 0 && list.size() > 1) drop_doubled_corners(list);
    if (inside_ != 0) keep_nearest_faces(list);
  }

 private:
  void one(const StaticPair& pair) {
    const float r = b_.radius[pair.body];
    if (pair.shape < kWallLeft) {
      const StaticShape& s = statics_[pair.shape];
      standing(pair, s, r);
      if (s.asleep) yield(pair, s);
      return;
    }
    const Walls::Face wall = walls_.face(pair.shape, centre_of(pair), lattice_);
    face(pair, wall.nx, wall.ny, static_cast<float>(wall.height) - r);
  }

  // Makes the contact as soft as it was when both sides moved. Both bodies are at rest, so that the normal lasts.
  void yield(const StaticPair& pair, const StaticShape& s) {
    const std::uint32_t at = pair.contact;
    if (c_.gap[at] < 0) {
      c_.gap[at] *= yield_of_sleeper(b_.properties(s.owner).inv_mass, b_.properties(b_.id[pair.body]).inv_mass);
    }
    c_.refresh[at] = std::numeric_limits<float>::infinity();
  }

  void standing(const StaticPair& pair, const StaticShape& s, float r) {
    const Vec2 a = lattice_.way(s.p, centre_of(pair));
    if (!s.segment) return round(pair, a, s.radius, r);
    const Vec2 u = lattice_.way(s.p, s.q);
    const double uu = dot(u, u), along = dot(a, u);
    if (along < 0 || along > uu) {
      ++corners_;
      return round(pair, along < 0 ? a : a - u, s.radius, r);
    }
    const double length = std::sqrt(uu);
    const double side = cross(u, a) / length;  // left of p->q is positive
    double sign = side < 0 || s.face ? -1 : 1;
    if (s.face && side > 0) ++inside_;
    // A disc that its neighbours press through a thin segment still counts on the side from which it came.
    const std::uint32_t at = pair.contact;
    if (c_.impulse[at] > 0 && !s.face) {
      const double was = cross(u, {static_cast<double>(c_.nx[at]), static_cast<double>(c_.ny[at])});
      if (was != 0) sign = was < 0 ? -1 : 1;
    }
    face(pair, static_cast<float>(-u.y / length * sign), static_cast<float>(u.x / length * sign),
         static_cast<float>(side * sign) - (r + s.radius));
  }

  void face(const StaticPair& pair, float nx, float ny, float gap) {
    const std::uint32_t at = pair.contact;
    c_.nx[at] = nx;
    c_.ny[at] = ny;
    c_.gap[at] = gap;
    c_.base_x[at] = c_.base_y[at] = 0;
    c_.rsum[at] = b_.radius[pair.body];
    c_.refresh[at] = std::numeric_limits<float>::infinity();
  }

  void round(const StaticPair& pair, Vec2 base, float fixed, float r) {
    const std::uint32_t at = pair.contact;
    const double far = length_of(base);
    c_.nx[at] = far > 0 ? static_cast<float>(base.x / far) : 0.0f;
    c_.ny[at] = far > 0 ? static_cast<float>(base.y / far) : 1.0f;
    c_.gap[at] = static_cast<float>(far) - (r + fixed);
    c_.base_x[at] = static_cast<float>(base.x);
    c_.base_y[at] = static_cast<float>(base.y);
    c_.rsum[at] = r + fixed;
    c_.refresh[at] = refresh_;
  }

  // If a disc meets the end of a segment, and this end lies on another segment that the disc meets, the other segment
  // carries the disc, so that there is no bump at joints. Of two ends at one point the first counts.
  void drop_doubled_corners(std::span<const StaticPair> list) {
    for (std::size_t k = 0; k < list.size(); ++k) {
      if (!is_corner(list[k])) continue;
      const Vec2 corner = corner_of(list[k]);
      for (std::size_t o = 0; o < list.size(); ++o) {
        if (o == k || list[o].shape >= kWallLeft || !statics_[list[o].shape].segment) continue;
        if (is_corner(list[o])) {  // the nearer end counts; of two at one point the first
          const Vec2 other = corner_of(list[o]);
          const double near = dot(other, other), mine = dot(corner, corner);
          const bool one_point = std::fabs(near - mine) <= 1e-5 * mine;
          if (one_point ? o > k : near > mine) continue;
          if (o > k && rises(list[k], list[o])) continue;
        }
        if (distance_to(list[o], corner) <
            1e-5 * static_cast<double>(b_.radius[list[k].body]) + 4 * lattice_.pitch_x()) {
          drop(list[k].contact);
          break;
        }
      }
    }
  }

  // Whether a segment rises from another one, seen from the side of the body.
  bool rises(const StaticPair& pair, const StaticPair& from) const {
    const StaticShape &s = statics_[pair.shape], &o = statics_[from.shape];
    const Vec2 u = lattice_.steps(o.p, o.q);
    const double side = outside(from) > 0 ? 1 : -1, least = 1e-3 * dot(u, u);
    const auto height = [&](const LatticePoint& p) { return side * cross(lattice_.steps(o.p, p), u); };
    return height(s.p) > least || height(s.q) > least;
  }

  // The vector from the centre of a body to the corner that it meets, m.
  Vec2 corner_of(const StaticPair& pair) const {
    return {-static_cast<double>(c_.base_x[pair.contact]), -static_cast<double>(c_.base_y[pair.contact])};
  }

  // Some edges of a polygon have the centre of a disc on their inner side. None of them counts if another edge has it
  // outside; else the nearest one counts, through which the disc leaves.
  void keep_nearest_faces(std::span<const StaticPair> list) {
    for (std::size_t k = 0; k < list.size(); ++k) {
      if (!is_face(list[k])) continue;
      const double mine = outside(list[k]);
      if (!(mine < 0)) continue;
      for (std::size_t o = 0; o < list.size(); ++o) {
        if (o == k || !is_face(list[o])) continue;
        if (statics_[list[o].shape].owner != statics_[list[k].shape].owner) continue;
        const double other = outside(list[o]);
        if (other < mine || (other == mine && o > k)) continue;
        drop(list[k].contact);
        break;
      }
    }
  }

  bool is_face(const StaticPair& pair) const { return pair.shape < kWallLeft && statics_[pair.shape].face; }

  LatticePoint centre_of(const StaticPair& pair) const {
    const std::size_t i = pair.body;
    return {b_.pos[2 * i], b_.pos[2 * i + 1], 0, 0};
  }

  // How far the centre of a body lies outside of the line of an edge, m.
  double outside(const StaticPair& pair) const {
    const StaticShape& s = statics_[pair.shape];
    const Vec2 a = lattice_.way(s.p, centre_of(pair)), u = lattice_.way(s.p, s.q);
    return cross(a, u) / length_of(u);
  }

  // Another contact counts in place of this one.
  void drop(std::uint32_t at) {
    c_.gap[at] = kNoGap;
    c_.refresh[at] = std::numeric_limits<float>::infinity();
    c_.impulse[at] = 0;
  }

  bool is_corner(const StaticPair& pair) const {
    return pair.shape < kWallLeft && statics_[pair.shape].segment &&
           (c_.base_x[pair.contact] != 0 || c_.base_y[pair.contact] != 0);
  }

  // The distance from a point, relative to the centre of the body, to a segment.
  double distance_to(const StaticPair& pair, Vec2 point) const {
    const StaticShape& s = statics_[pair.shape];
    const Vec2 u = lattice_.way(s.p, s.q);
    const Vec2 a = point + lattice_.steps(s.p, centre_of(pair)) - Vec2{s.p.dx, s.p.dy};
    return length_of(a - std::fmin(std::fmax(dot(a, u) / dot(u, u), 0), 1) * u);
  }

  const BodyStore& b_;
  const StaticShapes& statics_;
  const Lattice& lattice_;
  const Walls& walls_;
  StaticLanes& c_;
  float refresh_;
  int corners_ = 0, inside_ = 0;
};

}  // namespace

void ContactStore::find_gaps(const Walls& walls, float refresh, const PairTable& table) {
  solved_.load();
  const kernels::BodyView bodies = solved_.view();
  const kernels::ContactView lanes = pairs.view();
  kernels::ContactParams p;
  p.pitch_x = static_cast<float>(s_.lattice.pitch_x());
  p.pitch_y = static_cast<float>(s_.lattice.pitch_y());
  s_.pool.run(table.strips.size(), [&](std::size_t index) {
    const ContactBlocks& blocks = table.strips[index].blocks;
    if (blocks.begin != blocks.end) s_.kernels.prepare(bodies, lanes, p, blocks.begin, blocks.end);
    StaticGeometry geometry(s_, walls, refresh, fixed);
    std::span<const StaticPair> list = table.static_contacts[index];
    while (!list.empty()) {
      std::size_t of_body = 1;
      while (of_body < list.size() && list[of_body].body == list[0].body) ++of_body;
      geometry.body(list.first(of_body));
      list = list.subspan(of_body);
    }
  });
}

}  // namespace psim
