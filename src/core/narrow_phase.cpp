#include "narrow_phase.h"

#include <array>
#include <cmath>
#include <limits>

#include "softness.h"

namespace psim {
namespace {

constexpr float kFar = 1e6f;  // m: gap of a contact that another one stands for

class SingleGeometry {
 public:
  SingleGeometry(const BodyStore& b, const StaticShapes& shapes, const Walls& walls,
                 const Lattice& lattice, float refresh, ContactStore& c)
      : b_(b), shapes_(shapes), walls_(walls), c_(c), px_(lattice.pitch_x()),
        py_(lattice.pitch_y()), refresh_(refresh) {}

  /// All contacts of one body: list[begin..end).
  void body(const std::vector<SinglePair>& list, std::size_t begin, std::size_t end) {
    corners_ = inside_ = 0;
    for (std::size_t k = begin; k < end; ++k) one(list[k]);
    if (corners_ != 0 && end - begin > 1) drop_doubled_corners(list, begin, end);
    if (inside_ != 0) keep_nearest_faces(list, begin, end);
  }

 private:
  void one(const SinglePair& pair) {
    const std::uint32_t i = pair.body;
    const std::int32_t x = b_.pos[2 * std::size_t{i}], y = b_.pos[2 * std::size_t{i} + 1];
    const float r = b_.radius[i];
    if (pair.shape >= kWallLeft) {
      const auto d = [](std::int32_t a, std::int32_t w, float rest, double pitch) {
        return static_cast<float>(wrap_sub(a, w) * pitch - static_cast<double>(rest));
      };
      switch (pair.shape) {
        case kWallLeft: return face(pair, 1, 0, d(x, walls_.low.x, walls_.low.dx, px_) - r);
        case kWallRight: return face(pair, -1, 0, -d(x, walls_.high.x, walls_.high.dx, px_) - r);
        case kWallBottom: return face(pair, 0, 1, d(y, walls_.low.y, walls_.low.dy, py_) - r);
        default: return face(pair, 0, -1, -d(y, walls_.high.y, walls_.high.dy, py_) - r);
      }
    }
    const StaticShape& s = shapes_[pair.shape];
    standing(pair, s, x, y, r);
    if (s.asleep) yield(pair, s);
  }

  // As soft as the contact was when both sides moved; it is of bodies at rest, whose normal lasts.
  void yield(const SinglePair& pair, const StaticShape& s) {
    const std::uint32_t at = pair.contact;
    if (c_.s_gap[at] < 0) {
      c_.s_gap[at] *= yield_of_sleeper(b_.surface(s.owner).inv_mass, b_.surface(b_.id[pair.body]).inv_mass);
    }
    c_.s_refresh[at] = std::numeric_limits<float>::infinity();
  }

  void standing(const SinglePair& pair, const StaticShape& s, std::int32_t x, std::int32_t y, float r) {
    const double ax = wrap_sub(x, s.p.x) * px_ - static_cast<double>(s.p.dx);
    const double ay = wrap_sub(y, s.p.y) * py_ - static_cast<double>(s.p.dy);
    if (!s.segment) return round(pair, ax, ay, s.radius, r);
    const double ux = wrap_sub(s.q.x, s.p.x) * px_ + (static_cast<double>(s.q.dx) - static_cast<double>(s.p.dx));
    const double uy = wrap_sub(s.q.y, s.p.y) * py_ + (static_cast<double>(s.q.dy) - static_cast<double>(s.p.dy));
    const double uu = ux * ux + uy * uy;
    const double along = ax * ux + ay * uy;
    if (along < 0 || along > uu) {
      ++corners_;
      if (along < 0) return round(pair, ax, ay, s.radius, r);
      return round(pair, ax - ux, ay - uy, s.radius, r);
    }
    const double length = std::sqrt(uu);
    const double side = (ux * ay - uy * ax) / length;  // left of p->q is positive
    double sign = side < 0 || s.face ? -1 : 1;
    if (s.face && side > 0) ++inside_;
    // Pressed through a thin segment by its neighbours, a disc is still on the side it came from.
    const std::uint32_t at = pair.contact;
    if (c_.s_impulse[at] > 0 && !s.face) {
      const double was = static_cast<double>(c_.s_nx[at]) * -uy + static_cast<double>(c_.s_ny[at]) * ux;
      if (was != 0) sign = was < 0 ? -1 : 1;
    }
    face(pair, static_cast<float>(-uy / length * sign), static_cast<float>(ux / length * sign),
         static_cast<float>(side * sign) - (r + s.radius));
  }

  void face(const SinglePair& pair, float nx, float ny, float gap) {
    const std::uint32_t at = pair.contact;
    c_.s_nx[at] = nx;
    c_.s_ny[at] = ny;
    c_.s_gap[at] = gap;
    c_.s_base_x[at] = c_.s_base_y[at] = 0;
    c_.s_rsum[at] = b_.radius[pair.body];
    c_.s_refresh[at] = std::numeric_limits<float>::infinity();
  }

  void round(const SinglePair& pair, double x, double y, float fixed, float r) {
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

  // Where a disc meets the end of a segment that lies on another segment it meets, the other one
  // carries it: no bump at joints. Of two ends at one point the first counts.
  void drop_doubled_corners(const std::vector<SinglePair>& list, std::size_t begin,
                            std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const std::uint32_t at = list[k].contact;
      if (!is_corner(list[k])) continue;
      // The corner relative to the body's centre is -(base).
      const double cx = -static_cast<double>(c_.s_base_x[at]);
      const double cy = -static_cast<double>(c_.s_base_y[at]);
      for (std::size_t o = begin; o < end; ++o) {
        if (o == k || list[o].shape >= kWallLeft || !shapes_[list[o].shape].segment) continue;
        if (is_corner(list[o])) {  // the one whose end is nearer; of two at one point the first
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

  // Whether a segment goes up from another one, seen from the body's side.
  bool rises(const SinglePair& pair, const SinglePair& from) const {
    const StaticShape &s = shapes_[pair.shape], &o = shapes_[from.shape];
    const double ux = wrap_sub(o.q.x, o.p.x) * px_, uy = wrap_sub(o.q.y, o.p.y) * py_;
    const double side = outside(from) > 0 ? 1 : -1;
    const auto height = [&](const LatticePoint& p) {
      return side * (uy * (wrap_sub(p.x, o.p.x) * px_) - ux * (wrap_sub(p.y, o.p.y) * py_));
    };
    const double least = 1e-3 * (ux * ux + uy * uy);
    return height(s.p) > least || height(s.q) > least;
  }

  // Distance from a body's centre to the corner it meets, squared.
  double squared(const SinglePair& pair) const {
    const double x = static_cast<double>(c_.s_base_x[pair.contact]);
    const double y = static_cast<double>(c_.s_base_y[pair.contact]);
    return x * x + y * y;
  }

  // Edges of a polygon that have a disc's centre on their inner side: none of them counts if another
  // edge has it outside, else the nearest one, by which the disc leaves.
  void keep_nearest_faces(const std::vector<SinglePair>& list, std::size_t begin,
                          std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      if (!is_face(list[k])) continue;
      const double mine = outside(list[k]);
      if (!(mine < 0)) continue;
      for (std::size_t o = begin; o < end; ++o) {
        if (o == k || !is_face(list[o]) || shapes_[list[o].shape].owner != shapes_[list[k].shape].owner) {
          continue;
        }
        const double other = outside(list[o]);
        if (other < mine || (other == mine && o > k)) continue;
        drop(list[k].contact);
        break;
      }
    }
  }

  bool is_face(const SinglePair& pair) const {
    return pair.shape < kWallLeft && shapes_[pair.shape].face;
  }

  // How far a body's centre lies outside of an edge's line, m.
  double outside(const SinglePair& pair) const {
    const StaticShape& s = shapes_[pair.shape];
    const std::size_t i = pair.body;
    const double ax = wrap_sub(b_.pos[2 * i], s.p.x) * px_ - static_cast<double>(s.p.dx);
    const double ay = wrap_sub(b_.pos[2 * i + 1], s.p.y) * py_ - static_cast<double>(s.p.dy);
    const double ux = wrap_sub(s.q.x, s.p.x) * px_ + (static_cast<double>(s.q.dx) - static_cast<double>(s.p.dx));
    const double uy = wrap_sub(s.q.y, s.p.y) * py_ + (static_cast<double>(s.q.dy) - static_cast<double>(s.p.dy));
    return (uy * ax - ux * ay) / std::sqrt(ux * ux + uy * uy);
  }

  // Another contact stands for this one.
  void drop(std::uint32_t at) {
    c_.s_gap[at] = kFar;
    c_.s_refresh[at] = std::numeric_limits<float>::infinity();
    c_.s_impulse[at] = 0;
  }

  bool is_corner(const SinglePair& pair) const {
    return pair.shape < kWallLeft && shapes_[pair.shape].segment &&
           (c_.s_base_x[pair.contact] != 0 || c_.s_base_y[pair.contact] != 0);
  }

  // Distance from a point (relative to the body's centre) to a segment.
  double distance_to(const SinglePair& pair, double x, double y) const {
    const StaticShape& s = shapes_[pair.shape];
    const std::size_t i = pair.body;
    const double ax = x + wrap_sub(b_.pos[2 * i], s.p.x) * px_ - static_cast<double>(s.p.dx);
    const double ay = y + wrap_sub(b_.pos[2 * i + 1], s.p.y) * py_ - static_cast<double>(s.p.dy);
    const double ux = wrap_sub(s.q.x, s.p.x) * px_ + (static_cast<double>(s.q.dx) - static_cast<double>(s.p.dx));
    const double uy = wrap_sub(s.q.y, s.p.y) * py_ + (static_cast<double>(s.q.dy) - static_cast<double>(s.p.dy));
    const double t = std::fmin(std::fmax((ax * ux + ay * uy) / (ux * ux + uy * uy), 0), 1);
    const double dx = ax - t * ux, dy = ay - t * uy;
    return std::sqrt(dx * dx + dy * dy);
  }

  const BodyStore& b_;
  const StaticShapes& shapes_;
  const Walls& walls_;
  ContactStore& c_;
  double px_, py_;
  float refresh_;
  int corners_ = 0, inside_ = 0;
};

}  // namespace

void narrow_phase(BodyStore& b, SolverBodies& solved, const StaticShapes& shapes, const Walls& walls,
                  const Lattice& lattice, float refresh, PairTable& table, ContactStore& contacts,
                  const kernels::KernelTable& k, WorkerPool& pool) {
  solved.load(b, pool);
  const kernels::BodyView bodies = solved.view(b);
  const kernels::ContactView pairs = contacts.pairs();
  kernels::ContactParams p;
  p.pitch_x = static_cast<float>(lattice.pitch_x());
  p.pitch_y = static_cast<float>(lattice.pitch_y());
  pool.run(table.strips.size(), [&](std::size_t index) {
    const Strip& s = table.strips[index];
    if (s.block_begin != s.block_end) k.prepare(bodies, pairs, p, s.block_begin, s.block_end);
    const std::vector<SinglePair>& list = table.singles[index];
    SingleGeometry geometry(b, shapes, walls, lattice, refresh, contacts);
    for (std::size_t begin = 0; begin < list.size();) {
      std::size_t end = begin + 1;
      while (end < list.size() && list[end].body == list[begin].body) ++end;
      geometry.body(list, begin, end);
      begin = end;
    }
  });
}

}  // namespace psim
