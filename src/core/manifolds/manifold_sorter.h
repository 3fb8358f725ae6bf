// Sorts the pairs of the lists: which are manifolds, of which parts. For the files of manifolds alone.
#pragma once

#include <algorithm>
#include <cmath>

#include "compiler.h"
#include "manifolds/manifold_look.h"
#include "manifolds/manifolds.h"
#include "manifolds/part_boxes.h"

namespace psim {

// Decides which pairs leave the lists: those that must not collide, and the manifolds, which go to `out`.
struct Manifolds::Sorter {
  const Manifolds& m;
  const Joined* joined;
  const std::vector<ManifoldPair>& known;  // the pairs of the index
  std::vector<FoundPair>& out;
  mutable std::vector<std::uint32_t> near_a = {}, near_b = {};  // scratch
  const BodyStore& b = m.s_.bodies;
  const StaticShapes& statics = m.s_.statics;

  bool leaves(std::uint32_t i, std::uint32_t j) const {
    const int kinds = m.kind_[i] | m.kind_[j];
    if ((kinds & ~kTied) == 0 && joined == nullptr) return false;
    if (!collide_at_all(i, j)) return true;
    return (kinds & kShape) != 0 && note(i, j);
  }

  bool leaves(const StaticPair& pair) const {
    const std::uint8_t kind = m.kind_[pair.body];
    // Contacts of shapes alone know special surfaces.
    const bool special = pair.shape < kWallLeft ? statics[pair.shape].special : m.wall_special_;
    const bool shape = (kind & kShape) != 0 || special;
    if ((kind & kKinematic) != 0 && shape) return true;
    if (pair.shape < kWallLeft) {
      const StaticShape& piece = statics[pair.shape];
      const std::uint32_t id = b.id[pair.body];
      if (shape ? piece.face : piece.whole) return true;
      if (m.any_filter_ && (kind & kParts) == 0 && !b.collide(b.kind(id), 0, b.kind(piece.owner), piece.part))
        return true;
      if (joined != nullptr && (*joined)(id, piece.owner)) return true;
    }
    return shape && note(pair);
  }

 private:
  bool collide_at_all(std::uint32_t i, std::uint32_t j) const {
    const std::uint32_t id = b.id[i], other = b.id[j];
    const int kinds = m.kind_[i] | m.kind_[j];
    if ((kinds & (kFiltered | kSensor)) != 0 && !b.may_collide(b.kind(id), b.kind(other))) return false;
    if ((m.kind_[i] & m.kind_[j] & kKinematic) != 0) return false;  // neither body can be moved
    return joined == nullptr || !(*joined)(id, other);
  }

  // Adds the manifolds of a pair, one for each two of its parts. The first is made in place, since a copy would wait for
  // what was just written.
  template <class... Sides>
  bool note(const Sides&... sides) const {
    FoundPair& first = out.emplace_back();
    name(sides..., first);
    const std::uint32_t parts_a = first.of_piece() ? 1 : parts(first.a), parts_b = parts(first.b);
    // The boxes of two such bodies show which of their parts may meet while the pair lasts.
    const bool boxed = !first.fixed_a && m.boxed_ && (m.boxes_.has(first.a) || m.boxes_.has(first.b));
    const PartBoxes::Pair lie = !boxed ? PartBoxes::Pair{} : m.step_ > 0 ? as_they_lie(first) : as_they_lay(first);
    if (parts_a == 1 && parts_b == 1) {
      if ((boxed && !m.boxes_.meet(lie, 0, 0)) || (have_parts(first) && !collide(first))) {
        out.pop_back();
        return true;
      }
      first.before = m.index_.find(first, known);
      return true;
    }
    FoundPair pair = first;
    out.pop_back();
    const auto add = [&](std::uint32_t part_a, std::uint32_t part_b) {
      pair.part_a = part_a;
      pair.part_b = part_b;
      if (have_parts(pair) && !collide(pair)) return;
      pair.before = m.index_.find(pair, known);
      out.push_back(pair);
    };
    if (!boxed) {
      each_near(pair, parts_a, parts_b, sides..., add);
    } else if (!m.parts_.has(pair.a) && !m.parts_.has(pair.b)) {
      m.boxes_.each_meeting(lie, parts_a, parts_b, add);
    } else {
      each_near(pair, parts_a, parts_b, sides..., [&](std::uint32_t part_a, std::uint32_t part_b) {
        if (m.boxes_.meet(lie, part_a, part_b)) add(part_a, part_b);
      });
    }
    return true;
  }

  // Look finds nothing of two bodies with a larger gap than `within`.
  PartBoxes::Pair as_they_lie(const PairName& pair) const {
    const Vec2 way = m.s_.lattice.way(b.point(pair.a), b.point(pair.b)), u = b.velocity(pair.b) - b.velocity(pair.a);
    const float rims = std::fabs(b.rim_speed_of(pair.a)) + std::fabs(b.rim_speed_of(pair.b));
    const float closing = kernels::snapped(length_of(u)) + rims + m.gravity_ * m.step_;
    const float most_inner = std::min(b.radius[pair.a], b.radius[pair.b]);
    const float wanted = Look::wanted_of(most_inner, m.step_, closing);
    return {pair.a, pair.b, kernels::snapped(way.x), kernels::snapped(way.y), Look::margin_of(most_inner, wanted)};
  }

  // For lists that last: how two bodies lay when the lists were made, and how far both may go and turn until the lists
  // are made anew.
  PartBoxes::Pair as_they_lay(const PairName& pair) const {
    const Vec2 way = m.parts_.way(pair.a, pair.b);
    const double within = m.parts_.margin_of(pair.a) + m.parts_.margin_of(pair.b);
    const float turn = m.boxes_.turn_of(pair.a) + m.boxes_.turn_of(pair.b);
    return {pair.a, pair.b, kernels::snapped(way.x), kernels::snapped(way.y), kernels::snapped(within) + turn};
  }

  // Whether a body of a pair has parts that may differ.
  PSIM_INLINE bool have_parts(const PairName& pair) const {
    return ((m.kind_[pair.b] | (pair.of_piece() ? 0 : m.kind_[pair.a])) & kParts) != 0;
  }

  // Whether two parts collide, of such bodies. Walls hold bodies that are nothing but sensors, which would fall out of
  // the world, but no sensor that is a part of a body.
  bool collide(const PairName& pair) const {
    const BodyKind& kind = b.kind(pair.id_b);
    if (pair.of_wall()) return kind.sensor || !b.is_sensor(kind, pair.part_b);
    const std::uint32_t part_a = pair.of_piece() ? statics[pair.shape].part : pair.part_a;
    return b.collide(b.kind(pair.id_a), part_a, kind, pair.part_b);
  }

  // Calls add(part of A, part of B) for the parts of a body and a fixed piece that may meet, in order.
  template <class Add>
  void each_near(const PairName& pair, std::uint32_t, std::uint32_t parts_b, const StaticPair& of,
                 const Add& add) const {
    if (!m.parts_.has(pair.b)) {
      for (std::uint32_t b = 0; b < parts_b; ++b) add(0, b);
      return;
    }
    near_b.clear();
    m.parts_.near_piece(of, m.walls_, near_b);
    for (const std::uint32_t b : near_b) add(0, b);
  }
  // The same for two bodies.
  template <class Add>
  void each_near(const PairName& pair, std::uint32_t parts_a, std::uint32_t parts_b, std::uint32_t, std::uint32_t,
                 const Add& add) const {
    const bool many_a = m.parts_.has(pair.a), many_b = m.parts_.has(pair.b);
    near_a.clear();
    near_b.clear();
    if (many_a) {
      m.parts_.near_body(pair.a, pair.b, near_a);
    } else {
      for (std::uint32_t a = 0; a < parts_a; ++a) near_a.push_back(a);
    }
    if (many_b && !many_a) m.parts_.near_body(pair.b, pair.a, near_b);
    for (std::uint32_t b = 0; !many_b && b < parts_b; ++b) near_b.push_back(b);
    for (const std::uint32_t a : near_a) {
      if (many_a && many_b) {
        near_b.clear();
        m.parts_.near_part(pair.b, pair.a, a, near_b);
      }
      for (const std::uint32_t b : near_b) add(a, b);
    }
  }

  PSIM_INLINE std::uint32_t parts(std::uint32_t slot) const {
    return m.has_corners(slot) ? std::max(1u, b.kind(b.id[slot]).hull_count) : 1u;
  }

  void name(std::uint32_t i, std::uint32_t j, PairName& pair) const {
    const bool held_i = (m.kind_[i] & kKinematic) != 0, held_j = (m.kind_[j] & kKinematic) != 0;
    const bool swap = held_i != held_j ? held_j : b.id[j] < b.id[i];
    pair.a = swap ? j : i;
    pair.b = swap ? i : j;
    pair.id_a = b.id[pair.a];
    pair.id_b = b.id[pair.b];
    pair.fixed_a = held_i || held_j;
    pair.owner = b.radius[pair.b] <= b.radius[pair.a] ? pair.id_b : pair.id_a;
  }

  void name(const StaticPair& static_pair, PairName& pair) const {
    pair.b = static_pair.body;
    pair.id_b = b.id[static_pair.body];
    pair.shape = static_pair.shape;
    pair.id_a = pair.shape >= kWallLeft ? PairName::kNone : statics[pair.shape].owner;
    pair.fixed_a = true;
    // A body that hits a wall of sleepers may have hundreds of such pairs; each sleeper has few.
    pair.owner = pair.of_sleeper(statics) ? pair.id_a : pair.id_b;
  }
};

}  // namespace psim
