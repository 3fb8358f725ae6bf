// What contacts carry, out of a world into the bytes of a saved state and back (saved.h). Every strip writes its own
// where it lies in the bytes, and reads it there.
#include <algorithm>
#include <numeric>
#include <utility>

#include "float_settings.h"
#include "image.h"
#include "invariant.h"

namespace psim {

namespace {

// Where what strips have so much of begins, and the sum.
std::uint32_t place(std::vector<std::uint32_t>& first, const std::vector<std::uint32_t>& counts) {
  first.resize(counts.size());
  std::uint32_t sum = 0;
  for (std::size_t k = 0; k < counts.size(); ++k) first[k] = std::exchange(sum, sum + counts[k]);
  return sum;
}

// Pairs by body, up to what a byte holds; `many` has, in turn, what more there is.
void count_pairs(const PairTable& table, const Strip& strip, std::uint8_t* of_body, std::uint32_t* many) {
  if (strip.body_begin == strip.body_end) return;
  const std::uint32_t* const first = table.first.data();
  const std::uint32_t last = strip.body_end - 1;
  const auto count = [&](std::uint32_t i) {  // the first body's is marked
    return (i == last ? strip.pair_end : first[i + 1]) - (first[i] & ~PairTable::kStripStart);
  };
  const auto put = [&](std::uint32_t i, std::uint32_t n) {
    of_body[i] = static_cast<std::uint8_t>(std::min(static_cast<std::int32_t>(n), std::int32_t{Saved::kMany}));
    return n;
  };
  std::uint32_t any = put(strip.body_begin, count(strip.body_begin)) | put(last, count(last));
  for (std::uint32_t i = strip.body_begin + 1; i < last; ++i) any |= put(i, first[i + 1] - first[i]);
  for (std::uint32_t i = strip.body_begin; any >= Saved::kMany && i < strip.body_end; ++i) {
    if (of_body[i] == Saved::kMany) *many++ = count(i);
  }
}

// Pairs of a strip's bodies, all in all.
std::uint32_t count_of(const Saved::InBytes& b, const Strip& strip, std::size_t many) {
  const auto* const of_body = reinterpret_cast<const std::uint8_t*>(b.of_body.from);
  std::uint32_t sum = 0, top = 0;
  for (std::uint32_t i = strip.body_begin; i < strip.body_end; ++i) sum += of_body[i];
  if (sum >= Saved::kMany) {
    const auto many_of = std::count(of_body + strip.body_begin, of_body + strip.body_end, Saved::kMany);
    top = static_cast<std::uint32_t>(many_of);
  }
  for (; top != 0 && many < b.many.count; --top) sum += b.many[many++] - Saved::kMany;
  return sum;
}

}  // namespace

// Columns of what contacts carry, as Carried has them.
std::array<Column<float>*, 7> World::Impl::carried() {
  ContactStore& c = contacts;
  return {&c.impulse, &c.friction, &c.s_impulse, &c.s_friction, &c.s_nx, &c.s_ny, &c.s_gap};
}

// Whether 16 bits name the partners of a strip's bodies: they lie in it and the next one, but for those across a
// periodic world's seam and those of large bodies.
bool World::Impl::partners_are_near(std::size_t index) const {
  const std::size_t large = table.strips.size() - 1, next = index + 1;
  if (index == large || (next == large && desc.boundary == Boundary::periodic)) return false;
  return table.strips[next == large ? index : next].body_end - table.strips[index].body_begin <= 1u << 16;
}

// Where each strip has its contacts in the bytes. In all: what the bytes have of each.
Saved::Lengths World::Impl::place_contacts() {
  Saved& s = saved;
  Saved::Lengths all;
  all.pairs = place(s.first_pair, s.strip_pairs);
  all.singles = place(s.first_single, s.strip_singles);
  s.first_partner.resize(s.strip_pairs.size());
  s.first_many.resize(s.strip_pairs.size());
  for (std::size_t k = 0; k < table.strips.size(); ++k) {
    std::uint32_t& partners = partners_are_near(k) ? all.near : all.far;
    s.first_partner[k] = std::exchange(partners, partners + s.strip_pairs[k]);
    s.first_many[k] = std::exchange(all.many, all.many + s.strip_pairs[k] / Saved::kMany);
  }
  return all;
}

// How many are saved of each strip: none if what they carry is of no use. `lasting`: lists will be made again, in the
// same order.
void World::Impl::count_carried(bool lasting) {
  Saved& s = saved;
  const bool any = lasting || (impulses_valid && table.body_count != 0);
  s.strip_pairs.assign(table.strips.size(), 0);
  s.strip_singles.assign(table.strips.size(), 0);
  for (std::size_t k = 0; k < table.strips.size() && any; ++k) {
    const Strip& strip = table.strips[k];
    s.strip_pairs[k] = (lasting ? strip.pair_end : std::min(strip.pair_end, table.renewed_begin)) - strip.pair_begin;
    s.strip_singles[k] = static_cast<std::uint32_t>(table.singles[k].size());
  }
  const Saved::Lengths all = place_contacts();
  const bool rough = contacts.rough(), gaps = !sleepers.empty();
  Saved::InBytes& b = s.bytes = {};
  for (InPlace<float>* c : {&b.impulse, &b.friction}) c->count = all.pairs;
  for (InPlace<float>* c : {&b.s_impulse, &b.s_friction, &b.s_nx, &b.s_ny, &b.s_gap}) c->count = all.singles;
  if (!rough) b.friction.count = b.s_friction.count = 0;
  if (!gaps) b.s_gap.count = 0;
  s.renewed.clear();
  if (lasting) return;
  for (std::uint32_t p = table.renewed_begin; any && p < table.strips.back().pair_end; ++p) {
    const std::uint32_t lane = table.contact[p];
    s.renewed.push_back({table.owner[p], table.other[p], contacts.impulse[lane],
                         rough ? contacts.friction[lane] : 0.0f});
  }
  b.of_body.count = table.body_count;
  b.near.count = all.near;
  b.far.count = all.far;
  b.many.count = all.many;
  b.s_body.count = b.s_shape.count = all.singles;
}

// each(lane): of the pairs or singles of a strip, in order; by the number of what they carry.
template <class Each>
void World::Impl::each_lane(std::size_t strip, std::size_t column, const Each& each) const {
  if (column < Carried<InPlace>::kOfPairs) {
    const std::uint32_t* const contact = table.contact.data();
    const std::uint32_t begin = table.strips[strip].pair_begin;
    const std::uint32_t end = std::min(begin + saved.strip_pairs[strip], table.strips[strip].pair_end);
    for (std::uint32_t p = begin; p < end; ++p) each(contact[p]);
  } else {
    const std::vector<SinglePair>& singles = table.singles[strip];
    const std::size_t n = std::min<std::size_t>(singles.size(), saved.strip_singles[strip]);
    for (std::size_t k = 0; k < n; ++k) each(singles[k].contact);
  }
}

void World::Impl::write_carried(std::size_t index) {
  const auto columns = carried();
  const auto bytes = saved.bytes.all();
  for (std::size_t c = 0; c < columns.size(); ++c) {
    if (bytes[c]->count == 0) continue;
    const auto& first = c < Carried<InPlace>::kOfPairs ? saved.first_pair : saved.first_single;
    const float* const lanes = columns[c]->data();
    float* to = bytes[c]->room(first[index]);
    each_lane(index, c, [&](std::size_t lane) { *to++ = lanes[lane]; });
  }
}

// Pairs by body, and their partners; singles.
void World::Impl::write_names(std::size_t index) {
  const Saved::InBytes& b = saved.bytes;
  Strip strip = table.strips[index];
  const std::uint32_t pairs = saved.strip_pairs[index], pair_begin = strip.pair_begin, first = strip.body_begin;
  strip.pair_end = pair_begin + pairs;
  std::uint32_t* const many = b.many.room(saved.first_many[index]);
  std::fill_n(many, pairs / Saved::kMany, 0u);
  if (pairs == 0) {
    std::fill(b.of_body.room(first), b.of_body.room(strip.body_end), std::uint8_t{0});
  } else {
    count_pairs(table, strip, b.of_body.room(0), many);
  }
  const std::uint32_t* const other = table.other.data() + pair_begin;
  if (partners_are_near(index)) {
    std::uint16_t* const to = b.near.room(saved.first_partner[index]);
    for (std::uint32_t k = 0; k < pairs; ++k) to[k] = static_cast<std::uint16_t>(other[k] - first);
    PSIM_ASSERT(std::all_of(other, other + pairs, [&](std::uint32_t o) { return o - first < 1u << 16; }));
  } else {
    std::copy_n(other, pairs, b.far.room(saved.first_partner[index]));
  }
  for (std::uint32_t k = 0, at = saved.first_single[index]; k < saved.strip_singles[index]; ++k, ++at) {
    *b.s_body.room(at) = table.singles[index][k].body;
    *b.s_shape.room(at) = table.singles[index][k].shape;
  }
}

// Lists will be made again: what their contacts carry waits.
void World::Impl::keep_carried(Loader& loader) {
  const auto bytes = saved.bytes.all();
  const auto kept = saved.kept.all();
  for (std::size_t c = 0; c < kept.size(); ++c) {
    kept[c]->resize(bytes[c]->count);
    loader.copies().add(kept[c]->data(), bytes[c]->from, bytes[c]->bytes());
  }
  loader.finish(pool);
  saved.bytes = {};
}

// The saved pairs will become the table that impulses are carried from.
void World::Impl::take_pairs(Loader& loader) {
  const Saved::InBytes& b = saved.bytes;
  const auto columns = carried();
  const auto bytes = saved.bytes.all();
  const std::size_t strips = table.strips.size();
  bool sound = saved.strip_pairs.size() == strips && saved.strip_singles.size() == strips;
  const Saved::Lengths all = sound ? place_contacts() : Saved::Lengths();
  sound = sound && b.of_body.count == table.body_count && b.many.count == all.many && b.near.count == all.near &&
          b.far.count == all.far && b.s_body.count == all.singles && b.s_shape.count == all.singles;
  const auto length = [&](std::size_t c) { return c < Carried<InPlace>::kOfPairs ? all.pairs : all.singles; };
  for (std::size_t c = 0; c < columns.size(); ++c) {
    sound = sound && (bytes[c]->count == 0 || bytes[c]->count == length(c));
  }
  table.renewed_begin = PairTable::kNoneRenewed;
  if (!sound) {
    loader.fail("it is damaged");
    saved.bytes = {};
    table.body_count = 0;
    table.strips.clear();
    return;
  }
  for (std::size_t c = 0; c < columns.size(); ++c) {
    if ((bytes[c] == &b.friction || bytes[c] == &b.s_friction) && !contacts.rough()) continue;
    columns[c]->reserve(length(c) + 1);  // even of none: the column is there
    loader.copies().add(columns[c]->data(), bytes[c]->from, bytes[c]->bytes());
  }
  contacts.gap.reserve(all.pairs + 1);
  saved.named = true;
  std::size_t room = 0;
  saved.bytes.each_name([&](const auto& c) { room += Saver::round_up(c.bytes()); });
  saved.names.resize(room);
  std::byte* to = saved.names.data();
  saved.bytes.each_name([&](auto& c) {
    loader.copies().add(to, c.from, c.bytes());
    c.from = to;
    to += Saver::round_up(c.bytes());
  });
  table.first.reserve(std::size_t{table.body_count} + 1);
  for (Column<std::uint32_t>* c : {&table.owner, &table.other, &table.contact}) c->reserve(all.pairs + 1);
  table.pair_room = all.pairs;
  table.singles.resize(std::max(table.singles.size(), table.strips.size()));
  table.found.resize(table.singles.size());
  for (std::size_t k = 0; k < table.strips.size(); ++k) {
    table.strips[k].pair_begin = saved.first_pair[k];
    table.strips[k].pair_end = saved.first_pair[k] + saved.strip_pairs[k];
    table.singles[k].clear();
  }
  loader.finish(pool);
}

void World::Impl::make_pairs_again() {
  saved.named = false;
  pool.run(table.body_count != 0 ? table.strips.size() : 0, [&](std::size_t k) { read_names(k); });
  table.mark_strips();
  take_renewed();
  saved.bytes = {};
}

void World::Impl::read_names(std::size_t index) {
  const Saved::InBytes b = saved.bytes;
  const Strip strip = table.strips[index];
  std::uint32_t *const first = table.first.data(), *const owner = table.owner.data(), *const other = table.other.data();
  const auto* const of_body = reinterpret_cast<const std::uint8_t*>(b.of_body.from);
  std::size_t partner = saved.first_partner[index], many = saved.first_many[index];
  if (partners_are_near(index)) {
    for (std::uint32_t p = strip.pair_begin; p < strip.pair_end; ++p) other[p] = strip.body_begin + b.near[partner++];
  } else {
    for (std::uint32_t p = strip.pair_begin; p < strip.pair_end; ++p) other[p] = b.far[partner++];
  }
  std::iota(table.contact.data() + strip.pair_begin, table.contact.data() + strip.pair_end, strip.pair_begin);
  std::uint32_t p = strip.pair_begin;
  if (count_of(b, strip, many) != strip.pair_end - p) {  // other bytes than were saved
    table.strips[index].pair_end = p;
    std::fill(first + strip.body_begin, first + strip.body_end, p);
    return;
  }
  constexpr std::uint32_t kFew = 4;  // so many are written, whatever their number
  for (std::uint32_t i = strip.body_begin; i < strip.body_end; ++i) {
    first[i] = p;
    std::uint32_t n = of_body[i];
    if (n == 0) continue;
    if (n <= kFew && p + kFew <= strip.pair_end) {
      std::fill_n(owner + p, kFew, i);
    } else {
      if (n == Saved::kMany) n = many < b.many.count ? b.many[many++] : 0;
      n = std::min(n, strip.pair_end - p);
      std::fill_n(owner + p, n, i);
    }
    p += n;
  }
  for (std::uint32_t k = 0, at = saved.first_single[index]; k < saved.strip_singles[index]; ++k, ++at) {
    table.singles[index].push_back({b.s_body[at], b.s_shape[at], at});
  }
}

// Pairs that are no strip's, behind those of the strips.
void World::Impl::take_renewed() {
  const auto sound = [&](const Saved::Pair& p) { return p.owner < p.other && p.other < table.body_count; };
  if (saved.renewed.empty() || !std::all_of(saved.renewed.begin(), saved.renewed.end(), sound)) return;
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
    renewal.look_again(broad, bodies, shapes, kernels, pool, table);
    put_renewed();
  }
  ahead = now;
  saved.done.swap(done);
  loads.set_visits(visits);
  contacts.set_builds(saved.builds);
  const std::uint32_t pairs = place(saved.first_pair, saved.strip_pairs);
  const std::uint32_t singles = place(saved.first_single, saved.strip_singles);
  const auto columns = carried();
  const auto kept = saved.kept.all();
  if (saved.strip_pairs.size() != table.strips.size() || saved.kept.impulse.size() != pairs ||
      saved.kept.s_impulse.size() != singles) {
    return;  // other bytes than were saved
  }
  pool.run(table.strips.size(), [&](std::size_t k) {
    for (std::size_t c = 0; c < columns.size(); ++c) {
      if (kept[c]->empty()) continue;
      const auto& first = c < Carried<InPlace>::kOfPairs ? saved.first_pair : saved.first_single;
      const float* from = kept[c]->data() + first[k];
      each_lane(k, c, [&, lanes = columns[c]->data()](std::size_t lane) { lanes[lane] = *from++; });
    }
  });
}

}  // namespace psim
