#include "query/events.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <iterator>

#include "base/sort_keys.h"
#include "base/tasks.h"

namespace psim {
namespace {

using kernels::kBlock;

constexpr std::uint64_t kNoKey = ~std::uint64_t{0};

std::uint64_t key_of(std::uint32_t a, std::uint32_t b) {
  return a < b ? std::uint64_t{a} << 32 | b : std::uint64_t{b} << 32 | a;
}
std::uint32_t first_of(std::uint64_t key) { return static_cast<std::uint32_t>(key >> 32); }
std::uint32_t second_of(std::uint64_t key) { return static_cast<std::uint32_t>(key); }

// A bit for each closed contact of a block. An impulse of -0 marks an open one.
unsigned closed_bits(const float* impulse) {
  unsigned open = 0;
  for (std::size_t l = 0; l < kBlock; ++l) {
    open |= (std::bit_cast<std::uint32_t>(impulse[l]) >> 31) << l;
  }
  return ~open & 0xFFu;
}

// The keys that are in one sorted list and not in the other.
void differences(const std::vector<std::uint64_t>& before, const std::vector<std::uint64_t>& now,
                 std::vector<std::uint64_t>& began, std::vector<std::uint64_t>& ended) {
  std::size_t i = 0, j = 0;
  while (i < before.size() && j < now.size()) {
    if (before[i] == now[j]) {
      ++i, ++j;
    } else if (before[i] < now[j]) {
      ended.push_back(before[i++]);
    } else {
      began.push_back(now[j++]);
    }
  }
  ended.insert(ended.end(), before.begin() + static_cast<std::ptrdiff_t>(i), before.end());
  began.insert(began.end(), now.begin() + static_cast<std::ptrdiff_t>(j), now.end());
}

bool dynamic(const BodyStore& b, std::uint32_t id) { return b.properties(id).type == BodyType::dynamic_body; }

}  // namespace

void EventList::set_options(const EventOptions& options) {
  options_ = options;
  clear();
  if (!options.contacts) {
    build_ = 0;
    for (Keys* keys : {&lane_key_, &rest_found_, &rest_, &slept_, &paired_, &toggled_}) *keys = {};
    touching_ = {};
  }
  if (!options.sensors) sensed_ = {};
  if (!options.hits) {
    candidates_ = {};
    found_ = {};
  }
  if (!on()) {
    for (Keys* keys : {&before_, &now_, &began_, &ended_, &scratch_}) *keys = {};
    count_ = {};
    removed_ = {};
  }
}

void EventList::clear() {
  begin_.clear();
  end_.clear();
  hits_.clear();
  sensor_begin_.clear();
  sensor_end_.clear();
}

void EventList::body_left(BodyId id, bool same) {
  left_ = true;
  if (!same) removed_.push_back(id);
}

void EventList::sort(Keys& keys, std::uint32_t ids) {
  sort_by_first(keys, scratch_, count_, ids, first_of, std::less<>());
}

// Pairs of removed bodies have ended, even if other bodies have their ids now.
void EventList::retire(Keys& before, Keys& ended) const {
  if (removed_.empty()) return;
  const auto gone = [&](std::uint64_t key) {
    return std::any_of(removed_.begin(), removed_.end(),
                       [&](BodyId id) { return id.index == first_of(key) || id.index == second_of(key); });
  };
  const auto at = std::stable_partition(before.begin(), before.end(), [&](std::uint64_t key) { return !gone(key); });
  ended.insert(ended.end(), at, before.end());
  before.erase(at, before.end());
}

BodyId EventList::handle(const Observed& world, std::uint32_t id, bool gone) const {
  if (gone) {
    for (const BodyId& removed : removed_) {
      if (removed.index == id) return removed;
    }
  }
  return {id, world.bodies.info[id].generation};
}

void EventList::tell(const Observed& world, Keys& keys, bool gone, std::vector<TouchEvent>& out) const {
  sort_keys(keys.begin(), keys.end());
  out.clear();
  for (const std::uint64_t key : keys) {
    out.push_back({handle(world, first_of(key), gone), handle(world, second_of(key), gone)});
  }
}

// Notes the ids of the bodies in each lane.
void EventList::name_lanes(const Observed& world) {
  const BodyStore& b = world.bodies;
  const ContactStore& c = world.contacts.discs;
  const SolverBodies& solved = world.contacts.solved;
  const bool kinematic = world.any_kinematic();
  const auto blocks = static_cast<std::uint32_t>(touching_.size());
  world.pool.run(stream_tasks(blocks), [&](std::size_t t) {
    const BlockRange r = stream_range(t, blocks);
    for (std::size_t l = std::size_t{r.begin} * kBlock; l < std::size_t{r.end} * kBlock; ++l) {
      lane_key_[l] = kNoKey;
      if (c.body[2 * l] >= solved.dummies()) continue;
      const std::uint32_t i = b.id[solved.slot(c.body[2 * l])];
      const std::uint32_t j = b.id[solved.slot(c.body[2 * l + 1])];
      if (i == kNoSlot || j == kNoSlot) continue;  // a body left in this step
      if (kinematic && !dynamic(b, i) && !dynamic(b, j)) continue;
      lane_key_[l] = key_of(i, j);
    }
    for (std::size_t k = r.begin; k < r.end; ++k) {
      touching_[k] = static_cast<std::uint8_t>(closed_bits(c.impulse.data() + k * kBlock));
    }
  });
}

void EventList::compare_pairs(const Observed& world) {
  const ContactStore& c = world.contacts.discs;
  const bool stepped = world.bodies.awake() != 0;
  const std::uint32_t blocks = stepped ? c.pair_blocks() : 0;
  if (stepped && build_ == c.builds() && !left_ && touching_.size() == blocks) {
    for (std::size_t k = 0; k < blocks; ++k) {
      const unsigned closed = closed_bits(c.impulse.data() + k * kBlock);
      unsigned changed = closed ^ touching_[k];
      if (changed == 0) continue;
      touching_[k] = static_cast<std::uint8_t>(closed);
      for (std::size_t l = k * kBlock; changed != 0; changed >>= 1, ++l) {
        if ((changed & 1) == 0 || lane_key_[l] == kNoKey) continue;
        (((closed >> (l % kBlock)) & 1) != 0 ? began_ : ended_).push_back(lane_key_[l]);
        toggled_.push_back(lane_key_[l]);
      }
    }
    return;
  }
  // The pairs that touched before: those at the time when the lanes were made, changed by each pair that toggled an odd
  // number of times.
  sort_keys(toggled_.begin(), toggled_.end());
  scratch_.clear();
  for (std::size_t k = 0; k < toggled_.size(); ++k) {
    if (!scratch_.empty() && scratch_.back() == toggled_[k]) {
      scratch_.pop_back();
    } else {
      scratch_.push_back(toggled_[k]);
    }
  }
  toggled_.clear();
  before_.clear();
  if (scratch_.empty()) {
    before_.swap(paired_);
  } else {
    std::set_symmetric_difference(paired_.begin(), paired_.end(), scratch_.begin(), scratch_.end(),
                                  std::back_inserter(before_));
  }
  lane_key_.resize(std::size_t{blocks} * kBlock);
  touching_.resize(blocks);
  name_lanes(world);
  paired_.clear();
  for (std::size_t k = 0; k < blocks; ++k) {
    unsigned closed = touching_[k];
    for (std::size_t l = k * kBlock; closed != 0; closed >>= 1, ++l) {
      if ((closed & 1) != 0 && lane_key_[l] != kNoKey) paired_.push_back(lane_key_[l]);
    }
  }
  build_ = stepped ? c.builds() : 0;
  retire(before_, ended_);
  sort(paired_, world.bodies.id_count);
  differences(before_, paired_, began_, ended_);
}

void EventList::compare_rest(const Observed& world) {
  const BodyStore& b = world.bodies;
  const ContactStore& c = world.contacts.discs;
  const SolverBodies& solved = world.contacts.solved;
  const Manifolds& manifolds = world.contacts.manifolds;
  const bool kinematic = world.any_kinematic();
  const auto here = [&](std::uint32_t id) {
    return b.info[id].place == Place::moving || b.info[id].place == Place::fixed || b.info[id].place == Place::asleep;
  };
  now_.clear();
  if (b.awake() != 0) {
    for (std::size_t k = 0; k < c.static_blocks(); ++k) {
      unsigned closed = closed_bits(c.s_impulse.data() + k * kBlock);
      for (std::size_t l = k * kBlock; closed != 0; closed >>= 1, ++l) {
        if ((closed & 1) == 0 || c.s_body[l] >= solved.dummies()) continue;
        if (c.s_shape[l] >= kWallLeft) continue;
        const std::uint32_t id = b.id[solved.slot(c.s_body[l])];
        if (id == kNoSlot || (kinematic && !dynamic(b, id))) continue;
        now_.push_back(key_of(id, world.statics[c.s_shape[l]].owner));
      }
    }
    for (std::size_t s = 0; s < manifolds.strip_count(); ++s) {
      for (const std::uint32_t k : manifolds.active_of(s)) {
        const ManifoldPair& pair = manifolds.pairs()[k];
        if (pair.id_a == ManifoldPair::kNone || !manifolds.closed(s, pair)) continue;
        if (here(pair.id_a) && here(pair.id_b)) now_.push_back(key_of(pair.id_a, pair.id_b));
      }
    }
  }
  if (!left_ && now_ == rest_found_) return;
  rest_found_ = now_;
  sort(now_, b.id_count);
  now_.erase(std::unique(now_.begin(), now_.end()), now_.end());
  retire(rest_, ended_);
  differences(rest_, now_, began_, ended_);
  rest_ = now_;
}

// Sleepers still touch what they touched, though no contact says so; and a pair of discs becomes another kind of
// contact once one of them sleeps.
void EventList::settle_sleepers(const Observed& world) {
  const BodyStore& b = world.bodies;
  const auto place = [&](std::uint32_t id) { return b.info[id].place; };
  const auto asleep = [&](std::uint64_t key) {
    const Place p = place(first_of(key)), q = place(second_of(key));
    return p != Place::moving && q != Place::moving && (p == Place::asleep || q == Place::asleep);
  };
  retire(slept_, ended_);
  if (!world.sleep.sleepers.changed) return;
  sort_keys(began_.begin(), began_.end());
  sort_keys(ended_.begin(), ended_.end());
  // A pair that both ended and began only changed its kind, unless its id belongs to another body now.
  before_.clear();
  if (removed_.empty()) {
    std::set_intersection(began_.begin(), began_.end(), ended_.begin(), ended_.end(), std::back_inserter(before_));
  }
  const auto drop = [](Keys& from, const Keys& what) {
    std::erase_if(from, [&](std::uint64_t key) { return std::binary_search(what.begin(), what.end(), key); });
  };
  drop(began_, before_);
  drop(ended_, before_);
  // Pairs with a body that woke still touch, or have ended.
  now_.clear();
  std::erase_if(slept_, [&](std::uint64_t key) {
    if (asleep(key)) return false;
    now_.push_back(key);
    return true;
  });
  for (const std::uint64_t key : now_) {
    if (!std::binary_search(began_.begin(), began_.end(), key)) ended_.push_back(key);
  }
  drop(began_, now_);
  // Pairs with a body that fell asleep go on.
  const std::size_t before = slept_.size();
  if (removed_.empty()) {
    std::erase_if(ended_, [&](std::uint64_t key) {
      if (!asleep(key)) return false;
      slept_.push_back(key);
      return true;
    });
  }
  sort_keys(slept_.begin() + static_cast<std::ptrdiff_t>(before), slept_.end());
  std::inplace_merge(slept_.begin(), slept_.begin() + static_cast<std::ptrdiff_t>(before), slept_.end());
}

void EventList::gather_sensed(const Observed& world, const QueryIndex& index) {
  const BodyStore& b = world.bodies;
  now_.clear();
  if (world.population.traits.moving != 0) {
    const QueryIndex::Part& moving = index.part(world, QueryIndex::kMoving);
    const QueryIndex::Part& sleeping = index.part(world, QueryIndex::kSleeping);
    // Finds the bodies that overlap an item of a sensor in `part`.
    const auto look = [&](const QueryIndex::Part& part, const QueryItem& item) {
      const BodyKind& kind = b.kind(item.body);
      if (!kind.sensor) return;
      const Vec2 at{item.x, item.y};
      const double reach = static_cast<double>(item.radius);
      const Outline mine = QueryIndex::outline(world, part, item, {});
      for (const QueryIndex::Part* in : {&moving, &sleeping}) {
        in->grid.in_box({at.x - reach, at.y - reach}, {at.x + reach, at.y + reach},
                        [&](const QueryItem& other, Vec2 shift) {
                          const Vec2 to{other.x + shift.x - at.x, other.y + shift.y - at.y};
                          const double far = reach + static_cast<double>(other.radius);
                          if (to.x * to.x + to.y * to.y > far * far) return;
                          if (b.info[other.body].place == Place::frozen) return;
                          const BodyKind& theirs = b.kind(other.body);
                          if (theirs.sensor || !meet(kind.filter, theirs.filter)) return;
                          if (!overlap(mine, QueryIndex::outline(world, *in, other, to))) return;
                          now_.push_back(std::uint64_t{item.body} << 32 | other.body);
                        });
      }
    };
    const QueryIndex::Part& fixed = index.part(world, QueryIndex::kFixed);
    for (const QueryItem& item : fixed.grid.items()) look(fixed, item);
    if (world.any_kinematic()) {
      for (const QueryItem& item : moving.grid.items()) look(moving, item);
    }
  }
  sort_keys(now_.begin(), now_.end());
  now_.erase(std::unique(now_.begin(), now_.end()), now_.end());
  began_.clear();
  ended_.clear();
  retire(sensed_, ended_);
  differences(sensed_, now_, began_, ended_);
  sensed_ = now_;
  tell(world, began_, false, sensor_begin_);
  tell(world, ended_, true, sensor_end_);
}

void EventList::collect(const Observed& world, const QueryIndex& index) {
  if (options_.contacts) {
    began_.clear();
    ended_.clear();
    compare_pairs(world);
    compare_rest(world);
    settle_sleepers(world);
    tell(world, began_, false, begin_);
    tell(world, ended_, true, end_);
  }
  if (options_.hits) keep_hits(world);
  if (options_.sensors) gather_sensed(world, index);
  candidates_.clear();
  removed_.clear();
  left_ = false;
}

std::size_t EventList::bytes() const {
  std::size_t keys = 0;
  for (const Keys* k : {&lane_key_, &rest_found_, &rest_, &slept_, &sensed_, &before_, &now_, &began_, &ended_,
                        &scratch_, &paired_, &toggled_}) {
    keys += k->capacity();
  }
  return keys * sizeof(std::uint64_t) + count_.capacity() * sizeof(std::uint32_t) + touching_.capacity() +
         candidates_.capacity() * sizeof(Candidate) + (begin_.capacity() + end_.capacity()) * sizeof(TouchEvent) +
         hits_.capacity() * sizeof(HitEvent);
}

}  // namespace psim
