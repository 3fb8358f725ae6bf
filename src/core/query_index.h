// What questions are answered from: grids of the moving bodies (and frozen ones), of those that sleep, and
// of the static ones. Each is made by the first question after a change and kept until the next change.
//
// In: bodies, static shapes. Owner: the world. O(bodies) a grid; questions about static bodies alone do
// not make that of the moving ones. Many threads may ask at once: the first makes the grid, the others
// wait for it. Nobody may change the world meanwhile.
#pragma once

#include <atomic>
#include <mutex>
#include <vector>

#include "body_store.h"
#include "lattice.h"
#include "psim/world.h"
#include "query_grid.h"
#include "query_shapes.h"
#include "sleepers.h"
#include "static_shapes.h"

namespace psim {

struct FixedBody;

/// What an item is, where it is not a disc. Places are seen from the item's centre.
struct QueryPiece {
  enum Kind : std::uint8_t { kHull, kWholeStatic, kSegment };
  Vec2 at;                 ///< m: the hull's origin; a segment's first end
  Vec2 way;                ///< cosine and sine; m, from a segment's first end to its other
  float radius = 0;        ///< m, around a segment
  std::uint32_t hull = 0;  ///< in BodyStore::hulls; of a whole static one its shape's number
  Kind kind = kHull;
};

/// What the grids are made from.
struct QuerySource {
  const BodyStore& bodies;
  const StaticShapes& shapes;
  const std::vector<FixedBody>& fixed;
  const std::vector<BodyState>& frozen;
  const std::vector<Sleeper>& sleepers;
  const Lattice& lattice;
  Vec2 period;             ///< m; 0: not periodic
  bool all_discs = false;  ///< that move
};

class QueryIndex {
 public:
  static constexpr std::uint32_t kDisc = 0xFFFFFFFFu;  ///< QueryItem::piece

  /// A grid and what its items are.
  struct Part {
    QueryGrid grid;
    std::vector<QueryPiece> pieces;
  };

  /// Bodies moved, came or went.
  void forget_moving() { moving_ready_.store(false, std::memory_order_relaxed); }
  /// Some fell asleep or woke.
  void forget_sleeping() { sleeping_ready_.store(false, std::memory_order_relaxed); }
  void forget_fixed() { fixed_ready_.store(false, std::memory_order_relaxed); }

  const Part& moving(const QuerySource& source) const;
  const Part& sleeping(const QuerySource& source) const;
  const Part& fixed(const QuerySource& source) const;

  /// The outline of a piece whose item's centre lies at `at`.
  static Outline outline(const QuerySource& source, const QueryPiece& piece, Vec2 at);
  /// The same of an item, discs among them.
  static Outline outline(const QuerySource& source, const Part& part, const QueryItem& item,
                         Vec2 at);

  std::size_t bytes() const;

 private:
  using Fill = void (*)(const QuerySource&, Part&);
  const Part& made(const QuerySource& source, std::atomic<bool>& ready, Part& part, Fill fill) const;

  mutable std::mutex making_;
  mutable std::atomic<bool> moving_ready_{false}, sleeping_ready_{false},
      fixed_ready_{false};
  mutable Part moving_, sleeping_, fixed_;
};

}  // namespace psim
