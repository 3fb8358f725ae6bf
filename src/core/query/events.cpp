#include "query/events.h"

#include <algorithm>
#include <bit>
#include <functional>
#include <initializer_list>
#include <iterator>
#include <utility>

#include "base/sort_keys.h"
#include "contacts/touch_memory.h"

namespace psim {
namespace {

using kernels::kBlock;
using Keys = std::vector<std::uint64_t>;

constexpr std::uint64_t kNoKey = ~std::uint64_t{0};

std::uint32_t first_of(std::uint64_t key) { return static_cast<std::uint32_t>(key >> 32); }
std::uint32_t second_of(std::uint64_t key) { return static_cast<std::uint32_t>(key); }

bool is_wall(std::uint32_t id) { return id >= kWallLeft; }
// Of length 1, into a wall of the world; zero for a body.
Vec2 inward(std::uint32_t id) {
  if (!is_wall(id)) return {};
  const double to = id == kWallRight || id == kWallTop ? 1 : -1;
  return id == kWallLeft || id == kWallRight ? Vec2{to, 0} : Vec2{0, to};
}

// A bit for each closed contact of a block. An impulse of -0 marks an open one.
std::uint8_t closed_bits(const float* impulse) {
  unsigned open = 0;
  for (std::size_t l = 0; l < kBlock; ++l) open |= (std::bit_cast<std::uint32_t>(impulse[l]) >> 31) << l;
  return static_cast<std::uint8_t>(~open);
}

// Calls each(lane) for the bits of a block.
template <class Each>
void each_lane(std::size_t block, unsigned bits, const Each& each) {
  for (; bits != 0; bits &= bits - 1) each(block * kBlock + static_cast<std::size_t>(std::countr_zero(bits)));
}

// Appends the keys of one sorted list that are not in the other.
void add_difference(const Keys& from, const Keys& without, Keys& to) {
  std::set_difference(from.begin(), from.end(), without.begin(), without.end(), std::back_inserter(to));
}

// Moves the keys for which goes(key) holds to the end of another list. All keep their order.
template <class Goes>
void move_keys(Keys& from, Keys& to, const Goes& goes) {
  std::copy_if(from.begin(), from.end(), std::back_inserter(to), goes);
  std::erase_if(from, goes);
}

// Removes the keys that a sorted list has.
void drop(Keys& from, const Keys& what) {
  std::erase_if(from, [&](std::uint64_t key) { return std::binary_search(what.begin(), what.end(), key); });
}

}  // namespace

void EventList::set_options(const EventOptions& options) {
  options_ = options;
  slept_at_ = kNever;
  clear();
  if (!options.contacts) {
    build_ = 0;
    give_back(lane_key_, touching_, paired_, toggled_, rest_found_, rest_, slept_);
  }
  if (!options.contacts) {
    give_back(began_with_);
    contacts_ = ContactList();
  }
  if (!options.sensors) give_back(sensed_, felt_);
  if (!options.sleep && !options.moves) give_back(sleepers_, asleep_before_);
  if (!options.moves) give_back(moves_);
  if (!options.hits) give_back(hits_);
  if (!options.fluids) fluids_ = FluidEventList();
}

void EventList::clear() {
  for (std::vector<TouchEvent>* events : {&begin_, &end_, &sensor_begin_, &sensor_end_}) events->clear();
  hits_.hits.clear();
  fluids_.clear();
  fell_asleep_.clear();
  woke_.clear();
  moves_.clear();
}

void EventList::start_over() {
  const EventOptions kept = options_;
  *this = EventList();
  options_ = kept;
}

// The first of the removed bodies that had this index, or the end.
std::vector<BodyId>::const_iterator EventList::removed(std::uint32_t index) const {
  const auto first = std::ranges::lower_bound(removed_, index, {}, &BodyId::index);
  return first != removed_.end() && first->index == index ? first : removed_.end();
}

// Pairs of removed bodies have ended, even if other bodies have their ids now.
void EventList::retire(Keys& known) {
  if (removed_.empty()) return;
  const auto gone = [&](std::uint32_t index) { return removed(index) != removed_.end(); };
  move_keys(known, ended_, [&](std::uint64_t key) { return gone(first_of(key)) || gone(second_of(key)); });
}

// The pairs in now_ take the place of the known ones: those that were not known began, those that are gone ended.
void EventList::replace(Keys& known, std::uint32_t ids) {
  sort_by_first(now_, scratch_, count_, ids, first_of, std::less<>());
  now_.erase(std::unique(now_.begin(), now_.end()), now_.end());
  retire(known);
  add_difference(known, now_, ended_);
  add_difference(now_, known, began_);
  known.swap(now_);
}

// The handle of a body; of one that is gone that which it had.
BodyId EventList::last_handle(const Observed& world, std::uint32_t id) const {
  const auto gone = removed(id);
  return gone != removed_.end() ? *gone : is_wall(id) ? kNoBody : world.handle(id);
}

// Writes the events of what began and ended.
void EventList::tell(const Observed& world, std::vector<TouchEvent>& begin, std::vector<TouchEvent>& end) {
  const auto handle = [&](std::uint32_t id) { return is_wall(id) ? kNoBody : world.handle(id); };
  sort_keys(began_.begin(), began_.end());
  sort_keys(ended_.begin(), ended_.end());
  begin.clear();
  end.clear();
  for (const std::uint64_t key : began_) {
    begin.push_back({handle(first_of(key)), handle(second_of(key)), {}, inward(second_of(key))});
  }
  for (const std::uint64_t key : ended_) {
    end.push_back({last_handle(world, first_of(key)), last_handle(world, second_of(key)), {}, inward(second_of(key))});
  }
  began_.clear();
  ended_.clear();
}

// Where the pairs touch that began to, by the contacts of the step. Normals of walls are known, and tell which is which.
void EventList::find_points(const Observed& world, const LastStep& last) {
  if (begin_.empty()) return;
  began_with_.assign(world.bodies.id_count, 0);
  for (const TouchEvent& e : begin_) {
    began_with_[e.a.index] = 1;
    if (e.b != kNoBody) began_with_[e.b.index] = 1;
  }
  const std::span<const Contact> found = find_contacts(world, last, contacts_, &began_with_);
  const auto before = [](const Contact& c, const TouchEvent& e) {
    return std::pair(c.a.index, c.b.index) < std::pair(e.a.index, e.b.index);
  };
  auto first = found.begin();
  for (TouchEvent& e : begin_) {
    first = std::partition_point(first, found.end(), [&](const Contact& c) { return before(c, e); });
    const Contact* deepest = nullptr;
    for (auto c = first; c != found.end() && c->a == e.a && c->b == e.b; ++c) {
      const bool other_wall = e.b == kNoBody && !(dot(c->normal, e.normal) > 0.5);
      if (!other_wall && (deepest == nullptr || c->separation < deepest->separation)) deepest = &*c;
    }
    if (deepest == nullptr) continue;
    e.point = deepest->point;
    e.normal = deepest->normal;
  }
}

// Contacts of two discs. If the lanes are those of the last step, only changes are looked at.
void EventList::compare_lanes(const Observed& world) {
  const ContactStore& c = world.contacts.discs;
  const bool stepped = world.bodies.awake() != 0;
  const std::uint32_t blocks = stepped ? c.pairs.blocks : 0;
  if (!stepped || build_ != c.builds() || left_ || touching_.size() != blocks) {
    renew_lanes(world, blocks);
    build_ = stepped ? c.builds() : 0;
    return;
  }
  for (std::size_t k = 0; k < blocks; ++k) {
    const unsigned now = closed_bits(c.pairs.impulse.data() + k * kBlock);
    each_lane(k, now ^ touching_[k], [&](std::size_t l) {
      if (lane_key_[l] == kNoKey) return;
      ((now >> (l % kBlock) & 1) != 0 ? began_ : ended_).push_back(lane_key_[l]);
      toggled_.push_back(lane_key_[l]);
    });
    touching_[k] = static_cast<std::uint8_t>(now);
  }
}

void EventList::renew_lanes(const Observed& world, std::uint32_t blocks) {
  const BodyStore& b = world.bodies;
  const ContactStore& c = world.contacts.discs;
  const PairTable& table = world.table;
  // The pairs that touched before: those at the time when the lanes were made, changed by each pair that toggled an odd
  // number of times.
  sort_keys(toggled_.begin(), toggled_.end());
  scratch_.clear();
  for (const std::uint64_t key : toggled_) {
    if (!scratch_.empty() && scratch_.back() == key) {
      scratch_.pop_back();
    } else {
      scratch_.push_back(key);
    }
  }
  toggled_.clear();
  now_.clear();
  std::set_symmetric_difference(paired_.begin(), paired_.end(), scratch_.begin(), scratch_.end(),
                                std::back_inserter(now_));
  paired_.swap(now_);

  lane_key_.assign(std::size_t{blocks} * kBlock, kNoKey);
  touching_.resize(blocks);
  world.pool.run(blocks != 0 ? table.strips.size() : 0, [&](std::size_t strip) {
    for (std::uint32_t p = table.strips[strip].pair_begin; p < table.strips[strip].pair_end; ++p) {
      const std::uint32_t i = b.id[table.owner[p]], j = b.id[table.other[p]];
      if (i == kNoSlot || j == kNoSlot) continue;  // a body left in this step
      if (world.tells_of(i, j)) lane_key_[table.contact[p]] = pair_key(i, j);
    }
  });
  now_.clear();
  for (std::size_t k = 0; k < blocks; ++k) {
    touching_[k] = closed_bits(c.pairs.impulse.data() + k * kBlock);
    each_lane(k, touching_[k], [&](std::size_t l) {
      if (lane_key_[l] != kNoKey) now_.push_back(lane_key_[l]);
    });
  }
  replace(paired_, b.id_count);
}

// All other contacts: of discs with fixed bodies, and manifolds.
void EventList::compare_rest(const Observed& world) {
  const BodyStore& b = world.bodies;
  const ContactStore& c = world.contacts.discs;
  const Manifolds& manifolds = world.contacts.manifolds;
  const auto here = [&](std::uint32_t id) { return !is_out(b.info[id].place); };
  now_.clear();
  if (b.awake() != 0) {
    for (std::size_t s = 0; s < world.table.strips.size(); ++s) {
      for (const StaticPair& pair : world.table.static_contacts[s]) {
        if (!closed(c.fixed.impulse[pair.contact])) continue;
        const std::uint32_t id = b.id[pair.body];
        const std::uint32_t other = is_wall(pair.shape) ? pair.shape : world.statics[pair.shape].owner;
        if (id != kNoSlot && world.tells_of(id)) now_.push_back(pair_key(id, other));
      }
    }
    for (std::size_t s = 0; s < manifolds.strip_count(); ++s) {
      for (const std::uint32_t k : manifolds.strip(s).active) {
        const ManifoldPair& pair = manifolds.pairs()[k];
        if (!manifolds.closed(s, pair) || !here(pair.id_b)) continue;
        if (pair.of_wall()) {
          if (world.tells_of(pair.id_b)) now_.push_back(pair_key(pair.id_b, pair.shape));
        } else if (pair.id_a != ManifoldPair::kNone && here(pair.id_a)) {
          now_.push_back(pair_key(pair.id_a, pair.id_b));
        }
      }
    }
  }
  if (!left_ && now_ == rest_found_) return;
  rest_found_ = now_;
  replace(rest_, b.id_count);
}

// Sleepers still touch what they touched, though no contact says so; and a pair of discs becomes another kind of
// contact once one of them sleeps.
void EventList::settle_sleepers(const Observed& world) {
  const auto place = [&](std::uint32_t id) { return is_wall(id) ? Place::fixed : world.bodies.info[id].place; };
  const auto asleep = [&](std::uint64_t key) {
    const Place p = place(first_of(key)), q = place(second_of(key));
    return p != Place::moving && q != Place::moving && (p == Place::asleep || q == Place::asleep);
  };
  retire(slept_);
  if (!world.sleep.sleepers.changed) return;
  sort_keys(began_.begin(), began_.end());
  sort_keys(ended_.begin(), ended_.end());
  // A pair that both ended and began only changed its kind, unless its id belongs to another body now.
  now_.clear();
  if (removed_.empty()) {
    std::set_intersection(began_.begin(), began_.end(), ended_.begin(), ended_.end(), std::back_inserter(now_));
  }
  drop(began_, now_);
  drop(ended_, now_);
  // Pairs with a body that woke still touch, or have ended.
  now_.clear();
  move_keys(slept_, now_, std::not_fn(asleep));
  add_difference(now_, began_, ended_);
  drop(began_, now_);
  // Pairs with a body that fell asleep go on.
  const std::size_t before = slept_.size();
  if (removed_.empty()) move_keys(ended_, slept_, asleep);
  sort_keys(slept_.begin() + static_cast<std::ptrdiff_t>(before), slept_.end());
  merge_parts(slept_, before, now_);
}

void EventList::gather_sensed(const Observed& world, const QueryIndex& index) {
  const BodyStore& b = world.bodies;
  felt_.clear();
  if (world.population.traits.moving != 0) {
    const QueryIndex::Part& moving = index.part(world, QueryIndex::kMoving);
    const QueryIndex::Part& sleeping = index.part(world, QueryIndex::kSleeping);
    const QueryIndex::Part& fixed = index.part(world, QueryIndex::kFixed);
    const auto here = [&](std::uint32_t id) { return !is_out(b.info[id].place); };
    // Finds the bodies in some parts of the index that overlap the sensors in `part`.
    const auto look = [&](const QueryIndex::Part& part, std::initializer_list<const QueryIndex::Part*> into) {
      for (const QueryItem& item : part.grid.items()) {
        const BodyKind& kind = b.kind(item.body);
        if (!b.is_sensor(kind, item.part) || !here(item.body)) continue;
        const Outline mine = QueryIndex::outline(world, part, item, {});
        const double reach = wide(item.radius);
        const auto felt = [&](const QueryItem& other) {
          const BodyKind& theirs = b.kind(other.body);
          return other.body != item.body && here(other.body) && !b.is_sensor(theirs, other.part) &&
                 meet(b.filter_of(kind, item.part), b.filter_of(theirs, other.part));
        };
        const auto add = [&](std::uint32_t other) {
          felt_.emplace_back(std::uint64_t{item.body} << 32 | other, item.part);
        };
        for (const QueryIndex::Part* in : into) {
          QueryIndex::each_overlap(world, *in, mine, item.at, {reach, reach}, felt, add);
        }
      }
    };
    if (world.population.traits.sensors != world.population.traits.moving_sensors) look(fixed, {&moving, &sleeping});
    if (world.population.traits.moving_sensors != 0) {
      look(moving, {&moving, &sleeping, &fixed});
      look(sleeping, {&moving, &sleeping, &fixed});
    }
  }
  std::ranges::sort(felt_);  // Total order: equal ones are alike.
  felt_.erase(std::unique(felt_.begin(), felt_.end()), felt_.end());
  tell_sensed(world);
}

// Tells what is in felt_ and was not in sensed_, and the other way round; then felt_ takes the place of sensed_. A pair
// with a removed body has ended, even if another body has its id now.
void EventList::tell_sensed(const Observed& world) {
  const auto gone = [&](const Felt& f) {
    return removed(first_of(f.first)) != removed_.end() || removed(second_of(f.first)) != removed_.end();
  };
  const auto within = [](const std::vector<Felt>& all, const Felt& f) { return std::ranges::binary_search(all, f); };
  sensor_begin_.clear();
  sensor_end_.clear();
  for (const Felt& f : sensed_) {
    if (!gone(f) && within(felt_, f)) continue;
    const BodyId sensor = last_handle(world, first_of(f.first)), other = last_handle(world, second_of(f.first));
    sensor_end_.push_back({sensor, other, {}, {}, f.second});
  }
  for (const Felt& f : felt_) {
    if (!gone(f) && within(sensed_, f)) continue;
    sensor_begin_.push_back({world.handle(first_of(f.first)), world.handle(second_of(f.first)), {}, {}, f.second});
  }
  sensed_.swap(felt_);
}

void EventList::collect(const Observed& world, const QueryIndex& index, const LastStep& last, const Fluids& fluids) {
  // Total order: an index comes again with a higher generation only.
  std::ranges::sort(removed_, {}, [](BodyId id) { return std::pair(id.index, id.generation); });
  if (options_.contacts) {
    compare_lanes(world);
    compare_rest(world);
    settle_sleepers(world);
    tell(world, begin_, end_);
    find_points(world, last);
  }
  if (options_.hits) hits_.collect(world);
  if (options_.sensors) gather_sensed(world, index);
  if (options_.fluids) fluids_.collect(world, index, fluids);
  removed_.clear();
  left_ = false;
}

void EventList::collect_sleep(const Observed& world, bool stepped) {
  fell_asleep_.clear();
  woke_.clear();
  moves_.clear();
  if ((options_.sleep || options_.moves) && slept_at_ != world.sleep.sleepers.changes) {
    asleep_before_.swap(sleepers_);
    sleepers_.clear();
    for (const Sleeper& s : world.sleep.sleepers.list) sleepers_.push_back(world.handle(s.id));
    std::ranges::sort(sleepers_, {}, &BodyId::index);  // Total order: no two have one index.
    slept_at_ = world.sleep.sleepers.changes;
    const auto by_index = [](BodyId x, BodyId y) { return x.index < y.index; };
    const auto add_new = [&](const std::vector<BodyId>& now, const std::vector<BodyId>& before,
                             std::vector<BodyId>& to) {
      std::set_difference(now.begin(), now.end(), before.begin(), before.end(), std::back_inserter(to), by_index);
    };
    add_new(sleepers_, asleep_before_, fell_asleep_);
    add_new(asleep_before_, sleepers_, woke_);
    const auto gone = [&](BodyId id) {
      const BodyInfo& info = world.bodies.info[id.index];
      return info.generation != id.generation || is_out(info.place);
    };
    std::erase_if(woke_, gone);
  }
  if (options_.moves && stepped) {
    const auto fell_asleep = [&](std::uint32_t id) {
      const auto at = std::ranges::lower_bound(fell_asleep_, id, {}, &BodyId::index);
      return at != fell_asleep_.end() && at->index == id;
    };
    for (std::uint32_t id = 0; id < world.bodies.id_count; ++id) {
      const Place place = world.bodies.info[id].place;
      if (place != Place::moving && (place != Place::asleep || !fell_asleep(id))) continue;
      const BodyState s = world.state_of(id);
      moves_.push_back({s.id, {s.x, s.y}, s.angle, place == Place::asleep});
    }
  }
}

std::size_t EventList::bytes() const {
  return bytes_of(lane_key_, rest_found_, rest_, slept_, sensed_, felt_, now_, began_, ended_, scratch_, paired_,
                  toggled_, count_, touching_, begin_, end_, breaks, began_with_, sleepers_, asleep_before_,
                  fell_asleep_, woke_, moves_) +
         hits_.bytes() + contacts_.bytes() + fluids_.bytes();
}

}  // namespace psim
