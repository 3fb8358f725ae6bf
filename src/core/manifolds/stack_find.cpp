// Finds the stacks among the manifolds of a step. How they are solved is in stacks.cpp.
#include <algorithm>
#include <cmath>

#include "base/rotor.h"
#include "base/tasks.h"
#include "manifolds/stacks.h"

namespace psim {
namespace {

constexpr std::uint32_t kLongStack = 4;  // links from which a stack counts as long
constexpr float kMassRatio = 8;          // or one link has this mass ratio
constexpr float kSideShare = 0.05f;      // side contacts may carry this share of the support
constexpr float kClosed = 0.0002f;       // share of the inner radius: a solve may close a smaller gap
// A link becomes part of a long stack, and stays so, up to these speeds, in units of what gravity adds in a step.
constexpr double kCalm = 0.06, kShaken = 1.2;
constexpr std::uint32_t kFew = 16;  // shapes are few if no more than one in kFew bodies is one
constexpr std::size_t kRoom = 64;   // there is room for so many links, and for one for every eight bodies

// Whether the bodies of a pair touch.
bool touch(const BodyStore& b, const ManifoldPair& pair) {
  if (!pair.active || pair.manifold.count == 0) return false;
  if (pair.impulse[0] > 0 || (pair.manifold.count == 2 && pair.impulse[1] > 0)) return true;
  return pair.least_gap() <= kTouching * b.kind(pair.id_b).inner;
}

// The body below in a link, or none on fixed ground.
std::uint32_t lower_of(const ManifoldPair& pair, std::uint32_t upper) {
  if (pair.fixed_a) return ManifoldPair::kNone;
  return pair.b == upper ? pair.a : pair.b;
}

// Whether the bodies of a link move against each other by more than gravity adds in a step, about. A direct solve would
// throw bodies about that rock on each other.
bool rocks(const BodyStore& b, const ManifoldPair& pair, double g, double dt) {
  if (pair.manifold.count != 2) return false;
  const bool fixed = pair.of_piece();
  const Vec2 moves = b.velocity(pair.b) - (fixed ? Vec2{} : b.velocity(pair.a));
  const double turns_a = fixed ? 0 : std::fabs(b.rim_speed[pair.a]), turns_b = std::fabs(b.rim_speed[pair.b]);
  return length_of(moves) + turns_a + turns_b > (pair.was_stack == ManifoldPair::kNoStack ? kCalm : kShaken) * g * dt;
}

}  // namespace

void Stacks::find(const ManifoldParams& params) {
  forget();
  const std::vector<std::uint32_t>& bodies = manifolds_.shaped();
  const std::size_t usual = std::min(bodies.size(), kRoom + bodies.size() / 8);
  run_.reserve(usual);
  links_.reserve(usual);
  stacks_.reserve(usual);
  const double g = length_of(params.gravity);
  surfaces_ = params.surfaces;
  find_supports(params.gravity);
  mark_links();
  for (const std::uint32_t top : bodies) {
    if (!standing_[top].link || standing_[top].carries) continue;
    const bool steep = follow_down(top);
    if (run_.size() < kLongStack && !steep) continue;
    std::reverse(run_.begin(), run_.end());
    // A long stack consists of links at rest alone. The links between others are too few, or make a stack of their own.
    std::size_t begin = 0;
    for (std::size_t k = 0; k <= run_.size(); ++k) {
      if (k != run_.size()) {
        ManifoldPair& pair = manifolds_.pair(run_[k].pair);
        if (steep || !rocks(b_, pair, g, params.dt)) continue;
        pair.rest_frames = kRestFrames;
      }
      if (steep || k - begin >= kLongStack) add_stack(begin, k);
      begin = k + 1;
    }
  }
}

// Counts for each body the contacts on which it stands and those that it carries.
void Stacks::find_supports(Vec2 gravity) {
  const double g = length_of(gravity);
  standing_.resize(std::max<std::size_t>(standing_.size(), b_.count));
  const auto each_active = [&](const auto& visit) {
    run_phases(manifolds_.strip_count(), pool_, [&](std::size_t strip) {
      for (const std::uint32_t k : manifolds_.strip(strip).active) visit(k, manifolds_.pairs()[k]);
    });
  };
  const std::vector<std::uint32_t>& shaped = manifolds_.shaped();
  if (shaped.size() > b_.count / kFew) {
    run_stream(b_.blocks(), pool_, [&](BlockRange r) {
      const std::uint32_t begin = r.begin * kernels::kBlock, end = std::min(b_.count, r.end * kernels::kBlock);
      std::fill(standing_.begin() + begin, standing_.begin() + end, Standing());
    });
  } else {  // the discs beside them have such numbers, too
    each_active([&](std::uint32_t, const ManifoldPair& pair) {
      standing_[pair.b] = {};
      if (pair.a != kNone) standing_[pair.a] = {};
    });
    for (const std::uint32_t slot : shaped) standing_[slot] = {};
  }
  each_active([&](std::uint32_t k, const ManifoldPair& pair) {
    if (!(g > 0) || !touch(b_, pair)) return;
    const double up = -dot(gravity, {pair.manifold.nx, pair.manifold.ny}) / g;
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
  });
}

// Marks the bodies that are the upper one of a link, and those that carry one.
void Stacks::mark_links() {
  const auto links_down = [&](std::uint32_t slot) {
    const Standing& mine = standing_[slot];
    if (mine.below != 1 || mine.above > 1 || mine.side > kSideShare * mine.support) return false;
    const ManifoldPair& pair = manifolds_.pairs()[mine.on];
    if (surfaces_) {
      const Sides sides = manifolds_.sides_of(pair);
      if (sides.belt() != 0 || sides.rolling() > 0) return false;
    }
    if (pair.rest_frames != 0 || !pair.stands || (pair.fixed_a && pair.a == slot)) return false;
    if (b_.properties(b_.id[slot]).inv_mass == 0) return false;
    const std::uint32_t lower = lower_of(pair, slot);
    return lower == kNone || (manifolds_.has_corners(lower) && standing_[lower].above == 1);
  };
  for (const std::uint32_t slot : manifolds_.shaped()) {
    if (!links_down(slot)) continue;
    standing_[slot].link = true;
    const std::uint32_t lower = lower_of(manifolds_.pairs()[standing_[slot].on], slot);
    if (lower != kNone) standing_[lower].carries = true;
  }
}

// Follows the links from a body down to the ground or to the first body that is none. Returns whether a mass ratio on
// the way is large.
bool Stacks::follow_down(std::uint32_t top) {
  run_.clear();
  bool steep = false;
  for (std::uint32_t slot = top; slot != kNone && standing_[slot].link;) {
    StackLink link;
    link.pair = standing_[slot].on;
    const ManifoldPair& pair = manifolds_.pairs()[link.pair];
    link.b_above = pair.b == slot;
    const std::uint32_t lower = lower_of(pair, slot);
    if (lower != kNone) {
      const float here = b_.properties(b_.id[slot]).mass, there = b_.properties(b_.id[lower]).mass;
      steep |= here > kMassRatio * there || there > kMassRatio * here;
    }
    run_.push_back(link);
    slot = lower;
  }
  return steep;
}

// Adds a stack from links [begin, end) of the run, which starts at the bottom.
void Stacks::add_stack(std::size_t begin, std::size_t end) {
  stacks_.push_back({static_cast<std::uint32_t>(links_.size()), static_cast<std::uint32_t>(end - begin)});
  const bool grounded = manifolds_.pairs()[run_[begin].pair].fixed_a;
  for (std::size_t k = begin; k < end; ++k) {
    StackLink& link = links_.emplace_back(run_[k]);
    manifolds_.set_stack_role(link.pair, grounded ? ManifoldPair::kOnFixed : ManifoldPair::kOnMoving);
    link.closed = kClosed * b_.kind(manifolds_.pairs()[link.pair].id_b).inner;
  }
}

}  // namespace psim
