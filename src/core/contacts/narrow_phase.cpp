#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "contacts/contact_store.h"

namespace psim {
namespace {

class StaticGeometry {
 public:
  StaticGeometry(const Surroundings& s, const Walls& walls, float refresh, ContactStore& c)
      : b_(s.bodies),
        statics_(s.statics),
        walls_(walls),
        lattice_(s.lattice),
        c_(c),
        px_(lattice_.pitch_x()),
        py_(lattice_.pitch_y()),
        refresh_(refresh) {}

  /// Sees to all contacts of one body: list[begin..end).
  void body(const std::vector<StaticPair>& list, std::size_t begin, std::size_t end) {
    corners_ = inside_ = 0;
    for (std::size_t k = begin; k < end; ++k) one(list[k]);
    if (corners_ != 0 && end - begin > 1) drop_doubled_corners(list, begin, end);
    if (inside_ != 0) keep_nearest_faces(list, begin, end);
  }

 private:
  void one(const StaticPair& pair) {
    const std::uint32_t i = pair.body;
    const std::int32_t x = b_.pos[2 * std::size_t{i}], y = b_.pos[2 * std::size_t{i} + 1];
    const float r = b_.radius[i];
    if (pair.shape >= kWallLeft) {
      const auto d = [](std::int32_t a, std::int32_t w, float rest, double pitch) {
        return static_cast<float>(wrap_sub(a, w) * pitch - static_cast<double>(rest));
      };
      switch (pair.shape) {
        case kWallLeft:
          return face(pair, 1, 0, d(x, walls_.low.x, walls_.low.dx, px_) - r);
        case kWallRight:
          return face(pair, -1, 0, -d(x, walls_.high.x, walls_.high.dx, px_) - r);
        case kWallBottom:
          return face(pair, 0, 1, d(y, walls_.low.y, walls_.low.dy, py_) - r);
        default:
          return face(pair, 0, -1, -d(y, walls_.high.y, walls_.high.dy, py_) - r);
      }
    }
    const StaticShape& s = statics_[pair.shape];
    standing(pair, s, r);
    if (s.asleep) yield(pair, s);
  }

  // Makes the contact as soft as it was when both sides moved. Both bodies are at rest, so that the normal lasts.
  void yield(const StaticPair& pair, const StaticShape& s) {
    const std::uint32_t at = pair.contact;
    if (c_.s_gap[at] < 0) {
      c_.s_gap[at] *= yield_of_sleeper(b_.properties(s.owner).inv_mass, b_.properties(b_.id[pair.body]).inv_mass);
    }
    c_.s_refresh[at] = std::numeric_limits<float>::infinity();
  }

  void standing(const StaticPair& pair, const StaticShape& s, float r) {
    const Vec2 a = from_start(pair, s);
    if (!s.segment) return round(pair, a.x, a.y, s.radius, r);
    const Vec2 u = lattice_.way(s.p, s.q);
    const double uu = u.x * u.x + u.y * u.y;
    const double along = a.x * u.x + a.y * u.y;
    if (along < 0 || along > uu) {
      ++corners_;
      if (along < 0) return round(pair, a.x, a.y, s.radius, r);
      return round(pair, a.x - u.x, a.y - u.y, s.radius, r);
    }
    const double length = std::sqrt(uu);
    const double side = (u.x * a.y - u.y * a.x) / length;  // left of p->q is positive
    double sign = side < 0 || s.face ? -1 : 1;
    if (s.face && side > 0) ++inside_;
    // A disc that its neighbours press through a thin segment still counts on the side from which it came.
    const std::uint32_t at = pair.contact;
    if (c_.s_impulse[at] > 0 && !s.face) {
      const double was = static_cast<double>(c_.s_nx[at]) * -u.y + static_cast<double>(c_.s_ny[at]) * u.x;
      if (was != 0) sign = was < 0 ? -1 : 1;
    }
    face(pair, static_cast<float>(-u.y / length * sign), static_cast<float>(u.x / length * sign),
         static_cast<float>(side * sign) - (r + s.radius));
  }

  void face(const StaticPair& pair, float nx, float ny, float gap) {
    const std::uint32_t at = pair.contact;
    c_.s_nx[at] = nx;
    c_.s_ny[at] = ny;
    c_.s_gap[at] = gap;
    c_.s_base_x[at] = c_.s_base_y[at] = 0;
    c_.s_rsum[at] = b_.radius[pair.body];
    c_.s_refresh[at] = std::numeric_limits<float>::infinity();
  }

  void round(const StaticPair& pair, double x, double y, float fixed, float r) {
    const std::uint32_t at = pair.contact;
    const double far = std::sqrt(x * x + y * y);
    c_.s_nx[at] = far > 0 ? static_cast<float>(x / far) : 0.0f;
    c_.s_ny[at] = far > 0 ? static_cast<float>(y / far) : 1.0f;
    c_.s_gap[at] = static_cast<float>(far) - (r + fixed);
    c_.s_base_x[at] = static_cast<float>(x);
    c_.s_base_y[at] = static_cast<float>(y);
    c_.s_rsum[at] = r + fixed;
    c_.s_refresh[at] = refresh_;
  }

  // If a disc meets the end of a segment, and this end lies on another segment that the disc meets, the other segment
  // carries the disc, so that there is no bump at joints. Of two ends at one point the first counts.
  void drop_doubled_corners(const std::vector<StaticPair>& list, std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const std::uint32_t at = list[k].contact;
      if (!is_corner(list[k])) continue;
      // The corner lies at -(base) relative to the centre of the body.
      const double cx = -static_cast<double>(c_.s_base_x[at]);
      const double cy = -static_cast<double>(c_.s_base_y[at]);
      for (std::size_t o = begin; o < end; ++o) {
        if (o == k || list[o].shape >= kWallLeft || !statics_[list[o].shape].segment) continue;
        if (is_corner(list[o])) {  // the nearer end counts; of two at one point the first
          const double near = squared(list[o]), mine = cx * cx + cy * cy;
          const bool one_point = std::fabs(near - mine) <= 1e-5 * mine;
          if (one_point ? o > k : near > mine) continue;
          if (o > k && rises(list[k], list[o])) continue;
        }
        if (distance_to(list[o], cx, cy) < 1e-5 * static_cast<double>(b_.radius[list[k].body]) + 4 * px_) {
          drop(at);
          break;
        }
      }
    }
  }

  // Whether a segment rises from another one, seen from the side of the body.
  bool rises(const StaticPair& pair, const StaticPair& from) const {
    const StaticShape &s = statics_[pair.shape], &o = statics_[from.shape];
    const double ux = wrap_sub(o.q.x, o.p.x) * px_, uy = wrap_sub(o.q.y, o.p.y) * py_;
    const double side = outside(from) > 0 ? 1 : -1;
    const auto height = [&](const LatticePoint& p) {
      return side * (uy * (wrap_sub(p.x, o.p.x) * px_) - ux * (wrap_sub(p.y, o.p.y) * py_));
    };
    const double least = 1e-3 * (ux * ux + uy * uy);
    return height(s.p) > least || height(s.q) > least;
  }

  // The squared distance from the centre of a body to the corner that it meets.
  double squared(const StaticPair& pair) const {
    const double x = static_cast<double>(c_.s_base_x[pair.contact]);
    const double y = static_cast<double>(c_.s_base_y[pair.contact]);
    return x * x + y * y;
  }

  // Some edges of a polygon have the centre of a disc on their inner side. None of them counts if another edge has it
  // outside; else the nearest one counts, through which the disc leaves.
  void keep_nearest_faces(const std::vector<StaticPair>& list, std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      if (!is_face(list[k])) continue;
      const double mine = outside(list[k]);
      if (!(mine < 0)) continue;
      for (std::size_t o = begin; o < end; ++o) {
        if (o == k || !is_face(list[o]) || statics_[list[o].shape].owner != statics_[list[k].shape].owner) {
          continue;
        }
        const double other = outside(list[o]);
        if (other < mine || (other == mine && o > k)) continue;
        drop(list[k].contact);
        break;
      }
    }
  }

  bool is_face(const StaticPair& pair) const { return pair.shape < kWallLeft && statics_[pair.shape].face; }

  // The vector from the start of a shape to the lattice point of the body, m.
  Vec2 from_start(const StaticPair& pair, const StaticShape& s) const {
    const std::size_t i = pair.body;
    return lattice_.way(s.p, {b_.pos[2 * i], b_.pos[2 * i + 1], 0, 0});
  }

  // How far the centre of a body lies outside of the line of an edge, m.
  double outside(const StaticPair& pair) const {
    const StaticShape& s = statics_[pair.shape];
    const Vec2 a = from_start(pair, s), u = lattice_.way(s.p, s.q);
    return (u.y * a.x - u.x * a.y) / length_of(u);
  }

  // Another contact counts in place of this one.
  void drop(std::uint32_t at) {
    c_.s_gap[at] = kNoGap;
    c_.s_refresh[at] = std::numeric_limits<float>::infinity();
    c_.s_impulse[at] = 0;
  }

  bool is_corner(const StaticPair& pair) const {
    return pair.shape < kWallLeft && statics_[pair.shape].segment &&
           (c_.s_base_x[pair.contact] != 0 || c_.s_base_y[pair.contact] != 0);
  }

  // The distance from a point, relative to the centre of the body, to a segment.
  double distance_to(const StaticPair& pair, double x, double y) const {
    const StaticShape& s = statics_[pair.shape];
    const std::size_t i = pair.body;
    const double ax = x + wrap_sub(b_.pos[2 * i], s.p.x) * px_ - static_cast<double>(s.p.dx);
    const double ay = y + wrap_sub(b_.pos[2 * i + 1], s.p.y) * py_ - static_cast<double>(s.p.dy);
    const Vec2 u = lattice_.way(s.p, s.q);
    const double t = std::fmin(std::fmax((ax * u.x + ay * u.y) / (u.x * u.x + u.y * u.y), 0), 1);
    return length_of({ax - t * u.x, ay - t * u.y});
  }

  const BodyStore& b_;
  const StaticShapes& statics_;
  const Walls& walls_;
  const Lattice& lattice_;
  ContactStore& c_;
  double px_, py_;
  float refresh_;
  int corners_ = 0, inside_ = 0;
};

}  // namespace

void narrow_phase(const Surroundings& s, SolverBodies& solved, const Walls& walls, float refresh,
                  const PairTable& table, ContactStore& contacts) {
  solved.load();
  const kernels::BodyView bodies = solved.view();
  const kernels::ContactView pairs = contacts.pairs();
  kernels::ContactParams p;
  p.pitch_x = static_cast<float>(s.lattice.pitch_x());
  p.pitch_y = static_cast<float>(s.lattice.pitch_y());
  s.pool.run(table.strips.size(), [&](std::size_t index) {
    const Strip& strip = table.strips[index];
    if (strip.block_begin != strip.block_end) {
      s.kernels.prepare(bodies, pairs, p, strip.block_begin, strip.block_end);
    }
    const std::vector<StaticPair>& list = table.static_contacts[index];
    StaticGeometry geometry(s, walls, refresh, contacts);
    for (std::size_t begin = 0; begin < list.size();) {
      std::size_t end = begin + 1;
      while (end < list.size() && list[end].body == list[begin].body) ++end;
      geometry.body(list, begin, end);
      begin = end;
    }
  });
}

}  // namespace psim
