// Fixed geometry, and the lists of who may meet.
#include <cmath>
#include <cstring>
#include <limits>

#include "image_check.h"

namespace psim {

namespace {

// Differences and the largest of signed 16 bits are what every x86-64 does several at a time.
std::uint32_t largest(const std::byte* from, std::size_t n) {
  std::int16_t most = std::numeric_limits<std::int16_t>::min();
  for (std::size_t k = 0; k < n; ++k) {
    std::uint16_t one;
    std::memcpy(&one, from + k * sizeof one, sizeof one);
    most = std::max(most, static_cast<std::int16_t>(one ^ 0x8000));
  }
  return static_cast<std::uint16_t>(most ^ 0x8000);
}

// Whether all numbers are below an end, < 2^31.
bool all_below(std::uint32_t end, const std::byte* from, std::size_t n) {
  std::uint32_t odd = 0;
  for (std::size_t k = 0; k < n; ++k) {
    std::uint32_t one;
    std::memcpy(&one, from + k * sizeof one, sizeof one);
    odd |= one | (end - 1 - one);
  }
  return n == 0 || (end != 0 && odd >> 31 == 0);
}

}  // namespace

template <class W>
void Image::Check<W>::shapes() {
  if (as_before) return;
  const StaticShapes& s = w.shapes;
  std::size_t alive = 0;
  std::vector<std::uint8_t> hull_used(s.hulls_.size());
  for (const Hull& h : s.hulls_) {
    if (h.count != 0) hull(h);
  }
  for (U32 k = 0; k < s.count_ && ok(); ++k) {
    const StaticShape& x = s.shapes_[k];
    if (!x.alive) continue;
    ++alive;
    require(x.radius >= 0 && x.radius < 1e30f && place_of(x.owner) == (x.asleep ? Place::asleep : Place::fixed));
    if (!x.whole) continue;
    require(x.hull < s.hulls_.size());
    if (ok()) require(s.hulls_[x.hull].count != 0 && hull_used[x.hull]++ == 0);
  }
  require(alive == s.alive_);
  if (!ok()) return;
  free_list(s.free_hulls_, s.hulls_.size(), 0, [&](std::size_t k) { return hull_used[k] == 0; });
  // Numbers that nobody has, by run: each once.
  std::vector<std::uint8_t> taken(s.count_);
  const auto run = [&](U32 first, U32 length) {
    require(length <= s.count_ && first <= s.count_ - length);
    for (U32 k = first; ok() && k < first + length; ++k) require(!s.shapes_[k].alive && taken[k]++ == 0);
  };
  for (U32 length = 0; length <= StaticShapes::kLongestRun; ++length) {
    for (const U32 first : s.runs_[length]) run(first, length);
  }
  for (const auto& [first, length] : s.left_) run(first, length);
}

template <class W>
void Image::Check<W>::broad() {
  const BroadPhase& b = w.broad;
  const BroadPhaseParams& p = b.params_;
  require(p.margin.skin >= 0 && p.margin.time >= 0 && p.growth >= 0 && p.outer >= 0);
  require(b.most_ >= 0 && b.box_ >= 0 && b.area_ >= 0 && b.density_ >= 0 && b.tests_ >= 0 && b.pairs_a_large_ >= 0);
  constexpr double kMost = 1e9;
  for (const auto* list : {&b.pairs_a_body_, &b.pairs_a_piece_, &b.near_a_body_}) {
    require(std::all_of(list->begin(), list->end(), [](double x) { return x >= 0 && x <= kMost; }));
  }
  require(b.pairs_a_large_ <= kMost);
  const CellList& c = b.sort_.listed_;
  const bool there = lists || (w.ahead.built && w.ahead.part > Part::count);
  require(c.row_axis_ == 0 || c.row_axis_ == 1);
  if (ok() && (c.stays_ || (there && b.listed_))) axes();
  if (!ok() || !there) return;
  if (b.listed_) {
    cells();
  } else {
    grid();
  }
  require(p.periodic == (w.desc.boundary == Boundary::periodic));
}

template <class W>
void Image::Check<W>::grid() {
  const Grid& grid = w.broad.grid_;
  const kernels::GridView& g = grid.view;
  const double room = 64.0 * slots() + 65536;
  require(g.cols >= 1 && g.rows >= 1 && static_cast<double>(g.cols) * g.rows <= room);
  if (!ok()) return;
  require(g.stride == static_cast<U32>(g.cols) + 1 && grid.keys == (static_cast<U32>(g.rows) + 1) * g.stride + 3);
  require(grid.cell_x > 0 && grid.cell_y > 0 && grid.periodic == (w.desc.boundary == Boundary::periodic));
  require(g.scale_x == static_cast<float>(w.lattice.pitch_x() / grid.cell_x) &&
          g.scale_y == static_cast<float>(w.lattice.pitch_y() / grid.cell_y));
  require(g.offset_x == static_cast<float>(g.cols) / 2 && g.offset_y == static_cast<float>(g.rows) / 2);
}

// Cells may stay for the lists to come.
template <class W>
void Image::Check<W>::axes() {
  const CellList& c = w.broad.sort_.listed_;
  for (const CellList::Axis& x : c.axis_) {
    require(x.per >= 1 && x.per <= std::uint64_t{1} << 32 && x.cells >= 1 && x.cells <= x.per + 1);
    if (!ok()) return;
    require(x.width == 0x1p32 / static_cast<double>(x.per) && (!c.periodic_ || x.cells == x.per));
  }
  require(c.rows_ == c.axis_[c.row_axis_].cells && c.stride_ == c.axis_[1 - c.row_axis_].cells + 1);
  require(c.slot_bits_ >= 0 && c.slot_bits_ <= 32);
  require(static_cast<double>(c.rows_ + 1) * static_cast<double>(c.stride_) < std::ldexp(1.0, 64 - c.slot_bits_));
}

template <class W>
void Image::Check<W>::cells() {
  const CellList& c = w.broad.sort_.listed_;
  require(c.periodic_ == (w.desc.boundary == Boundary::periodic) && slots() < std::uint64_t{1} << c.slot_bits_);
  const auto built = a.seen(w.bodies.built, 2 * std::size_t{slots()});
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const CellList::Axis& x = c.axis_[axis];
    std::uint64_t most = 0;  // steps from the low side
    for (std::size_t k = 0; k < slots(); ++k) {
      most = std::max(most, std::uint64_t{static_cast<U32>(wrap_sub(built[2 * k + axis], x.low))});
    }
    require((most * x.per) >> 32 < x.cells);
  }
}

template <class W>
void Image::Check<W>::pairs() {
  const Saved& s = w.saved;
  require(s.dead_radii.size() <= w.bodies.dead);
  for (const float radius : s.dead_radii) require(radius >= 0);
  std::uint64_t all = 0, singles = 0;
  for (const U32 n : s.strip_pairs) all += n;
  for (const U32 n : s.strip_singles) singles += n;
  require(s.strip_pairs.size() == s.strip_singles.size() && all <= 0x7FFFFFFFu && singles <= 0x7FFFFFFFu && a.fits(all) && a.fits(singles));
  const Carried<InPlace>& carried = s.bytes;
  for (const InPlace<float>* c : {&carried.impulse, &carried.friction}) {
    require(c->count == 0 || c->count == all);
  }
  for (const InPlace<float>* c : {&carried.s_impulse, &carried.s_friction, &carried.s_nx, &carried.s_ny, &carried.s_gap}) {
    require(c->count == 0 || c->count == singles);
  }
  if (lists && !w.loose) return;
  const PairTable& t = w.table;
  require(t.strips.size() == s.strip_pairs.size() && a.fits(t.body_count));
  require(t.body_count == 0 || t.large_begin <= t.body_count);
  if (!ok()) return;
  U32 at = 0;
  for (const Strip& strip : t.strips) {
    require(strip.body_begin == at && strip.body_end >= at && strip.body_end <= t.body_count);
    at = strip.body_end;
  }
  require(t.body_count == 0 || (!t.strips.empty() && at == t.body_count));
  for (const Saved::Pair& p : s.renewed) require(p.owner < p.other && p.other < t.body_count);
  for (std::size_t k = 1; k < s.renewed.size(); ++k) {
    const Saved::Pair &p = s.renewed[k - 1], &q = s.renewed[k];
    require(p.owner != q.owner ? p.owner < q.owner : p.other < q.other);
  }
  require(s.origin.size() <= slots() && std::all_of(s.origin.begin(), s.origin.end(), [&](U32 slot) {
    return slot == kNoSlot || a.fits(slot);
  }));
  require(!stands() || t.body_count <= slots() || (all == 0 && singles == 0 && s.renewed.empty()));
  if (ok()) names();
}

// Who is a pair, and which fixed shape a body has: of each strip, or all at once.
template <class W>
void Image::Check<W>::names() {
  const Saved& s = w.saved;
  const Saved::InBytes& b = s.bytes;
  const PairTable& t = w.table;
  Saved::Lengths all;
  for (std::size_t k = 0; k < t.strips.size(); ++k) {
    const U32 pairs = s.strip_pairs[k];
    all.pairs += pairs;
    all.singles += s.strip_singles[k];
    all.many += pairs / Saved::kMany;
    if (!w.partners_are_near(k)) {
      all.far += pairs;
      continue;
    }
    if (all.near + pairs > b.near.count) break;
    const U32 most = pairs != 0 ? largest(b.near.from + 2 * std::size_t{all.near}, pairs) : 0;
    require(pairs == 0 || t.strips[k].body_begin + most < t.body_count);
    all.near += pairs;
  }
  require(b.of_body.count == t.body_count && b.many.count == all.many && b.near.count == all.near && b.far.count == all.far);
  require(b.s_body.count == all.singles && b.s_shape.count == all.singles);
  if (!ok()) return;
  require(all_below(t.body_count, b.far.from, all.far) && all_below(t.body_count, b.s_body.from, all.singles));
  for (std::size_t k = 0; k < all.singles && ok(); ++k) require(is_shape(b.s_shape[k]));
}

template void Image::Check<World::Impl>::shapes();
template void Image::Check<World::Impl>::broad();
template void Image::Check<World::Impl>::grid();
template void Image::Check<World::Impl>::axes();
template void Image::Check<World::Impl>::cells();
template void Image::Check<World::Impl>::pairs();
template void Image::Check<World::Impl>::names();

}  // namespace psim
