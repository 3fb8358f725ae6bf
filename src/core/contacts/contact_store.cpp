#include "contacts/contact_store.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "base/invariant.h"

namespace psim {
namespace {

using kernels::kBlock;
using kernels::Model;

// Open contacts have an impulse of -0.
float pressing(float impulse) { return impulse > 0 ? impulse : 0.0f; }

float mixed_friction(float a, float b) { return std::sqrt(a * b); }

// The lane in which the pair (a, b), in either order, was laid out before; or none.
constexpr std::uint32_t kNoLane = 0xFFFFFFFFu;

std::uint32_t find_pair(const PairTable& old, std::uint32_t a, std::uint32_t b) {
  if (a >= old.body_count || b >= old.body_count) return kNoLane;
  const std::uint32_t pair = old.find(a, b);
  return pair == PairTable::kNoPair ? kNoLane : old.contact[pair];
}

std::uint32_t find_static(const PairTable& old, std::uint32_t body, std::uint32_t shape) {
  if (body >= old.body_count) return kNoLane;
  const std::vector<StaticPair>& list = old.static_contacts[old.strip_of(body)];
  const auto [begin, end] = contacts_of(list, body);
  const auto at = std::find_if(begin, end, [&](const StaticPair& pair) { return pair.shape == shape; });
  return at == end ? kNoLane : at->contact;
}

std::uint32_t blocks_of(std::uint32_t lanes) { return (lanes + kBlock - 1) / kBlock; }

}  // namespace

// Where the lanes of each class begin: the colours of ordinary contacts, their overflow, then the same for contacts
// under heavy loads. Each contact of the overflow has a block of its own.
struct ContactStore::Layout {
  Counts begin{};                     // first lane of each class
  std::uint32_t loaded = 0, end = 0;  // blocks

  Layout(const Counts& counts, std::uint32_t first_block, bool split) : end(first_block) {
    for (std::uint32_t c = 0; c < (split ? kLoaded : kColours); ++c) place(counts, c);
    place(counts, kOverflow);
    loaded = end;
    if (!split) return;
    for (std::uint32_t c = kLoaded; c < kColours; ++c) place(counts, c);
    place(counts, kLoadedOverflow);
  }

 private:
  void place(const Counts& counts, std::uint32_t c) {
    begin[c] = end * kBlock;
    end += c < kColours ? blocks_of(counts[c]) : counts[c];
  }
};

// Gives each pair the first colour that is free for both bodies, in the order of the pairs. This touches bodies of the
// strip and of the first row of the next one: even strips come first, then odd ones.
void ContactStore::colour_strip(const PairTable& table, std::size_t index) {
  const Strip& s = table.strips[index];
  Counts& counts = counts_[index];
  counts.fill(0);
  for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) {
    used_[table.owner[p]] = 0;
    used_[table.other[p]] = 0;
  }
  const std::uint32_t last = s.loaded ? kLoaded : kColours;
  for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) {
    const std::uint32_t a = table.owner[p], b = table.other[p];
    const bool loaded = s.loaded && (loads_.at(a) || loads_.at(b));
    const std::uint32_t taken = used_[a] | used_[b] | (loaded ? (1u << kLoaded) - 1 : 0);
    auto c = static_cast<std::uint32_t>(std::countr_zero(~taken));
    if (c >= (loaded ? kColours : last)) c = loaded ? kLoadedOverflow : kOverflow;
    const std::uint32_t bit = c < kColours ? 1u << c : 0u;
    used_[a] |= bit;
    used_[b] |= bit;
    colour_[p] = static_cast<std::uint8_t>(c);
    ++counts[c];
  }
}

// The static contacts of a body get one class after another. Those under heavy loads have classes of their own.
std::uint32_t ContactStore::static_class(const Strip& s, std::uint32_t body, std::uint32_t sequence) const {
  if (!s.loaded) return std::min(sequence, kOverflow);
  if (loads_.at(body)) return sequence < kColours - kLoaded ? kLoaded + sequence : kLoadedOverflow;
  return sequence < kLoaded ? sequence : kOverflow;
}

// Calls each(contact, its class) for the static contacts of a strip.
template <class List, class Each>
void ContactStore::each_static(const Strip& s, List& list, const Each& each) const {
  std::uint32_t last = kNoSlot, sequence = 0;
  for (auto& pair : list) {
    sequence = pair.body == last ? sequence + 1 : 0;
    last = pair.body;
    each(pair, static_class(s, pair.body, sequence));
  }
}

std::uint32_t ContactStore::colour_of_static(const Strip& s, const StaticPair& static_pair, std::uint32_t sequence) {
  const bool loaded = s.loaded && static_pair.contact / kBlock >= s.static_loaded_begin;
  const std::uint32_t most = s.loaded && !loaded ? kLoaded : kColours;
  const std::uint32_t colour = loaded ? kLoaded + sequence : sequence;
  return colour < most ? colour : kColours;
}

// Whether any contact of the strip belongs to a body under a heavy load.
bool ContactStore::is_loaded(const PairTable& table, std::size_t index) const {
  const Strip& s = table.strips[index];
  for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) {
    if (loads_.at(table.owner[p]) || loads_.at(table.other[p])) return true;
  }
  const auto& static_contacts = table.static_contacts[index];
  return std::any_of(static_contacts.begin(), static_contacts.end(),
                     [&](const StaticPair& pair) { return loads_.at(pair.body); });
}

void ContactStore::fill_pair(std::uint32_t i, std::uint32_t j, std::size_t lane) {
  body[2 * lane] = numbers_.number(i);
  body[2 * lane + 1] = numbers_.number(j);
  rsum[lane] = b_.radius[i] + b_.radius[j];
  if (model_.model == Model::plain && !model_.bounce) return;
  const BodyProperties& ia = alike_ != nullptr ? *alike_ : b_.properties(b_.id[i]);
  const BodyProperties& ib = alike_ != nullptr ? *alike_ : b_.properties(b_.id[j]);
  if (model_.bounce) e[lane] = std::max(ia.restitution, ib.restitution);
  if (model_.model == Model::plain) return;
  const float w = ia.inv_mass + ib.inv_mass;
  wa[lane] = ia.inv_mass;
  wb[lane] = ib.inv_mass;
  mass[lane] = w > 0 ? 1 / w : 0;
  if (model_.model == Model::massed) return;
  mu[lane] = mixed_friction(ia.friction, ib.friction);
  qa[lane] = ia.rim_gain;
  qb[lane] = ib.rim_gain;
  const float wt = w + ia.rim_gain + ib.rim_gain;
  tmass[lane] = wt > 0 ? 1 / wt : 0;
}

// Fills the lanes of a layout that have no contact.
template <class Each>
void ContactStore::pad(const Counts& counts, const Counts& begin, const Each& each) {
  for (std::uint32_t c = 0; c < kColours; ++c) {
    for (std::uint32_t l = counts[c]; l < blocks_of(counts[c]) * kBlock; ++l) each(begin[c] + l);
  }
  for (const std::uint32_t c : {kOverflow, kLoadedOverflow}) {
    for (std::uint32_t l = 0; l < counts[c] * kBlock; ++l) {
      if (l % kBlock != 0) each(begin[c] + l);
    }
  }
}

// Makes a lane that does nothing: a resting dummy beyond the bodies against itself, far apart.
void ContactStore::pad_pair(std::size_t lane, std::uint32_t dummy) {
  body[2 * lane] = dummy;
  body[2 * lane + 1] = dummy + 1;
  rsum[lane] = -1;
  impulse[lane] = 0;
  if (model_.bounce) {
    e[lane] = 0;
    impact[lane] = 1;
  }
  if (model_.model == Model::plain) return;
  wa[lane] = wb[lane] = mass[lane] = 0;
  if (model_.model == Model::massed) return;
  mu[lane] = qa[lane] = qb[lane] = tmass[lane] = friction[lane] = 0;
}

// Lays out the pairs of a strip in order. Calls each(pair, lane) once all is set but the impulses.
template <class Each>
void ContactStore::place_pairs(PairTable& table, std::size_t index, const Each& each) {
  const Strip& s = table.strips[index];
  const Counts& counts = counts_[index];
  // Each strip has two dummies beyond the last block of bodies.
  const auto dummy = numbers_.dummies() + 2 * static_cast<std::uint32_t>(index);
  Counts next = Layout(counts, s.block_begin, s.loaded).begin;
  pad(counts, next, [&](std::uint32_t lane) { pad_pair(lane, dummy); });
  for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) {
    const std::uint32_t c = colour_[p];
    const std::uint32_t at = next[c];
    next[c] += c < kColours ? 1 : kBlock;
    table.contact[p] = at;
    fill_pair(table.owner[p], table.other[p], at);
    each(p, at);
  }
}

void ContactStore::lay_out_strip(PairTable& table, const PairTable& old, const std::uint32_t* from,
                                 const TouchMemory& recent, std::size_t index) {
  const bool rough = model_.model == Model::rough, plain = model_.model == Model::plain;
  const bool carry = old.body_count != 0;
  place_pairs(table, index, [&](std::uint32_t p, std::uint32_t at) {
    const std::uint32_t i = table.owner[p], j = table.other[p];
    const std::uint32_t before =
        !carry ? kNoLane : (from != nullptr ? find_pair(old, from[i], from[j]) : find_pair(old, i, j));
    impulse[at] = before == kNoLane ? 0.0f : pressing(old_impulse_[before]);
    if (rough) friction[at] = before == kNoLane ? 0.0f : old_friction_[before];
    if (before != kNoLane || recent.empty()) return;
    if (const Touch* touch = recent.find(TouchKey::bodies(b_.id[i], b_.id[j]))) {
      const float unit = touch->times(plain, b_.properties(b_.id[i]).mass);
      impulse[at] = unit * touch->impulse[0];
      if (rough) friction[at] = unit * touch->friction[0];
    }
  });
}

void ContactStore::lift(const PairTable& table) {
  const Strip& s = table.strips.back();
  const bool rough = model_.model == Model::rough;
  lifted_.clear();
  for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) {
    const std::uint32_t at = table.contact[p];
    lifted_.push_back({table.owner[p], table.other[p], impulse[at], rough ? friction[at] : 0.0f});
  }
}

// The pairs that the strip kept come first, as before; then come those of renewed bodies in order.
void ContactStore::lay_out_renewed(PairTable& table) {
  const bool rough = model_.model == Model::rough;
  auto before = lifted_.cbegin();
  place_pairs(table, table.strips.size() - 1, [&](std::uint32_t p, std::uint32_t at) {
    const std::uint32_t i = table.owner[p], j = table.other[p];
    if (p >= table.renewed_begin) {
      while (before != lifted_.cend() && (before->owner != i ? before->owner < i : before->other < j)) ++before;
    }
    const bool known = before != lifted_.cend() && before->owner == i && before->other == j;
    impulse[at] = known ? pressing(before->impulse) : 0.0f;
    if (rough) friction[at] = known ? before->friction : 0.0f;
    if (known) ++before;
  });
}

void ContactStore::renew(bool static_contacts, PairTable& table) {
  const std::size_t last = table.strips.size() - 1;
  colour_.reserve_loosely(table.pair_room);
  table.strips[last].loaded = loads_.any() && is_loaded(table, last);
  colour_strip(table, last);
  if (static_contacts) swap_statics();
  place_strips(table);
  make_room(std::size_t{pair_blocks_} * kBlock, std::size_t{static_blocks_} * kBlock);
  lay_out_renewed(table);
  if (static_contacts) {
    const TouchMemory none;
    pool_.run(table.strips.size(), [&](std::size_t strip) {
      lay_out_statics(table, none, strip, [](const StaticPair& pair) { return pair.contact; });
    });
  }
  ++builds_;
}

// Writes all numbers of a static contact into its lane but normal and impulses.
void ContactStore::fill_static(const StaticPair& pair, std::size_t lane) {
  s_body[lane] = numbers_.number(pair.body);
  s_shape[lane] = pair.shape;
  const BodyProperties& properties = b_.properties(b_.id[pair.body]);
  const bool is_wall = pair.shape >= kWallLeft;
  const float we = is_wall ? static_cast<float>(wall_.restitution) : statics_[pair.shape].restitution;
  const float wm = is_wall ? static_cast<float>(wall_.friction) : statics_[pair.shape].friction;
  if (model_.bounce) s_e[lane] = std::max(properties.restitution, we);
  if (model_.model == Model::plain) return;
  s_wb[lane] = properties.inv_mass;
  s_mass[lane] = properties.inv_mass > 0 ? 1 / properties.inv_mass : 0;
  if (model_.model == Model::massed) return;
  s_mu[lane] = mixed_friction(properties.friction, wm);
  s_qb[lane] = properties.rim_gain;
  const float wt = properties.inv_mass + properties.rim_gain;
  s_tmass[lane] = wt > 0 ? 1 / wt : 0;
}

// Makes a static lane that does nothing: a resting dummy, far from anything.
void ContactStore::pad_static(std::size_t lane, std::uint32_t dummy) {
  s_body[lane] = dummy;
  s_shape[lane] = kNoSlot;
  s_nx[lane] = 0;
  s_ny[lane] = 1;
  s_gap[lane] = 1;
  s_base_x[lane] = s_base_y[lane] = s_rsum[lane] = 0;
  s_refresh[lane] = std::numeric_limits<float>::infinity();
  s_impulse[lane] = 0;
  if (model_.bounce) {
    s_e[lane] = 0;
    s_impact[lane] = 1;
  }
  if (model_.model == Model::plain) return;
  s_wb[lane] = s_mass[lane] = 0;
  if (model_.model == Model::massed) return;
  s_mu[lane] = s_qb[lane] = s_tmass[lane] = s_friction[lane] = 0;
}

// before(pair) gives the lane that a static contact had, or kNoLane.
template <class Before>
void ContactStore::lay_out_statics(PairTable& table, const TouchMemory& recent, std::size_t index,
                                   const Before& lane_before) {
  std::vector<StaticPair>& list = table.static_contacts[index];
  if (list.empty()) return;
  const Strip& s = table.strips[index];
  const Counts& counts = static_counts_[index];
  const auto dummy = numbers_.dummies() + 2 * static_cast<std::uint32_t>(index);
  Counts next = Layout(counts, s.static_begin, s.loaded).begin;
  pad(counts, next, [&](std::uint32_t lane) { pad_static(lane, dummy); });
  each_static(s, list, [&](StaticPair& pair, std::uint32_t c) {
    const std::uint32_t at = next[c];
    next[c] += c < kColours ? 1 : kBlock;
    const std::uint32_t before = lane_before(pair);
    const auto kept = [&](const Column<float>& old) { return before == kNoLane ? 0.0f : old[before]; };
    pair.contact = at;
    fill_static(pair, at);
    s_impulse[at] = pressing(kept(old_s_impulse_));
    // The narrow phase keeps a pressed contact on the side where it was.
    s_nx[at] = kept(old_s_nx_);
    s_ny[at] = kept(old_s_ny_);
    if (rough()) s_friction[at] = kept(old_s_friction_);
    if (before == kNoLane && !recent.empty()) recall_static(recent, pair, at);
  });
}

// Gives a new contact the impulse that it had before one of its sides fell asleep or woke.
void ContactStore::recall_static(const TouchMemory& recent, const StaticPair& pair, std::size_t lane) {
  const bool asleep = pair.shape < kWallLeft && statics_[pair.shape].asleep;
  const std::uint32_t id = b_.id[pair.body];
  const Touch* touch =
      recent.find(asleep ? TouchKey::bodies(id, statics_[pair.shape].owner) : TouchKey::fixed(id, pair.shape));
  if (touch == nullptr) return;
  const float unit = touch->times(model_.model == Model::plain, b_.properties(id).mass);
  s_impulse[lane] = unit * touch->impulse[0];
  if (rough()) s_friction[lane] = unit * touch->friction[0];
}

void ContactStore::begin(ContactModel model, const BodyProperties* alike, PairTable& table) {
  model_ = model;
  alike_ = alike;
  const std::size_t strips = table.strips.size();
  counts_.resize(std::max(counts_.size(), strips));
  static_counts_.resize(counts_.size());
  used_.reserve(kernels::round_up_block(b_.count));
  colour_.reserve_loosely(table.pair_room);
  table.contact.reserve_loosely(table.pair_room);
  for (Strip& s : table.strips) s.loaded = false;
  if (loads_.any()) {
    pool_.run(strips, [&](std::size_t k) { table.strips[k].loaded = is_loaded(table, k); });
  }
}

void ContactStore::colour(const PairTable& table, std::size_t begin, std::size_t end) {
  run_phases(table.strips.size(), begin, end, pool_, [&](std::size_t strip) { colour_strip(table, strip); });
}

// Finds out which blocks each strip has.
void ContactStore::place_strips(PairTable& table) {
  pair_blocks_ = static_blocks_ = colours_ = 0;
  pair_count_ = static_count_ = loaded_blocks_ = 0;
  for (std::size_t k = 0; k < table.strips.size(); ++k) {
    Strip& s = table.strips[k];
    Counts& static_contacts = static_counts_[k];
    static_contacts.fill(0);
    each_static(s, table.static_contacts[k], [&](const StaticPair&, std::uint32_t c) { ++static_contacts[c]; });
    const Layout pairs(counts_[k], pair_blocks_, s.loaded), fixed(static_contacts, static_blocks_, s.loaded);
    s.block_begin = pair_blocks_;
    s.loaded_begin = pairs.loaded;
    s.block_end = pair_blocks_ = pairs.end;
    s.static_begin = static_blocks_;
    s.static_loaded_begin = fixed.loaded;
    s.static_end = static_blocks_ = fixed.end;
    s.colours = kColours;
    while (s.colours != 0 && counts_[k][s.colours - 1] == 0) --s.colours;
    colours_ = std::max(colours_, s.colours);
    pair_count_ += s.pair_end - s.pair_begin;
    static_count_ += table.static_contacts[k].size();
    const auto loaded = (s.block_end - s.loaded_begin) + (s.static_end - s.static_loaded_begin);
    loaded_blocks_ += std::uint64_t{loaded} * (HeavyLoads::kSweeps - 1);
  }
}

void ContactStore::lay_out(PairTable& table, const PairTable& old, const std::uint32_t* from, const TouchMemory& recent,
                           std::size_t begin, std::size_t end) {
  if (begin == 0) {
    place_strips(table);
    swap_impulses();
    laying_ = true;
    make_room(std::size_t{pair_blocks_} * kBlock, std::size_t{static_blocks_} * kBlock);
  }
  pool_.run(end - begin, [&](std::size_t n) {
    lay_out_strip(table, old, from, recent, begin + n);
    lay_out_statics(table, recent, begin + n, [&](const StaticPair& pair) {
      return find_static(old, from != nullptr ? from[pair.body] : pair.body, pair.shape);
    });
  });
}

}  // namespace psim
