// Contacts of shapes, joints, and who sleeps.
#include "image_check.h"

namespace psim {

template <class W>
void Image::Check<W>::manifolds() {
  const Manifolds& m = w.manifolds;
  const std::size_t strips = m.strips_.size(), pairs = m.pairs_.size();
  // While work is spread over frames these are of several steps, and are made anew before anyone reads them.
  const bool spread = w.ahead.built || w.ahead.part != Part::check;
  const bool exact = !spread && !w.lists_stale;
  require(!exact || (m.begin_.empty() ? pairs == 0 : m.begin_.front() == 0 && m.begin_.back() == pairs));
  require(m.begin_.size() <= strips + 1);
  require(std::is_sorted(m.begin_.begin(), m.begin_.end()));
  const bool present = !w.lists_stale && w.plan.shapes;
  for (const U32 slot : m.shaped_) require(slot < slots() || !present);
  many_ask(pairs);
  const U32 bodies = stands() ? slots() : std::max(slots(), w.table.body_count);
  const auto of = [&](U32 slot, U32 id, U32 part) {
    require(is_body(id));
    if (!ok()) return;
    require(part < std::max(make_of(id).hull_count, 1u));
    if (present && w.bodies.dead == 0 && w.doubtful.empty()) require(slot < slots() && slot_ids[slot] == id);
  };
  for (const ManifoldPair& p : m.pairs_) {
    require(p.owner < ids() && p.manifold.count >= 0 && p.manifold.count <= 2);
    require((p.a == PairName::kNone) == (p.shape != PairName::kNone) && p.recalled <= 2);
    require(p.colour < 4 * ManifoldPair::kColours || p.colour == ManifoldPair::kAlone);
    if (present || w.impulses_valid) require(p.b < bodies && (p.a == PairName::kNone || p.a < bodies));
    if (p.a == PairName::kNone) require(is_shape(p.shape));
    if (!ok()) return;
    if (present) {
      of(p.b, p.id_b, p.part_b);
      if (p.a != PairName::kNone) of(p.a, p.id_a, p.part_a);
      if (p.a == PairName::kNone) fixed_side(p);
    }
    require(p.id_b < ids() && (p.id_a < ids() || p.id_a == PairName::kNone));
  }
  std::uint64_t points = 0;
  for (std::size_t k = 0; k < strips && ok(); ++k) {
    if (!spread || lists) strip(k, spread);
    points += m.strips_[k].points;
  }
  require(m.points_ == 0 || (m.points_ <= points && w.plan.shapes));
  for (const std::uint64_t ghost : m.ghosts_) require(ghost >> 32 < slots() || !present);
}

template <class W>
void Image::Check<W>::fixed_side(const PairName& p) {
  require(p.fixed_a);
  if (p.shape < kWallLeft) require(shape(p.shape).alive && shape(p.shape).owner == p.id_a);
}

// Those behind the last strip that has pairs are of lists of before: cleared before anyone reads them.
template <class W>
void Image::Check<W>::strip(std::size_t index, bool spread) {
  const Manifolds& m = w.manifolds;
  const Manifolds::StripBlocks& s = m.strips_[index];
  const auto blocks = static_cast<U32>(s.blocks.size());
  require(std::is_sorted(std::begin(s.end), std::end(s.end)) && s.end[3] <= blocks);
  if (index + 1 < m.begin_.size()) {
    const U32 begin = m.begin_[index], end = std::min(m.begin_[index + 1], static_cast<U32>(m.pairs_.size()));
    for (const auto* list : {&s.active, &s.laid}) {
      // Of pairs that are gone, or not looked at yet: made anew before anyone reads it.
      if ((w.lists_stale && !m.laid_) || (spread && list == &s.active)) continue;
      require(std::all_of(list->begin(), list->end(), [&](U32 k) { return k >= begin && (k < end || spread); }));
    }
    for (U32 k = begin; k < end; ++k) {
      const U32 lane = m.pairs_[k].lane;
      require(lane == PairName::kNone || lane / kernels::kBlock < blocks || ((spread || w.lists_stale) && !m.laid_));
    }
  }
  if (w.lists_stale) return;
  const std::size_t bodies = kernels::round_up_block(slots()) + 2 * m.strip_count();  // two that rest a strip
  for (const kernels::ManifoldBlock& block : s.blocks) {
    for (const U32 body : block.body) require(body < bodies);
  }
}

template <class W>
void Image::Check<W>::joints() {
  const JointStore& j = w.joints;
  const std::size_t all = j.joints_.size();
  std::size_t alive = 0;
  many_ask(all);
  for (std::size_t k = 0; k < all && ok(); ++k) joint(k, alive);
  require(alive == j.count_);
  free_list(j.free_, all, 0, [&](std::size_t k) { return !j.joints_[k].alive; });
  require(j.first_.size() <= ids());
  chains(alive);
  require(std::is_sorted(j.bodies_.begin(), j.bodies_.end()) && (j.bodies_.empty() || j.bodies_.back() < ids()));
  if (!ok()) return;
  std::size_t used = 0;
  std::uint64_t total = 0;
  for (U32 list = 0; list < JointStore::kLists; ++list) {
    const std::vector<U32>& lanes = j.lanes_[list];
    JointLists::visit(j.lists_, list, [&](const auto& blocks) {
      require(lanes.size() == blocks.size() * kernels::kBlock);
      total += blocks.size();
    });
    for (U32 lane = 0; lane < lanes.size(); ++lane) {
      const U32 k = lanes[lane];
      if (k == kNoSlot) continue;
      require(k < all && j.joints_[k].alive && j.joints_[k].list == list && j.joints_[k].lane == lane);
      ++used;
    }
  }
  for (const auto& r : j.ranges_) {
    require(r.list < JointStore::kLists && r.begin <= r.end);
    if (ok()) require(std::size_t{r.end} * kernels::kBlock <= j.lanes_[r.list].size());
  }
  for (const auto& r : j.jobs_) require(r.begin <= r.end && r.end <= j.ranges_.size());
  for (const auto& r : j.phases_) require(r.begin <= r.end && r.end <= j.jobs_.size());
  require(j.stale_ || total == j.total_blocks_);
  require(j.total_blocks_ <= total);
}

template <class W>
void Image::Check<W>::joint(std::size_t k, std::size_t& alive) {
  const JointStore& j = w.joints;
  const JointStore::Joint& x = j.joints_[k];
  if (!x.alive) return;
  ++alive;
  const AlikeBodies *one = run_of(x.desc.a.index), *two = run_of(x.desc.b.index);
  require(one != nullptr && two != nullptr && x.desc.a.index != x.desc.b.index && x.desc.length && x.desc.reference);
  if (!ok()) return;
  for (const AlikeBodies* run : {one, two}) {
    require(run->place == Place::moving || run->place == Place::asleep || run->place == Place::fixed);
  }
  require(one->generation == x.desc.a.generation && two->generation == x.desc.b.generation);
  if (!ok()) return;
  const bool dynamic[2] = {w.bodies.surfaces[one->surface].inv_mass > 0, w.bodies.surfaces[two->surface].inv_mass > 0};
  require((dynamic[0] || dynamic[1]) && x.swapped == !dynamic[1]);
  require(x.list == JointLists::list_of(x.kind, !dynamic[0] || !dynamic[1]));
  if (!ok()) return;
  if (x.lane != kNoSlot) {
    require(x.lane < j.lanes_[x.list].size());
    if (ok()) require(j.lanes_[x.list][x.lane] == k);
    const bool members = j.stale_ || j.bodies_stale_ || (x.body[0] < j.bodies_.size() && x.body[1] < j.bodies_.size());
    require(members);
    if (ok() && !j.stale_ && !j.bodies_stale_) {
      require(j.bodies_[x.body[0]] == (x.swapped ? x.desc.b.index : x.desc.a.index) &&
              j.bodies_[x.body[1]] == (x.swapped ? x.desc.a.index : x.desc.b.index));
    }
  } else {
    require(j.stale_ || x.dormant);
  }
}
// Each joint is in the lists of both its bodies, once.
template <class W>
void Image::Check<W>::chains(std::size_t alive) {
  const JointStore& j = w.joints;
  std::size_t found = 0;
  for (U32 id = 0; id < j.first_.size(); ++id) {
    for (U32 k = j.first_[id]; k != kNoSlot && ok();) {
      require(k < j.joints_.size() && ++found <= 2 * alive);
      if (!ok()) return;
      const JointStore::Joint& x = j.joints_[k];
      require(x.alive && (x.desc.a.index == id || x.desc.b.index == id));
      k = x.next[x.desc.a.index == id ? 0 : 1];
    }
  }
  require(found == 2 * alive);
}

template <class W>
void Image::Check<W>::sleepers() {
  const Sleepers& s = w.sleepers;
  const bool known = s.watching_ || w.bodies.asleep != 0;
  require(s.seen_.rests == 0 || (known && s.seen_.rests == ids() - w.bodies.asleep));
  const auto sound = [&](const std::vector<Touch>& touches) {
    return std::all_of(touches.begin(), touches.end(), [&](const Touch& t) {
      return t.first() < ids() && t.points <= 2 && (t.of_fixed() || t.second() < ids());
    });
  };
  require(sound(s.recent.list_));
  if (as_before) return;
  require(sound(s.touches));
  for (const Sleeper& x : s.list) {
    require(x.touches <= s.touches.size() && x.first_touch <= s.touches.size() - x.touches);
    require(x.shapes <= w.shapes.count_ && x.first_shape <= w.shapes.count_ - x.shapes);
    for (U32 k = x.first_shape; ok() && k < x.first_shape + x.shapes; ++k) {
      require(w.shapes.shapes_[k].alive && w.shapes.shapes_[k].asleep && w.shapes.shapes_[k].owner == x.id);
    }
    require(x.shapes != 0);
  }
  std::size_t pieces = 0, asleep = 0;
  for (const Sleeper& x : s.list) pieces += x.shapes;
  for (U32 k = 0; k < w.shapes.count_; ++k) asleep += w.shapes.shapes_[k].alive && w.shapes.shapes_[k].asleep ? 1 : 0;
  require(pieces == asleep);
}

template void Image::Check<World::Impl>::manifolds();
template void Image::Check<World::Impl>::fixed_side(const PairName&);
template void Image::Check<World::Impl>::strip(std::size_t, bool);
template void Image::Check<World::Impl>::joints();
template void Image::Check<World::Impl>::joint(std::size_t, std::size_t&);
template void Image::Check<World::Impl>::chains(std::size_t);
template void Image::Check<World::Impl>::sleepers();

}  // namespace psim
