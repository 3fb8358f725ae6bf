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
#include "base/worker_pool.h"
#include "bodies/body_store.h"
#include "bodies/static_shapes.h"
#include "kernel_table.h"
#include "lists/grid_sort.h"
#include "lists/large_cells.h"
#include "lists/pair_table.h"

namespace psim {

/// What the broad phase must know of the world.
struct BroadPhaseParams {
  kernels::ReachParams margin;
  float ahead = 0;      ///< s: the search uses the positions that bodies will have after this time
  double outer = 0;     ///< m: a typical distance of candidates; 0: the value of the last build
  bool sample = false;  ///< measure how many candidates a body is compared with
  double growth = 1;    ///< expected number of candidates over that of the last build
  bool walls = false;
  bool periodic = false;
  bool mixed_radii = false;
  bool link_all = false;  ///< every body takes substeps (fields)
  Bounds bounds;          ///< relative to the lattice centre, m
};

class BroadPhase {
 public:
  /// For saved states; behind the bodies. `cells`: bodies lie in cells that are laid.
  template <class A>
  void describe(A& a, const BodyStore& bodies, bool periodic, bool cells);

  /// Below this number of bodies, building lists is so cheap that they need not last.
  static constexpr std::uint32_t kSmallWorld = 512;
  /// Number of large bodies whose search is one piece.
  static constexpr std::uint32_t kLargePiece = 16;
  /// Number of bodies whose search for fixed shapes is one piece.
  static constexpr std::uint32_t kNearPiece = 32;

  BroadPhase(MemoryMeter& meter, const Lattice& lattice)
      : sort_(meter), large_cells_(meter), picked_owner_(meter), picked_other_(meter), lattice_(&lattice) {}

  /// True if the lists can serve `time` seconds more.
  bool lists_serve(BodyStore& bodies, float time, const kernels::KernelTable& k, WorkerPool& pool);

  /// Sorts the bodies and fills `table`. `from()` then maps slots to the slots before.
  void build(BodyStore& bodies, StaticShapes& statics, const BroadPhaseParams& params, const kernels::KernelTable& k,
             WorkerPool& pool, PairTable& table);

  /// The lists of the last build once more, from `built` and `reach` as they were then and bodies in the
  /// order that it left: after a saved state came back.
  void build_again(BodyStore& bodies, StaticShapes& statics, const kernels::KernelTable& k, WorkerPool& pool,
                   PairTable& table);
  /// The same up to a part of a build that was under way: count(); move(), with the searches still to do.
  void count_again(const BodyStore& bodies, const kernels::KernelTable& k, WorkerPool& pool);
  void move_again(BodyStore& bodies, const kernels::KernelTable& k, WorkerPool& pool, PairTable& table);

  /// build() in parts, for a step that is spread over frames. The parts in order:
  ///   measure    how far each body reaches
  ///   count      the cell of each body
  ///   move       bodies to their cells, in moves() pieces; the columns change with the last piece
  ///   search     candidate pairs; searches() grows when a search ran out of room, until all are done
  ///   find_near  bodies near fixed shapes, and which bodies are linked, in nears() pieces
  /// Pieces run in ascending ranges [begin, end). Afterwards `built` holds the places of the bodies.
  void measure(BodyStore& bodies, StaticShapes& statics, const BroadPhaseParams& params, const kernels::KernelTable& k,
               WorkerPool& pool);
  void count(const BodyStore& bodies, const kernels::KernelTable& k, WorkerPool& pool);
  std::size_t moves() const { return listed_ ? 1 : sort_.moves(); }
  void move(BodyStore& bodies, const kernels::KernelTable& k, WorkerPool& pool, PairTable& table, std::size_t begin,
            std::size_t end);
  void search(const BodyStore& bodies, const kernels::KernelTable& k, WorkerPool& pool, PairTable& table,
              std::size_t begin, std::size_t end);
  void find_near(BodyStore& bodies, const StaticShapes& statics, WorkerPool& pool, PairTable& table, std::size_t begin,
                 std::size_t end);
  /// A piece of find_near(): a strip, or some of its bodies if each one must query the fixed shapes.
  std::size_t nears() const { return near_pieces_.size(); }
  struct Near {
    std::uint32_t strip = 0, begin = 0, end = 0;  // bodies
    bool first = true, last = true;               // whether it is the strip's first, last piece
  };
  const Near& near_at(std::size_t piece) const { return near_pieces_[piece]; }
  /// Expected number of fixed shapes near a body of a strip.
  double expected_near(std::size_t strip) const;
  void finish(BodyStore& bodies, const kernels::KernelTable& k, WorkerPool& pool) const;
  std::size_t searches() const { return searched_ + pending_.size(); }
  /// Expected work of a search: the number of bodies (of a strip, or some of the large ones), the pairs that each
  /// will have, and for large bodies the number of other large bodies that each is compared with.
  struct Search {
    double bodies = 0, pairs = 0;
    bool large = false;
    double others = 0;
  };
  Search search_at(std::size_t search, const PairTable& table) const;

  /// Whether only cells that hold bodies exist.
  bool lists_cells() const { return listed_; }
  /// Number of cells of the grid.
  std::uint64_t cell_count() const { return listed_ ? 0 : grid_.keys; }
  /// Number of pairs of a body and a fixed shape or wall at the last build.
  std::size_t near_pairs() const { return near_pairs_; }

  /// Makes room for `pairs` candidate pairs, for the cells of `bodies` bodies, and for moving `all` slots.
  void spare(std::size_t bodies, std::size_t all, std::size_t pairs) {
    picked_owner_.reserve(pairs);
    picked_other_.reserve(pairs);
    sort_.spare(bodies, all);
  }

  /// By slot: the slot that the body had before the last sort.
  const std::uint32_t* from() const { return sort_.from(); }
  /// By slot: the slot that the body had when contacts were last laid out.
  const std::uint32_t* origin() const { return chained_ ? origin_.data() : sort_.from(); }
  void copy_origin(std::vector<std::uint32_t>& to) const {
    if (chained_) {
      to = origin_;
    } else {
      to.assign(from(), from() + sorted_);
    }
  }
  /// An empty `origin` says that bodies lie in the order by which contacts were laid out.
  void set_origin(const std::vector<std::uint32_t>& origin) {
    origin_ = origin;
    chained_ = !origin.empty();
  }
  bool has_moved_on() const { return chained_; }  ///< bodies were sorted again since contacts were laid out
  /// Call when the lists of the last sort are thrown away before contacts were laid out by them.
  void keep_origin();
  /// Call when contacts were laid out by the lists of the last sort.
  void forget_origin() { chained_ = false; }
  /// Counts the lanes of the search that made the lists, and the candidates in them, for every 64th body. Adds
  /// nothing where cells are listed.
  void sample_lanes(const BodyStore& bodies, std::uint32_t large_begin, std::uint64_t& lanes,
                    std::uint64_t& used) const;
  GridSort& sorter() { return sort_; }
  const GridSort& sorter() const { return sort_; }
  /// Area of the bodies at the last build, m^2: their box, or, where cells are listed, the area that they would
  /// fill at the density around them. 0 before the first build.
  double area() const { return area_; }
  /// The same, also before the first build: then `bounds`, m^2, or in a far larger world an estimate from the
  /// neighbourhood of some bodies of mean radius `radius`.
  double area_about(const BodyStore& bodies, double radius, double bounds) const;
  /// Number of cells of the last build.
  std::size_t cells() const { return listed_ ? sort_.listed().size() : std::size_t{grid_.keys}; }
  bool listed() const { return listed_; }
  /// Mean number of bodies that a body is compared with.
  double tests() const;

  /// Whether the bodies' box is wider than high, at the last build.
  bool wide() const {
    const auto way = [&](int axis) { return static_cast<double>(all_.extent[axis + 2]) - all_.extent[axis]; };
    return way(0) * lattice_->pitch_x() > way(1) * lattice_->pitch_y();
  }
  /// The margin of the last build.
  const kernels::ReachParams& margin() const { return params_.margin; }
  const Lattice& lattice() const { return *lattice_; }
  /// Appends the bodies within reach of a body at `built`, from the cells of the last build and from the large
  /// bodies; the body itself may be among them. False if the list is full.
  bool around(const BodyStore& bodies, const kernels::KernelTable& k, std::uint32_t body, std::uint32_t large_begin,
              kernels::PairList& list) const;
  /// Appends the walls and fixed shapes within a body's reach to `out`.
  void near_body(const BodyStore& bodies, const StaticShapes& statics, std::uint32_t body,
                 std::vector<std::uint32_t>& found, std::vector<StaticPair>& out) const;

  /// Mean number of bodies per square metre around a body at the last build; 0 before the first.
  double density() const { return density_; }

  /// Selects from the candidates of strips [begin, end) the pairs that can meet within `time` at their present
  /// relative velocity u: gap < |u| time + slack of the strip. Fills `table` and sets bodies.linked. O(candidates).
  void select(BodyStore& bodies, float time, const std::vector<float>& slack, bool link_all,
              const PairTable& candidates, PairTable& table, const kernels::KernelTable& k, WorkerPool& pool,
              std::size_t begin, std::size_t end);
  /// Packs the selected pairs side by side, after all strips were selected.
  void pack(BodyStore& bodies, const PairTable& candidates, PairTable& table, WorkerPool& pool, std::size_t begin,
            std::size_t end);

 private:
  static constexpr double kMostGuess = 1e9;  // pairs of a body

  bool grid_fits(const BodyStore& bodies, bool periodic) const;
  double choose_reach(const BodyStore& bodies, double most, double area) const;
  void set_reach(double reach, float most);
  double least_edge(double reach) const;
  void choose_grid(const BodyStore& bodies, const BroadPhaseParams& p, const std::int32_t extent[4], float most);
  bool choose_cells(const BodyStore& bodies, const BroadPhaseParams& p, const std::int32_t extent[4], float most,
                    double density);
  double waste(const BodyStore& bodies, float most, double density) const;
  void cut_strips(const BodyStore& bodies, PairTable& table) const;
  void cut_rows(std::uint32_t target, PairTable& table) const;
  void cut_listed_rows(std::uint32_t target, PairTable& table) const;
  bool search_strip(const BodyStore& bodies, const kernels::KernelTable& k, std::size_t strip, PairTable& table) const;
  bool search_rows(const BodyStore& bodies, const kernels::KernelTable& k, const Strip& s,
                   kernels::PairList& list) const;
  bool search_listed(const BodyStore& bodies, const kernels::KernelTable& k, const Strip& s,
                     kernels::PairList& list) const;
  bool search_seam(const BodyStore& bodies, const kernels::KernelTable& k, std::uint32_t cell,
                   kernels::PairList& list) const;
  bool search_large(const BodyStore& bodies, const kernels::KernelTable& k, std::size_t piece, PairTable& table);
  void join_large(PairTable& table);
  bool search_box(const BodyStore& bodies, const kernels::KernelTable& k, std::uint32_t body,
                  kernels::PairList& list) const;
  bool search_listed_box(const BodyStore& bodies, const kernels::KernelTable& k, std::uint32_t body,
                         kernels::PairList& list) const;
  void place(BodyStore& bodies, float ahead, const kernels::KernelTable& k, BlockRange blocks) const;
  double sample_density(std::uint32_t bodies) const;
  void find_lists(BodyStore& bodies, const StaticShapes& statics, const kernels::KernelTable& k, WorkerPool& pool,
                  PairTable& table);
  double expected_pairs(std::size_t strip) const;
  double expected_of_large(std::size_t piece) const;
  void cut_large(const PairTable& table);
  void give_room(PairTable& table);
  void give_more_room(PairTable& table);
  void open_lists(BodyStore& bodies, WorkerPool& pool, PairTable& table, bool again);
  void note_pairs(const PairTable& table);
  void link(BodyStore& bodies, const PairTable& table, std::size_t strip) const;
  void cut_near(const PairTable& table);
  double common_way() const;
  bool nothing_near(const BodyStore& bodies, const StaticShapes& statics, const Near& piece) const;
  void find_statics(const BodyStore& bodies, const StaticShapes& statics, const Near& piece, PairTable& table) const;
  kernels::PairRow view(const BodyStore& bodies) const;
  kernels::PairRow row_view(const BodyStore& bodies, std::uint32_t row) const;

  struct LargePiece {  // some of the large bodies, and their pairs or the room for their pairs
    std::uint32_t body_begin = 0, body_end = 0, pair_begin = 0, pair_end = 0;
  };
  template <class Each>
  void each_pending(PairTable& table, const Each& each);

  struct alignas(64) Measure {  // longest reach and box of one task's bodies
    float most = 0;
    std::int32_t extent[4] = {};
  };

  GridSort sort_;
  LargeCells large_cells_;                    // cells of the bodies that are not in the grid, if there are many
  float pad_reach_ = 0, next_pad_reach_ = 0;  // m: reach of the padding slots, in these lists and in the next
  std::vector<Measure> measures_;
  Measure all_;
  Column<std::uint32_t> picked_owner_, picked_other_;  // selected pairs, before they are packed
  const Lattice* lattice_;
  Grid grid_;
  bool listed_ = false;  // the cells are those of sort_.listed(), not of grid_
  float large_ = 1e30f;  // m: a body with a longer reach is not in the grid
  float most_ = 0;       // m: largest reach in the grid
  double box_ = 0;       // m^2: area of the box around all bodies
  double area_ = 0, density_ = 0;
  std::vector<double> pairs_a_body_;   // by strip: pairs a body at the last build
  double pairs_a_large_ = 64;          // on average
  std::vector<double> pairs_a_piece_;  // by piece of the large bodies: pairs a body
  BroadPhaseParams params_;            // the parameters of the present build
  std::size_t near_pairs_ = 0;
  double tests_ = 0;          // comparisons a body, in a grid; 0: not known
  std::uint32_t sorted_ = 0;  // number of bodies after the last sort
  // After lists were thrown away: the slots that bodies had when contacts were last laid out, and scratch.
  std::vector<std::uint32_t> origin_, next_origin_;
  bool chained_ = false;             // origin_ holds
  std::vector<double> near_a_body_;  // by strip: fixed shapes near a body at the last build
  bool fixed_ = false;               // whether there are fixed shapes
  std::vector<Near> near_pieces_;
  std::vector<LargePiece> large_pieces_;
  std::vector<std::uint32_t> pending_;  // what is still to be searched: strips, then pieces of the large bodies
  std::size_t searched_ = 0;            // number of searches before those
  std::vector<std::uint8_t> full_;      // by strip and piece: its room was too small
  bool scattered_ = false;              // the rooms of the large bodies' pieces do not lie side by side
};

}  // namespace psim
