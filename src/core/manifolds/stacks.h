// Stacks: bodies that stand on each other one by one. A sweep brings a load down one contact at a
// time, so a tall stack or a heavy body on light ones sags and drifts; a stack's contacts can be
// solved together, exactly, in a time proportional to their number.
//
// A link is a contact that carries: |n.up| >= 1/2, touching. Upper body: one support below, at most one
// above, side contacts that carry next to nothing. Lower body: fixed, or this one support above. A
// stack is a run of links down to the first body that does not qualify; it counts if it is long and
// at rest or has a large mass ratio (docs/decisions/007-manifolds.md has what was measured).
//
// In: manifolds of the step. In and out: velocities, rim speeds and impulses of the stack's lanes.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "manifolds/manifolds.h"
#include "views.h"

namespace psim {

/// A contact carries weight if the |cosine| between its normal and gravity is larger.
constexpr double kSupport = 0.5;

/// The factors L D L^T of a symmetric S that is scaled to a unit diagonal.
struct StackFactor {
  double l10 = 0, l20 = 0, l21 = 0, d[3] = {}, scale[3] = {};
};
/// A link after those above it were eliminated, for the rows that were active. It is valid while these rows stay
/// active.
struct ReducedLink {
  unsigned rows = 0xFF;  // bits 1, 2, 4: active; 8, 16: with compliance; 0xFF: nothing is known yet
  StackFactor factor;    // factors of the block
  double m[3][3] = {};   // its inverse times the coupling with the link below
};
/// A 3 x 3 problem: two normals and one friction row.
struct StackLink {
  std::uint32_t pair = 0;
  bool b_above = false;  // B stands on A
  double closed = 0;     // m: a solve may close this gap
  // The same for all solves of a step:
  kernels::ManifoldBlock* block = nullptr;  // where the pair was laid out
  std::uint32_t lane = 0;                   // in the block
  Vec2 along[3];                            // direction of each row, for the upper body
  double up[3] = {}, low[3] = {};           // lever arm of each row, for the upper and the lower body
  double wu = 0, gu = 0, wl = 0, gl = 0;    // inverse mass and R^2 / I of the two
  double an = 0, bn = 0;                    // arm of the friction row
  double a[3][3] = {}, soft[2] = {};        // own block; compliance of the normals
  double full[3][3] = {};                   // coupling with the link below
  ReducedLink reduced[2];                   // rigid, soft
  // In one solve:
  unsigned rows = 0;  // as in ReducedLink
  double r[3] = {}, right[3] = {}, d[3] = {};
  bool active(int row) const { return (rows >> row & 1u) != 0; }
  double compliance(int row) const { return row < 2 && (rows >> (3 + row) & 1u) != 0 ? soft[row] : 0; }
  double coupling(int row, int below, const StackLink& under) const {
    return active(row) && under.active(below) ? full[row][below] : 0;
  }
};

class Stacks {
 public:
  Stacks(const Surroundings& s, Manifolds& manifolds) : b_(s.bodies), pool_(s.pool), manifolds_(manifolds) {}

  /// Finds the stacks among the pairs as they are now, and tells the pairs (ManifoldPair::stack)
  /// before they are laid out. O(pairs).
  void find(const ManifoldParams& params);
  void forget() {
    stacks_.clear();
    links_.clear();
  }
  /// Gives the memory back. There are no shapes that could stand on each other.
  void release() { give_back(standing_, run_, links_, stacks_); }
  bool any() const { return !stacks_.empty(); }
  std::size_t link_count() const { return stacks_.empty() ? 0 : links_.size(); }

  /// Calls each(links) for every stack, with its links from the bottom up.
  template <class Each>
  void each_stack(const Each& each) const {
    for (const Stack& s : stacks_) each(std::span(links_).subspan(s.first, s.count));
  }

  /// Reads the lanes where the pairs were laid out.
  void place();

  /// Solves every stack directly: softly, with overlaps pushed out (`soft`), or rigidly.
  void solve(const kernels::BodyView& bodies, const kernels::ContactParams& p, double gravity, bool soft);

  std::size_t bytes() const { return bytes_of(standing_, run_, links_, stacks_); }

 private:
  static constexpr std::uint32_t kNone = ManifoldPair::kNone;

  // The contacts on which a body stands, and those that it carries.
  struct Standing {
    std::uint8_t below = 0, above = 0;  // contacts, counted up to 2
    bool link = false;                  // the body is the upper one of a link
    bool carries = false;               // the body is the lower one of a link
    std::uint32_t on = kNone;           // the pair that supports the body
    float support = 0, side = 0;        // N s: of what supports it, the most of a contact at its side
  };
  struct Stack {
    std::uint32_t first = 0, count = 0;  // links, from the bottom
  };

  std::span<StackLink> links_of(const Stack& stack) { return std::span(links_).subspan(stack.first, stack.count); }
  void find_supports(Vec2 gravity);
  void count_supports(const Manifolds::StripBlocks& strip, Vec2 gravity);
  void stand(std::uint32_t upper, std::uint32_t lower, std::uint32_t pair, float load);
  void lean(std::uint32_t a, std::uint32_t b, float load);
  void mark_links();
  bool follow_down(std::uint32_t top);
  void add_stack(std::size_t begin, std::size_t end);

  bool surfaces_ = false;  // some run or resist rolling
  const BodyStore& b_;
  WorkerPool& pool_;
  Manifolds& manifolds_;
  std::vector<Standing> standing_;  // by slot
  std::vector<StackLink> run_;      // links of bodies that stand on each other, from the bottom
  std::vector<StackLink> links_;
  std::vector<Stack> stacks_;
};

}  // namespace psim
