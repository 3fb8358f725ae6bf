// Broad phase: finds which bodies may touch before the lists are made again.
//
// Every body gets a margin of skin + |v| time. The lists serve until some body has used up its margin.
// Lists for a single step look at the bodies where they will be in the middle of the step, and measure v
// against the mean velocity: bodies that fly side by side need little margin.
// Bodies are sorted into a grid over their box. Where most cells of a grid would be empty, they are sorted
// into a list of the cells that hold bodies (cell_list.h).
// In: positions, velocities, radii. Out: bodies in cell order, a PairTable of candidate pairs (each
// once) and of bodies near fixed shapes. O(bodies + candidates).
#pragma once

#include <cstdint>
#include <vector>

#include "base/tasks.h"
#include "lists/broad_cells.h"
#include "lists/broad_near.h"
#include "lists/broad_search.h"
#include "lists/common_motion.h"
#include "lists/pair_table.h"
#include "lists/slot_origin.h"

namespace psim {

class BroadPhase {
 public:
  /// For saved states; behind the bodies. `cells`: bodies lie in cells that are laid.
  void describe(class Archive& a, bool periodic, bool cells);

  /// Below this number of bodies, building lists is so cheap that they need not last.
  static constexpr std::uint32_t kSmallWorld = 512;

  explicit BroadPhase(const Surroundings& s) : s_(s) {}

  /// Returns a function that tells how far, m, some body of blocks [begin, end) would go beyond its margin within `time`
  /// seconds more; 0 or less: none does. Padding slots are asked, too.
  auto beyond_margins(float time) const {
    kernels::StreamParams p;
    p.pitch_x = static_cast<float>(s_.lattice.pitch_x());
    p.pitch_y = static_cast<float>(s_.lattice.pitch_y());
    return [=, &b = s_.bodies, &k = s_.kernels, view = s_.bodies.view()](std::uint32_t begin, std::uint32_t end) {
      return k.list_age(view, b.built.data(), b.radius.data(), b.reach.data(), p, time, begin, end);
    };
  }
  /// True if the lists can serve `time` seconds more.
  bool lists_serve(float time) const;

  /// New lists, in parts, since a step may be spread over frames. The parts in order:
  ///   measure    how far each body reaches
  ///   count      the cell of each body
  ///   move       bodies to their cells, in cells().moves() pieces; the columns change with the last piece
  ///   search     candidate pairs; pairs().searches() grows when a search ran out of room, until all are done
  ///   find_near  bodies near fixed shapes and, if it `links`, which bodies are linked (a selection finds that out
  ///              itself), in near().pieces() pieces
  ///   finish     `built` holds the places of the bodies from now on
  /// Pieces run in ascending ranges [begin, end). They fill `table`; cells().from() maps slots to the slots before.
  void measure(const BroadPhaseParams& params);
  void count() { cells_.count(params_); }
  void move(std::size_t begin, std::size_t end);  ///< from the end of the last piece on, bodies lie in the new order
  void open(PairTable& table);
  void search(PairTable& table, std::size_t begin, std::size_t end);
  void find_near(PairTable& table, bool links, std::size_t begin, std::size_t end);
  void finish() const;
  /// search() and find_near() to their ends.
  void find_lists(PairTable& table);

  /// The lists of the last build once more, from `built` and `reach` as they were then and bodies in the
  /// order that it left: after a saved state came back.
  void build_again(PairTable& table);
  /// The same up to a part of a build that was under way: count(); move(), with the searches still to do.
  void count_again() { cells_.count_again(); }
  void move_again(PairTable& table);

  const BroadCells& cells() const { return cells_; }
  const PairSearch& pairs() const { return search_; }
  const NearSearch& near() const { return near_; }
  BodyMover& mover() { return cells_.mover(); }
  /// The margin of the last build.
  const kernels::ReachParams& margin() const { return params_.margin; }
  /// s: it used the places that bodies would have after this time.
  float ahead() const { return params_.ahead; }

  /// Makes room for the cells of `bodies` bodies, and for moving `all` slots.
  void spare(std::size_t bodies, std::size_t all) { cells_.spare(bodies, all); }
  /// Begins a table whose strips are cut: each gets a list of contacts with fixed shapes, with room for the usual few so
  /// that warm steps do not allocate, and no body is linked yet, or all are.
  void begin_table(PairTable& table, std::uint32_t bodies, bool link_all) const;

  /// Brings what bodies have in common up to date. False if they move apart too far for the lists.
  bool update_common() {
    return common_.update(s_.bodies.built.data(), {params_.walls, params_.bounds},
                          static_cast<double>(params_.margin.beside));
  }

  CommonMotion& common() { return common_; }
  const CommonMotion& common() const { return common_; }

  SlotOrigin origin{cells_};

 private:
  void place(float ahead, BlockRange blocks) const;
  float reach_beyond_common(BlockRange blocks) const;
  void open_lists(PairTable& table, double pairs_a_body, double growth);

  const Surroundings s_;
  BroadPhaseParams params_;  // of the present build
  CommonMotion common_{s_};
  BroadCells cells_{s_};
  PairSearch search_{s_, cells_};
  NearSearch near_{s_, params_, cells_};
  float pad_reach_ = 0, next_pad_reach_ = 0;  // m: reach of the padding slots, in these lists and in the next
};

}  // namespace psim
