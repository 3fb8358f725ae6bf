// What a step makes of all manifolds: strip by strip the pairs are looked at (manifold_look.cpp), and those that are
// contacts go on to the layout.
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "base/rotor.h"
#include "base/sort_keys.h"
#include "base/tasks.h"
#include "manifolds/manifold_look.h"

namespace psim {

// Whether continuous collision looks at a pair, however slow its bodies are, so that nothing presses them through each
// other: contacts with kinematic bodies, contacts that are deep, and segments near the middle of a hull, whether or not
// they are contacts. Shares of the inner radius.
static bool is_watched(const Surroundings& s, const ManifoldPair& pair) {
  constexpr float kBeside = 0.6f;
  if (!pair.fixed_a || pair.moved || pair.of_wall()) return false;
  if (!pair.of_piece()) return pair.active;
  const BodyKind& kind = s.bodies.kind(pair.id_b);
  if (pair.crossing == ManifoldPair::kPasses) return false;
  const float inner = kind.hull_count != 0 ? kind.inner : s.bodies.radius[pair.b];
  if (pair.active && pair.least_gap() < -kDeep * inner) return true;
  const StaticShape& piece = s.statics[pair.shape];
  if (!piece.segment || piece.asleep) return false;
  const Vec2 middle =
      kind.hull_count > 1 ? s.bodies.hulls[kind.first_hull + pair.part_b].middle_at(s.bodies.angle[pair.b]) : Vec2{};
  const Vec2 u = s.lattice.steps(piece.p, piece.q), at = s.lattice.steps(piece.p, s.bodies.point(pair.b)) + middle;
  const double size = double{piece.radius} + kBeside * inner, uu = dot(u, u), off = cross(u, at), along = dot(u, at);
  return off * off < size * size * uu && along > -size * std::sqrt(uu) && along < uu + size * std::sqrt(uu);
}

// A body that comes upon fixed or kinematic geometry faster than kFlying times its inner radius in a step meets it in
// continuous collision alone, at the time and in the pose of the impact: it may turn far until then, and bounce on. One
// that meets geometry that does not turn and is not too fast does so in the impact sweeps of the substeps, which know
// gravity and whom else it meets.
static bool flies(const BodyStore& b, const ManifoldParams& params, const ManifoldPair& pair, float inner) {
  const std::size_t i = pair.b, a = pair.a;
  const Manifold& m = pair.manifold;
  float x = b.vel[2 * i], y = b.vel[2 * i + 1], turn = b.rim_speed[i] / b.radius[i];
  float spin = 0;
  if (!pair.of_piece()) {  // as seen from A, which turns
    spin = b.rim_speed[a] / b.radius[a];
    const float rx = m.point[0].ax - m.point[0].bx, ry = m.point[0].ay - m.point[0].by;  // from A's centre to B's
    x -= b.vel[2 * a] - spin * ry;
    y -= b.vel[2 * a + 1] + spin * rx;
    turn -= spin;
  }
  const float swing = std::fabs(turn) * (b.radius[i] - pair.round_b), dt = static_cast<float>(params.dt);
  if (!(dt * (swing - (m.nx * x + m.ny * y)) > kFlying * inner)) return false;
  return spin != 0 || dt * std::sqrt(x * x + y * y) > kMostSizes * b.radius[i];
}

// Notes whether a pair is a contact now and was one in the last step. One that is none any more keeps its lane for a while,
// open. Returns whether other pairs must get lanes.
bool Manifolds::note_contact(StripBlocks& strip, std::uint32_t k, bool laid) {
  ManifoldPair& pair = pairs_[k];
  const bool lies = pair.lane != PairName::kNone;
  if (pair.active) {
    if (!lies || pair.idle != 0) strip.fresh.push_back(k);
    pair.idle = 0;
    return !lies;
  }
  if (pair.moved) return lies;
  if (!lies && !pair.is_idle()) {
    pair.idle = 0;
    return false;
  }
  const bool opens = pair.idle == 0;
  strip.others |= opens;
  if (opens) pair.idle = 1;
  if (opens && laid) {
    if (known_lane_[k] != PairName::kNone) strip.lasting.forget(std::exchange(known_lane_[k], PairName::kNone));
    const std::size_t block = pair.lane / kernels::kBlock;
    if (block < strip.blocks.size()) open_lane(strip.blocks[block], pair.lane % kernels::kBlock);
    pair.changed = true;
  }
  if (!pair.is_idle()) return true;  // long enough
  strip.idle.push_back(k);
  return false;
}

// Runs once all pairs of a strip were looked at.
void Manifolds::finish_strip(const ManifoldParams& params, std::size_t index) {
  StripBlocks& strip = strips_[index];
  if (!any_kinematic_) see_ground(params, index);
  const bool laid = stale_[index] == 0;
  bool stale = !laid;
  strip.active.clear();
  strip.rewrite.clear();
  strip.watched.clear();
  strip.landing.clear();
  strip.open.clear();
  strip.idle.clear();
  strip.fresh.clear();
  strip.others |= stale;
  for (std::uint32_t k = begin_[index]; k < begin_[index + 1]; ++k) {
    if (steady_lane(strip, k) != PairName::kNone) {
      strip.active.push_back(k);
      continue;
    }
    ManifoldPair& pair = pairs_[k];
    pair.flying = pair.active && pair.fixed_a && flies(s_.bodies, params, pair, inner_of(pair.b));
    if (pair.flying) pair.active = false;
    stale |= note_contact(strip, k, laid);
    if (pair.flying || is_watched(s_, pair)) strip.watched.push_back(k);
    if (!pair.active) continue;
    strip.active.push_back(k);
    if (pair.landing) strip.landing.push_back(k);
    if (pair.rocking) strip.open.push_back(k);
    if (!laid) continue;
    if (!pair.changed && pair.lane / kernels::kBlock < strip.blocks.size()) {
      kernels::ManifoldBlock& c = strip.blocks[pair.lane / kernels::kBlock];
      const std::uint32_t l = pair.lane % kernels::kBlock;
      for (int p = 0; p < pair.manifold.count; ++p) c.point[p].gap[l] = pair.gap[p] + pair.offset[p];
    }
    if (pair.changed || pair.was_stack != ManifoldPair::kNoStack) strip.rewrite.push_back(k);
  }
  strip.across.reserve(strip.active.capacity());
  stale_[index] = stale;
  strip.others |= stale || !strip.fresh.empty();
  if (!stale) {
    if (++strip.lasting.calm > SteadyLanes::kCalm) note_steady(index);
    return;
  }
  catch_up(index);
  forget_steady(index);
  if (!any_kinematic_) order_by_approach(index);
}

// Of the fixed pieces that a body meets, those come last that it approaches most: whatever the order in which the ground
// is listed, the sweeps go the same way. The pairs of a body swap their places in the list of active ones.
void Manifolds::order_by_approach(std::size_t index) {
  std::vector<std::uint32_t>& active = strips_[index].active;
  const auto of_ground = [&](std::uint32_t k) {
    return pairs_[k].fixed_a && !pairs_[k].of_wall() && !pairs_[k].of_sleeper(s_.statics);
  };
  const auto approach = [&](std::uint32_t k) {
    const ManifoldPair& pair = pairs_[k];
    const Vec2 v = s_.bodies.velocity(pair.b) - (pair.of_piece() ? Vec2{} : s_.bodies.velocity(pair.a));
    return -(pair.manifold.nx * static_cast<float>(v.x) + pair.manifold.ny * static_cast<float>(v.y));
  };
  const auto less = [&](std::uint32_t a, std::uint32_t b) {  // a total order: no index occurs twice
    const float of_a = approach(a), of_b = approach(b);
    return of_a != of_b ? of_a < of_b : a < b;
  };
  if (any_kinematic_) return order_scattered(active, of_ground, less);
  for (const auto& [first, last] : pieces_of(index)) {
    auto k = std::ranges::lower_bound(active, first);
    const auto behind = std::ranges::lower_bound(active, last);
    while (k != behind) {
      const std::uint32_t body = pairs_[*k].b;
      const bool ground = of_ground(*k);
      auto end = k + 1;
      while (ground && end != behind && pairs_[*end].b == body && of_ground(*end)) ++end;
      std::sort(k, end, less);  // Total order: as above.
      k = end;
    }
  }
}

// The same where some pieces are kinematic, so that those of a body lie anywhere in the list.
void Manifolds::order_scattered(std::vector<std::uint32_t>& active, const auto& of_ground, const auto& less) {
  const auto each_ground = [&](const auto& each) {
    for (std::uint32_t at = 0; at < active.size(); ++at) {
      if (of_ground(active[at])) each(at, pairs_[active[at]].b);
    }
  };
  each_ground([&](std::uint32_t, std::uint32_t body) { used_[body] = 0; });
  each_ground([&](std::uint32_t, std::uint32_t body) { ++used_[body]; });
  crowded_.clear();
  each_ground([&](std::uint32_t at, std::uint32_t body) {
    if (used_[body] > 1) crowded_.push_back(std::uint64_t{body} << 32 | at);
  });
  sort_keys(crowded_.begin(), crowded_.end());
  for (auto first = crowded_.begin(); first != crowded_.end();) {
    const auto end = first + used_[*first >> 32];
    turned_.clear();
    for (auto place = first; place != end; ++place) turned_.push_back(active[static_cast<std::uint32_t>(*place)]);
    std::sort(turned_.begin(), turned_.end(), less);  // Total order: as above.
    for (const std::uint32_t k : turned_) active[static_cast<std::uint32_t>(*first++)] = k;
  }
}

// Finds how bodies that are not discs lie now, and their inner radii.
void Manifolds::turn_shapes() {
  constexpr float kThin = 0.2f;          // the inner radius counts as at least this share of the reach
  constexpr std::size_t kBodies = 1024;  // a job
  run_each(shaped_.size(), kBodies, s_.pool, [&](std::size_t n, std::size_t) {
    const std::size_t i = shaped_[n];
    const Rotor q = rotor_of(s_.bodies.angle[i]);
    rotor_[2 * i] = q.c;
    rotor_[2 * i + 1] = q.s;
    inner_[i] = std::max(kThin * s_.bodies.radius[i], s_.bodies.kind(s_.bodies.id[i]).inner);
  });
}

void Manifolds::refresh(const ManifoldParams& params, std::size_t begin, std::size_t end) {
  const bool decides = params.asking || !decisions_.empty();
  if (begin == 0) {
    if (std::exchange(attempted_, true)) stood_known_ = false;  // the last step was given up
    known_lane_.resize(pairs_.size(), PairName::kNone);         // there is room
    g_ = kernels::snapped(length_of(params.gravity));
    if (!fixed_known_) {
      any_kinematic_ = std::ranges::any_of(pairs_, &PairName::of_kinematic);
      list_fixed([&](const auto& each) {
        for (std::uint32_t k = 0; k < pairs_.size(); ++k) each(pairs_[k], k);
      });
    }
    turn_shapes();
    look_in_lanes(params, !both_ && !params.surfaces && !decides);
  }
  const auto last_of_strip = [&](const Cut& c) { return c.end == begin_[c.strip + 1]; };
  const bool at_end = any_kinematic_ || decides;  // strips are finished once all pairs were looked at
  const auto whole = [&](const Cut& c) { return !at_end && c.begin == begin_[c.strip] && last_of_strip(c); };
  s_.pool.run(end - begin, [&](std::size_t n) {
    Cut& c = cuts_[begin + n];
    c.looks = look(params, c);
    if (whole(c)) finish_strip(params, c.strip);
  });
  if (at_end && end == cuts_.size()) {
    if (decides) ask(*params.pre_solve);
    if (any_kinematic_) see_all_ground(params);
    s_.pool.run(strip_count(), [&](std::size_t index) { finish_strip(params, index); });
    for (std::size_t index = 0; index < strip_count() && any_kinematic_; ++index) {
      if (stale_[index] != 0) order_by_approach(index);
    }
  }
  if (!at_end) {
    s_.pool.run(end - begin, [&](std::size_t n) {
      const Cut& c = cuts_[begin + n];
      if (last_of_strip(c) && !whole(c)) finish_strip(params, c.strip);
    });
  }
  if (end != cuts_.size()) return;
  new_pairs_ = 0;
  looks_ = {};
  for (const Cut& c : cuts_) looks_ += c.looks;
}

}  // namespace psim
