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
#include "bodies/surroundings.h"
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
  void describe(class Archive& a, bool periodic, bool cells);

  /// Below this number of bodies, building lists is so cheap that they need not last.
  static constexpr std::uint32_t kSmallWorld = 512;
  /// Number of large bodies whose search is one piece, and of bodies whose search for fixed shapes is one piece.
  static constexpr std::uint32_t kLargePiece = 16, kNearPiece = 32;

  explicit BroadPhase(const Surroundings& s);

  /// True if the lists can serve `time` seconds more.
  bool lists_serve(float time);

  /// New lists, in parts, since a step may be spread over frames. The parts in order:
  ///   measure    how far each body reaches
  ///   count      the cell of each body
  ///   move       bodies to their cells, in moves() pieces; the columns change with the last piece
  ///   search     candidate pairs; searches() grows when a search ran out of room, until all are done
  ///   find_near  bodies near fixed shapes, and which bodies are linked, in nears() pieces
  ///   finish     `built` holds the places of the bodies from now on
  /// Pieces run in ascending ranges [begin, end). They fill `table`; from() maps slots to the slots before.
  void measure(const BroadPhaseParams& params);
  void count();
  std::size_t moves() const { return listed_ ? 1 : sort_.moves(); }
  void move(PairTable& table, std::size_t begin, std::size_t end);
  void search(PairTable& table, std::size_t begin, std::size_t end);
  void find_near(PairTable& table, std::size_t begin, std::size_t end);
  void finish() const;
  /// search() and find_near() to their ends.
  void find_lists(PairTable& table);
  std::size_t searches() const { return searched_ + pending_.size(); }
  std::size_t nears() const { return near_pieces_.size(); }

  /// The lists of the last build once more, from `built` and `reach` as they were then and bodies in the
  /// order that it left: after a saved state came back.
  void build_again(PairTable& table);
  /// The same up to a part of a build that was under way: count(); move(), with the searches still to do.
  void count_again();
  void move_again(PairTable& table);

  /// A piece of find_near(): a strip, or some of its bodies if each one must query the fixed shapes.
  struct Near {
    std::uint32_t strip = 0, begin = 0, end = 0;  // bodies
    bool first = true, last = true;               // whether it is the strip's first, last piece
  };
  const Near& near_at(std::size_t piece) const { return near_pieces_[piece]; }
  /// Expected number of fixed shapes near a body of a strip.
  double expected_near(std::size_t strip) const;
  /// Expected work of a search: the number of bodies (of a strip, or some of the large ones), the pairs that each
  /// will have, and for large bodies the number of other large bodies that each is compared with.
  struct Search {
    double bodies = 0, pairs = 0;
    bool large = false;
    double others = 0;
  };
  Search search_at(std::size_t search, const PairTable& table) const;

  /// Whether only cells that hold bodies exist.
  bool listed() const { return listed_; }
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
  void keep_origin() {
    if (!chained_) copy_origin(origin_);
    chained_ = true;
  }
  /// Call when contacts were laid out by the lists of the last sort.
  void forget_origin() { chained_ = false; }
  /// Counts the lanes of the search that made the lists, and the candidates in them, for every 64th body. Adds
  /// nothing where cells are listed.
  void sample_lanes(std::uint32_t large_begin, std::uint64_t& lanes, std::uint64_t& used) const;
  GridSort& sorter() { return sort_; }
  const GridSort& sorter() const { return sort_; }
  /// Area of the bodies at the last build, m^2: their box, or, where cells are listed, the area that they would
  /// fill at the density around them. 0 before the first build.
  double area() const { return area_; }
  /// The same, also before the first build: then `bounds`, m^2, or in a far larger world an estimate from the
  /// neighbourhood of some bodies of mean radius `radius`.
  double area_about(double radius, double bounds) const;
  /// Mean number of bodies that a body is compared with.
  double tests() const;
  /// Mean number of bodies per square metre around a body at the last build; 0 before the first.
  double density() const { return density_; }

  /// Whether the bodies' box is wider than high, at the last build.
  bool wide() const {
    const auto way = [&](int axis) { return static_cast<double>(all_.extent[axis + 2]) - all_.extent[axis]; };
    return way(0) * lattice_.pitch_x() > way(1) * lattice_.pitch_y();
  }
  /// The margin of the last build.
  const kernels::ReachParams& margin() const { return params_.margin; }
  const Lattice& lattice() const { return lattice_; }
  /// Appends the bodies within reach of a body at `built`, from the cells of the last build and from the large
  /// bodies; the body itself may be among them. False if the list is full.
  bool around(std::uint32_t body, std::uint32_t large_begin, kernels::PairList& list) const;
  /// Appends the walls and fixed shapes within a body's reach to `out`.
  void near_body(std::uint32_t body, std::vector<std::uint32_t>& found, std::vector<StaticPair>& out) const;

  /// Selects from the candidates of strips [begin, end) the pairs that can meet within `time` at their present
  /// relative velocity u: gap < |u| time + slack of the strip. Fills `table` and sets bodies.linked. O(candidates).
  void select(float time, const std::vector<float>& slack, bool link_all, const PairTable& candidates, PairTable& table,
              std::size_t begin, std::size_t end);
  /// Packs the selected pairs side by side, after all strips were selected.
  void pack(const PairTable& candidates, PairTable& table, std::size_t begin, std::size_t end);

 private:
  static constexpr double kMostGuess = 1e9;  // pairs of a body

  double choose_reach(double area) const;
  void set_reach(double reach);
  double least_edge(double reach) const;
  void choose_grid();
  bool choose_cells(double density);
  double waste(double density) const;
  void cut_strips(PairTable& table) const;
  void cut_rows(std::uint32_t target, PairTable& table) const;
  void cut_listed_rows(std::uint32_t target, PairTable& table) const;
  bool search_strip(std::size_t strip, PairTable& table) const;
  bool search_rows(const Strip& s, kernels::PairList& list) const;
  bool search_listed(const Strip& s, kernels::PairList& list) const;
  bool search_seam(std::uint32_t cell, kernels::PairList& list) const;
  bool search_large(std::size_t piece, PairTable& table);
  void join_large(PairTable& table);
  bool search_box(std::uint32_t body, kernels::PairList& list) const;
  void place(float ahead) const;
  void place(float ahead, BlockRange blocks) const;
  double sample_density(std::uint32_t bodies) const;
  double expected_pairs(std::size_t strip) const;
  double expected_of_large(std::size_t piece) const;
  void give_first_room(PairTable& table);
  void give_more_room(PairTable& table);
  void open_lists(PairTable& table, bool again);
  void link_none_or_all(bool all) const;
  void note_pairs(const PairTable& table);
  void link(const PairTable& table, std::size_t strip) const;
  void cut_near(const PairTable& table);
  double common_way() const;
  bool nothing_near(const Near& piece) const;
  void find_statics(const Near& piece, PairTable& table) const;
  kernels::PairRow view() const;
  kernels::PairRow row_view(std::uint32_t row) const;

  struct LargePiece {  // some of the large bodies, and their pairs or the room for their pairs
    std::uint32_t body_begin = 0, body_end = 0, pair_begin = 0, pair_end = 0;
  };
  template <class Wanted>
  void give_room(PairTable& table, std::uint32_t room, const Wanted& wanted);

  struct alignas(64) Measure {  // longest reach and box of one task's bodies
    float most = 0;
    std::int32_t extent[4] = {};
  };

  const Lattice& lattice_;
  BodyStore& b_;
  StaticShapes& statics_;
  const kernels::KernelTable& k_;
  WorkerPool& pool_;
  GridSort sort_;
  LargeCells large_cells_;                    // cells of the bodies that are not in the grid, if there are many
  float pad_reach_ = 0, next_pad_reach_ = 0;  // m: reach of the padding slots, in these lists and in the next
  std::vector<Measure> measures_;
  Measure all_;
  Column<std::uint32_t> picked_owner_, picked_other_;  // selected pairs, before they are packed
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
