#include "contacts/contact_store.h"

#include <algorithm>
#include <bit>

#include "compiler.h"

namespace psim {
namespace {

using kernels::kBlock;
using Class = ContactClass;

std::uint32_t find_static(const PairTable& old, std::uint32_t body, std::uint32_t shape) {
  if (body >= old.body_count) return ContactLanes::kNoLane;
  const std::vector<StaticPair>& list = old.static_contacts[old.strip_of(body)];
  const auto [begin, end] = contacts_of(list, body);
  const auto at = std::find_if(begin, end, [&](const StaticPair& pair) { return pair.shape == shape; });
  return at == end ? ContactLanes::kNoLane : at->contact;
}

// Whether any contact of the strip belongs to a body under a heavy load.
bool has_loaded(const PairTable& table, std::size_t index, const HeavyLoads& loads) {
  const Strip& s = table.strips[index];
  for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) {
    if (loads.at(table.owner[p]) || loads.at(table.other[p])) return true;
  }
  const std::vector<StaticPair>& list = table.static_contacts[index];
  return std::any_of(list.begin(), list.end(), [&](const StaticPair& pair) { return loads.at(pair.body); });
}

// The static contacts of a body get one class after another. Those under heavy loads have classes of their own.
std::uint32_t class_of_static(const Strip& s, bool loaded, std::uint32_t sequence) {
  const std::uint32_t c = loaded ? Class::kLoaded + sequence : sequence;
  const std::uint32_t end = s.loaded && !loaded ? Class::kLoaded : Class::kColours;
  return c < end ? c : loaded ? Class::kLoadedOverflow : Class::kOverflow;
}

// Calls each(contact, its class) for the static contacts of a strip.
template <class List, class Each>
void each_static(const Strip& s, List& list, const HeavyLoads& loads, const Each& each) {
  std::uint32_t last = kNoSlot, sequence = 0;
  for (auto& pair : list) {
    sequence = pair.body == last ? sequence + 1 : 0;
    last = pair.body;
    each(pair, class_of_static(s, s.loaded && loads.at(pair.body), sequence));
  }
}

// Where the lanes of a strip lie: the colours of ordinary contacts, their overflow, then the same for contacts under
// heavy loads. Each contact of the overflow has a block of its own.
class Layout {
 public:
  Layout(const Class::Counts& counts, std::uint32_t first_block, bool split) : blocks{first_block, 0, first_block} {
    for (std::uint32_t c = 0; c < (split ? Class::kLoaded : Class::kColours); ++c) place(counts, c);
    place(counts, Class::kOverflow);
    blocks.loaded = blocks.end;
    if (!split) return;
    for (std::uint32_t c = Class::kLoaded; c < Class::kColours; ++c) place(counts, c);
    place(counts, Class::kLoadedOverflow);
  }

  /// The next lane of a class.
  std::uint32_t take(std::uint32_t c) {
    const std::uint32_t lane = next_[c];
    next_[c] += c < Class::kColours ? 1 : kBlock;
    return lane;
  }

  /// Calls each(lane) for the lanes that have no contact, before any was taken.
  template <class Each>
  void each_empty(const Class::Counts& counts, const Each& each) const {
    for (std::uint32_t c = 0; c < counts.size(); ++c) {
      const bool overflow = c >= Class::kColours;
      for (std::uint32_t l = overflow ? 1 : counts[c]; l < blocks_of(counts, c) * kBlock; ++l) {
        if (!overflow || l % kBlock != 0) each(next_[c] + l);
      }
    }
  }

  ContactBlocks blocks;

 private:
  static std::uint32_t blocks_of(const Class::Counts& counts, std::uint32_t c) {
    return c < Class::kColours ? (counts[c] + kBlock - 1) / kBlock : counts[c];
  }
  void place(const Class::Counts& counts, std::uint32_t c) {
    next_[c] = blocks.end * kBlock;
    blocks.end += blocks_of(counts, c);
  }

  Class::Counts next_{};
};

}  // namespace

// Gives each pair the first colour that is free for both bodies, in the order of the pairs. This touches bodies of the
// strip and of the first row of the next one: even strips come first, then odd ones.
void ContactStore::colour_strip(PairTable& table, std::size_t index) {
  Strip& s = table.strips[index];
  Class::Counts& counts = pairs.counts[index];
  s.loaded = loads_.any() && has_loaded(table, index, loads_);
  // Numbers that stores of colours might change, for all that the compiler knows, are held in variables of this function.
  const std::uint32_t begin = s.pair_begin, end = s.pair_end;
  const std::uint32_t *const owner = table.owner.data(), *const other = table.other.data();
  std::uint32_t* const used = used_.data();
  std::uint8_t* const colour = colour_.data();
  for (std::uint32_t p = begin; p < end; ++p) used[owner[p]] = used[other[p]] = 0;
  const bool any_loaded = s.loaded;
  const std::uint32_t last = any_loaded ? Class::kLoaded : Class::kColours;
  Class::Counts number{};
  std::uint32_t now = kNoSlot, taken_of_owner = 0;
  for (std::uint32_t p = begin; p < end; ++p) {
    const std::uint32_t a = owner[p], b = other[p];
    taken_of_owner = a == now ? taken_of_owner : used[a];
    now = a;
    const bool loaded = any_loaded && (loads_.at(a) || loads_.at(b));
    const std::uint32_t taken = taken_of_owner | used[b] | (loaded ? (1u << Class::kLoaded) - 1 : 0);
    auto c = static_cast<std::uint32_t>(std::countr_zero(~taken));
    if (c >= (loaded ? Class::kColours : last)) c = loaded ? Class::kLoadedOverflow : Class::kOverflow;
    const std::uint32_t bit = c < Class::kColours ? 1u << c : 0u;
    used[a] = taken_of_owner |= bit;
    used[b] |= bit;
    colour[p] = static_cast<std::uint8_t>(c);
    ++number[c];
  }
  counts = number;
}

std::uint32_t ContactStore::colour_of_static(const Strip& s, const StaticPair& static_pair, std::uint32_t sequence) {
  const bool loaded = s.loaded && static_pair.contact / kBlock >= s.static_blocks.loaded;
  return class_of_static(s, loaded, sequence);
}

// Lays out the pairs of a strip in order. Calls each(pair, lane) once all is set but the impulses and the pair's `contact`.
// properties(slot) is asked where bodies differ.
template <class Properties, class Each>
void ContactStore::lay_out_pairs(PairTable& table, std::size_t index, const Properties& properties, const Each& each) {
  const BodyStore& b = s_.bodies;
  const Strip& s = table.strips[index];
  const Class::Counts& counts = pairs.counts[index];
  Layout lanes(counts, s.blocks.begin, s.loaded);
  const bool material = model_.massed() || model_.bounce;
  if (material && alike_ != nullptr) {
    pairs.fill_all(model_, s_.mixing, std::size_t{kBlock} * s.blocks.begin, std::size_t{kBlock} * s.blocks.end,
                   *alike_);
  }
  lanes.each_empty(counts, [&](std::uint32_t lane) { pairs.pad(model_, lane, solved_.dummies_of(index)); });
  for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) {
    const std::uint32_t i = table.owner[p], j = table.other[p], at = lanes.take(colour_[p]);
    pairs.body[2 * std::size_t{at}] = solved_.number(i);
    pairs.body[2 * std::size_t{at} + 1] = solved_.number(j);
    pairs.rsum[at] = b.radius[i] + b.radius[j];
    if (material && alike_ == nullptr) pairs.fill(model_, s_.mixing, at, properties(i), properties(j));
    each(p, at);
    table.contact[p] = at;
  }
}

// The lanes of old pairs into `contact`, in a loop of its own: there they are looked for one after the other, and the
// impulses are on their way when they are asked for.
void ContactStore::find_lanes(PairTable& table, std::size_t index, const PairTable& old, const std::uint32_t* from) {
  const std::uint32_t begin = table.strips[index].pair_begin, end = table.strips[index].pair_end;
  const std::uint32_t *const owner = table.owner.data(), *const other = table.other.data();
  std::uint32_t* const contact = table.contact.data();
  const float* const impulse = pairs.old_impulse.data();
  const float* const friction = model_.rough() ? pairs.old_friction.data() : nullptr;
  const auto was = [from](std::uint32_t slot) { return from != nullptr ? from[slot] : slot; };
  const std::uint32_t bodies = old.body_count;
  for (std::uint32_t p = begin; p < end; ++p) {
    const std::uint32_t a = was(owner[p]), b = was(other[p]);
    const std::uint32_t pair = std::max(a, b) < bodies ? old.find(a, b) : PairTable::kNoPair;
    const std::uint32_t lane = pair == PairTable::kNoPair ? ContactLanes::kNoLane : old.contact[pair];
    contact[p] = lane;
    if (lane == ContactLanes::kNoLane) continue;
    PSIM_PREFETCH(impulse + lane);
    if (friction != nullptr) PSIM_PREFETCH(friction + lane);
  }
}

// Gives a new contact of a body the impulse that it had before one of its sides fell asleep or woke.
void ContactStore::recall(const Touch* touch, std::uint32_t id, ContactLanes& lanes, std::size_t lane) {
  if (touch == nullptr) return;
  const float unit = touch->times(!model_.massed(), s_.bodies.properties(id).mass);
  lanes.impulse[lane] = unit * touch->impulse[0];
  if (model_.rough()) lanes.friction[lane] = unit * touch->friction[0];
}

void ContactStore::lift(const PairTable& table) {
  const Strip& s = table.strips.back();
  const std::size_t all = s.pair_end - s.pair_begin;
  lifted_.clear();
  if (all > lifted_.capacity()) lifted_.reserve(all + all / 8 + 1024);  // the next lists are often a little longer
  for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) lifted_.push_back(impulse_of(table, p));
}

void ContactStore::renew(bool static_contacts, PairTable& table) {
  colour_.reserve_loosely(table.pair_room);
  colour_strip(table, table.strips.size() - 1);
  if (static_contacts) fixed.swap_impulses();
  place_strips(table);
  // The pairs that the strip kept come first, as before; then come those of renewed bodies in order.
  auto before = lifted_.cbegin();
  const BodyStore& b = s_.bodies;
  const auto properties_of = [&b](std::uint32_t slot) -> const BodyProperties& { return b.properties(b.id[slot]); };
  lay_out_pairs(table, table.strips.size() - 1, properties_of, [&](std::uint32_t p, std::uint32_t at) {
    const std::uint32_t i = table.owner[p], j = table.other[p];
    if (p >= table.renewed_begin) {
      while (before != lifted_.cend() && (before->owner != i ? before->owner < i : before->other < j)) ++before;
    }
    if (before == lifted_.cend() || before->owner != i || before->other != j) return pairs.put(model_, at, 0, 0);
    pairs.put(model_, at, before->impulse, before->friction);
    ++before;
  });
  if (static_contacts) {
    const TouchMemory none;
    s_.pool.run(table.strips.size(), [&](std::size_t strip) {
      lay_out_statics(table, none, strip, [](const StaticPair& pair) { return pair.contact; });
    });
  }
  ++builds_;
}

// lane_before(pair) gives the lane that a static contact had, or kNoLane.
template <class LaneBefore>
void ContactStore::lay_out_statics(PairTable& table, const TouchMemory& recent, std::size_t index,
                                   const LaneBefore& lane_before) {
  std::vector<StaticPair>& list = table.static_contacts[index];
  if (list.empty()) return;
  const Strip& s = table.strips[index];
  const Class::Counts& counts = fixed.counts[index];
  Layout lanes(counts, s.static_blocks.begin, s.loaded);
  lanes.each_empty(counts, [&](std::uint32_t lane) { fixed.pad(model_, lane, solved_.dummies_of(index)); });
  each_static(s, list, loads_, [&](StaticPair& pair, std::uint32_t c) {
    const std::uint32_t before = lane_before(pair), at = lanes.take(c), id = s_.bodies.id[pair.body];
    const bool known = before != ContactLanes::kNoLane, wall = pair.shape >= kWallLeft;
    pair.contact = at;
    fixed.body[at] = solved_.number(pair.body);
    fixed.shape[at] = pair.shape;
    BodyProperties side;  // without inverse mass
    side.restitution = wall ? coefficient(wall_.restitution) : s_.statics[pair.shape].restitution;
    side.friction = wall ? coefficient(wall_.friction) : s_.statics[pair.shape].friction;
    fixed.fill(model_, s_.mixing, at, side, s_.bodies.properties(id));
    fixed.carry(model_, at, before);
    // The narrow phase keeps a pressed contact on the side where it was.
    fixed.nx[at] = known ? fixed.old_nx[before] : 0;
    fixed.ny[at] = known ? fixed.old_ny[before] : 0;
    if (known || recent.empty()) return;
    if (wall || !s_.statics[pair.shape].asleep) return recall(recent.find(fixed_key(id, pair.shape)), id, fixed, at);
    const StaticShape& shape = s_.statics[pair.shape];
    recall(recent.find(pair_key(id, shape.owner), touch_parts(id, 0, shape.owner, shape.part)), id, fixed, at);
  });
}

void ContactStore::begin(ContactModel model, const BodyProperties* alike, PairTable& table) {
  model_ = model;
  alike_ = alike;
  pairs.counts.resize(std::max(pairs.counts.size(), table.strips.size()));
  fixed.counts.resize(pairs.counts.size());
  used_.reserve(kernels::round_up_block(s_.bodies.count));
  colour_.release_if_short(table.pair_room);
  colour_.reserve_loosely(table.pair_room);
  table.contact.release_if_short(table.pair_room);
  table.contact.reserve_loosely(table.pair_room);
  if (alike_ == nullptr && (model_.massed() || model_.bounce)) {
    find_entries();
  } else {
    entry_.release();
  }
}

// The way from a slot to its properties goes through two columns that lie in another order.
void ContactStore::find_entries() {
  const BodyStore& b = s_.bodies;
  entry_.reserve(kernels::round_up_block(b.count));
  run_stream(b.blocks(), s_.pool, [&](BlockRange r) {
    for (std::uint32_t i = r.begin * kBlock; i < std::min(b.count, r.end * kBlock); ++i) {
      entry_[i] = b.id[i] == kNoSlot ? 0 : b.info[b.id[i]].properties;
    }
  });
}

void ContactStore::colour(PairTable& table, std::size_t begin, std::size_t end) {
  run_phases(table.strips.size(), begin, end, s_.pool, [&](std::size_t strip) { colour_strip(table, strip); });
}

// Finds out which blocks each strip has, and makes room for them.
void ContactStore::place_strips(PairTable& table) {
  pairs.blocks = fixed.blocks = colours_ = 0;
  pairs.count = fixed.count = loaded_blocks_ = 0;
  for (std::size_t k = 0; k < table.strips.size(); ++k) {
    Strip& s = table.strips[k];
    Class::Counts& static_counts = fixed.counts[k];
    static_counts.fill(0);
    each_static(s, table.static_contacts[k], loads_, [&](const StaticPair&, std::uint32_t c) { ++static_counts[c]; });
    s.blocks = Layout(pairs.counts[k], pairs.blocks, s.loaded).blocks;
    s.static_blocks = Layout(static_counts, fixed.blocks, s.loaded).blocks;
    pairs.blocks = s.blocks.end;
    fixed.blocks = s.static_blocks.end;
    s.colours = Class::kColours;
    while (s.colours != 0 && pairs.counts[k][s.colours - 1] == 0) --s.colours;
    colours_ = std::max(colours_, s.colours);
    pairs.count += s.pair_end - s.pair_begin;
    fixed.count += table.static_contacts[k].size();
    const auto loaded = (s.blocks.end - s.blocks.loaded) + (s.static_blocks.end - s.static_blocks.loaded);
    loaded_blocks_ += std::uint64_t{loaded} * (HeavyLoads::kSweeps - 1);
  }
  make_room(std::size_t{pairs.blocks} * kBlock, std::size_t{fixed.blocks} * kBlock);
}

void ContactStore::lay_out(PairTable& table, const PairTable& old, const std::uint32_t* from, const TouchMemory& recent,
                           std::size_t begin, std::size_t end) {
  if (begin == 0) {
    place_strips(table);
    pairs.swap_impulses();
    fixed.swap_impulses();
    laying_ = true;
  }
  const auto was = [&](std::uint32_t slot) { return from != nullptr ? from[slot] : slot; };
  const auto properties_of = [&](std::uint32_t slot) -> const BodyProperties& {
    return s_.bodies.property_table[entry_[slot]];
  };
  s_.pool.run(end - begin, [&](std::size_t n) {
    find_lanes(table, begin + n, old, from);
    lay_out_pairs(table, begin + n, properties_of, [&](std::uint32_t p, std::uint32_t at) {
      const std::uint32_t before = table.contact[p];
      pairs.carry(model_, at, before);
      if (before != ContactLanes::kNoLane || recent.empty()) return;
      const std::uint32_t id = s_.bodies.id[table.owner[p]];
      recall(recent.find(pair_key(id, s_.bodies.id[table.other[p]])), id, pairs, at);
    });
    lay_out_statics(table, recent, begin + n,
                    [&](const StaticPair& pair) { return find_static(old, was(pair.body), pair.shape); });
  });
}

}  // namespace psim
