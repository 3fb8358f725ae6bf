// Whether a state that was read in a dry run agrees with itself: counts with each other, numbers of bodies, slots,
// shapes, pairs and joints with the lists that they are of. Bytes of a file may be anything; what is sound here can be
// restored and stepped without reading or writing where nothing is. Numbers that only make a world odd (a place, a
// speed, an impulse) are let through. O(short lists), and one pass over the ids of all slots.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <vector>

#include "image.h"

namespace psim {

namespace {

struct IdSums {
  std::uint32_t sum = 0;  // of id + 1, modulo 2^32: dead slots count nothing
  std::uint32_t odd = 0;  // its high bit: some are none
};

[[gnu::always_inline]] inline void add_ids(const std::byte* from, std::size_t n, std::uint32_t ids, IdSums& out) {
  std::uint32_t sum = 0, odd = 0;
  for (std::size_t k = 0; k < n; ++k) {
    std::uint32_t one;
    std::memcpy(&one, from + 4 * k, sizeof one);
    ++one;
    sum += one;
    odd |= one | (ids - one);
  }
  out = {sum, odd};
}

#if defined(__x86_64__)
[[gnu::target("avx2")]] void add_ids_avx2(const std::byte* from, std::size_t n, std::uint32_t ids, IdSums& out) {
  add_ids(from, n, ids, out);
}
#endif

void add_ids(const std::byte* from, std::size_t n, std::uint32_t ids, [[maybe_unused]] Isa isa, IdSums& out) {
#if defined(__x86_64__)
  if (isa == Isa::avx2) return add_ids_avx2(from, n, ids, out);
#endif
  add_ids(from, n, ids, out);
}

}  // namespace

template <class W>
struct Image::Check {
  Loader& a;
  const W& w;
  bool lists;
  std::vector<std::uint64_t> of_place = std::vector<std::uint64_t>(kLastOf<Place> + 1);
  std::vector<std::uint64_t> hull_users = {};  // by first hull

  using U32 = std::uint32_t;
  bool ok() const { return a.ok(); }
  void require(bool sound) { a.require(sound); }
  U32 ids() const { return w.bodies.id_count; }
  U32 slots() const { return w.bodies.count; }

  // Runs of bodies alike hold a range of ids each: found by bisection.
  std::vector<U32> first_of_run = {};
  const AlikeBodies* run_of(U32 id) const {
    if (id >= ids()) return nullptr;
    const auto at = std::upper_bound(first_of_run.begin(), first_of_run.end(), id);
    return &w.bodies.roster[static_cast<std::size_t>(at - first_of_run.begin()) - 1];
  }
  Place place_of(U32 id) const {
    const AlikeBodies* run = run_of(id);
    return run != nullptr ? run->place : Place::none;
  }
  const Surface& surface_of(U32 id) const { return w.bodies.surfaces[run_of(id)->surface]; }
  const Make& make_of(U32 id) const { return w.bodies.makes[surface_of(id).make]; }
  bool is_body(U32 id) const { return place_of(id) != Place::none; }

  // Free entries of a table: those without a user, each once.
  template <class IsFree>
  void free_list(const std::vector<U32>& list, std::size_t entries, std::size_t begin, const IsFree& is_free) {
    std::size_t all = 0;
    for (std::size_t k = begin; k < entries; ++k) all += is_free(k) ? 1 : 0;
    std::vector<U32> sorted(list);
    std::sort(sorted.begin(), sorted.end());
    require(sorted.size() == all && std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end());
    require(std::all_of(sorted.begin(), sorted.end(), [&](U32 k) { return k >= begin && k < entries && is_free(k); }));
  }

  void settings() {
    const Ahead& now = w.ahead;
    require(w.substeps >= 1 && w.substeps <= 64 && now.horizon >= 1 && now.waits < 255);
    require(w.list_span >= 0 && w.select_span >= 0 && w.list_skin > 0 && w.last_substep >= 0 && w.stiff_substep >= 0);
    require(w.first_radius >= 0 && w.least_radius >= 0);
    for (const Saved::Done& d : w.saved.done) require(d.part <= static_cast<U32>(Part::done) && d.span >= 0 && d.span <= 1e30);
  }

  // ---- who is there ----

  void tables() {
    const BodyStore& b = w.bodies;
    for (const SurfaceTable::Entry& e : b.surfaces.list_) {
      const Surface& s = e.surface;
      require(s.inv_mass >= 0 && s.mass >= 0 && s.spin_gain >= 0 && s.radius >= 0 && s.restitution >= 0 &&
              s.restitution <= 1 && s.friction >= 0 && s.make < b.makes.list_.size());
    }
    require(!b.makes.list_.empty() && b.makes.list_[0].make == Make{});
    require(!b.hulls.hulls_.empty() && b.makes.last_ < b.makes.list_.size());
    const std::vector<Hull>& hulls = b.hulls.hulls_;
    for (std::size_t k = 1; k < hulls.size() && ok(); ++k) hull(hulls[k]);
    std::vector<std::uint8_t> taken(hulls.size());
    for (const ShapeTable::Set& s : b.hulls.sets_) {
      require(s.first >= 1 && s.count >= 1 && s.first < hulls.size() && s.count <= hulls.size() - s.first);
      for (U32 k = s.first; ok() && k < s.first + s.count; ++k) require(taken[k]++ == 0);
    }
    for (const MakeTable::Entry& e : b.makes.list_) {
      if (e.make.hull_count == 0) require(e.make.first_hull == 0);
      require(e.make.inner >= 0);
    }
  }
  void hull(const Hull& h) { require(h.count >= 1 && h.count <= Hull::kMost && h.radius >= 0 && h.reach >= 0 && h.inner >= 0); }

  void roster() {
    const BodyStore& b = w.bodies;
    std::uint64_t id = 0, kinematic = 0;
    std::vector<std::uint64_t> surface_users(b.surfaces.list_.size()), make_users(b.makes.list_.size());
    hull_users.assign(b.hulls.hulls_.size(), 0);
    for (const AlikeBodies& run : b.roster) {
      first_of_run.push_back(static_cast<U32>(id));
      id += run.count;
      require(run.count != 0 && id <= ids());
      of_place[static_cast<std::size_t>(run.place)] += run.count;
      if (run.place == Place::none) continue;
      require(run.surface < surface_users.size());
      if (!ok()) return;
      const Surface& s = b.surfaces[run.surface];
      surface_users[run.surface] += run.count;
      make_users[s.make] += run.count;
      const Make& make = b.makes[s.make];
      if (make.hull_count != 0) {
        require(make.first_hull < hull_users.size());
        if (!ok()) return;
        hull_users[make.first_hull] += run.count;
      }
      require((run.place == Place::fixed) == (s.type == BodyType::static_body));
      if (run.place == Place::moving || run.place == Place::asleep) {
        require(s.radius > 0 && (s.type == BodyType::dynamic_body ? s.mass > 0 : s.inv_mass == 0));
        if (s.type == BodyType::kinematic_body) kinematic += run.count;
      }
    }
    require(id == ids());
    if (!ok()) return;
    for (std::size_t k = 0; k < surface_users.size(); ++k) require(surface_users[k] == b.surfaces.list_[k].users);
    for (std::size_t k = 1; k < make_users.size(); ++k) require(make_users[k] == b.makes.list_[k].users);
    for (const ShapeTable::Set& s : b.hulls.sets_) {
      require(hull_users[s.first] == s.users);
      hull_users[s.first] = 0;
    }
    for (const std::uint64_t users : hull_users) require(users == 0);  // of no set
    for (std::size_t k = 1; k < make_users.size(); ++k) {
      const Make& make = b.makes.list_[k].make;
      if (make_users[k] == 0 || make.hull_count == 0) continue;
      require(std::any_of(b.hulls.sets_.begin(), b.hulls.sets_.end(), [&](const ShapeTable::Set& s) {
        return s.first == make.first_hull && s.count == make.hull_count;
      }));
    }
    free_list(b.surfaces.free_, surface_users.size(), 0, [&](std::size_t k) { return surface_users[k] == 0; });
    free_list(b.makes.free_, make_users.size(), 1, [&](std::size_t k) { return make_users[k] == 0; });
    free_list(b.hulls.free_, b.hulls.sets_.size(), 0, [&](std::size_t k) { return b.hulls.sets_[k].users == 0; });
    const auto count = [&](Place place) { return of_place[static_cast<std::size_t>(place)]; };
    require(b.dead <= b.count && count(Place::moving) == b.count - b.dead);
    require(count(Place::fixed) == b.fixed && count(Place::fixed) == w.fixed.size());
    require(count(Place::frozen) == w.frozen.size() && count(Place::none) == b.free_ids.size());
    require(count(Place::asleep) == b.asleep && count(Place::asleep) == w.sleepers.list.size());
    require(b.moving == count(Place::moving) + b.asleep && b.living == ids() - b.free_ids.size());
    require(b.kinematic == 0 || b.kinematic == kinematic);
    if (!ok() || b.free_ids.empty()) return;
    std::vector<std::uint8_t> seen(ids());
    for (const U32 k : b.free_ids) require(k < ids() && place_of(k) == Place::none && seen[k]++ == 0);
  }

  // Bodies of a list stand where the list says.
  template <class List, class IdOf>
  void listed(Place place, const List& list, const IdOf& id_of) {
    U32 id = 0;
    for (const AlikeBodies& run : w.bodies.roster) {
      if (run.place == place) {
        require(run.slot < list.size() && run.count <= list.size() - run.slot);
        for (U32 k = 0; k < run.count && ok(); ++k) require(id_of(list[run.slot + k]) == id + k);
      }
      id += run.count;
    }
  }

  // Ids of the slots: they are ids, and have the sum of those that move; in small worlds each is there once.
  InPlace<U32> slot_ids = {};
  void columns() {
    slot_ids = a.seen(w.bodies.id, slots());
    IdSums sums;
    add_ids(slot_ids.from, slots(), ids(), w.options.isa, sums);
    std::uint64_t wanted = 0, id = 0;
    for (const AlikeBodies& run : w.bodies.roster) {
      if (run.place == Place::moving) wanted += run.count * (2 * id + run.count + 1) / 2;
      id += run.count;
    }
    require(ids() < 1u << 31 && (sums.odd >> 31) == 0 && sums.sum == static_cast<U32>(wanted));
    constexpr U32 kFew = 4096;
    if (!ok() || ids() > kFew) return;
    std::vector<std::uint8_t> seen(ids());
    for (U32 k = 0; k < slots(); ++k) {
      const U32 body = slot_ids[k];
      if (body != kNoSlot) require(place_of(body) == Place::moving && seen[body]++ == 0);
    }
  }

  void others() {
    listed(Place::fixed, w.fixed, [](const FixedBody& f) { return f.id; });
    listed(Place::frozen, w.frozen, [](const BodyState& s) { return s.id.index; });
    listed(Place::asleep, w.sleepers.list, [](const Sleeper& s) { return s.id; });
    for (const BodyId& id : w.doubtful) require(id.index < ids());
    for (const auto& h : w.held) {
      require(place_of(h.first) == Place::moving && surface_of(h.first).type == BodyType::kinematic_body);
    }
    for (const U32 id : w.bullets) {
      const Place place = place_of(id);
      require((place == Place::moving || place == Place::asleep) && make_of(id).bullet);
    }
    for (const Saved::Done& d : w.saved.done) require(d.span > 0 || place_of(d.id) == Place::moving);
    for (const FixedBody& f : w.fixed) require(f.first_shape <= w.shapes.count_ && f.radius >= 0);
  }

  // What the plan follows from, and what it asks for.
  void traits() {
    Traits t;
    const Traits& was = w.traits;
    for (const AlikeBodies& run : w.bodies.roster) {
      if (run.place != Place::moving && run.place != Place::asleep && run.place != Place::fixed) continue;
      const Surface& s = w.bodies.surfaces[run.surface];
      const Make& make = w.bodies.makes[s.make];
      const std::uint64_t n = run.count;
      if (make.sensor) t.sensors += n;
      if (make.filter != Filter{}) t.filtered += n;
      if (run.place == Place::fixed) {
        t.fixed += n;
        continue;
      }
      t.moving += n;
      if (make.hull_count != 0) t.cornered += n;
      if (make.hull_count == 0) t.discs += n;
      if (s.radius == w.first_radius) t.same_radius += n;
      if (s.type == BodyType::kinematic_body) t.kinematic += n;
      if (make.bullet) t.bullets += n;
    }
    require(t.sensors == was.sensors && t.filtered == was.filtered && t.fixed == was.fixed && t.moving == was.moving &&
            t.cornered == was.cornered && t.discs == was.discs && t.kinematic == was.kinematic &&
            t.bullets == was.bullets && t.same_radius == was.same_radius);
    require(was.joints == w.joints.count_);
    require(was.fields == needs_forces(w.desc.fields) && was.integrator == w.desc.integrator && was.walls == (w.desc.boundary == Boundary::walls));
    const std::size_t n = slots();
    const bool turns = n == 0 || a.seen(w.bodies.spin, n).from != nullptr;
    require(!w.plan.rotation || turns);
    if (w.plan_stale) return;
    Plan wanted = make_plan(was);
    wanted.publish = w.plan.publish;
    wanted.events = w.plan.events;
    require(wanted == w.plan);
  }

  // ---- fixed geometry ----

  void shapes() {
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

  bool is_shape(U32 shape) const { return shape < w.shapes.count_ || (shape >= kWallLeft && shape <= kWallTop); }

  // ---- lists ----

  void broad() {
    const BroadPhase& b = w.broad;
    const BroadPhaseParams& p = b.params_;
    require(p.margin.skin >= 0 && p.margin.time >= 0 && p.growth >= 0 && p.outer >= 0);
    require(b.most_ >= 0 && b.box_ >= 0 && b.area_ >= 0 && b.density_ >= 0 && b.tests_ >= 0 && b.pairs_a_large_ >= 0);
    constexpr double kMost = 1e9;
    for (const auto* list : {&b.pairs_a_body_, &b.pairs_a_piece_, &b.near_a_body_}) {
      require(std::all_of(list->begin(), list->end(), [](double x) { return x >= 0 && x <= kMost; }));
    }
    require(b.pairs_a_large_ <= kMost);
    if (!lists && !w.ahead.built) return;
    if (b.listed_) {
      cells();
    } else {
      grid();
    }
    require(p.periodic == (w.desc.boundary == Boundary::periodic));
    require(p.mixed_radii || w.traits.same_radius == w.traits.moving || w.ahead.sorted);
  }
  void grid() {
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
  void cells() {
    const CellList& c = w.broad.sort_.listed_;
    require((c.row_axis_ == 0 || c.row_axis_ == 1) && c.periodic_ == (w.desc.boundary == Boundary::periodic));
    if (!ok()) return;
    const auto built = a.seen(w.bodies.built, 2 * std::size_t{slots()});
    for (int axis = 0; axis < 2; ++axis) {
      const CellList::Axis& x = c.axis_[axis];
      require(x.per >= 1 && x.per <= std::uint64_t{1} << 32 && x.cells >= 1 && x.cells <= x.per + 1);
      if (!ok()) return;
      require(x.width == 0x1p32 / static_cast<double>(x.per));
      if (c.periodic_) require(x.cells == x.per);
      std::uint64_t most = 0;  // steps from the low side
      for (std::size_t k = 0; k < slots(); ++k) {
        most = std::max(most, std::uint64_t{static_cast<U32>(wrap_sub(built[2 * k + static_cast<std::size_t>(axis)], x.low))});
      }
      require((most * x.per) >> 32 < x.cells);
    }
    require(c.rows_ == c.axis_[c.row_axis_].cells && c.stride_ == c.axis_[1 - c.row_axis_].cells + 1);
    require(c.slot_bits_ >= 0 && c.slot_bits_ <= 32 && slots() < std::uint64_t{1} << c.slot_bits_);
    require(static_cast<double>(c.rows_ + 1) * static_cast<double>(c.stride_) < std::ldexp(1.0, 64 - c.slot_bits_));
  }

  void pairs() {
    const Saved& s = w.saved;
    require(s.dead_radii.size() <= w.bodies.dead);
    for (const float radius : s.dead_radii) require(radius >= 0);
    std::uint64_t all = 0, singles = 0;
    for (const U32 n : s.strip_pairs) all += n;
    for (const U32 n : s.strip_singles) singles += n;
    require(s.strip_pairs.size() == s.strip_singles.size() && all <= 0x7FFFFFFFu && singles <= 0x7FFFFFFFu && a.fits(all) && a.fits(singles));
    if (lists && !w.loose) return;
    const PairTable& t = w.table;
    require(t.strips.size() == s.strip_pairs.size() && a.fits(t.body_count) && t.large_begin <= t.body_count);
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
    const bool moved = !s.origin.empty();
    for (const U32 slot : s.origin) require(slot == kNoSlot || a.fits(slot));
    require(!moved || s.origin.size() == slots() || s.origin.size() == w.broad.sorted_);
    require(w.broad.sorted_ <= slots() || !w.impulses_valid || w.bodies.dead != 0);
  }

  // ---- contacts of shapes ----

  void manifolds() {
    const Manifolds& m = w.manifolds;
    const std::size_t strips = m.strips_.size(), pairs = m.pairs_.size();
    // While work is spread over frames these are of several steps, and are made anew before anyone reads them.
    const bool spread = w.ahead.built || w.ahead.part != Part::check;
    require(spread || (m.begin_.empty() ? pairs == 0 : m.begin_.front() == 0 && m.begin_.back() == pairs));
    require(!m.laid_ || m.begin_.size() <= strips + 1);
    require(std::is_sorted(m.begin_.begin(), m.begin_.end()));
    require(m.stale_.size() <= strips || m.stale_.size() >= m.strip_count());
    const bool present = !w.lists_stale && w.plan.shapes;
    for (const U32 slot : m.shaped_) require(slot < slots() || !present);
    const auto of = [&](U32 slot, U32 id, U32 part) {
      require(slot < std::max(slots(), w.table.body_count) && is_body(id));
      if (!ok()) return;
      require(part < std::max(make_of(id).hull_count, 1u));
      if (present && w.bodies.dead == 0 && w.doubtful.empty()) require(slot < slots() && slot_ids[slot] == id);
    };
    for (const ManifoldPair& p : m.pairs_) {
      require(p.owner < ids() && p.manifold.count >= 0 && p.manifold.count <= 2);
      require((p.a == PairName::kNone) == (p.shape != PairName::kNone) && p.recalled <= 2);
      if (!ok()) return;
      if (present) {
        of(p.b, p.id_b, p.part_b);
        if (p.a != PairName::kNone) of(p.a, p.id_a, p.part_a);
        if (p.a == PairName::kNone) require(is_shape(p.shape));
      }
      require(p.id_b < ids() && (p.id_a < ids() || p.id_a == PairName::kNone));
    }
    std::uint64_t points = 0;
    for (std::size_t k = 0; k < strips && ok(); ++k) {
      if (!spread) strip(k);
      points += m.strips_[k].points;
    }
    require(m.points_ == 0 || (m.points_ <= points && w.plan.shapes));
    for (const std::uint64_t ghost : m.ghosts_) require(ghost >> 32 < slots() || !present);
  }
  void strip(std::size_t index) {
    const Manifolds& m = w.manifolds;
    const Manifolds::StripBlocks& s = m.strips_[index];
    const bool there = index + 1 < m.begin_.size();
    const U32 begin = there ? m.begin_[index] : 0, end = there ? m.begin_[index + 1] : 0;
    const auto blocks = static_cast<U32>(s.blocks.size());
    for (const auto* list : {&s.active, &s.laid}) {
      if (w.lists_stale && !m.laid_) break;  // of pairs that are gone: made anew before anyone looks
      for (const U32 k : *list) require(k >= begin && k < end && (list == &s.active || m.pairs_[k].lane / kernels::kBlock < blocks));
    }
    for (U32 k = begin; k < end; ++k) {
      const ManifoldPair& p = m.pairs_[k];
      require(p.lane == PairName::kNone || p.lane / kernels::kBlock < blocks);
    }
    for (const U32 block : s.end) require(block <= blocks);
    if (w.lists_stale) return;
    const U32 most = slots() + 64;
    for (const kernels::ManifoldBlock& block : s.blocks) {
      for (const U32 body : block.body) require(body <= most);
    }
  }

  // ---- joints ----

  void joints() {
    const JointStore& j = w.joints;
    const std::size_t all = j.joints_.size();
    std::size_t alive = 0;
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
  void joint(std::size_t k, std::size_t& alive) {
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
  void chains(std::size_t alive) {
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

  // ---- sleep, events ----

  void sleepers() {
    const Sleepers& s = w.sleepers;
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
    for (const auto* touches : {&s.touches, &s.recent.list_}) {
      for (const Touch& t : *touches) {
        require(t.first() < ids() && t.points <= 2 && (t.of_fixed() || t.second() < ids()));
      }
    }
  }

  void events() {
    const EventList& e = w.events;
    constexpr std::uint64_t kNoKey = ~std::uint64_t{0};
    for (const BodyId& id : e.removed_) require(id.index < ids());
    const auto known = [&](std::uint64_t key) { return key >> 32 < ids() && static_cast<U32>(key) < ids(); };
    require(e.lane_key_.size() == e.touching_.size() * kernels::kBlock);
    require(e.build_ != w.contacts.builds_ || e.touching_.empty() || e.touching_.size() == w.contacts.pair_blocks_ || !e.on());
    for (const std::uint64_t key : e.lane_key_) require(key == kNoKey || known(key));
    for (const auto* keys : {&e.paired_, &e.toggled_, &e.rest_found_, &e.rest_, &e.slept_, &e.sensed_}) {
      require(std::all_of(keys->begin(), keys->end(), known));
    }
    for (const auto* keys : {&e.paired_, &e.rest_, &e.slept_}) require(std::is_sorted(keys->begin(), keys->end()));
  }

  void all() {
    const auto each = [&](auto... part) { ((ok() ? (this->*part)() : void()), ...); };
    each(&Check::settings, &Check::tables, &Check::roster, &Check::columns, &Check::others, &Check::traits, &Check::shapes,
         &Check::broad, &Check::pairs, &Check::manifolds, &Check::joints, &Check::sleepers, &Check::events);
  }
};

template <class W>
void Image::check(Loader& a, const W& world, bool lists) {
  Check<W> check{a, world, lists};
  check.all();
}

template void Image::check(Loader&, const World::Impl&, bool);

}  // namespace psim
