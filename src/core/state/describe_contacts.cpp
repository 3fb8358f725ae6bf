// What bodies have to do with each other: the lists of who may meet, contacts of shapes, joints, and what events
// compare the next step with.
#include <cmath>

#include "joints/joint_store.h"
#include "lists/broad_phase.h"
#include "lists/renewal.h"
#include "manifolds/manifolds.h"
#include "manifolds/manifolds_around.h"
#include "query/events.h"
#include "state/describe.h"

namespace psim {

// ---- lists: how they were made, which is all that making them again needs, and their strips

void BroadPhase::describe(Archive& a, bool periodic, bool cells) {
  constexpr double kMostGuess = 1e9;  // pairs of a body
  BroadPhaseParams& p = params_;
  BroadCells& c = cells_;
  PairSearch& s = search_;
  Grid& grid = c.grid_;
  bool fixed = s_.statics.any();  // kept in the format, but known from the fixed shapes
  kernels::GridView& g = grid.view;
  a.refuse_nan(true);
  values(a, p.margin.skin, p.margin.of_radius, p.margin.time, p.margin.common_x, p.margin.common_y, p.margin.beside,
         p.ahead, p.outer, p.sample, p.growth, p.walls, p.periodic, p.mixed_radii, p.link_all, p.bounds);
  values(a, c.extent_.most, c.extent_.box, c.sorted_);
  values(a, g.mid_x, g.mid_y, g.scale_x, g.scale_y, g.offset_x, g.offset_y, g.cols, g.rows, g.stride);
  values(a, grid.cell, grid.periodic, grid.keys, c.listed_, c.large_, c.most_, c.box_, c.area_, c.density_, pad_reach_,
         next_pad_reach_, s.pairs_a_large_, near_.pairs_, c.tests_, fixed);
  for (std::vector<double>* guess : {&s.pairs_a_body_, &s.pairs_a_piece_, &near_.near_a_body_}) {
    a.packed(*guess);
    if (a.loading()) {
      a.require(std::all_of(guess->begin(), guess->end(), [](double x) { return x >= 0 && x <= kMostGuess; }));
    }
  }
  a.refuse_nan(false);
  common_.describe(a);
  c.list_.describe(a, periodic, cells && c.listed_);
  if (!a.loading()) return;
  a.require(p.margin.skin >= 0 && p.margin.of_radius >= 0 && p.margin.time >= 0 && p.margin.beside >= 0 &&
            p.growth >= 0 && p.outer >= 0);
  a.require(c.most_ >= 0 && c.box_ >= 0 && c.area_ >= 0 && c.density_ >= 0 && c.tests_ >= 0 && s.pairs_a_large_ >= 0 &&
            s.pairs_a_large_ <= kMostGuess);
  if (!cells) return;
  a.require(p.periodic == periodic);
  if (c.listed_) return;
  // Every cell that a body may get lies in the grid.
  a.require(g.cols >= 1 && g.rows >= 1 && static_cast<double>(g.cols) * g.rows <= 64.0 * s_.bodies.count + 65536);
  a.require(g.stride == static_cast<std::uint32_t>(g.cols) + 1 &&
            grid.keys == (static_cast<std::uint32_t>(g.rows) + 1) * g.stride + 3);
  a.require(grid.cell[0] > 0 && grid.cell[1] > 0 && grid.periodic == periodic);
  a.require(g.scale_x == static_cast<float>(s_.lattice.pitch_x() / grid.cell[0]) &&
            g.scale_y == static_cast<float>(s_.lattice.pitch_y() / grid.cell[1]));
  a.require(g.offset_x == static_cast<float>(g.cols) / 2 && g.offset_y == static_cast<float>(g.rows) / 2);
}

// The regions alone. Who is in them, and what they have in common, follows from the bodies.
void CommonMotion::describe(Archive& a) {
  Grid& g = grid_;
  values(a, g.shift, g.low, g.columns, g.rows);
  if (!a.loading()) return;
  counted_ = false;
  a.require((g.columns == 0) == (g.rows == 0));
  a.require(static_cast<double>(g.columns) * g.rows <= static_cast<double>(most_regions()));
  for (const int axis : {0, 1}) {
    if (g.columns == 0) break;
    a.require(g.shift[axis] >= 1 && g.shift[axis] <= 31);
    if (!a.ok()) break;
    const std::uint32_t n = axis == 0 ? g.columns : g.rows;
    a.require(n <= along(g.shift[axis]));
  }
  if (!a.ok()) stop();
}

void CellList::describe(Archive& a, bool periodic, bool used) {
  for (CellAxis& x : axis_) values(a, x.low, x.per, x.cells, x.width);
  values(a, row_axis_, stride_, rows_, periodic_, slot_bits_, stays_);
  a.require(row_axis_ == 0 || row_axis_ == 1);
  if (!a.loading() || !a.ok()) return;
  sorted_ = 0;
  if (!stays_ && !used) return;
  // The cells that are laid fit together.
  for (const CellAxis& x : axis_) {
    a.require(x.per >= 1 && x.per <= std::uint64_t{1} << 32 && x.cells >= 1 && x.cells <= x.per + 1);
    a.require(x.width == 0x1p32 / static_cast<double>(x.per) && (!periodic_ || x.cells == x.per));
  }
  a.require(rows_ == axis_[row_axis_].cells && stride_ == axis_[1 - row_axis_].cells + 1);
  a.require(slot_bits_ >= 0 && slot_bits_ <= 32 &&
            static_cast<double>(rows_ + 1) * static_cast<double>(stride_) < std::ldexp(1.0, 64 - slot_bits_));
  if (!used || !a.ok()) return;
  // Every body lies in one of them.
  a.require(periodic_ == periodic && b_.count < std::uint64_t{1} << slot_bits_);
  for (std::size_t k = 0; k < 2 * std::size_t{b_.count} && a.ok(); ++k) {
    a.require(axis_[k % 2].at(b_.built[k]) < axis_[k % 2].cells);
  }
}

// Where renewed bodies were when all lists were made. Where they are looked for now, the bodies say.
void ListRenewal::describe(Archive& a, std::size_t slots) {
  a.list(renewed_, [&](Renewed& x) {
    a.index(slots, x.slot);
    values(a, x.x, x.y, x.reach);
  });
  a.packed(linked_, slots);
  if (a.loading()) mark_.reserve(slots);
}

void describe_strips(Archive& a, PairTable& table) {
  const std::uint32_t& bodies = table.body_count;
  values(a, table.body_count, table.large_begin);
  std::uint32_t at = 0;
  a.list(table.strips, [&](Strip& s) {
    values(a, s.body_begin, s.body_end, s.row_begin, s.row_end);
    a.require(s.body_begin == at && s.body_end >= at && s.body_end <= bodies);
    at = s.body_end;
  });
  a.require(a.fits(bodies) && at == bodies && (bodies == 0 || table.large_begin <= bodies));
}

// ---- contacts and events

void one_value(Archive& a, ManifoldPair& p) {
  values(a, p.a, p.b, p.shape, p.id_a, p.id_b, p.owner, p.part_a, p.part_b, p.fixed_a, p.lane);
  values(a, p.manifold, p.base, p.turn_a, p.turn_b, p.margin);
  for (int k = 0; k < 2; ++k) values(a, p.gap[k], p.impulse[k], p.friction[k], p.offset[k]);
  values(a, p.round_a, p.round_b, p.roll, p.crossing, p.active, p.ahead, p.flying, p.ghost, p.moved, p.landing,
         p.rocking, p.lasting, p.changed, p.stack, p.was_stack, p.rest_frames, p.idle, p.recalled, p.colour, p.balanced,
         p.placed, p.stands, p.hangs, p.yields);
  a.require(p.manifold.count >= 0 && p.manifold.count <= 2 && p.recalled <= 2 && p.idle <= ManifoldPair::kIdle);
  a.require((p.a == PairName::kNone) == (p.shape != PairName::kNone));
  a.require(p.colour < 4 * ManifoldPair::kColours || p.colour == ManifoldPair::kAlone);
}

void Decisions::describe(Archive& a, const BodyStore& bodies) {
  a.list(list_, [&](Decision& d) {
    values(a, d.name.a, d.name.b, d.name.part_a, d.name.part_b, d.through, d.changed, d.surface);
    const bool wall = d.name.b == kNoSlot && d.name.part_b >= kWallLeft;
    a.require(d.name.a < bodies.id_count && (wall || d.name.b < bodies.id_count));
  });
  if (a.loading()) a.require(std::ranges::is_sorted(list_, std::ranges::less_equal{}, &Decision::name));
}

void PartSearch::describe(Archive& a) {
  const BodyStore& b = s_.bodies;
  values(a, common_way_);
  const auto noted = [&](std::vector<Noted>& all, const auto& belongs) {
    // Bodies that were removed or took another slot since are in no list any more; another body may have their slot.
    if (!a.loading()) std::erase_if(all, [&](const Noted& n) { return n.slot >= b.count || !belongs(n.slot); });
    a.list(all, [&](Noted& n) {
      a.index(b.count, n.slot);
      values(a, n.angle, n.turn);
      a.require(a.ok() && belongs(n.slot) && n.turn >= 0);
    });
    a.require(std::ranges::is_sorted(all, std::ranges::less_equal{}, &Noted::slot) || all.empty());
  };
  noted(wide_, [&](std::uint32_t slot) { return b.id[slot] != kNoSlot && has_many(slot); });
  noted(few_, [&](std::uint32_t slot) { return b.id[slot] != kNoSlot && has_few(slot); });
}

void Manifolds::describe(Archive& a, const ManifoldsAround& around) {
  const std::uint32_t slots = s_.bodies.count;
  parts_.describe(a);
  boxed_ = boxed_ && !a.loading();
  long_known_ = long_known_ && !a.loading();
  decisions_.describe(a, s_.bodies);
  values(a, pairs_);
  std::uint32_t own_end = std::min(own_end_, static_cast<std::uint32_t>(pairs_.size()));
  a.value(own_end);
  a.require(own_end <= pairs_.size());
  a.packed(begin_);
  a.list(strips_, [&](StripBlocks& s) {
    a.plain(s.blocks);
    a.plain(s.surfaces);
    a.require(s.surfaces.empty() || s.surfaces.size() == s.blocks.size());
    a.packed(s.active);
    a.packed(s.laid);
    // In the middle of a step a strip may watch pairs of lists that are not saved yet; who goes on from the state finds
    // them anew.
    std::vector<std::uint32_t> watched;
    if (!a.loading())
      std::ranges::copy_if(s.watched, std::back_inserter(watched), [&](auto k) { return k < pairs_.size(); });
    a.packed(watched);
    if (a.loading()) s.watched = std::move(watched);
    values(a, s.end, s.colours, s.points);
  });
  a.packed(special_);
  a.packed(stale_);
  a.packed(shaped_, around.present() ? slots : kAnyNumber);
  bool kinds = slots != 0 && kind_.capacity() >= slots;
  a.value(kinds);
  if (kinds) {
    if (a.loading()) kind_.reserve(slots);
    a.packed(kind_, slots);
  }
  Totals& t = totals_;
  values(a, t.points, g_, any_filter_, wall_special_, t.loaded, t.colours, t.blocks, t.pass_blocks, laid_, looks_.again,
         new_pairs_, cold_, weighs_);
  if (!a.loading()) return;
  own_end_ = own_end;
  if (!kinds) kind_.release();
  for (std::uint32_t i = 0; i < slots && around.present() && a.ok(); ++i) {
    const std::uint32_t id = s_.bodies.id[i];
    a.require(kinds && (id == kNoSlot || has_corners(i) == (s_.bodies.kind(id).hull_count != 0)));
  }
  for (const ManifoldPair& p : pairs_) check_pair(a, p, around);
  a.require(begin_.size() <= strips_.size() + 1);
  a.require(std::is_sorted(begin_.begin(), begin_.end()));
  a.require(!around.exact() ||
            (begin_.empty() ? pairs_.empty() : begin_.front() == 0 && begin_.back() == pairs_.size()));
  std::uint64_t points = 0;
  for (std::size_t k = 0; k < strips_.size() && a.ok(); ++k) {
    check_strip(a, k, around);
    points += strips_[k].points;
  }
  a.require(t.points == 0 || (t.points <= points && around.wanted));
  if (!a.ok()) return;
  follow_from_pairs();
}

// What follows from the pairs that were read.
void Manifolds::follow_from_pairs() {
  const std::uint32_t slots = s_.bodies.count;
  for (StripBlocks& s : strips_) {
    std::erase_if(s.watched, [&](std::uint32_t k) { return k >= pairs_.size(); });
    s.landing.clear();
    s.open.clear();
    s.lasting.clear();
    s.lasting.reserve(s.blocks.size());
    for (auto* list : {&s.rewrite, &s.idle, &s.fresh}) list->reserve(s.laid.size());
    std::ranges::copy_if(s.active, std::back_inserter(s.landing),
                         [&](std::uint32_t k) { return k < pairs_.size() && pairs_[k].landing; });
    std::ranges::copy_if(s.active, std::back_inserter(s.open),
                         [&](std::uint32_t k) { return k < pairs_.size() && pairs_[k].rocking; });
  }
  known_lane_.assign(pairs_.size(), PairName::kNone);
  stood_known_ = false;
  old_pairs_.clear();
  both_ = collecting_ = false;
  indexed_ = fixed_known_ = false;
  cut();
  rotor_.reserve(2 * std::size_t{slots});
  inner_.reserve(slots);
  used_.reserve(slots);
  stood_.resize(slots);
}

void Manifolds::check_pair(Archive& a, const ManifoldPair& p, const ManifoldsAround& around) const {
  const BodyStore& b = s_.bodies;
  const auto of = [&](std::uint32_t slot, std::uint32_t id, std::uint32_t part) {
    a.require(id < b.id_count);
    if (!a.ok()) return;
    a.require(b.info[id].place != Place::none && part < std::max(b.kind(id).hull_count, 1u));
    if (around.present() && around.in_place) a.require(slot < b.count && b.id[slot] == id);
  };
  const bool fixed = p.of_piece(), wall = p.of_wall();
  a.require(p.owner < b.id_count && p.id_b < b.id_count && (p.id_a < b.id_count || p.id_a == PairName::kNone));
  if (around.present() || around.carried) a.require(p.b < around.numbered && (fixed || p.a < around.numbered));
  if (fixed) a.require(wall ? p.shape <= kWallTop : p.shape < s_.statics.size());
  if (!a.ok() || !around.present()) return;
  of(p.b, p.id_b, p.part_b);
  if (!fixed) return of(p.a, p.id_a, p.part_a);
  a.require(p.fixed_a);
  if (!wall) a.require(s_.statics[p.shape].alive && s_.statics[p.shape].owner == p.id_a);
}

// Lists of pairs that are gone, or not looked at yet, are made anew before anyone reads them.
void Manifolds::check_strip(Archive& a, std::size_t index, const ManifoldsAround& around) const {
  const StripBlocks& s = strips_[index];
  const auto blocks = static_cast<std::uint32_t>(s.blocks.size());
  a.require(std::is_sorted(std::begin(s.end), std::end(s.end)) && s.end[3] <= blocks);
  if (around.spread && !around.lists) return;
  if (index + 1 < begin_.size()) {
    const std::uint32_t begin = begin_[index];
    const std::uint32_t end = std::min(begin_[index + 1], static_cast<std::uint32_t>(pairs_.size()));
    for (const auto* list : {&s.active, &s.laid}) {
      if ((!around.fresh && !laid_) || (around.spread && list == &s.active)) continue;
      a.require(std::all_of(list->begin(), list->end(),
                            [&](std::uint32_t k) { return k >= begin && (k < end || around.spread); }));
    }
    for (std::uint32_t k = begin; k < end; ++k) {
      const std::uint32_t lane = pairs_[k].lane;
      a.require(lane == PairName::kNone || lane / kernels::kBlock < blocks ||
                ((around.spread || !around.fresh) && !laid_));
    }
  }
  if (!around.fresh) return;
  const std::size_t bodies = kernels::round_up_block(s_.bodies.count) + 2 * strip_count();  // two that rest a strip
  for (const kernels::ManifoldBlock& block : s.blocks) {
    for (const std::uint32_t body : block.body) a.require(body < bodies);
  }
}

void FluidEventList::describe(Archive& a, std::uint32_t ids) {
  a.list(inside_, [&](FluidEvent& e) {
    a.index(ids, e.sensor.index);
    values(a, e.sensor.generation, e.part, e.fluid, e.particle);
  });
  if (a.loading()) clear();
}

void EventList::describe(Archive& a, std::uint32_t ids) {
  values(a, options_.contacts, options_.hits, options_.hit_speed, options_.sensors, options_.sleep, options_.moves,
         options_.fluids, left_, build_);
  a.list(sleepers_, [&](BodyId& id) {
    a.index(ids, id.index);
    a.value(id.generation);
  });
  a.list(removed_, [&](BodyId& id) {
    a.index(ids, id.index);
    a.value(id.generation);
  });
  a.packed(touching_);
  for (Keys* keys : {&lane_key_, &paired_, &toggled_, &rest_found_, &rest_, &slept_}) {
    a.packed(*keys);
    if (!a.loading()) continue;
    for (const std::uint64_t key : *keys) {
      const auto other = static_cast<std::uint32_t>(key);
      const bool wall =
          other >= kWallLeft && other <= kWallTop && (keys == &rest_found_ || keys == &rest_ || keys == &slept_);
      const bool known = key >> 32 < ids && (other < ids || wall);
      a.require(known || (keys == &lane_key_ && key == ~std::uint64_t{0}));
    }
  }
  a.list(sensed_, [&](Felt& f) {
    values(a, f.first, f.second);
    a.require(f.first >> 32 < ids && static_cast<std::uint32_t>(f.first) < ids);
  });
  fluids_.describe(a, ids);
  if (!a.loading()) return;
  a.require(std::ranges::is_sorted(sensed_));
  slept_at_ = kNever;
  const auto by_index = [](BodyId x, BodyId y) { return x.index >= y.index; };
  a.require(std::adjacent_find(sleepers_.begin(), sleepers_.end(), by_index) == sleepers_.end());
  a.require(lane_key_.size() == touching_.size() * kernels::kBlock);
  for (const Keys* keys : {&paired_, &rest_, &slept_}) a.require(std::is_sorted(keys->begin(), keys->end()));
  clear();
}

// ---- joints: what the host asked for, and the blocks with what they did in the last substep. Which joint lies in
// which lane, and who is joined to whom, follows from that.

static void check_joint(Archive& a, const JointDesc& joint, const BodyStore& b) {
  a.require(joint.a.index != joint.b.index && joint.length && joint.reference);
  const bool alone = joint.type == JointType::pulley || joint.type == JointType::filter;
  for (const BodyId& end : {joint.a, joint.b}) {
    if (end == kWorldBody && !alone) continue;
    a.require(end.index < b.id_count && b.info[end.index].generation == end.generation);
    if (!a.ok()) return;
    const Place place = b.info[end.index].place;
    a.require(place != Place::none && place != Place::frozen);
  }
}

// What a few joints have besides the basics.
void JointStore::describe_extra(Archive& a, Joint& j) {
  bool rare = j.extra != kNoSlot;
  values(a, rare);
  if (!rare || !a.ok()) return;
  a.require(j.alive);
  if (a.loading()) {
    j.extra = static_cast<std::uint32_t>(extras_.size());
    extras_.emplace_back();
  }
  Extra& extra = extras_[j.extra];
  values(a, extra.desc);
  if (j.kind != kernels::JointKind::linkage || !a.ok()) return;
  if (a.loading()) {
    extra.linkage = linkages_.add();
    linkages_[extra.linkage].set_type(extra.desc.type);
  }
  linkages_[extra.linkage].each_impulse([&a](double& l) { values(a, l); });
}

// A joint that was read: its bodies, and whether it is solved as its description asks for.
void JointStore::check(Archive& a, Joint& j) {
  using kernels::JointKind;
  const auto index = static_cast<std::uint32_t>(&j - joints_.data());
  const JointDesc d = desc({index, j.generation});
  set_desc(j, d);
  check_joint(a, d, s_.bodies);
  const JointKind asked = kind_of(d);
  a.require(j.kind == asked || (j.kind == JointKind::driven && asked == JointKind::pin));
  a.require(asked != JointKind::linkage || (j.extra != kNoSlot && extras_[j.extra].linkage != kNoSlot));
  for (const JointId part : {d.joint_a, d.joint_b}) {
    if (d.type != JointType::gear) break;
    a.require(part.index < joints_.size() && is_valid(part) && part.index != index);
    if (!a.ok()) return;
    const JointType type = joints_[part.index].desc.type;
    a.require(type == JointType::revolute || type == JointType::prismatic);
  }
}

void JointStore::describe(Archive& a) {
  if (!a.loading()) {
    save_impulses();
  } else {
    lose_all();
  }
  a.list(joints_, [&](Joint& j) {
    Basics& d = j.desc;
    values(a, d.type, d.a, d.b, d.anchor_a, d.anchor_b, d.length, d.stiffness, d.damping, d.axis, d.reference, d.lower,
           d.upper, d.motor_speed, d.motor_limit, d.collide);
    values(a, j.generation, j.alive, j.dormant, j.kind, j.impulse, j.gain);
    describe_extra(a, j);
  });
  describe_free(a, free_, 0, joints_.size(),
                [&](std::size_t k) { return !joints_[k].alive && joints_[k].generation != kLastGeneration; });
  a.list(tethers_, [&](Tether& t) { values(a, t.key[0], t.key[1], t.key[2], t.impulse); });
  bool laid = !stale_;
  values(a, laid, h_, cycles_.count);
  a.require(cycles_.count >= 1 && cycles_.count <= JointCycles::kMost);
  if (a.loading()) {
    free_extras_.reserve(extras_.size());  // dropping needs no memory
    for (Joint& j : joints_) {
      if (j.alive && a.ok()) check(a, j);
    }
    if (!a.ok()) lose_all(), free_.clear();
    count_ = exclusions_ = 0;
    first_.clear();
    for (auto& lanes : lanes_) lanes.clear();
    for (std::uint32_t k = 0; k < joints_.size(); ++k) {
      if (joints_[k].alive) enter(k);
    }
    for (const std::uint32_t gear : gears_) find_sides(joints_[gear]);  // all others are known now
    stale_ = true;                                                      // what follows from the joints is found anew
    if (laid && a.ok()) {
      lay_out();
      stale_ = false;
    }
  }
  for (std::uint32_t k = 0; k < kLists && laid; ++k) {
    JointLists::visit(lists_, k, [&](auto& blocks) {
      const std::size_t n = blocks.size();
      a.plain(blocks);
      a.require(blocks.size() == n);
      blocks.resize(n);
    });
  }
}

}  // namespace psim
