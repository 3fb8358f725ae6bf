// Finds the stacks among the manifolds of a step. How they are solved is in stacks.cpp.
#include <algorithm>
#include <cmath>

#include "base/tasks.h"
#include "manifolds/stacks.h"

namespace psim {
namespace {

constexpr std::uint32_t kLongStack = 4;  // links from which a stack counts as long
constexpr float kMassRatio = 8;          // or one link has this mass ratio
constexpr float kSideShare = 0.05f;      // side contacts may carry this share of the support
constexpr float kTouching = 0.002f;      // share of the inner radius: a smaller gap counts as touching
constexpr float kClosed = 0.0002f;       // share of the inner radius: a solve may close a smaller gap
// A link becomes part of a long stack, and stays so, up to these speeds, in units of what gravity adds in a step.
constexpr double kCalm = 0.06, kShaken = 1.2;
constexpr std::size_t kRoom = 64;  // there is room for so many links, and for one for every eight bodies

// Whether the bodies of a pair touch.
bool touch(const BodyStore& b, const ManifoldPair& pair) {
  if (!pair.active || pair.manifold.count == 0) return false;
  if (pair.impulse[0] > 0 || (pair.manifold.count == 2 && pair.impulse[1] > 0)) return true;
  const float least = pair.manifold.count == 2 ? std::fmin(pair.gap[0], pair.gap[1]) : pair.gap[0];
  return least <= kTouching * b.kind(pair.id_b).inner;
}

// Whether the bodies of a link move against each other by more than gravity adds in a step, about. A direct solve would
// throw bodies about that rock on each other.
bool rocks(const BodyStore& b, const ManifoldPair& pair, double g, double dt) {
  if (pair.manifold.count != 2) return false;
  const bool fixed = pair.a == ManifoldPair::kNone;
  const Vec2 moves = b.velocity(pair.b) - (fixed ? Vec2{} : b.velocity(pair.a));
  const double turns_a = fixed ? 0 : std::fabs(static_cast<double>(b.rim_speed[pair.a]));
  const double turns_b = std::fabs(static_cast<double>(b.rim_speed[pair.b]));
  return std::hypot(moves.x, moves.y) + turns_a + turns_b >
         (pair.was_stack == ManifoldPair::kNoStack ? kCalm : kShaken) * g * dt;
}

}  // namespace

void Stacks::find(const BodyStore& b, Manifolds& manifolds, const ManifoldParams& params, const PairTable& table,
                  WorkerPool& pool) {
  links_.clear();
  stacks_.clear();
  const std::size_t bodies = manifolds.shaped().size(), usual = std::min(bodies, kRoom + bodies / 8);
  run_.reserve(usual);
  links_.reserve(usual);
  stacks_.reserve(usual);
  const double g = length_of(params.gravity);
  find_supports(b, manifolds, params.gravity, g, table, pool);
  mark_links(b, manifolds);
  for (const std::uint32_t top : manifolds.shaped()) {
    if (!standing_[top].link || standing_[top].carries) continue;
    const bool steep = follow_down(b, manifolds, top);
    if (run_.size() < kLongStack && !steep) continue;
    std::reverse(run_.begin(), run_.end());
    // A long stack consists of links at rest alone. The links between others are too few, or make a stack of their own.
    std::size_t begin = 0;
    for (std::size_t k = 0; k <= run_.size(); ++k) {
      if (k != run_.size()) {
        if (steep || !rocks(b, manifolds.pairs()[run_[k].pair], g, params.dt)) continue;
        manifolds.pair(run_[k].pair).rest_frames = kRestFrames;
      }
      if (steep || k - begin >= kLongStack) add_stack(b, manifolds, begin, k);
      begin = k + 1;
    }
  }
}

// Counts for each body the contacts on which it stands and those that it carries.
void Stacks::find_supports(const BodyStore& b, const Manifolds& manifolds, Vec2 gravity, double g,
                           const PairTable& table, WorkerPool& pool) {
  const auto upright = [&](const ManifoldPair& pair) {
    return -(gravity.x * static_cast<double>(pair.manifold.nx) + gravity.y * static_cast<double>(pair.manifold.ny)) / g;
  };
  standing_.resize(std::max<std::size_t>(standing_.size(), b.count));
  run_phases(table.strips.size(), pool, [&](std::size_t strip) {
    for (const std::uint32_t k : manifolds.active_of(strip)) {
      const ManifoldPair& pair = manifolds.pairs()[k];
      standing_[pair.b] = {};
      if (pair.a != kNone) standing_[pair.a] = {};
    }
  });
  for (const std::uint32_t slot : manifolds.shaped()) standing_[slot] = {};
  run_phases(table.strips.size(), pool, [&](std::size_t strip) {
    for (const std::uint32_t k : manifolds.active_of(strip)) {
      const ManifoldPair& pair = manifolds.pairs()[k];
      if (!(g > 0) || !touch(b, pair)) continue;
      const double up = upright(pair);
      const float load = pair.impulse[0] + (pair.manifold.count == 2 ? pair.impulse[1] : 0);
      const auto stand = [&](std::uint32_t upper, std::uint32_t lower) {
        if (upper != kNone) {
          ++standing_[upper].below;
          standing_[upper].on = k;
          standing_[upper].support = load;
        }
        if (lower != kNone) ++standing_[lower].above;
      };
      if (up >= kSupport) {
        stand(pair.b, pair.a);
      } else if (up <= -kSupport) {
        stand(pair.a, pair.b);
      } else {
        standing_[pair.b].side += load;
        if (pair.a != kNone) standing_[pair.a].side += load;
      }
    }
  });
}

// Marks the bodies that are the upper one of a link, and those that carry one.
void Stacks::mark_links(const BodyStore& b, const Manifolds& manifolds) {
  const auto links_down = [&](std::uint32_t slot) {
    const Standing& mine = standing_[slot];
    if (mine.below != 1 || mine.above > 1 || mine.side > kSideShare * mine.support) return false;
    const ManifoldPair& pair = manifolds.pairs()[mine.on];
    const bool b_above = pair.b == slot;
    if (pair.rest_frames != 0 || (!b_above && pair.fixed_a) || b.properties(b.id[slot]).inv_mass == 0) {
      return false;
    }
    if (pair.fixed_a) return true;
    const std::uint32_t lower = b_above ? pair.a : pair.b;
    return manifolds.has_corners(lower) && standing_[lower].above == 1;
  };
  for (const std::uint32_t slot : manifolds.shaped()) {
    if (!links_down(slot)) continue;
    standing_[slot].link = true;
    const ManifoldPair& pair = manifolds.pairs()[standing_[slot].on];
    if (!pair.fixed_a) standing_[pair.b == slot ? pair.a : pair.b].carries = true;
  }
}

// Follows the links from a body down to the ground or to the first body that is none. Returns whether a mass ratio on
// the way is large.
bool Stacks::follow_down(const BodyStore& b, const Manifolds& manifolds, std::uint32_t top) {
  run_.clear();
  bool steep = false;
  for (std::uint32_t slot = top; slot != kNone && standing_[slot].link;) {
    StackLink link;
    link.pair = standing_[slot].on;
    const ManifoldPair& pair = manifolds.pairs()[link.pair];
    link.b_above = pair.b == slot;
    const std::uint32_t lower = pair.fixed_a ? kNone : (link.b_above ? pair.a : pair.b);
    if (lower != kNone) {
      const float here = b.properties(b.id[slot]).mass, there = b.properties(b.id[lower]).mass;
      steep |= here > kMassRatio * there || there > kMassRatio * here;
    }
    run_.push_back(link);
    slot = lower;
  }
  return steep;
}

// Adds a stack from links [begin, end) of the run, which starts at the bottom.
void Stacks::add_stack(const BodyStore& b, Manifolds& manifolds, std::size_t begin, std::size_t end) {
  stacks_.push_back({static_cast<std::uint32_t>(links_.size()), static_cast<std::uint32_t>(end - begin), false});
  const bool grounded = manifolds.pairs()[run_[begin].pair].fixed_a;
  for (std::size_t k = begin; k < end; ++k) {
    manifolds.set_stack_role(run_[k].pair, grounded ? ManifoldPair::kOnFixed : ManifoldPair::kOnMoving);
    run_[k].closed = static_cast<double>(kClosed * b.kind(manifolds.pairs()[run_[k].pair].id_b).inner);
    links_.push_back(run_[k]);
  }
}

void Stacks::place(const Manifolds& manifolds) {
  for (StackLink& link : links_) {
    link.lane = manifolds.pairs()[link.pair].lane;
    link.strip = static_cast<std::uint32_t>(manifolds.strip_of(link.pair));
  }
}

}  // namespace psim
