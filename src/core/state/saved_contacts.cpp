#include "state/saved_contacts.h"

#include <algorithm>
#include <numeric>

#include "bodies/body_store.h"
#include "state/describe.h"

namespace psim {

void SavedContacts::gather(const PairTable& table, const ContactStore& contacts, bool any, bool named, bool gaps,
                           const std::uint32_t* ids) {
  *this = {};
  strip_pairs_.resize(table.strips.size());
  strip_statics_.resize(table.strips.size());
  owned_.resize(table.body_count);
  if (!any) return;
  const bool rough = contacts.model().rough();
  const auto take = [&](int first, int last, std::uint32_t lane) {
    for (int k = first; k < last; ++k) {
      if (rough || !is_friction(k)) carried_[k].push_back(column(contacts, k)[lane]);
    }
  };
  const auto dead = [&](std::uint32_t slot) { return named && ids != nullptr && ids[slot] == kNoSlot; };
  for (std::size_t k = 0; k < table.strips.size(); ++k) {
    const Strip& strip = table.strips[k];
    const std::uint32_t end = named ? std::min(strip.pair_end, table.renewed_begin) : strip.pair_end;
    for (std::uint32_t p = strip.pair_begin; p < end; ++p) {
      const std::uint32_t owner = table.owner[p], other = table.other[p];
      if (dead(owner) || dead(other)) continue;
      take(kImpulse, kStatic, table.contact[p]);
      ++strip_pairs_[k];
      if (!named) continue;
      other_.push_back(other);
      ++owned_[owner];
    }
    for (const StaticPair& pair : table.static_contacts[k]) {
      if (dead(pair.body)) continue;
      take(kStatic, gaps ? kColumns : kGap, pair.contact);
      ++strip_statics_[k];
      if (!named) continue;
      s_body_.push_back(pair.body);
      s_shape_.push_back(pair.shape);
    }
  }
  if (!named || table.strips.empty()) return;
  for (std::uint32_t p = table.renewed_begin; p < table.strips.back().pair_end; ++p) {
    if (!dead(table.owner[p]) && !dead(table.other[p])) renewed_.push_back(contacts.impulse_of(table, p));
  }
}

void SavedContacts::describe(Archive& a, const PairTable& table, const StaticShapes& statics, bool named) {
  a.packed(strip_pairs_);
  a.packed(strip_statics_);
  for (auto& column : carried_) a.plain(column);
  const std::size_t pairs = carried_[kImpulse].size(), statics_met = carried_[kStatic].size();
  const auto sum = [](const auto& list) { return std::accumulate(list.begin(), list.end(), std::uint64_t{0}); };
  a.require(sum(strip_pairs_) == pairs && sum(strip_statics_) == statics_met);
  for (int k = kFriction; k < kColumns; ++k) {
    const bool may_be_empty = is_friction(k) || k == kGap;
    a.require((may_be_empty && empty(k)) || carried_[k].size() == (k < kStatic ? pairs : statics_met));
  }
  if (!named) return;
  a.packed(owned_);
  a.packed(other_, table.body_count);
  a.packed(s_body_, table.body_count);
  a.packed(s_shape_);
  a.list(renewed_, [&](PairImpulse& pair) {
    a.index(table.body_count, pair.owner, pair.other);
    values(a, pair.impulse, pair.friction);
    a.require(pair.owner < pair.other);
  });
  if (!a.loading()) return;
  const auto name = [](const PairImpulse& pair) { return std::pair(pair.owner, pair.other); };
  a.require(std::ranges::is_sorted(renewed_, {}, name) && (renewed_.empty() || table.body_count != 0));
  for (const std::uint32_t shape : s_shape_) {
    a.require(shape < statics.size() || (shape >= kWallLeft && shape <= kWallTop));
  }
  a.require(owned_.size() == table.body_count && other_.size() == pairs && s_body_.size() == statics_met &&
            s_shape_.size() == s_body_.size() && strip_pairs_.size() == table.strips.size() &&
            strip_statics_.size() == table.strips.size());
  for (std::size_t k = 0; k < table.strips.size() && a.ok(); ++k) {
    const Strip& strip = table.strips[k];
    a.require(std::accumulate(owned_.data() + strip.body_begin, owned_.data() + strip.body_end, std::uint64_t{0}) ==
              strip_pairs_[k]);
  }
}

void SavedContacts::make_table(PairTable& table, ContactStore& c) const {
  const std::size_t all = carried_[kImpulse].size() + renewed_.size();
  const bool rough = c.model().rough();
  table.spare(table.body_count, all + 1);
  table.pair_room = static_cast<std::uint32_t>(all);
  table.renewed_begin = PairTable::kNoneRenewed;
  table.static_contacts.resize(std::max(table.static_contacts.size(), table.strips.size()));
  table.near_scratch.resize(table.static_contacts.size());
  c.pairs.gap.reserve(all + 1);
  for (int k = 0; k < kColumns; ++k) {
    if (is_friction(k) && !rough) continue;
    column(c, k).reserve((k < kStatic ? all : carried_[kStatic].size()) + 1);  // even of none: the column is there
    std::copy(carried_[k].begin(), carried_[k].end(), column(c, k).data());
  }
  std::copy(other_.begin(), other_.end(), table.other.data());
  std::iota(table.contact.data(), table.contact.data() + all, 0u);
  std::uint32_t p = 0, s = 0;
  for (std::size_t k = 0; k < table.strips.size(); ++k) {
    Strip& strip = table.strips[k];
    strip.pair_begin = p;
    for (std::uint32_t i = strip.body_begin; i < strip.body_end; ++i) {
      table.first[i] = p;
      std::fill_n(table.owner.data() + p, owned_[i], i);
      p += owned_[i];
    }
    strip.pair_end = p;
    table.static_contacts[k].clear();
    for (std::uint32_t n = 0; n < strip_statics_[k]; ++n, ++s) {
      table.static_contacts[k].push_back({s_body_[s], s_shape_[s], s});
    }
  }
  table.mark_strips();
  if (renewed_.empty()) return;
  table.renewed_begin = p;  // behind those of the strips
  for (const PairImpulse& pair : renewed_) {
    table.owner[p] = pair.owner;
    table.other[p] = pair.other;
    c.pairs.impulse[p] = pair.impulse;
    if (rough) c.pairs.friction[p] = pair.friction;
    ++p;
  }
  table.strips.back().pair_end = p;
}

bool SavedContacts::put_back(const PairTable& table, ContactStore& c) const {
  if (strip_pairs_.size() != table.strips.size() || strip_statics_.size() != table.strips.size()) return false;
  const auto put = [&](int first, int last, std::size_t from, std::uint32_t lane) {
    for (int k = first; k < last; ++k) {
      if (!empty(k) && (c.model().rough() || !is_friction(k))) column(c, k)[lane] = carried_[k][from];
    }
  };
  std::size_t pair = 0, fixed = 0;
  for (std::size_t k = 0; k < table.strips.size(); ++k) {
    const Strip& strip = table.strips[k];
    if (strip.pair_end - strip.pair_begin != strip_pairs_[k] || table.static_contacts[k].size() != strip_statics_[k]) {
      return false;
    }
    for (std::uint32_t p = strip.pair_begin; p < strip.pair_end; ++p) put(kImpulse, kStatic, pair++, table.contact[p]);
    for (const StaticPair& at : table.static_contacts[k]) put(kStatic, kColumns, fixed++, at.contact);
  }
  return true;
}

}  // namespace psim
