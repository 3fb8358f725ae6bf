// Columns: bodies that stand on each other one by one. A sweep brings a load down one contact at a
// time, so a tall stack or a heavy body on light ones sags and drifts; a column's contacts can be
// solved together, exactly, in a time proportional to their number.
//
// A link is a contact that carries: |n.up| >= 1/2, touching. Upper body: one support below, at most one
// above, side contacts that carry next to nothing. Lower body: fixed, or this one support above. A
// column is a run of links down to the first body that does not qualify; it counts if it is long and
// at rest or has a large mass ratio (docs/decisions/007-manifolds.md has what was measured).
//
// In: manifolds of the step. In and out: velocities, spins and impulses of the column's lanes.
#pragma once

#include <cstdint>
#include <vector>

#include "body_store.h"
#include "manifolds.h"
#include "views.h"
#include "worker_pool.h"

namespace psim {

class Columns {
 public:
  /// Finds the columns among the pairs as they are now, and tells the pairs (ManifoldPair::column)
  /// before they are laid out. O(pairs).
  void find(const BodyStore& bodies, Manifolds& manifolds, const ManifoldParams& params,
            const PairTable& table, WorkerPool& pool);
  void forget() {
    columns_.clear();
    links_.clear();
  }
  /// Nobody can stand on another any more: the memory is given back.
  void release() {
    std::vector<Column>().swap(columns_);
    std::vector<Link>().swap(links_);
    std::vector<Link>().swap(run_);
    std::vector<Standing>().swap(standing_);
  }
  bool any() const { return !columns_.empty(); }
  std::size_t link_count() const { return columns_.empty() ? 0 : links_.size(); }

  /// each(walk): for every column; walk(visit) calls visit(pair) for its contacts, from the bottom.
  template <class Each>
  void each_column(const Each& each) const {
    for (const Column& c : columns_) {
      each([&](const auto& visit) {
        for (std::uint32_t k = c.first; k < c.first + c.count; ++k) visit(links_[k].pair);
      });
    }
  }

  /// Looks up where the pairs were laid out.
  void place(const Manifolds& manifolds);

  /// One direct solve of every column: softly with the overlaps pushed out (`soft`), or rigid.
  void solve(const kernels::BodyView& bodies, Manifolds& manifolds, const kernels::ContactParams& p,
             double gravity, bool soft, WorkerPool& pool);

  std::size_t bytes() const {
    return (links_.capacity() + run_.capacity()) * sizeof(Link) + columns_.capacity() * sizeof(Column) +
           standing_.capacity() * sizeof(Standing);
  }

 private:
  static constexpr std::uint32_t kNone = ManifoldPair::kNone;

  // What a body stands on and carries.
  struct Standing {
    std::uint32_t below = 0, above = 0;  // contacts
    std::uint32_t on = kNone;            // the pair that is its support
    float support = 0, side = 0;         // impulses
    bool link = false;                   // it is the upper body of a link
    bool carries = false;                // it is the lower one of another
  };
  // L D L^T of a symmetric S scaled to a unit diagonal.
  struct Factor {
    double l10 = 0, l20 = 0, l21 = 0, d[3] = {}, scale[3] = {};
  };
  // A link with those above eliminated, of the rows that were active. It stays as it is while they do.
  struct Reduced {
    unsigned rows = 0xFF;    // 1, 2, 4: active; 8, 16: with compliance. None yet
    Factor factor;           // of the block
    double m[3][3] = {};     // its inverse times the coupling with the link below
  };
  // A 3 x 3 problem: two normals and one friction row.
  struct Link {
    std::uint32_t pair = 0, strip = 0, lane = 0;
    bool b_above = false;  // B stands on A
    double closed = 0;     // m: gap that a solve may close
    // Of the step.
    double dx[3] = {}, dy[3] = {};     // direction of each row, of the upper body
    double up[3] = {}, low[3] = {};    // turning of the upper and the lower body
    double wu = 0, gu = 0, wl = 0, gl = 0;  // inverse mass and R^2 / I of the two
    double an = 0, bn = 0;                  // arm of the friction row
    double a[3][3] = {}, soft[2] = {};      // own block; compliance of the normals
    double full[3][3] = {};                 // coupling with the link below
    Reduced reduced[2];                     // rigid, soft
    // Of a solve.
    unsigned rows = 0;  // as in Reduced
    double r[3] = {}, right[3] = {}, d[3] = {};
    bool active(int row) const { return (rows >> row & 1u) != 0; }
    double compliance(int row) const { return row < 2 && (rows >> (3 + row) & 1u) != 0 ? soft[row] : 0; }
    double coupling(int row, int below, const Link& under) const {
      return active(row) && under.active(below) ? full[row][below] : 0;
    }
  };
  struct Column {
    std::uint32_t first = 0, count = 0;  // links, from the bottom
    bool read = false;                   // what is of the step
  };

  void add_column(const BodyStore& bodies, Manifolds& manifolds, std::size_t begin, std::size_t end);
  static Factor factor_of(const double s[3][3]);
  template <int N>
  static void solve(const Factor& factor, double (&x)[3][N]);
  static void read_step(Manifolds& manifolds, Link& link);
  static void couple(Link& link, const Link& under);
  static void reduce(Link* links, std::uint32_t count, bool soft);
  void solve_one(const kernels::BodyView& bodies, Manifolds& manifolds,
                 const kernels::ContactParams& p, double gravity, bool soft, Column& column);
  static void apply(const kernels::BodyView& bodies, Manifolds& manifolds, const Link& link,
                    double step);
  static void read(const kernels::BodyView& bodies, Manifolds& manifolds, const kernels::ContactParams& p,
                   double gravity, bool soft, Link& link);

  std::vector<Standing> standing_;  // by slot
  std::vector<Link> run_;           // of bodies that stand on each other, from the bottom
  std::vector<Link> links_;
  std::vector<Column> columns_;
};

}  // namespace psim
