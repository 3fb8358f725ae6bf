// Colours and blocks of the touching pairs of a strip.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <iterator>
#include <utility>

#include "base/elementary.h"
#include "base/tasks.h"
#include "contacts/contact_model.h"
#include "least.h"
#include "manifolds/manifolds.h"
#include "manifolds/stacks.h"

namespace psim {
namespace {

using kernels::kBlock;
using kernels::ManifoldBlock;
using kernels::snapped;

constexpr std::uint32_t kColours = ManifoldPair::kColours;  // one more class has blocks with a single lane
constexpr float kOpen = -0.0f;

// If a contact carries weight and stands on fixed ground, the body below takes this share of its impulse in a sweep. So
// loads go down a pile no faster than the contacts below can answer them (docs/decisions/007-manifolds.md). The ground
// takes the rest: where there is none, momentum must stay.
constexpr float kReaction = 0.5f;

constexpr float kMostOffset = 0.05f;  // share of the inner radius, see ManifoldPair::offset

void no_point(ManifoldBlock::Point& p, std::uint32_t l) {
  p.an[l] = p.at[l] = p.bn[l] = p.bt[l] = 0;
  p.gap[l] = kNoGap;
  p.impulse[l] = kOpen;
  p.friction[l] = p.start[l] = 0;
}

// A lane without points.
void empty(ManifoldBlock& c, std::uint32_t l) {
  no_point(c.point[0], l);
  no_point(c.point[1], l);
}

// Makes a lane that does nothing: two resting dummies, far apart.
void pad(ManifoldBlock& c, std::uint32_t l, std::uint32_t dummy) {
  c.body[2 * l] = dummy;
  c.body[2 * l + 1] = dummy + 1;
  c.nx[l] = 0;
  c.ny[l] = 1;
  empty(c, l);
  c.wa[l] = c.wb[l] = c.share_a[l] = c.share_b[l] = 1;
  c.ga[l] = c.gb[l] = c.round_a[l] = c.round_b[l] = c.lead_a[l] = c.lead_b[l] = 0;
  c.mu[l] = c.e[l] = c.soft[l] = c.rate[l] = c.apart[l] = 0;
}

// Whether a pair lies under a heavy load. Those of stacks do not count, since stacks are solved exactly.
bool is_loaded(const ManifoldPair& pair, const HeavyLoads& loads) {
  return pair.stack == ManifoldPair::kNoStack && loads.any() &&
         ((!pair.of_piece() && loads.at(pair.a)) || loads.at(pair.b));
}

// Writes the points of a pair into its lane: arms in units of the bodies' radii, gaps, impulses.
void fill_points(ManifoldBlock& c, std::uint32_t l, const ManifoldPair& pair, const Manifold& m, float size_a,
                 float size_b) {
  const bool fixed = pair.of_piece();
  for (int k = 0; k < 2; ++k) {
    ManifoldBlock::Point& p = c.point[k];
    if (k >= m.count) {
      no_point(p, l);
      continue;
    }
    const ManifoldPoint& from = m.point[k];
    const auto along = [&](float x, float y) { return m.nx * x + m.ny * y; };
    const auto across = [&](float x, float y) { return x * m.ny - y * m.nx; };
    p.an[l] = fixed ? 0.0f : snapped(along(from.ax, from.ay) / size_a);
    p.at[l] = fixed ? 0.0f : snapped(across(from.ax, from.ay) / size_a);
    p.bn[l] = snapped(along(from.bx, from.by) / size_b);
    p.bt[l] = snapped(across(from.bx, from.by) / size_b);
    p.gap[l] = pair.gap[k];
    p.impulse[l] = pair.impulse[k];
    p.friction[l] = pair.friction[k];
    p.start[l] = 0;
  }
}

Stiffness stiffness_of(const ManifoldParams& params, const ManifoldPair& pair, bool loaded, bool bounces) {
  if (pair.stack != ManifoldPair::kNoStack) return params.in_stacks[pair.stack == ManifoldPair::kOnFixed];
  if (bounces && !loaded) return params.bouncing[pair.fixed_a];
  return params.plain[(pair.fixed_a ? 1u : 0u) + (loaded ? 2u : 0u)];
}

void set_stiffness(ManifoldBlock& c, std::uint32_t l, const ManifoldPair& pair, const ManifoldParams& params,
                   bool loaded) {
  const Stiffness of = stiffness_of(params, pair, loaded, c.e[l] != 0);
  c.soft[l] = of.soft;
  c.rate[l] = of.rate;
}

void set_reactions(ManifoldBlock& c, std::uint32_t l, const ManifoldPair& pair, Vec2 gravity, bool loaded) {
  c.share_a[l] = c.share_b[l] = 1;
  const double g = length_of(gravity);
  // The impulse of an impact is applied at once, that of a stack exactly.
  if (!pair.yields || pair.stack != ManifoldPair::kNoStack || c.e[l] > 0 || loaded || !(g > 0)) return;
  const double down = dot(gravity, {pair.manifold.nx, pair.manifold.ny}) / g;
  if (down <= -kSupport) c.share_a[l] = kReaction;
  if (down >= kSupport) c.share_b[l] = kReaction;
}

// Finds the offsets with which the impulses of a pair balance its gaps: rate s = -soft K l, where K is the inverse mass
// at the point. An offset may take out the whole overlap: a large body sinks deep into a small one that moves, and hardly
// into one that sleeps.
void balance(const BodyStore& b, ManifoldPair& pair, const ManifoldBlock& c, std::uint32_t l) {
  const float small = kMostOffset * b.kind(pair.id_b).inner;
  for (int k = 0; k < pair.manifold.count; ++k) {
    const ManifoldBlock::Point& p = c.point[k];
    const float own = c.wa[l] + c.wb[l] + c.ga[l] * p.at[l] * p.at[l] + c.gb[l] * p.bt[l] * p.bt[l];
    const float wanted = -c.soft[l] * own * pair.impulse[k] / c.rate[l];
    const float most = greater(small, -pair.gap[k]);
    pair.offset[k] = pair.impulse[k] > 0 ? std::clamp(wanted - pair.gap[k], -small, most) : 0.0f;
  }
  pair.balanced = c.soft[l];
}

// The run of a strip to which a pair belongs, see StripBlocks::end.
std::uint32_t class_of(const ManifoldPair& pair, const HeavyLoads& loads) {
  return (pair.fixed_a ? 2u : 0u) + (is_loaded(pair, loads) ? 1u : 0u);
}

}  // namespace

void Manifolds::open_lane(ManifoldBlock& c, std::uint32_t l) { empty(c, l); }

void Manifolds::forget() {
  accept();
  own_end_ = 0;
  indexed_ = fixed_known_ = false;
  pairs_.clear();
  begin_.clear();
  cuts_.clear();
  for (StripBlocks& s : strips_) {
    s.laid.clear();
    s.lasting.clear();
  }
  known_lane_.clear();
  ranges_.clear();
  stood_known_ = false;
  std::ranges::fill(stale_, std::uint8_t{1});
}

bool Manifolds::fit(std::size_t strips) {
  const std::size_t pairs = pairs_.size();
  if (strips == 0 || strip_count() != strips || strips_.size() < strips || stale_.size() < strips ||
      special_.size() < strips || begin_[strips - 1] > own_end_ || own_end_ > pairs) {
    return false;
  }
  for (StripBlocks& s : strips_) std::erase_if(s.laid, [pairs](std::uint32_t k) { return k >= pairs; });
  if (begin_.back() == pairs) return true;
  begin_.back() = static_cast<std::uint32_t>(pairs);
  cut();
  return true;
}

void Manifolds::clear() {
  forget();
  old_pairs_.clear();
  strips_.clear();
  shaped_.clear();
  decisions_.clear();
  totals_ = {};
}

void Manifolds::release() {
  clear();
  give_back(pairs_, old_pairs_, renewed_, before_, begin_, found_, counts_, ranges_, strips_, special_, known_lane_,
            stood_, stale_, shaped_, fixed_, crowded_, turned_, turning_, kind_, rotor_, inner_, used_, ties);
  boxes_.release();
  index_.release();
  give_back(long_);
  boxed_ = long_known_ = false;
}

// Lays out one strip.
struct Manifolds::Layout {
  Manifolds& m;
  std::size_t index;
  const HeavyLoads& loads;
  const ManifoldParams& params;
  std::uint32_t dummy;  // the first of two bodies that rest, for lanes without a pair
  std::uint8_t& stale;
  StripBlocks& strip;
  const BodyStore& b = m.s_.bodies;
  // By run of the strip and colour: the number of pairs, then the next free lane.
  std::array<std::array<std::uint32_t, kColours + 1>, 4> lanes{};

  void run() {
    const auto changes_stack = [&](std::uint32_t k) { return m.pairs_[k].stack != m.pairs_[k].was_stack; };
    // Contacts of a stack do not count as heavy loads, so that these pairs get into other runs.
    if (stale != 0 || (loads.any() && std::ranges::any_of(strip.rewrite, changes_stack))) return make_blocks();
    const bool all = params.changed && params.asleep;  // contacts with sleepers are balanced anew
    for (const std::uint32_t k : all ? strip.active : strip.rewrite) {
      m.catch_up(strip, k);
      if (all || m.pairs_[k].changed || changes_stack(k)) fill(m.pairs_[k]);
    }
    if (!params.changed || all) return;
    each(strip.active, [&](const ManifoldPair& pair) {
      set_stiffness(strip.blocks[pair.lane / kBlock], pair.lane % kBlock, pair, params, is_loaded(pair, loads));
    });
  }

 private:
  template <class Visit>
  void each(const std::vector<std::uint32_t>& list, const Visit& visit) const {
    for (const std::uint32_t k : list) visit(m.pairs_[k]);
  }

  void make_blocks() {
    stale = 0;
    m.catch_up(index);
    m.forget_steady(index);
    colour();
    const std::uint32_t blocks = place_runs();
    if (blocks > strip.blocks.capacity())
      strip.blocks.reserve(blocks + blocks / 2 + 4);  // with spare room, since contacts come and go
    strip.lasting.reserve(strip.blocks.capacity());
    if (params.surfaces) strip.surfaces.reserve(strip.blocks.capacity());
    strip.blocks.resize(blocks);
    strip.surfaces.assign(params.surfaces ? blocks : 0, {});
    for (ManifoldBlock& block : strip.blocks) {
      for (std::uint32_t l = 0; l < kBlock; ++l) pad(block, l, dummy);
    }
    each(strip.laid, [&](ManifoldPair& pair) {
      std::uint32_t& at = lanes[class_of(pair, loads)][pair.lane];
      const bool alone = pair.lane == kColours;
      pair.lane = at;
      at += alone ? kBlock : 1;
      fill(pair);
      if (!pair.active) {
        empty(strip.blocks[pair.lane / kBlock], pair.lane % kBlock);
        pair.changed = true;
      }
    });
  }

  // Gives each active pair the first free colour, class by class, and counts the pairs of each. A fixed A may be in many
  // lanes of a block.
  void colour() {
    std::array<bool, 4> any{};
    each(strip.laid, [](ManifoldPair& pair) {
      pair.lane = ManifoldPair::kNone;
      if (pair.idle == ManifoldPair::kIdle) pair.idle = 0;
    });
    const std::size_t all = strip.active.size() + strip.idle.size();
    if (all > strip.laid.capacity()) strip.laid.reserve(all + all / 2);
    strip.laid.clear();
    std::merge(strip.active.begin(), strip.active.end(), strip.idle.begin(), strip.idle.end(),
               std::back_inserter(strip.laid));
    for (auto* list : {&strip.rewrite, &strip.idle, &strip.fresh}) list->reserve(strip.laid.capacity());
    each(strip.laid, [&](const ManifoldPair& pair) { any[class_of(pair, loads)] = true; });
    strip.points = 0;
    Column<std::uint32_t>& used = m.used_;
    for (std::uint32_t k = 0; k < 4; ++k) {
      if (!any[k]) continue;
      const auto each_here = [&](const auto& visit) {
        each(strip.laid, [&](ManifoldPair& pair) {
          if (class_of(pair, loads) == k) visit(pair);
        });
      };
      each_here([&](const ManifoldPair& pair) {
        used[pair.b] = 0;
        if (!pair.fixed_a) used[pair.a] = 0;
      });
      each_here([&](ManifoldPair& pair) {
        const std::uint32_t taken = used[pair.b] | (pair.fixed_a ? 0u : used[pair.a]);
        const auto colour = static_cast<std::uint32_t>(std::countr_one(taken));
        if (colour < kColours) {
          used[pair.b] |= 1u << colour;
          if (!pair.fixed_a) used[pair.a] |= 1u << colour;
        }
        pair.lane = colour;  // the lane itself is known once all colours are
        pair.colour = colour < kColours ? static_cast<std::uint8_t>(k * kColours + colour) : ManifoldPair::kAlone;
        ++lanes[k][colour];
        strip.points += pair.active ? static_cast<std::uint32_t>(pair.manifold.count) : 1;
      });
    }
  }

  // Turns the numbers of pairs into the first lane of each colour. Returns the number of blocks.
  std::uint32_t place_runs() {
    std::uint32_t blocks = 0;
    strip.colours = 0;
    for (std::uint32_t k = 0; k < 4; ++k) {
      for (std::uint32_t colour = 0; colour <= kColours; ++colour) {
        const std::uint32_t n = lanes[k][colour];
        lanes[k][colour] = blocks * kBlock;
        blocks += colour < kColours ? (n + kBlock - 1) / kBlock : n;
        if (n != 0) strip.colours = std::max(strip.colours, colour + 1);
      }
      strip.end[k] = blocks;
    }
    return blocks;
  }

  // A body that is locked along the axis that is nearest to the normal yields to nothing that presses it.
  float inv_mass_along(const BodyProperties& of, const Manifold& at) const {
    if (!params.locks) return of.inv_mass;
    const Locks& locks = b.kinds[of.kind].locks;
    return (std::fabs(at.nx) > std::fabs(at.ny) ? locks.x : locks.y) ? 0.0f : of.inv_mass;
  }

  // What rolls has a round outline: of two, the smaller one.
  void fill_surface(const ManifoldPair& pair, const Sides& sides, float size_a, float size_b) const {
    kernels::SurfaceBlock& s = strip.surfaces[pair.lane / kBlock];
    const std::uint32_t l = pair.lane % kBlock;
    const float round = pair.round_a > 0 && pair.round_b > 0 ? std::min(pair.round_a, pair.round_b)
                                                             : std::max(pair.round_a, pair.round_b);
    s.belt[l] = snapped(sides.belt());
    s.resist[l] = snapped(sides.rolling() * round);
    s.inv_size_a[l] = pair.of_piece() ? 0.0f : 1 / size_a;
    s.inv_size_b[l] = 1 / size_b;
    s.roll[l] = snapped(pair.roll);
  }

  // Writes the numbers of a pair whose hulls were looked at into its lane.
  void fill(ManifoldPair& pair) const {
    ManifoldBlock& c = strip.blocks[pair.lane / kBlock];
    const std::uint32_t l = pair.lane % kBlock;
    const bool fixed = pair.of_piece();
    c.body[2 * l] = fixed ? dummy : pair.a;
    c.body[2 * l + 1] = pair.b;
    Manifold turned;
    float lead[2] = {};
    const bool stands = pair.impulse[0] > 0 && pair.impulse[1] > 0;  // on two points, so that it does not turn
    const bool turns = !stands && m.halfway(pair, static_cast<float>(params.dt), turned, lead);
    const Manifold& at = turns ? turned : std::as_const(pair.manifold);
    c.lead_a[l] = snapped(lead[0]), c.lead_b[l] = snapped(lead[1]);
    c.nx[l] = snapped(at.nx);
    c.ny[l] = snapped(at.ny);
    c.apart[l] = fixed ? 0.0f : at.nx * (at.point[0].ax - at.point[0].bx) + at.ny * (at.point[0].ay - at.point[0].by);
    const float size_a = fixed ? 1.0f : b.radius[pair.a], size_b = b.radius[pair.b];
    fill_points(c, l, pair, at, size_a, size_b);
    static constexpr BodyProperties kWall{};
    const BodyProperties& sa = pair.of_wall() ? kWall : b.properties(pair.id_a);
    const BodyProperties& sb = b.properties(pair.id_b);
    const Sides sides = m.sides_of(pair, sa, sb);
    c.wa[l] = fixed ? 0.0f : inv_mass_along(sa, at);
    c.wb[l] = inv_mass_along(sb, at);
    if (c.wa[l] + c.wb[l] == 0) {  // nothing moves them along the normal, with whatever mass
      c.wa[l] = fixed ? 0.0f : sa.inv_mass;
      c.wb[l] = sb.inv_mass;
    }
    c.ga[l] = fixed ? 0.0f : sa.rim_gain;
    c.gb[l] = sb.rim_gain;
    c.round_a[l] = fixed ? 0.0f : pair.round_a / size_a;
    c.round_b[l] = pair.round_b / size_b;
    if (!strip.surfaces.empty()) fill_surface(pair, sides, size_a, size_b);
    c.mu[l] = sides.friction(m.s_.mixing);
    c.e[l] = sides.restitution(m.s_.mixing);
    const bool loaded = is_loaded(pair, loads);
    set_stiffness(c, l, pair, params, loaded);
    set_reactions(c, l, pair, params.gravity, loaded);
    if (pair.stack != pair.was_stack) pair.balanced = ManifoldPair::kUnbalanced;
    const bool is_balanced =
        pair.balanced == c.soft[l] || (pair.balanced != ManifoldPair::kUnbalanced && !pair.of_sleeper(m.s_.statics));
    if (!is_balanced && !m.cold_) balance(b, pair, c, l);  // of a cold start, the impulses say nothing
    for (int k = 0; k < pair.manifold.count; ++k) c.point[k].gap[l] += pair.offset[k];
    pair.changed = false;
    pair.was_stack = pair.stack;
  }
};

void Manifolds::lay_out(const HeavyLoads& loads, const ManifoldParams& params, std::uint32_t dummies) {
  run_phases(strip_count(), s_.pool, [&](std::size_t index) {
    const std::uint32_t dummy = dummies + 2 * static_cast<std::uint32_t>(index);
    Layout{*this, index, loads, params, dummy, stale_[index], strips_[index]}.run();
    for (const std::uint32_t k : strips_[index].idle) ++pairs_[k].idle;
    strips_[index].others = false;
  });
  laid_ = true;
  attempted_ = false;
  list_turning(static_cast<float>(params.dt));
  totals_ = {};
  for (std::size_t s = 0; s < strip_count(); ++s) {
    const StripBlocks& strip = strips_[s];
    const auto& end = strip.end;
    const std::uint32_t loaded = (end[1] - end[0]) + (end[3] - end[2]);
    totals_.points += strip.points;
    totals_.colours = std::max(totals_.colours, strip.colours);
    totals_.blocks += end[3];
    totals_.loaded |= loaded != 0;
    totals_.pass_blocks += end[3] + std::uint64_t{loaded} * (HeavyLoads::kSweeps - 1);
  }
}

std::uint64_t Manifolds::expected_lanes() const {
  constexpr std::uint64_t kEmpty = 2 * kBlock;  // empty lanes at the ends of the colours of a strip
  std::uint64_t sum = 0;
  for (std::size_t s = 0; s < strip_count(); ++s) {
    const StripBlocks& strip = strips_[s];
    if (!strip.active.empty())
      sum += stale_[s] != 0 ? strip.active.size() + kEmpty : kBlock * std::uint64_t{strip.end[3]};
  }
  return sum;
}

std::uint64_t Manifolds::expected_writes() const {
  std::uint64_t sum = 0;
  for (std::size_t s = 0; s < strip_count(); ++s) {
    sum += stale_[s] != 0 ? strips_[s].active.size() : strips_[s].rewrite.size();
  }
  return sum;
}

Manifolds::Closed Manifolds::closed(std::size_t index) const {
  Closed sum;
  for (const ManifoldBlock& block : strips_[index].blocks) {
    std::uint32_t open = 0, apart = 0;  // an impulse of -0 marks an open contact
    for (std::uint32_t l = 0; l < kBlock; ++l) {
      const std::uint32_t first = std::bit_cast<std::uint32_t>(block.point[0].impulse[l]) >> 31;
      const std::uint32_t second = std::bit_cast<std::uint32_t>(block.point[1].impulse[l]) >> 31;
      open += first + second;
      apart += first & second;
    }
    sum.points += 2 * kBlock - open;
    sum.pairs += kBlock - apart;
  }
  return sum;
}

std::size_t Manifolds::bytes() const {
  std::size_t sum = bytes_of(pairs_, old_pairs_, before_, renewed_, shaped_, counts_, ranges_, fixed_, crowded_,
                             turned_, turning_, known_lane_, stood_, ties) +
                    parts_.bytes() + index_.bytes() + decisions_.bytes();
  for (const StripBlocks& s : strips_)
    sum += bytes_of(s.blocks, s.surfaces, s.active, s.laid, s.rewrite, s.landing, s.open, s.watched, s.idle, s.fresh,
                    s.across) +
           s.lasting.bytes();
  for (const std::vector<FoundPair>& found : found_) sum += bytes_of(found);
  return sum;
}

}  // namespace psim
