// Light bodies between much heavier ones, or between one of those and fixed ground: rollers under a plate. A sweep over
// single contacts passes a share w_heavy / w_light of a load on, a thousandth, say, and the heavy body sinks meanwhile.
// Here all contacts of a light body with heavy and fixed ones are solved together, as a linear complementarity problem,
// so that the heavy body meets what lies behind the light one; and so on from one light body to the next.
//
//   plate   ---------------------        blocks: the contacts of each disc with the plate and with the ground,
//   discs     (1)  (2)  (3)   | box      those of the plate with the box
//   ground  ==================|=====
//
// In: contacts of the step, with normals and gaps. In and out: velocities, rim speeds and the impulses of lanes.
// Where nobody carries a much heavier body (HeavyLoads), nothing is done, and no memory is taken.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "contacts/contact_store.h"
#include "lists/heavy_loads.h"
#include "manifolds/manifolds.h"
#include "views.h"

namespace psim {

/// A point of contact of a body with a heavier or a fixed one.
struct SqueezedRow {
  std::uint32_t light = 0, other = kNoSlot;  // numbers of the solver; kNoSlot: fixed geometry
  kernels::ManifoldBlock* block = nullptr;   // where it lies; null: in a lane of discs
  std::uint32_t lane = 0;
  std::uint32_t point = 0;
  std::uint32_t order = 0;  // in which it was found
  bool light_b = true;      // the light body is B
  float gap = 0;            // m, at the start of the step
  float offset = 0;         // m: of the gap in the lane (ManifoldPair::offset)
  double wl = 0, wo = 0;    // 1/kg
  double w_heavy = 0;       // 1/kg, of the heavy body whose load it bears
  struct Lane {
    float share_a = 1, share_b = 1, soft = 0, rate = 0;
  };
  Lane was;         // numbers of its lane (ManifoldBlock), which has others meanwhile
  double unit = 1;  // kg where the impulses of the lane are m/s, else 1

  Vec2 along;                     // the direction in which an impulse pushes the light body
  double arm = 0, arm_other = 0;  // of both bodies, as in ManifoldBlock
  double gl = 0, go = 0;          // R^2 / I, 1/kg
  double compliance = 0;          // m/s for each N s, while it overlaps

  // In one solve:
  double bias = 0, softness = 0, impulse = 0;  // m/s; compliance, m/s for each N s; N s
  double push = 0;                             // m/s: how fast overlaps are pushed out
  double start = 0, way = 0;                   // N s: the impulse before a sweep; the direction of the search
  double first = 0, speed = 0;                 // N s: the impulse before; m/s: the parting velocity without impulses
  bool apart = false, active = false;
};

class Squeezed {
 public:
  Squeezed(ContactStore& discs, Manifolds& manifolds, const HeavyLoads& loads)
      : discs_(discs), manifolds_(manifolds), loads_(loads) {}

  /// Finds the squeezed bodies among the contacts of this step, once these have lanes, normals and gaps. O(contacts under
  /// heavy loads + contacts of shapes), or nothing where there are no heavy loads.
  void find(const BodyStore& bodies, const PairTable& table, const kernels::ContactParams& p);
  bool any() const { return !blocks_.empty(); }
  std::size_t row_count() const { return rows_.size(); }
  /// Gives the lanes of shapes their shares and their softness back: in this step the sweeps over single contacts solved
  /// them as the blocks do, without half-reactions and all but rigidly.
  void finish();
  /// Gives the memory back.
  void release() { give_back(found_, rows_, blocks_, light_, heavy_); }
  std::size_t bytes() const { return bytes_of(found_, rows_, blocks_, light_, heavy_); }

  /// Solves all blocks, sweep after sweep: softly, with overlaps pushed out (`soft`), or rigidly. O(rows) a sweep.
  void solve(const kernels::BodyView& view, const kernels::ContactParams& p, bool soft);

 private:
  static constexpr std::uint32_t kMost = 6;  // rows of a block
  struct Block {
    std::uint32_t first = 0, count = 0;  // rows
    double a[kMost][kMost] = {};         // the velocity that an impulse of the second row adds at the first one
  };
  std::span<SqueezedRow> rows_of(const Block& block) { return std::span(rows_).subspan(block.first, block.count); }
  ContactLanes& lanes_of(const SqueezedRow& row) {
    return row.other == kNoSlot ? static_cast<ContactLanes&>(discs_.fixed) : discs_.pairs;
  }

  template <class Wanted>
  void add_discs(const BodyStore& bodies, const PairTable& table, std::size_t strip, const Wanted& wanted);
  template <class Wanted>
  void add_shapes(const BodyStore& bodies, std::size_t strip, const Wanted& wanted);
  template <class Wanted>
  void add_rows(const BodyStore& bodies, const PairTable& table, const Wanted& wanted);
  template <class Take>
  void make_blocks(const Take& take);
  bool is_squeezed(std::span<const SqueezedRow> rows);
  Vec2 along(const SqueezedRow& row);
  void set_lanes(const kernels::ContactParams& p, const Block& block);

  void read_disc(const kernels::BodyView& v, const kernels::ContactParams& p, bool soft, SqueezedRow& row);
  void read_point(const kernels::BodyView& v, const kernels::ContactParams& p, bool soft, SqueezedRow& row);
  void aim(const kernels::ContactParams& p, bool soft, double s, double vn0, double e, SqueezedRow& row);
  void couple(const kernels::ContactParams& p, Block& block);
  double settle(const kernels::BodyView& v, const Block& block);
  static double parting(const kernels::BodyView& v, const SqueezedRow& row);
  bool gains_energy(const kernels::BodyView& v) const;
  static void put(const SqueezedRow& row, const SqueezedRow::Lane& lane);
  float& impulse_of(const SqueezedRow& row);

  ContactStore& discs_;
  Manifolds& manifolds_;
  const HeavyLoads& loads_;
  std::vector<SqueezedRow> found_, rows_;
  std::vector<Block> blocks_;
  std::vector<std::uint32_t> light_, heavy_;  // bodies that are squeezed, and those that squeeze them, ascending
};

}  // namespace psim
