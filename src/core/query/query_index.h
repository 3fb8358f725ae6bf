// The grids from which queries are answered: one of the moving (and frozen) bodies, one of those that sleep, and
// one of the static ones. The first query after a change makes a grid; it lasts until the next change.
//
// In: bodies, static shapes. O(bodies) a grid; queries about static bodies alone do not make the grid of the
// moving ones. Many threads may ask at once: the first makes the grid, the others wait for it. Nobody may
// change the world meanwhile.
#pragma once

#include <atomic>
#include <concepts>
#include <mutex>
#include <vector>

#include "geometry/convex.h"
#include "query/observed.h"
#include "query/query_grid.h"

namespace psim {

/// The piece of an item that is no disc. Places are relative to the centre of the item.
struct QueryPiece {
  enum Kind : std::uint8_t { kHull, kWholeStatic, kSegment };
  Vec2 at{};               ///< m: the origin of a hull; the first end of a segment
  Vec2 way{};              ///< of a hull its cosine and sine; of a segment the way from its first end to the other, m
  float radius = 0;        ///< m, around a segment
  std::uint32_t hull = 0;  ///< number in BodyStore::hulls; of a whole static polygon the number of its shape
  Kind kind = kHull;
};

class QueryIndex {
 public:
  static constexpr std::uint32_t kDisc = 0xFFFFFFFFu;  ///< QueryItem::piece

  /// A grid and the pieces of its items.
  struct Part {
    QueryGrid grid;
    std::vector<QueryPiece> pieces;
  };

  /// Whose grids there are: moving and frozen bodies, bodies that sleep, and fixed geometry.
  enum Who : std::uint8_t { kMoving, kSleeping, kFixed };

  /// They moved, came or went, fell asleep or woke.
  void forget(std::same_as<Who> auto... who) { (ready_[who].store(false, std::memory_order_relaxed), ...); }
  const Part& part(const Observed& world, Who who) const;

  /// The outline of an item if its centre lies at `at`.
  static Outline outline(const Observed& world, const Part& part, const QueryItem& item, Vec2 at);

  /// Calls each(id) for the bodies with wanted(item) that have a point in common with `shape`, an outline about `at`. Its
  /// box has half the width and height `half`. A body may come more than once.
  template <class Wanted, class Each>
  static void each_overlap(const Observed& world, const Part& part, const Outline& shape, Vec2 at, Vec2 half,
                           const Wanted& wanted, const Each& each) {
    part.grid.in_box(at - half, at + half, [&](const QueryItem& item, Vec2 shift) {
      const Vec2 to = item.seen_from(at, shift);
      const double r = wide(item.radius);
      if (std::fabs(to.x) > half.x + r || std::fabs(to.y) > half.y + r || !wanted(item)) return;
      if (overlap(shape, outline(world, part, item, to))) each(item.body);
    });
  }

  std::size_t bytes() const;

 private:
  // A part is made under the lock by the first query that needs it. Its flag is set by release after it was made and read
  // by acquire before it is used. forget() is relaxed: whoever changes the world is alone with it.
  mutable std::mutex making_;
  mutable std::atomic<bool> ready_[3]{};
  mutable Part parts_[3];
};

}  // namespace psim
