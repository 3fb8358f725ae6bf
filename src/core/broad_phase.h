// Broad phase: which bodies may touch before the lists are made again.
//
// Lists are made with a margin of skin + |v| time around every body and serve until some body has
// used its margin up. Lists for a single step look at the bodies where they will be in its middle,
// with v against the mean velocity: bodies that fly side by side need little margin.
// Cells are a grid over the bodies' box, or, where so many of those would be empty that they would have
// to be far too wide, a list of those that bodies lie in (cell_list.h).
// In: positions, velocities, radii. Out: bodies in cell order, a PairTable of candidate pairs (each
// once) and of bodies near fixed shapes. O(bodies + candidates).
#pragma once

#include <cstdint>
#include <vector>

#include "body_store.h"
#include "grid_sort.h"
#include "kernel_table.h"
#include "large_cells.h"
#include "pair_table.h"
#include "static_shapes.h"
#include "tasks.h"
#include "worker_pool.h"

namespace psim {

/// What the broad phase must know of the world.
struct BroadPhaseParams {
  kernels::ReachParams margin;
  float ahead = 0;   ///< s: bodies are looked at where they will be by then
  double outer = 0;  ///< m: a typical distance of candidates; 0: as at the last build
  bool sample = false;   ///< find out how many bodies each is looked at with
  double growth = 1; ///< of candidates since the last build, at a guess
  bool walls = false;
  bool periodic = false;
  bool mixed_radii = false;
  bool link_all = false;  ///< every body takes substeps (fields)
  Bounds bounds;          ///< relative to the lattice centre, m
};

class BroadPhase {
  friend struct Image;

 public:
  /// Bodies of which lists are too cheap to make them last.
  static constexpr std::uint32_t kSmallWorld = 512;
  /// Large bodies that are searched for in one piece.
  static constexpr std::uint32_t kLargePiece = 16;
  /// Bodies that are looked for near fixed shapes in one piece.
  static constexpr std::uint32_t kNearPiece = 32;

  BroadPhase(MemoryMeter& meter, const Lattice& lattice)
      : sort_(meter), large_cells_(meter), picked_owner_(meter), picked_other_(meter), lattice_(&lattice) {}

  /// True if the lists can serve a step of `time` seconds more.
  bool lists_serve(BodyStore& bodies, float time, const kernels::KernelTable& k, WorkerPool& pool);

  /// Sorts the bodies and fills `table`. `from()` then maps slots to the slots before.
  void build(BodyStore& bodies, StaticShapes& shapes, const BroadPhaseParams& params,
             const kernels::KernelTable& k, WorkerPool& pool, PairTable& table);

  /// The lists of the last build once more, from `built` and `reach` as they were then and bodies in the
  /// order that it left: after a saved state came back.
  void build_again(BodyStore& bodies, StaticShapes& shapes, const kernels::KernelTable& k,
                   WorkerPool& pool, PairTable& table);
  /// The same up to a part of a build that was under way: count(); move(), with the searches still to do.
  void count_again(const BodyStore& bodies, const kernels::KernelTable& k, WorkerPool& pool);
  void move_again(BodyStore& bodies, const kernels::KernelTable& k, WorkerPool& pool,
                  PairTable& table);

  /// build() in parts, for a step spread over frames: how far bodies reach, their cells, bodies to their cells
  /// in moves() moves, which show with the last; then the searches for pairs [begin, end), as many as
  /// searches() says once those that it said before are done; then, in nears() pieces, bodies near fixed
  /// shapes and who is linked; then `built` is where the bodies are now. Ranges are done in order.
  void measure(BodyStore& bodies, StaticShapes& shapes, const BroadPhaseParams& params,
               const kernels::KernelTable& k, WorkerPool& pool);
  void count(const BodyStore& bodies, const kernels::KernelTable& k, WorkerPool& pool);
  std::size_t moves() const { return listed_ ? 1 : sort_.moves(); }
  void move(BodyStore& bodies, const kernels::KernelTable& k, WorkerPool& pool, PairTable& table,
            std::size_t begin, std::size_t end);
  void search(const BodyStore& bodies, const kernels::KernelTable& k, WorkerPool& pool,
              PairTable& table, std::size_t begin, std::size_t end);
  void find_near(BodyStore& bodies, const StaticShapes& shapes, WorkerPool& pool, PairTable& table,
                 std::size_t begin, std::size_t end);
  /// A piece of that: a strip, or some of its bodies where each asks for the fixed shapes near it.
  std::size_t nears() const { return near_pieces_.size(); }
  struct Near {
    std::uint32_t strip = 0, begin = 0, end = 0;  // bodies
    bool first = true, last = true;               // of the strip's
  };
  const Near& near_at(std::size_t piece) const { return near_pieces_[piece]; }
  /// Fixed shapes near a body of a strip, at a guess.
  double expected_near(std::size_t strip) const;
  void finish(BodyStore& bodies, const kernels::KernelTable& k, WorkerPool& pool) const;
  std::size_t searches() const { return searched_ + pending_.size(); }
  /// What a search goes through, at a guess: bodies of a strip or some of the large ones, the pairs that each will
  /// have, and how many large bodies each of those is looked at with.
  struct Search {
    double bodies = 0, pairs = 0;
    bool large = false;
    double others = 0;
  };
  Search search_at(std::size_t search, const PairTable& table) const;

  /// Whether there are no cells but those that bodies lie in.
  bool lists_cells() const { return listed_; }
  /// Of the grid.
  std::uint64_t cell_count() const { return listed_ ? 0 : grid_.keys; }
  /// Bodies near fixed shapes, and walls: pairs, in all, at the last build.
  std::size_t near_pairs() const { return near_pairs_; }

  /// Makes room for so many candidate pairs that are selected from, for cells, and for moving bodies.
  void spare(std::size_t bodies, std::size_t all, std::size_t pairs) {
    picked_owner_.reserve(pairs);
    picked_other_.reserve(pairs);
    sort_.spare(bodies, all);
  }

  /// Of the last sort.
  const std::uint32_t* from() const { return sort_.from(); }
  /// Maps slots to those that they were when contacts were last laid out.
  const std::uint32_t* origin() const { return chained_ ? origin_.data() : sort_.from(); }
  void copy_origin(std::vector<std::uint32_t>& to) const {
    if (chained_) {
      to = origin_;
    } else {
      to.assign(from(), from() + sorted_);
    }
  }
  /// None: bodies lie as contacts were laid out by.
  void set_origin(const std::vector<std::uint32_t>& origin) {
    origin_ = origin;
    chained_ = !origin.empty();
  }
  bool has_moved_on() const { return chained_; }  ///< bodies do not lie as contacts were laid out by
  /// The last sort's lists are thrown away before contacts were laid out by them.
  void keep_origin();
  /// Contacts are laid out by the last sort's lists.
  void forget_origin() { chained_ = false; }
  /// Lanes of the search that made the lists, and candidates in them: of every 64th body. Nothing where cells are
  /// listed.
  void sample_lanes(const BodyStore& bodies, std::uint32_t large_begin, std::uint64_t& lanes, std::uint64_t& used) const;
  GridSort& sorter() { return sort_; }
  const GridSort& sorter() const { return sort_; }
  /// Area that the bodies lie in at the last build, m^2: their box, or, where cells are listed, as much
  /// as they would fill at the density around them; 0 before the first.
  double area() const { return area_; }
  /// The same before the first build too: then `bounds`, m^2, or in far larger worlds what some bodies
  /// of mean radius `radius` see around them.
  double area_about(const BodyStore& bodies, double radius, double bounds) const;
  /// Cells of the last build.
  std::size_t cells() const {
    return listed_ ? sort_.listed().size() : std::size_t{grid_.keys};
  }
  bool listed() const { return listed_; }
  /// Bodies that one is looked at with, about.
  double tests() const;

  /// Whether the bodies' box is wider than high, at the last build.
  bool wide() const {
    const auto way = [&](int axis) { return static_cast<double>(all_.extent[axis + 2]) - all_.extent[axis]; };
    return way(0) * lattice_->pitch_x() > way(1) * lattice_->pitch_y();
  }
  /// Of the last build.
  const kernels::ReachParams& margin() const { return params_.margin; }
  const Lattice& lattice() const { return *lattice_; }
  /// Bodies that lie in the cells of the last build or are large, within reach of a body at `built`; perhaps itself.
  /// False if the list is full.
  bool around(const BodyStore& bodies, const kernels::KernelTable& k, std::uint32_t body, std::uint32_t large_begin,
              kernels::PairList& list) const;
  /// Walls and fixed shapes within a body's reach, appended to `out`.
  void near_body(const BodyStore& bodies, const StaticShapes& shapes, std::uint32_t body,
                 std::vector<std::uint32_t>& found, std::vector<SinglePair>& out) const;

  /// Bodies a square metre around a body, on average over bodies, at the last build; 0 before the
  /// first.
  double density() const { return density_; }

  /// Of the candidates, the pairs that can meet within `time` at their present relative speed:
  /// gap < |u| time + slack of the strip, of strips [begin, end). Fills `table` alike and sets bodies.linked.
  /// O(candidates).
  void select(BodyStore& bodies, float time, const std::vector<float>& slack, bool link_all,
              const PairTable& candidates, PairTable& table, const kernels::KernelTable& k,
              WorkerPool& pool, std::size_t begin, std::size_t end);
  /// Closes up what was selected, once all is.
  void pack(BodyStore& bodies, const PairTable& candidates, PairTable& table, WorkerPool& pool,
            std::size_t begin, std::size_t end);

 private:
  double choose_reach(const BodyStore& bodies, double most, double area) const;
  void set_reach(double reach, float most);
  double least_edge(double reach) const;
  void choose_grid(const BodyStore& bodies, const BroadPhaseParams& p, const std::int32_t extent[4],
                   float most);
  bool choose_cells(const BodyStore& bodies, const BroadPhaseParams& p,
                    const std::int32_t extent[4], float most, double density);
  double waste(const BodyStore& bodies, float most, double density) const;
  void cut_strips(const BodyStore& bodies, PairTable& table) const;
  void cut_rows(std::uint32_t target, PairTable& table) const;
  void cut_listed_rows(std::uint32_t target, PairTable& table) const;
  bool search_strip(const BodyStore& bodies, const kernels::KernelTable& k, std::size_t strip,
                    PairTable& table) const;
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
  bool search_listed_box(const BodyStore& bodies, const kernels::KernelTable& k,
                         std::uint32_t body, kernels::PairList& list) const;
  void place(BodyStore& bodies, float ahead, const kernels::KernelTable& k,
             BlockRange blocks) const;
  double sample_density(std::uint32_t bodies) const;
  void find_lists(BodyStore& bodies, const StaticShapes& shapes, const kernels::KernelTable& k,
                  WorkerPool& pool, PairTable& table);
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
  bool nothing_near(const BodyStore& bodies, const StaticShapes& shapes, const Near& piece) const;
  void find_singles(const BodyStore& bodies, const StaticShapes& shapes, const Near& piece, PairTable& table) const;
  kernels::PairRow view(const BodyStore& bodies) const;
  kernels::PairRow row_view(const BodyStore& bodies, std::uint32_t row) const;

  struct LargePiece {  // some of the large bodies, and their pairs or the room for them
    std::uint32_t body_begin = 0, body_end = 0, pair_begin = 0, pair_end = 0;
  };
  template <class Each>
  void each_pending(PairTable& table, const Each& each);

  struct alignas(64) Measure {  // of one task's bodies
    float most = 0;
    std::int32_t extent[4] = {};
  };

  GridSort sort_;
  LargeCells large_cells_;  // of bodies that are not in the grid, if there are many
  float pad_reach_ = 0, next_pad_reach_ = 0;  // m: of padding beyond the bodies, in these lists and the next
  std::vector<Measure> measures_;
  Measure all_;
  Column<std::uint32_t> picked_owner_, picked_other_;  // selected pairs, before they are packed
  const Lattice* lattice_;
  Grid grid_;
  bool listed_ = false;  // cells are those of sort_.listed(), not of grid_
  float large_ = 1e30f;  // m: reach above which a body is not in the grid
  float most_ = 0;       // m: largest reach in the grid
  double box_ = 0;       // m^2, of all bodies
  double area_ = 0, density_ = 0;
  std::vector<double> pairs_a_body_;  // of each strip at the last build
  double pairs_a_large_ = 64;         // on average
  std::vector<double> pairs_a_piece_; // of a body in each piece of the large ones
  BroadPhaseParams params_;             // of the present build
  std::size_t near_pairs_ = 0;
  double tests_ = 0;                    // in a grid; 0: not known
  std::uint32_t sorted_ = 0;            // bodies that the last sort left
  // Once lists were thrown away: where those bodies lay when contacts were last laid out, and room to chain.
  std::vector<std::uint32_t> origin_, next_origin_;
  bool chained_ = false;                // origin_ holds
  std::vector<double> near_a_body_;   // fixed shapes near a body, of each strip at the last build
  bool fixed_ = false;                // there are fixed shapes
  std::vector<Near> near_pieces_;
  std::vector<LargePiece> large_pieces_;
  std::vector<std::uint32_t> pending_;  // to be searched: strips in the grid, behind them pieces of the large bodies
  std::size_t searched_ = 0;            // searches before those
  std::vector<std::uint8_t> full_;      // whose room was too small
  bool scattered_ = false;              // pieces of the large bodies do not have their rooms side by side
};

}  // namespace psim
