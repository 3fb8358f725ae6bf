// What contacts carry, out of a world into a saved state and back (saved.h).
#include <algorithm>

#include "float_settings.h"
#include "image.h"

namespace psim {

namespace {

// A body's count past what a byte holds.
void count_many(std::vector<std::uint32_t>& many, std::uint32_t count, bool another) {
  if (!another) return;
  if (count == Saved::kMany) many.push_back(count);
  many.back() = count;
}

}  // namespace

// each(a number of a contact, what is kept of it): in lists that last, in their order.
template <class Each>
void World::Impl::each_lane(const Each& each) {
  Saved& s = saved;
  const auto visit = [&](Column<float>& column, Refilled<float>& kept, std::size_t lane,
                         std::size_t at) {
    if (!kept.empty()) each(column[lane], kept[at]);
  };
  pool.run(table.strips.size(), [&](std::size_t k) {
    const Strip& strip = table.strips[k];
    std::size_t at = s.strip_pairs[k];
    for (std::uint32_t p = strip.pair_begin; p < strip.pair_end; ++p, ++at) {
      const std::size_t lane = table.contact[p];
      visit(contacts.impulse, s.impulse, lane, at);
      visit(contacts.friction, s.friction, lane, at);
      visit(contacts.gap, s.gap, lane, at);
    }
    at = s.strip_singles[k];
    for (const SinglePair& single : table.singles[k]) {
      visit(contacts.s_impulse, s.s_impulse, single.contact, at);
      visit(contacts.s_friction, s.s_friction, single.contact, at);
      visit(contacts.s_nx, s.s_nx, single.contact, at);
      visit(contacts.s_ny, s.s_ny, single.contact, at);
      visit(contacts.s_gap, s.s_gap, single.contact, at++);
    }
  });
}

// Copies what contacts carry. `lasting`: the lists will be made again, in the same order.
void World::Impl::keep_contacts(bool lasting) {
  Saved& s = saved;
  s.clear_names();
  if (lasting) {
    std::size_t pairs = 0, singles = 0;
    for (std::size_t k = 0; k < table.strips.size(); ++k) {
      s.strip_pairs.push_back(static_cast<std::uint32_t>(pairs));  // where it begins
      s.strip_singles.push_back(static_cast<std::uint32_t>(singles));
      pairs += table.strips[k].pair_end - table.strips[k].pair_begin;
      singles += table.singles[k].size();
    }
    s.make_room(pairs, singles, contacts.rough(), !sleepers.empty());
    each_lane([](float& lane, float& kept) { kept = lane; });
    return;
  }
  s.of_body.assign(table.body_count, 0);
  s.strip_pairs.assign(table.strips.size(), 0);
  s.strip_singles.assign(table.strips.size(), 0);
  if (!impulses_valid || table.body_count == 0) {
    s.make_room(0, 0, false, false);
    return;
  }
  keep_pairs();
  keep_singles();
}

// The pairs that carry something: every strip writes its own where it would if all were kept, then the gaps close.
void World::Impl::keep_pairs() {
  Saved& s = saved;
  const bool rough = contacts.rough(), gaps = !sleepers.empty();
  const bool all = gaps || !sleepers.recent.empty();  // even one without an impulse is known
  std::uint32_t room = 0;
  s.strip_room.clear();
  for (const Strip& strip : table.strips) {  // whose pairs need not lie in this order in the table
    s.strip_room.push_back(room);
    room += strip.pair_end - strip.pair_begin;
  }
  s.make_room(room, 0, rough, gaps);
  s.other.resize(room);
  s.strip_many.resize(std::max(s.strip_many.size(), table.strips.size()));
  pool.run(table.strips.size(), [&](std::size_t k) {
    const Strip& strip = table.strips[k];
    // By pointers of its own: the bytes that it writes might else be any of them.
    const std::uint32_t* const contact = table.contact.data();
    const std::uint32_t* const other = table.other.data();
    const std::uint32_t* const owners = table.owner.data();
    const float* const impulses = contacts.impulse.data();
    const float* const frictions = rough ? contacts.friction.data() : nullptr;
    const float* const depths = gaps ? contacts.gap.data() : nullptr;
    std::uint32_t* const to_other = s.other.data();
    float *const to_impulse = s.impulse.data(), *const to_friction = s.friction.data(),
                 *const to_gap = s.gap.data();
    std::uint8_t* const of_body = s.of_body.data();
    const std::uint32_t every = all ? 1 : 0, end = std::min(strip.pair_end, table.renewed_begin);
    std::uint32_t to = s.strip_room[k], owner = kNoSlot, count = 0;
    for (std::uint32_t p = strip.pair_begin; p < end; ++p) {
      const std::uint32_t lane = contact[p];
      const float impulse = impulses[lane], friction = frictions ? frictions[lane] : 0.0f;
      to_other[to] = other[p];
      to_impulse[to] = impulse;
      if (frictions) to_friction[to] = friction;
      if (depths) to_gap[to] = depths[lane];
      // Without branches: whether a contact pressed cannot be foreseen.
      const std::uint32_t one = every | static_cast<std::uint32_t>(impulse > 0) |
                                static_cast<std::uint32_t>(friction != 0);
      to += one;
      count = (count & (0u - static_cast<std::uint32_t>(owners[p] == owner))) + one;
      owner = owners[p];
      of_body[owner] = static_cast<std::uint8_t>(std::min<std::uint32_t>(count, Saved::kMany));
      if (count >= Saved::kMany) count_many(s.strip_many[k], count, one != 0);
    }
    s.strip_pairs[k] = to - s.strip_room[k];
  });
  std::size_t kept = 0;
  for (std::size_t k = 0; k < table.strips.size(); ++k) {
    const auto close = [&](auto& column) {
      const auto from = column.begin() + s.strip_room[k];
      std::copy(from, from + s.strip_pairs[k], column.begin() + kept);
    };
    if (kept != s.strip_room[k]) {
      close(s.other);
      close(s.impulse);
      if (rough) close(s.friction);
      if (gaps) close(s.gap);
    }
    kept += s.strip_pairs[k];
    s.many.insert(s.many.end(), s.strip_many[k].begin(), s.strip_many[k].end());
    s.strip_many[k].clear();
  }
  s.make_room(kept, 0, rough, gaps);
  s.other.resize(kept);
  for (std::uint32_t p = table.renewed_begin; p < table.strips.back().pair_end; ++p) {
    const std::uint32_t lane = table.contact[p];
    s.renewed.push_back({table.owner[p], table.other[p], contacts.impulse[lane],
                         rough ? contacts.friction[lane] : 0.0f, gaps ? contacts.gap[lane] : 0.0f});
  }
}

void World::Impl::keep_singles() {
  Saved& s = saved;
  const bool rough = contacts.rough(), gaps = !sleepers.empty();
  std::size_t n = 0;
  for (std::size_t k = 0; k < table.strips.size(); ++k) n += table.singles[k].size();
  s.make_room(s.other.size(), n, rough, gaps);
  std::size_t at = 0;
  for (std::size_t k = 0; k < table.strips.size(); ++k) {
    s.strip_singles[k] = static_cast<std::uint32_t>(table.singles[k].size());
    for (const SinglePair& single : table.singles[k]) {
      const std::uint32_t lane = single.contact;
      s.s_body.push_back(single.body);
      s.s_shape.push_back(single.shape);
      s.s_impulse[at] = contacts.s_impulse[lane];
      s.s_nx[at] = contacts.s_nx[lane];
      s.s_ny[at] = contacts.s_ny[lane];
      if (rough) s.s_friction[at] = contacts.s_friction[lane];
      if (gaps) s.s_gap[at] = contacts.s_gap[lane];
      ++at;
    }
  }
}

// The saved pairs become the table that impulses are carried from.
void World::Impl::take_pairs() {
  const Saved& s = saved;
  ArchiveCopies copies;
  const auto put = [&copies](auto& to, const auto& from) {
    to.reserve(from.size() + 1);  // even of none: the column is there
    copies.add(to.data(), from.data(), from.size() * sizeof from[0]);
  };
  put(contacts.impulse, s.impulse);
  put(contacts.gap, s.gap.empty() ? s.impulse : s.gap);
  put(contacts.s_impulse, s.s_impulse);
  put(contacts.s_nx, s.s_nx);
  put(contacts.s_ny, s.s_ny);
  put(contacts.s_gap, s.s_gap.empty() ? s.s_impulse : s.s_gap);
  if (contacts.rough()) {
    put(contacts.friction, s.friction);
    put(contacts.s_friction, s.s_friction);
  }
  put(table.other, s.other);
  copies.run(pool);
  const auto n = static_cast<std::uint32_t>(s.other.size());
  table.first.reserve(std::size_t{table.body_count} + 1);
  table.owner.reserve(n);
  table.contact.reserve(n);
  table.singles.resize(std::max(table.singles.size(), table.strips.size()));
  table.found.resize(table.singles.size());
  table.pair_room = n;
  std::uint32_t pairs = 0, single = 0;
  for (std::size_t k = 0; k < table.strips.size(); ++k) {
    Strip& strip = table.strips[k];
    strip.pair_begin = pairs;
    strip.pair_end = pairs += s.strip_pairs[k];
    table.singles[k].clear();
    for (std::uint32_t end = single + s.strip_singles[k]; single < end; ++single) {
      table.singles[k].push_back({s.s_body[single], s.s_shape[single], single});
    }
  }
  pool.run(table.strips.size(), [&](std::size_t k) {
    const Strip& strip = table.strips[k];
    const std::uint8_t* const of_body = s.of_body.data();
    auto many = s.many.begin();
    if (many != s.many.end()) many += std::count(of_body, of_body + strip.body_begin, Saved::kMany);
    std::uint32_t p = strip.pair_begin;
    for (std::uint32_t i = strip.body_begin; i < strip.body_end; ++i) {
      table.first[i] = p;
      const std::uint32_t count = of_body[i] < Saved::kMany ? of_body[i] : *many++;
      for (const std::uint32_t end = p + count; p < end; ++p) {
        table.owner[p] = i;
        table.contact[p] = p;
      }
    }
  });
  table.mark_strips();
  take_renewed();
}

// Pairs that are no strip's, behind those of the strips.
void World::Impl::take_renewed() {
  table.renewed_begin = PairTable::kNoneRenewed;
  if (saved.renewed.empty()) return;
  table.renewed_begin = table.pair_room;
  std::uint32_t p = table.pair_room;
  table.pair_room = table.strips.back().pair_end = p + static_cast<std::uint32_t>(saved.renewed.size());
  for (auto* column : {&table.owner, &table.other, &table.contact}) column->reserve(table.pair_room);
  for (auto* column : {&contacts.impulse, &contacts.gap}) column->reserve(table.pair_room);
  if (contacts.rough()) contacts.friction.reserve(table.pair_room);
  for (const Saved::Pair& pair : saved.renewed) {
    table.owner[p] = pair.owner;
    table.other[p] = pair.other;
    contacts.impulse[p] = pair.impulse;
    contacts.gap[p] = pair.gap;
    if (contacts.rough()) contacts.friction[p] = pair.friction;
    table.contact[p] = p;
    ++p;
  }
}

void World::Impl::make_lists_again() {
  saved.missing = false;
  const FloatSettings settings;
  if (loose) {
    broad.build_again(bodies, shapes, kernels, pool, candidates);
    return;
  }
  renewal.turn_back(bodies);
  broad.build_again(bodies, shapes, kernels, pool, table);
  lists_stale = impulses_valid = true;
  old_table.body_count = 0;
  const Ahead now = ahead;
  const double visits = loads.visits();
  std::vector<Saved::Done> done;
  done.swap(saved.done);
  ahead = {};
  ahead.part = Part::group;
  ahead.laid = true;
  StepReport ignored;
  while (ahead.part != after_contacts()) work({}, ignored, pieces());
  accept_work();
  if (renewal.renewed() != 0) {
    contacts.lift(table);
    renewal.renew_again(broad, bodies, shapes, kernels, pool, table);
    contacts.renew(bodies, shapes, desc.wall, renewal.singles_changed(), table, pool);
  }
  ahead = now;
  saved.done.swap(done);
  loads.set_visits(visits);
  contacts.set_builds(saved.builds);
  each_lane([](float& lane, float& kept) { lane = kept; });
}

}  // namespace psim
