// The grids from which queries are answered: one of the moving (and frozen) bodies, one of those that sleep, and
// one of the static ones. The first query after a change makes a grid; it lasts until the next change.
//
// In: bodies, static shapes. O(bodies) a grid; queries about static bodies alone do not make the grid of the
// moving ones. Many threads may ask at once: the first makes the grid, the others wait for it. Nobody may
// change the world meanwhile.
#pragma once

#include <atomic>
#include <mutex>
#include <vector>

#include "base/lattice.h"
#include "bodies/body_store.h"
#include "bodies/static_shapes.h"
#include "psim/world.h"
#include "query/query_grid.h"
#include "query/query_shapes.h"
#include "sleep/sleepers.h"

namespace psim {

/// The piece of an item that is no disc. Places are relative to the centre of the item.
struct QueryPiece {
  enum Kind : std::uint8_t { kHull, kWholeStatic, kSegment };
  Vec2 at;                 ///< m: the origin of a hull; the first end of a segment
  Vec2 way;                ///< of a hull its cosine and sine; of a segment the way from its first end to the other, m
  float radius = 0;        ///< m, around a segment
  std::uint32_t hull = 0;  ///< number in BodyStore::hulls; of a whole static polygon the number of its shape
  Kind kind = kHull;
};

/// The parts of a world from which the grids are made.
struct QuerySource {
  const BodyStore& bodies;
  const StaticShapes& statics;
  const std::vector<FixedBody>& fixed;
  const std::vector<BodyState>& frozen;
  const std::vector<Sleeper>& sleepers;
  const Lattice& lattice;
  Vec2 period;             ///< m; 0: not periodic
  bool all_discs = false;  ///< all moving bodies are discs
};

class QueryIndex {
 public:
  static constexpr std::uint32_t kDisc = 0xFFFFFFFFu;  ///< QueryItem::piece

  /// A grid and the pieces of its items.
  struct Part {
    QueryGrid grid;
    std::vector<QueryPiece> pieces;
  };

  /// Bodies moved, came or went.
  void forget_moving() { moving_ready_.store(false, std::memory_order_relaxed); }
  /// Bodies fell asleep or woke.
  void forget_sleeping() { sleeping_ready_.store(false, std::memory_order_relaxed); }
  void forget_fixed() { fixed_ready_.store(false, std::memory_order_relaxed); }

  const Part& moving(const QuerySource& source) const;
  const Part& sleeping(const QuerySource& source) const;
  const Part& fixed(const QuerySource& source) const;

  /// The outline of a piece if the centre of its item lies at `at`.
  static Outline outline(const QuerySource& source, const QueryPiece& piece, Vec2 at);
  /// The outline of an item, which may be a disc.
  static Outline outline(const QuerySource& source, const Part& part, const QueryItem& item, Vec2 at);

  std::size_t bytes() const;

 private:
  using Fill = void (*)(const QuerySource&, Part&);
  const Part& made(const QuerySource& source, std::atomic<bool>& ready, Part& part, Fill fill) const;

  mutable std::mutex making_;
  mutable std::atomic<bool> moving_ready_{false}, sleeping_ready_{false}, fixed_ready_{false};
  mutable Part moving_, sleeping_, fixed_;
};

}  // namespace psim
