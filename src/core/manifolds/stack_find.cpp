// Finds the stacks among the manifolds of a step. How they are solved is in stacks.cpp.
#include <algorithm>
#include <bit>
#include <cmath>

#include "base/rotor.h"
#include "base/tasks.h"
#include "manifolds/stacks.h"

namespace psim {
namespace {

constexpr std::uint32_t kLongStack = 4;  // links from which a stack counts as long
constexpr float kMassRatio = 8;          // or one link has this mass ratio
constexpr float kSideShare = 0.05f;      // each contact at the side may carry this share of the support
constexpr float kClosed = 0.0002f;       // share of the inner radius: a solve may close a smaller gap
// A link becomes part of a long stack, and stays so, up to these speeds, in units of what gravity adds in a step.
constexpr double kCalm = 0.06, kShaken = 1.2;
constexpr std::uint32_t kFew = 16;  // shapes are few if no more than one in kFew bodies is one
constexpr std::size_t kRoom = 64;   // there is room for so many links, and for one for every eight bodies

// The impulse that the bodies of a pair exchange, N s, and whether they touch.
float load_of(const ManifoldPair& p) { return p.impulse[0] + (p.manifold.count == 2 ? p.impulse[1] : 0); }
bool touch(const BodyStore& b, const ManifoldPair& p, float load) {
  return load > 0 || p.least_gap() <= kTouching * b.kind(p.id_b).inner;
}

// How the contacts of a block stand: a bit for each lane.
struct Standing8 {
  std::uint32_t touch = 0, up = 0, down = 0;  // they touch; B stands on A; A on B
  float load[kernels::kBlock];                // N s
};

// Gravity as a vector and what a normal must have along it to carry weight.
struct Weight {
  double x, y, least;
  explicit Weight(Vec2 gravity) : x(gravity.x), y(gravity.y), least(kSupport * length_of(gravity)) {}
  double along(float nx, float ny) const { return x * static_cast<double>(nx) + y * static_cast<double>(ny); }
};

Standing8 standing_of(const kernels::ManifoldBlock& c, const kernels::LastingBlock& then, const Weight& weight) {
  Standing8 s;
  for (std::uint32_t l = 0; l < kernels::kBlock; ++l) {
    const float least = std::min(c.point[1].gap[l], c.point[0].gap[l]);
    const double along = weight.along(then.nx[l], then.ny[l]);
    s.load[l] = std::max(c.point[0].impulse[l], 0.0f) + std::max(c.point[1].impulse[l], 0.0f);
    s.touch |= static_cast<std::uint32_t>((s.load[l] > 0) | (least <= then.touching[l])) << l;
    s.up |= static_cast<std::uint32_t>(along <= -weight.least) << l;
    s.down |= static_cast<std::uint32_t>(along >= weight.least) << l;
  }
  return s;
}

// Calls visit(lane) for each bit.
template <class Visit>
void each_lane(std::uint32_t lanes, const Visit& visit) {
  for (; lanes != 0; lanes &= lanes - 1) visit(static_cast<std::uint32_t>(std::countr_zero(lanes)));
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
        if (steep || !rocks(b_, manifolds_.pairs()[run_[k].pair], g, params.dt)) continue;
        manifolds_.hold_out(run_[k].pair, manifolds_.strip_of(run_[k].pair));
      }
      if (steep || k - begin >= kLongStack) add_stack(begin, k);
      begin = k + 1;
    }
  }
}

// Notes that one body stands on another one.
void Stacks::stand(std::uint32_t upper, std::uint32_t lower, std::uint32_t pair, float load) {
  const auto count = [](std::uint8_t& contacts) {
    if (contacts < 2) ++contacts;
  };
  if (upper != kNone) {
    Standing& of = standing_[upper];
    count(of.below);
    of.on = pair;
    of.support = load;
  }
  if (lower != kNone) count(standing_[lower].above);
}

void Stacks::lean(std::uint32_t a, std::uint32_t b, float load) {
  standing_[b].side = std::max(standing_[b].side, load);
  if (a != kNone) standing_[a].side = std::max(standing_[a].side, load);
}

// The contacts of a strip, in any order: what is counted does not depend on it.
void Stacks::count_supports(const Manifolds::StripBlocks& strip, Vec2 gravity) {
  const Weight weight(gravity);
  for (std::uint32_t block = 0; block < strip.lasting.steady.size(); ++block) {
    const std::uint32_t steady = strip.lasting.steady[block];
    if (steady == 0) continue;
    const kernels::LastingBlock& then = strip.lasting.then[block];
    const Standing8 s = standing_of(strip.blocks[block], then, weight);
    const std::uint32_t touch = s.touch & steady;
    const bool fixed = block >= strip.end[1];
    const auto a = [&](std::uint32_t l) { return fixed ? kNone : then.body[2 * l]; };
    const auto b = [&](std::uint32_t l) { return then.body[2 * l + 1]; };
    each_lane(touch & s.up, [&](std::uint32_t l) { stand(b(l), a(l), then.pair[l], s.load[l]); });
    each_lane(touch & s.down, [&](std::uint32_t l) { stand(a(l), b(l), then.pair[l], s.load[l]); });
    each_lane(touch & ~(s.up | s.down), [&](std::uint32_t l) { lean(a(l), b(l), s.load[l]); });
  }
  for (const std::uint32_t k : strip.active) {
    if (manifolds_.steady_lane(strip, k) != kNone) continue;
    const ManifoldPair& pair = manifolds_.pairs()[k];
    const float load = load_of(pair);
    if (pair.manifold.count == 0 || !touch(b_, pair, load)) continue;
    const double along = weight.along(pair.manifold.nx, pair.manifold.ny);
    if (along <= -weight.least) {
      stand(pair.b, pair.a, k, load);
    } else if (along >= weight.least) {
      stand(pair.a, pair.b, k, load);
    } else {
      lean(pair.a, pair.b, load);
    }
  }
}

// Counts for each body the contacts on which it stands and those that it carries.
void Stacks::find_supports(Vec2 gravity) {
  standing_.resize(std::max<std::size_t>(standing_.size(), b_.count));
  const std::vector<std::uint32_t>& shaped = manifolds_.shaped();
  if (shaped.size() > b_.count / kFew) {
    run_stream(b_.blocks(), pool_, [&](BlockRange r) {
      const std::uint32_t begin = r.begin * kernels::kBlock, end = std::min(b_.count, r.end * kernels::kBlock);
      std::fill(standing_.begin() + begin, standing_.begin() + end, Standing());
    });
  } else {  // the discs beside them have such numbers, too
    run_phases(manifolds_.strip_count(), pool_, [&](std::size_t strip) {
      for (const std::uint32_t k : manifolds_.strip(strip).active) {
        const ManifoldPair& pair = manifolds_.pairs()[k];
        standing_[pair.b] = {};
        if (pair.a != kNone) standing_[pair.a] = {};
      }
    });
    for (const std::uint32_t slot : shaped) standing_[slot] = {};
  }
  if (!(length_of(gravity) > 0)) return;
  run_phases(manifolds_.strip_count(), pool_,
             [&](std::size_t strip) { count_supports(manifolds_.strip(strip), gravity); });
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
