// What contacts of shapes are, what contacts of discs count, and what events compare the next step with.
#include "contacts/contact_store.h"
#include "contacts/solver_bodies.h"
#include "lists/heavy_loads.h"
#include "manifolds/manifolds.h"
#include "query/events.h"
#include "solver/continuous.h"
#include "solver/solver.h"
#include "state/describe.h"

namespace psim {

// Their impulses are saved by pair (saved_contacts.h).
template <class A>
void ContactStore::describe(A& a) {
  numbers(a, model_.model, model_.bounce, pair_blocks_, static_blocks_, colours_, pair_count_, static_count_,
          loaded_blocks_, builds_);
}

template <class A>
void SolverBodies::describe(A& a) {
  numbers(a, count_, compact_);
}
template <class A>
void Solver::describe(A& a) {
  numbers(a, closed_, sweeps_);
}
template <class A>
void HeavyLoads::describe(A& a) {
  a.value(visits_);
}
template <class A>
void Continuous::describe(A& a) {
  a.value(looked_);
}

template <class A>
void ManifoldPair::describe(A& a) {
  numbers(a, this->a, b, shape, id_a, id_b, owner, part_a, part_b, fixed_a, lane);
  numbers(a, manifold.nx, manifold.ny, manifold.count);
  for (ManifoldPoint& q : manifold.point) numbers(a, q.ax, q.ay, q.bx, q.by, q.gap, q.feature);
  numbers(a, base.x, base.y, base.dx, base.dy, turn_a.c, turn_a.s, turn_b.c, turn_b.s, margin);
  for (int k = 0; k < 2; ++k) numbers(a, gap[k], impulse[k], friction[k], offset[k]);
  numbers(a, round_a, round_b, active, ahead, ghost, moved, lasting, changed, stack, was_stack, rest_frames, recalled,
          colour, balanced);
  a.require(manifold.count >= 0 && manifold.count <= 2 && recalled <= 2 && (this->a == kNone) == (shape != kNone));
  a.require(colour < 4 * kColours || colour == kAlone);
}

template <class A>
void Manifolds::describe(A& a, const ManifoldsAround& around) {
  a.list(pairs_, [&](ManifoldPair& p) { p.describe(a); });
  a.packed(begin_);
  a.list(strips_, [&](StripBlocks& s) {
    a.plain(s.blocks);
    a.packed(s.active);
    a.packed(s.laid);
    for (std::uint32_t& end : s.end) a.value(end);
    numbers(a, s.colours, s.points);
  });
  a.packed(ghosts_);
  a.packed(special_);
  a.packed(stale_);
  a.packed(shaped_, around.present ? around.slots : kAnyNumber);
  bool kinds = around.slots != 0 && kind_.capacity() >= around.slots;
  a.value(kinds);
  if (kinds) {
    if constexpr (A::kLoading) kind_.reserve(around.slots);
    a.packed(
        around.slots, [&](std::size_t k) -> auto& { return kind_[k]; });
  }
  numbers(a, points_, g_, any_filter_, loaded_, colours_, blocks_, pass_blocks_, laid_, looks_, new_pairs_);
  if constexpr (!A::kLoading) return;
  if (!kinds) kind_.release();
  for (const ManifoldPair& p : pairs_) check_pair(a, p, around);
  a.require(begin_.size() <= strips_.size() + 1);
  a.require(std::is_sorted(begin_.begin(), begin_.end()));
  a.require(!around.exact || (begin_.empty() ? pairs_.empty() : begin_.front() == 0 && begin_.back() == pairs_.size()));
  std::uint64_t points = 0;
  for (std::size_t k = 0; k < strips_.size() && a.ok(); ++k) {
    check_strip(a, k, around);
    points += strips_[k].points;
  }
  a.require(points_ == 0 || (points_ <= points && around.wanted));
  for (const std::uint64_t ghost : ghosts_) a.require(ghost >> 32 < around.slots || !around.present);
  if (a.ok()) complete(around.slots);
}

template <class A>
void Manifolds::check_pair(A& a, const ManifoldPair& p, const ManifoldsAround& around) const {
  const BodyStore& b = around.bodies;
  const auto of = [&](std::uint32_t slot, std::uint32_t id, std::uint32_t part) {
    a.require(id < b.id_count);
    if (!a.ok()) return;
    a.require(b.info[id].place != Place::none && part < std::max(b.kind(id).hull_count, 1u));
    if (around.present && around.in_place) a.require(slot < around.slots && b.id[slot] == id);
  };
  const bool fixed = p.a == PairName::kNone, wall = p.shape >= kWallLeft;
  a.require(p.owner < b.id_count && p.id_b < b.id_count && (p.id_a < b.id_count || p.id_a == PairName::kNone));
  if (around.present || around.carried) a.require(p.b < around.numbered && (fixed || p.a < around.numbered));
  if (fixed) a.require(wall ? p.shape <= kWallTop : p.shape < around.statics.size());
  if (!a.ok() || !around.present) return;
  of(p.b, p.id_b, p.part_b);
  if (!fixed) return of(p.a, p.id_a, p.part_a);
  a.require(p.fixed_a);
  if (!wall) a.require(around.statics[p.shape].alive && around.statics[p.shape].owner == p.id_a);
}

// Lists of pairs that are gone, or not looked at yet, are made anew before anyone reads them.
template <class A>
void Manifolds::check_strip(A& a, std::size_t index, const ManifoldsAround& around) const {
  const StripBlocks& s = strips_[index];
  const auto blocks = static_cast<std::uint32_t>(s.blocks.size());
  a.require(std::is_sorted(std::begin(s.end), std::end(s.end)) && s.end[3] <= blocks);
  if (around.spread && !around.lists) return;
  if (index + 1 < begin_.size()) {
    const std::uint32_t begin = begin_[index];
    const std::uint32_t end = std::min(begin_[index + 1], static_cast<std::uint32_t>(pairs_.size()));
    for (const auto* list : {&s.active, &s.laid}) {
      if ((!around.fresh && !laid_) || (around.spread && list == &s.active)) continue;
      a.require(std::all_of(list->begin(), list->end(),
                            [&](std::uint32_t k) { return k >= begin && (k < end || around.spread); }));
    }
    for (std::uint32_t k = begin; k < end; ++k) {
      const std::uint32_t lane = pairs_[k].lane;
      a.require(lane == PairName::kNone || lane / kernels::kBlock < blocks ||
                ((around.spread || !around.fresh) && !laid_));
    }
  }
  if (!around.fresh) return;
  const std::size_t bodies = kernels::round_up_block(around.slots) + 2 * strip_count();  // two that rest a strip
  for (const kernels::ManifoldBlock& block : s.blocks) {
    for (const std::uint32_t body : block.body) a.require(body < bodies);
  }
}

// What follows from the pairs that were read.
void Manifolds::complete(std::size_t slots) {
  old_pairs_.clear();
  both_ = collecting_ = false;
  indexed_ = false;
  own_end_ = std::min(own_end_, static_cast<std::uint32_t>(pairs_.size()));
  cut();
  owner_.resize(pairs_.size());
  for (std::size_t k = 0; k < pairs_.size(); ++k) owner_[k] = pairs_[k].owner;
  rotor_.reserve(2 * slots);
  inner_.reserve(slots);
  used_.reserve(slots);
}

template <class A>
void EventList::describe(A& a, std::uint32_t ids) {
  numbers(a, options_.contacts, options_.hits, options_.hit_speed, options_.sensors, left_, build_);
  a.list(removed_, [&](BodyId& id) {
    a.index(ids, id.index);
    a.value(id.generation);
  });
  a.packed(touching_);
  for (Keys* keys : {&lane_key_, &paired_, &toggled_, &rest_found_, &rest_, &slept_, &sensed_}) {
    a.packed(*keys);
    if constexpr (A::kLoading) {
      for (const std::uint64_t key : *keys) {
        const bool known = key >> 32 < ids && static_cast<std::uint32_t>(key) < ids;
        a.require(known || (keys == &lane_key_ && key == ~std::uint64_t{0}));
      }
    }
  }
  if constexpr (!A::kLoading) return;
  a.require(lane_key_.size() == touching_.size() * kernels::kBlock);
  for (const Keys* keys : {&paired_, &rest_, &slept_}) a.require(std::is_sorted(keys->begin(), keys->end()));
  clear();
}

PSIM_DESCRIBED(Manifolds, const ManifoldsAround&);
PSIM_DESCRIBED(EventList, std::uint32_t);
template void ContactStore::describe(Saver&);
template void ContactStore::describe(Loader&);
template void SolverBodies::describe(Saver&);
template void SolverBodies::describe(Loader&);
template void Solver::describe(Saver&);
template void Solver::describe(Loader&);
template void HeavyLoads::describe(Saver&);
template void HeavyLoads::describe(Loader&);
template void Continuous::describe(Saver&);
template void Continuous::describe(Loader&);

}  // namespace psim
