#include "state/saved_contacts.h"

#include <algorithm>
#include <numeric>

#include "state/describe.h"

namespace psim {

void SavedContacts::clear() {
  for (auto* list : {&strip_pairs_, &strip_statics_, &owned_, &other_, &s_body_, &s_shape_}) list->clear();
  for (auto* list : {&impulse_, &friction_, &s_impulse_, &s_friction_, &s_nx_, &s_ny_, &s_gap_}) list->clear();
  renewed_.clear();
}

void SavedContacts::gather_none(const PairTable& table) {
  clear();
  strip_pairs_.resize(table.strips.size());
  strip_statics_.resize(table.strips.size());
  owned_.resize(table.body_count);
}

void SavedContacts::gather(const PairTable& table, const ContactStore& contacts, bool named, bool gaps) {
  clear();
  const bool rough = contacts.rough();
  for (std::size_t k = 0; k < table.strips.size(); ++k) {
    const Strip& strip = table.strips[k];
    const std::uint32_t end = named ? std::min(strip.pair_end, table.renewed_begin) : strip.pair_end;
    for (std::uint32_t p = strip.pair_begin; p < end; ++p) {
      const std::uint32_t lane = table.contact[p];
      impulse_.push_back(contacts.impulse[lane]);
      if (rough) friction_.push_back(contacts.friction[lane]);
    }
    for (const StaticPair& pair : table.static_contacts[k]) {
      s_impulse_.push_back(contacts.s_impulse[pair.contact]);
      if (rough) s_friction_.push_back(contacts.s_friction[pair.contact]);
      s_nx_.push_back(contacts.s_nx[pair.contact]);
      s_ny_.push_back(contacts.s_ny[pair.contact]);
      if (gaps) s_gap_.push_back(contacts.s_gap[pair.contact]);
      if (!named) continue;
      s_body_.push_back(pair.body);
      s_shape_.push_back(pair.shape);
    }
    strip_pairs_.push_back(end - strip.pair_begin);
    strip_statics_.push_back(static_cast<std::uint32_t>(table.static_contacts[k].size()));
    if (!named) continue;
    other_.insert(other_.end(), table.other.data() + strip.pair_begin, table.other.data() + end);
    for (std::uint32_t i = strip.body_begin; i < strip.body_end; ++i) {
      const std::uint32_t next = i + 1 == strip.body_end ? end : table.first[i + 1];
      owned_.push_back(next - table.pairs_of_begin(i));
    }
  }
  if (!named || table.strips.empty()) return;
  for (std::uint32_t p = table.renewed_begin; p < table.strips.back().pair_end; ++p) {
    const std::uint32_t lane = table.contact[p];
    renewed_.push_back(
        {table.owner[p], table.other[p], contacts.impulse[lane], rough ? contacts.friction[lane] : 0.0f});
  }
}

template <class A>
void SavedContacts::describe(A& a, const PairTable& table, const StaticShapes& statics, bool named) {
  a.packed(strip_pairs_);
  a.packed(strip_statics_);
  for (auto* list : {&impulse_, &friction_, &s_impulse_, &s_friction_, &s_nx_, &s_ny_, &s_gap_}) a.plain(*list);
  const auto sum = [](const auto& list) { return std::accumulate(list.begin(), list.end(), std::uint64_t{0}); };
  a.require(sum(strip_pairs_) == impulse_.size() && sum(strip_statics_) == s_impulse_.size());
  a.require(friction_.empty() || friction_.size() == impulse_.size());
  for (const auto* list : {&s_friction_, &s_nx_, &s_ny_, &s_gap_}) {
    a.require((list->empty() && list != &s_nx_ && list != &s_ny_) || list->size() == s_impulse_.size());
  }
  if (!named) return;
  a.packed(owned_);
  a.packed(other_, table.body_count);
  a.packed(s_body_, table.body_count);
  a.packed(s_shape_);
  a.list(renewed_, [&](Renewed& pair) {
    a.index(table.body_count, pair.owner, pair.other);
    numbers(a, pair.impulse, pair.friction);
    a.require(pair.owner < pair.other);
  });
  if constexpr (!A::kLoading) return;
  const auto before = [](const Renewed& p, const Renewed& q) {
    return p.owner != q.owner ? p.owner < q.owner : p.other < q.other;
  };
  a.require(std::is_sorted(renewed_.begin(), renewed_.end(), before) && (renewed_.empty() || table.body_count != 0));
  for (const std::uint32_t shape : s_shape_) {
    a.require(shape < statics.size() || (shape >= kWallLeft && shape <= kWallTop));
  }
  a.require(owned_.size() == table.body_count && other_.size() == impulse_.size() &&
            s_body_.size() == s_impulse_.size() && s_shape_.size() == s_body_.size() &&
            strip_pairs_.size() == table.strips.size() && strip_statics_.size() == table.strips.size());
  for (std::size_t k = 0; k < table.strips.size() && a.ok(); ++k) {
    const Strip& strip = table.strips[k];
    a.require(std::accumulate(owned_.data() + strip.body_begin, owned_.data() + strip.body_end, std::uint64_t{0}) ==
              strip_pairs_[k]);
  }
}

void SavedContacts::make_table(PairTable& table, ContactStore& c) const {
  const std::size_t all = impulse_.size() + renewed_.size(), singles = s_impulse_.size();
  const bool rough = c.rough();
  table.spare(table.body_count, all + 1);
  table.pair_room = static_cast<std::uint32_t>(all);
  table.renewed_begin = PairTable::kNoneRenewed;
  table.static_contacts.resize(std::max(table.static_contacts.size(), table.strips.size()));
  table.found.resize(table.static_contacts.size());
  for (Column<float>* column : {&c.impulse, &c.gap}) column->reserve(all + 1);  // even of none: the column is there
  for (Column<float>* column : {&c.s_impulse, &c.s_nx, &c.s_ny, &c.s_gap}) column->reserve(singles + 1);
  if (rough) {
    c.friction.reserve(all + 1);
    c.s_friction.reserve(singles + 1);
    std::copy(friction_.begin(), friction_.end(), c.friction.data());
    std::copy(s_friction_.begin(), s_friction_.end(), c.s_friction.data());
  }
  std::copy(impulse_.begin(), impulse_.end(), c.impulse.data());
  std::copy(s_impulse_.begin(), s_impulse_.end(), c.s_impulse.data());
  std::copy(s_nx_.begin(), s_nx_.end(), c.s_nx.data());
  std::copy(s_ny_.begin(), s_ny_.end(), c.s_ny.data());
  std::copy(s_gap_.begin(), s_gap_.end(), c.s_gap.data());
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
  for (const Renewed& pair : renewed_) {
    table.owner[p] = pair.owner;
    table.other[p] = pair.other;
    c.impulse[p] = pair.impulse;
    if (rough) c.friction[p] = pair.friction;
    ++p;
  }
  table.strips.back().pair_end = p;
}

bool SavedContacts::put_back(const PairTable& table, ContactStore& c) const {
  if (strip_pairs_.size() != table.strips.size() || strip_statics_.size() != table.strips.size()) return false;
  std::size_t pair = 0, single = 0;
  for (std::size_t k = 0; k < table.strips.size(); ++k) {
    const Strip& strip = table.strips[k];
    if (strip.pair_end - strip.pair_begin != strip_pairs_[k] || table.static_contacts[k].size() != strip_statics_[k]) {
      return false;
    }
    for (std::uint32_t p = strip.pair_begin; p < strip.pair_end; ++p, ++pair) {
      c.impulse[table.contact[p]] = impulse_[pair];
      if (!friction_.empty() && c.rough()) c.friction[table.contact[p]] = friction_[pair];
    }
    for (const StaticPair& at : table.static_contacts[k]) {
      c.s_impulse[at.contact] = s_impulse_[single];
      if (!s_friction_.empty() && c.rough()) c.s_friction[at.contact] = s_friction_[single];
      c.s_nx[at.contact] = s_nx_[single];
      c.s_ny[at.contact] = s_ny_[single];
      if (!s_gap_.empty()) c.s_gap[at.contact] = s_gap_[single];
      ++single;
    }
  }
  return true;
}

PSIM_DESCRIBED(SavedContacts, const PairTable&, const StaticShapes&, bool);

}  // namespace psim
