#include "image.h"

namespace psim {

namespace {

// A variant by the number of its alternative.
template <class A, class V, std::size_t... I>
void alternative(A& a, V& v, std::index_sequence<I...>) {
  auto which = static_cast<std::uint32_t>(v.index());
  a.value(which);
  a.require(which < sizeof...(I));
  if constexpr (A::kLoading) {
    ((which == I ? static_cast<void>(v.template emplace<I>()) : void()), ...);
  }
}

template <class A>
void visit_vec(A& a, Vec2& v) {
  numbers(a, v.x, v.y);
}

}  // namespace

template <class A>
void Image::visit(A& a, WorldDesc& d) {
  numbers(a, d.bounds.xmin, d.bounds.ymin, d.bounds.xmax, d.bounds.ymax, d.boundary, d.gravity.x, d.gravity.y,
          d.linear_damping, d.wall.density, d.wall.restitution, d.wall.friction, d.dt, d.substeps, d.integrator,
          d.restitution_threshold, d.sleeping, d.skin);
  list(a, d.fields, [&](Field& f) {
    alternative(a, f, std::make_index_sequence<2>());
    if (auto* w = std::get_if<WellField>(&f)) {
      numbers(a, w->position.x, w->position.y, w->strength, w->softening, w->exponent, w->range);
    } else {
      auto& drag = std::get<DragField>(f);
      numbers(a, drag.linear, drag.quadratic);
    }
  });
}

template <class A>
void Image::visit(A& a, Traits& t) {
  numbers(a, t.moving, t.discs, t.held_discs, t.rough_discs, t.same_mass, t.same_radius, t.same_surface,
          t.moving_bounce, t.moving_rough, t.kinematic, t.odd_gravity, t.fixed, t.fixed_bounce, t.fixed_rough,
          t.cornered, t.filtered, t.sensors, t.bullets, t.joints, t.exclusions, t.turning, t.walls, t.wall_bounce,
          t.wall_rough, t.mass_ratio, t.gravity, t.fields, t.integrator, t.damping, t.events, t.sleeping);
}

template <class A>
void Image::visit(A& a, Plan& p) {
  numbers(a, p.forces, p.fields, p.scales, p.integrator, p.friction, p.restitution, p.masses, p.uneven, p.loads,
          p.radii, p.surfaces, p.rotation, p.shapes, p.filters, p.joints, p.turns, p.continuous, p.bullets, p.sleep,
          p.events, p.model.model, p.model.bounce);
}

template <class A>
void Image::visit(A& a, Surface& s) {
  numbers(a, s.inv_mass, s.mass, s.spin_gain, s.radius, s.gravity_scale, s.restitution, s.friction);
  std::uint32_t make = s.make;
  BodyType type = s.type;
  numbers(a, make, type);
  s.make = make & MakeTable::kMost;
  s.type = type;
}

template <class A>
void Image::visit(A& a, Hull& h) {
  for (int k = 0; k < Hull::kMost; ++k) numbers(a, h.x[k], h.y[k], h.nx[k], h.ny[k]);
  numbers(a, h.radius, h.reach, h.inner, h.count);
}

template <class A>
void Image::visit(A& a, Make& m) {
  numbers(a, m.first_hull, m.hull_count, m.centre_x, m.centre_y, m.inner, m.filter.category, m.filter.mask,
          m.filter.group, m.bullet, m.sensor);
}

template <class A>
void Image::visit(A& a, JointDesc& d) {
  a.value(d.type);
  visit(a, d.a);
  visit(a, d.b);
  visit_vec(a, d.anchor_a);
  visit_vec(a, d.anchor_b);
  maybe(a, d.length);
  numbers(a, d.stiffness, d.damping);
  visit_vec(a, d.axis);
  maybe(a, d.reference);
  maybe(a, d.lower);
  maybe(a, d.upper);
  numbers(a, d.motor_speed, d.motor_limit, d.collide);
}

template <class A>
void Image::visit(A& a, ManifoldPair& p) {
  numbers(a, p.a, p.b, p.shape, p.id_a, p.id_b, p.owner, p.part_a, p.part_b, p.fixed_a, p.lane);
  Manifold& m = p.manifold;
  numbers(a, m.nx, m.ny, m.count);
  for (ManifoldPoint& q : m.point) numbers(a, q.ax, q.ay, q.bx, q.by, q.gap, q.feature);
  numbers(a, p.base_x, p.base_y, p.base_dx, p.base_dy, p.turn_a.c, p.turn_a.s, p.turn_b.c, p.turn_b.s, p.margin);
  for (int k = 0; k < 2; ++k) numbers(a, p.gap[k], p.impulse[k], p.friction[k], p.offset[k]);
  numbers(a, p.round_a, p.round_b, p.active, p.ahead, p.ghost, p.moved, p.lasting, p.changed, p.column, p.was_column,
          p.rest_frames, p.recalled, p.colour, p.balanced);
}

// ---- bodies ------------------------------------------------------------------------------------

namespace {

void find_roster(BodyStore& b) {
  if (!b.roster_changed) return;
  b.roster_changed = false;
  std::vector<AlikeBodies>& out = b.roster;
  out.clear();
  b.roster_sum.reset();
  for (std::uint32_t id = 0; id < b.id_count; ++id) {
    const BodyInfo& info = b.info[id];
    const bool listed = info.place != Place::moving && info.place != Place::none && info.place != Place::asleep;
    if (!out.empty()) {
      AlikeBodies& last = out.back();
      if (last.generation == info.generation && last.surface == info.surface && last.place == info.place &&
          (!listed || info.slot == last.slot + last.count)) {
        ++last.count;
        continue;
      }
    }
    out.push_back({1, info.generation, info.surface, listed ? info.slot : kNoSlot, info.place});
  }
}

// Where they sleep, the packs of sleepers say.
void take_roster(const std::vector<AlikeBodies>& roster, BodyStore& b) {
  b.slots_stale = true;
  b.alike = !b.roster_changed && roster == b.roster;
  if (b.alike) return;
  b.roster = roster;
  b.roster_changed = false;
  b.roster_sum.reset();
  std::uint32_t id = 0;
  for (const AlikeBodies& run : roster) {
    for (std::uint32_t k = 0; k < run.count && id < b.id_count; ++k, ++id) {
      const bool stays = run.place == Place::asleep && b.info[id].place == Place::asleep;
      const std::uint32_t slot = stays ? b.info[id].slot : run.slot == kNoSlot ? kNoSlot : run.slot + k;
      b.info[id] = {slot, run.generation, run.surface, run.place};
    }
  }
}

}  // namespace

template <class A>
void Image::bodies(A& a, BodyStore& b, bool lists) {
  [[maybe_unused]] const std::uint32_t ids = b.id_count;
  numbers(a, b.id_count, b.count, b.dead, b.living, b.moving, b.fixed, b.kinematic, b.asleep);
  std::vector<AlikeBodies> loaded;
  if constexpr (!A::kLoading) find_roster(b);
  records(a, A::kLoading ? loaded : b.roster,
          [](auto& record, AlikeBodies& r) { numbers(record, r.count, r.generation, r.surface, r.slot, r.place); });
  if (!a.fits(b.id_count) || !a.fits(b.count)) return;
  if (a.dry()) b.roster.swap(loaded);
  if (A::kLoading && !a.dry()) {
    b.info.reserve(b.id_count);
    for (std::uint32_t id = b.id_count; id < ids; ++id)
      b.info[id] = BodyInfo{};  // as if never used
    take_roster(loaded, b);
    b.reserve_slots(1);  // even of none: columns that the plan wants are there
  }
  a.vector(b.free_ids);
  const std::size_t n = b.count;
  a.column(b.pos, 2 * n);
  a.column(b.vel, 2 * n);
  a.column(b.disp, 2 * n);
  a.column(b.id, n);
  // What only some worlds have.
  bool turns = !b.spin.empty(), rests = !b.vel_rest.empty(), offsets = !b.disp_rest.empty();
  numbers(a, turns, rests, offsets);
  if (A::kLoading && !a.dry()) {
    if (turns) b.add_rotation();
    if (rests) b.add_rests(offsets);
    if (!rests) b.vel_rest.release();
    if (!offsets) b.disp_rest.release();
    if (!turns) b.drop_rotation();
  }
  if (turns) {
    a.column(b.spin, n);
    a.column(b.angle, n);
  }
  if (rests) a.column(b.vel_rest, 2 * n);
  if (offsets) a.column(b.disp_rest, 2 * n);
  if (lists) {
    a.column(b.built, 2 * n);
    a.column(b.reach, n);
  }
  SurfaceTable& surfaces = b.surfaces;
  if constexpr (A::kLoading) surfaces.list_.swap(surfaces.before_);
  records(a, surfaces.list_, [](auto& record, SurfaceTable::Entry& e) {
    visit(record, e.surface);
    record.value(e.users);
  });
  if constexpr (A::kLoading) {
    const auto same = [](const SurfaceTable::Entry& one, const SurfaceTable::Entry& other) {
      return one.surface == other.surface;
    };
    b.alike = b.alike && std::ranges::equal(surfaces.list_, surfaces.before_, same);
  }
  a.values(b.surfaces.free_);
  a.value(b.surfaces.last_);
  std::vector<MakeTable::Entry> makes;
  if (A::kLoading && !a.dry()) makes = b.makes.list_;
  records(a, b.makes.list_, [](auto& record, MakeTable::Entry& e) {
    visit(record, e.make);
    record.value(e.users);
  });
  a.values(b.makes.free_);
  a.value(b.makes.last_);
  if constexpr (A::kLoading) {
    const auto same = [](const MakeTable::Entry& one, const MakeTable::Entry& other) { return one.make == other.make; };
    b.alike = b.alike && std::ranges::equal(b.makes.list_, makes, same);
  }
  ShapeTable& h = b.hulls;
  records(a, h.hulls_, [](auto& record, Hull& hull) { visit(record, hull); });
  list(a, h.sets_, [&](ShapeTable::Set& s) { numbers(a, s.first, s.count, s.users); });
  a.values(h.free_);
  if constexpr (A::kLoading) {
    h.by_hash_.clear();
    h.by_first_.clear();
    for (std::uint32_t k = 0; k < h.sets_.size(); ++k) {
      const ShapeTable::Set& s = h.sets_[k];
      if (s.users == 0 || a.dry()) continue;
      const auto first = h.hulls_.begin() + s.first;
      h.by_hash_.emplace(ShapeTable::hash({first, first + s.count}), k);
      h.by_first_[s.first] = k;
    }
  }
}

// ---- lists -------------------------------------------------------------------------------------

template <class A>
void Image::broad(A& a, BroadPhase& b) {
  BroadPhaseParams& p = b.params_;
  numbers(a, p.margin.skin, p.margin.time, p.margin.common_x, p.margin.common_y, p.ahead, p.outer,
          p.sample, p.growth, p.walls, p.periodic, p.mixed_radii, p.link_all, p.bounds.xmin,
          p.bounds.ymin, p.bounds.xmax, p.bounds.ymax);
  numbers(a, b.all_.most, b.all_.extent[0], b.all_.extent[1], b.all_.extent[2], b.all_.extent[3], b.sorted_);
  kernels::GridView& g = b.grid_.view;
  numbers(a, g.mid_x, g.mid_y, g.scale_x, g.scale_y, g.offset_x, g.offset_y, g.cols, g.rows, g.stride);
  numbers(a, b.grid_.cell_x, b.grid_.cell_y, b.grid_.periodic, b.grid_.keys, b.listed_, b.large_,
          b.most_, b.box_, b.area_, b.density_, b.pad_reach_, b.next_pad_reach_, b.pairs_a_large_,
          b.near_pairs_, b.tests_);
  a.vector(b.pairs_a_body_);
  a.vector(b.pairs_a_piece_);
  a.vector(b.near_a_body_);
  a.value(b.fixed_);
  CellList& c = b.sort_.listed_;
  for (CellList::Axis& axis : c.axis_) numbers(a, axis.low, axis.per, axis.cells, axis.width);
  numbers(a, c.row_axis_, c.stride_, c.rows_, c.periodic_, c.slot_bits_, c.stays_);
  if constexpr (A::kLoading) c.sorted_ = 0;
}

// Where renewed bodies were when all lists were made; where they are looked for now, bodies() has.
template <class A>
void Image::renewal(A& a, ListRenewal& r, std::size_t slots) {
  list(a, r.renewed_, [&](ListRenewal::Renewed& x) { numbers(a, x.slot, x.x, x.y, x.reach); });
  a.values(r.linked_);
  a.value(r.time_);
  a.require(std::all_of(r.renewed_.begin(), r.renewed_.end(), [&](const auto& x) { return x.slot < slots; }));
  a.require(std::all_of(r.linked_.begin(), r.linked_.end(), [&](std::uint32_t slot) { return slot < slots; }));
  if (A::kLoading && !a.dry()) r.mark_.reserve(slots);
}

template <class A>
void Image::contacts(A& a, ContactStore& c) {
  numbers(a, c.model_.model, c.model_.bounce, c.pair_blocks_, c.single_blocks_, c.colours_, c.pair_count_,
          c.single_count_, c.loaded_blocks_, c.builds_);
}

template <class A>
void Image::solved(A& a, SolverBodies& s) {
  numbers(a, s.count_, s.compact_);
}

template <class A>
void Image::counts(A& a, Solver& s, HeavyLoads& l, Continuous& c) {
  numbers(a, s.closed_, s.sweeps_, l.visits_, c.looked_);
}

template <class A>
void Image::table(A& a, PairTable& t) {
  numbers(a, t.body_count, t.large_begin);
  list(a, t.strips, [&](Strip& s) {
    numbers(a, s.body_begin, s.body_end, s.row_begin, s.row_end);
  });
}

template <class A>
void Image::manifolds(A& a, Manifolds& m, std::size_t slots) {
  static_assert(sizeof(kernels::ManifoldBlock) % (4 * kernels::kBlock) == 0, "a block is made of 4-byte numbers alone");
  const auto all = [&] {
    records(a, m.pairs_, [](auto& record, ManifoldPair& p) { visit(record, p); });
    a.values(m.begin_);
    list(a, m.strips_, [&](Manifolds::StripBlocks& s) {
      a.vector(s.blocks);
      a.values(s.active);
      a.values(s.laid);
      for (std::uint32_t& end : s.end) a.value(end);
      numbers(a, s.colours, s.points);
    });
    a.vector(m.ghosts_);
    a.vector(m.special_);
    a.vector(m.stale_);
    a.values(m.shaped_);
  };
  a.part(all, [] {});
  bool kinds = slots != 0 && m.kind_.capacity() >= slots;
  a.value(kinds);
  if (kinds) a.column(m.kind_, slots);
  if (A::kLoading && !kinds) m.kind_.release();
  numbers(a, m.points_, m.g_, m.any_filter_, m.loaded_, m.colours_, m.blocks_, m.pass_blocks_,
          m.laid_, m.looks_, m.new_pairs_);
}

void Image::take(Manifolds& m, Manifolds& read, std::size_t slots, bool keep_room) {
  const auto take = [keep_room](auto& mine, auto& theirs) { keep_room ? void(mine = theirs) : mine.swap(theirs); };
  take(m.pairs_, read.pairs_);
  take(m.begin_, read.begin_);
  take(m.strips_, read.strips_);
  take(m.ghosts_, read.ghosts_);
  take(m.special_, read.special_);
  take(m.stale_, read.stale_);
  take(m.shaped_, read.shaped_);
  if (!read.kind_.empty()) {
    m.kind_.reserve(slots);
    std::copy_n(read.kind_.data(), slots, m.kind_.data());
  }
  m.points_ = read.points_;
  m.g_ = read.g_;
  m.any_filter_ = read.any_filter_;
  m.loaded_ = read.loaded_;
  m.colours_ = read.colours_;
  m.blocks_ = read.blocks_;
  m.pass_blocks_ = read.pass_blocks_;
  m.laid_ = read.laid_;
  m.looks_ = read.looks_;
  m.new_pairs_ = read.new_pairs_;
  m.old_pairs_.clear();
  m.own_end_ = std::min(m.own_end_, static_cast<std::uint32_t>(m.pairs_.size()));
  m.indexed_ = false;
  m.cut();
  m.owner_.resize(m.pairs_.size());
  for (std::size_t k = 0; k < m.pairs_.size(); ++k) m.owner_[k] = m.pairs_[k].owner;
  m.rotor_.reserve(2 * slots);
  m.inner_.reserve(slots);
  m.used_.reserve(slots);
}

// ---- joints, sleep, events -----------------------------------------------------------------------

template <class A>
void Image::joints(A& a, JointStore& j, JointStore* read) {
  if constexpr (!A::kLoading) j.save_impulses();
  const auto all = [&] {
    records(a, j.joints_, [](auto& record, JointStore::Joint& joint) {
      visit(record, joint.desc);
      numbers(record, joint.generation, joint.alive, joint.swapped, joint.dormant, joint.kind, joint.next[0],
              joint.next[1], joint.list, joint.lane, joint.body[0], joint.body[1]);
      for (float& l : joint.impulse) record.value(l);
    });
    a.values(j.free_);
    a.values(j.first_);
    numbers(a, j.count_, j.stale_, j.bodies_stale_, j.h_);
    a.values(j.bodies_);
    for (std::uint32_t k = 0; k < JointStore::kLists; ++k) {
      a.values(j.lanes_[k]);
      JointLists::visit(j.lists_, k, [&](auto& blocks) { a.vector(blocks); });
    }
    list(a, j.ranges_, [&](auto& r) { numbers(a, r.list, r.begin, r.end); });
    list(a, j.jobs_, [&](auto& r) { numbers(a, r.begin, r.end); });
    list(a, j.phases_, [&](auto& r) { numbers(a, r.begin, r.end); });
    a.value(j.total_blocks_);
  };
  a.part(all, [&] { take(j, *read); });
}

void Image::take(JointStore& j, JointStore& read) {
  const auto excludes_as = [](const JointStore::Joint& one, const JointStore::Joint& other) {
    if (!one.alive || !other.alive) return one.alive == other.alive;
    return one.desc.a.index == other.desc.a.index && one.desc.b.index == other.desc.b.index &&
           one.desc.collide == other.desc.collide;
  };
  const bool same = std::ranges::equal(j.joints_, read.joints_, excludes_as);
  j.joints_.swap(read.joints_);
  j.free_.swap(read.free_);
  j.first_.swap(read.first_);
  j.bodies_.swap(read.bodies_);
  for (std::uint32_t k = 0; k < JointStore::kLists; ++k) j.lanes_[k].swap(read.lanes_[k]);
  std::swap(j.lists_, read.lists_);
  j.ranges_.swap(read.ranges_);
  j.jobs_.swap(read.jobs_);
  j.phases_.swap(read.phases_);
  j.count_ = read.count_;
  j.stale_ = read.stale_;
  j.bodies_stale_ = read.bodies_stale_;
  j.h_ = read.h_;
  j.total_blocks_ = read.total_blocks_;
  if (same) return;
  j.exclusions_.clear();
  j.exclusive_.clear();
  for (const JointStore::Joint& joint : j.joints_) {
    if (joint.alive) j.exclude(joint.desc, +1);
  }
}

template <class A>
void Image::events(A& a, EventList& e) {
  numbers(a, e.options_.contacts, e.options_.hits, e.options_.hit_speed, e.options_.sensors, e.left_, e.build_);
  list(a, e.removed_, [&](BodyId& id) { visit(a, id); });
  a.vector(e.touching_);
  for (EventList::Keys* keys : {&e.lane_key_, &e.paired_, &e.toggled_, &e.rest_found_, &e.rest_, &e.slept_, &e.sensed_}) {
    a.vector(*keys);
  }
  if constexpr (A::kLoading) {
    e.begin_.clear();
    e.end_.clear();
    e.hits_.clear();
    e.sensor_begin_.clear();
    e.sensor_end_.clear();
  }
}

#define PSIM_IMAGE_OF(A)                                              \
  template void Image::visit(A&, WorldDesc&);                         \
  template void Image::visit(A&, Traits&);                            \
  template void Image::visit(A&, Plan&);                              \
  template void Image::visit(A&, JointDesc&);                         \
  template void Image::visit(A&, Surface&);                           \
  template void Image::visit(A&, Hull&);                              \
  template void Image::bodies(A&, BodyStore&, bool);                  \
  template void Image::broad(A&, BroadPhase&);                        \
  template void Image::renewal(A&, ListRenewal&, std::size_t);                     \
  template void Image::contacts(A&, ContactStore&);                   \
  template void Image::manifolds(A&, Manifolds&, std::size_t);        \
  template void Image::joints(A&, JointStore&, JointStore*);          \
  template void Image::events(A&, EventList&);                        \
  template void Image::table(A&, PairTable&);                         \
  template void Image::counts(A&, Solver&, HeavyLoads&, Continuous&); \
  template void Image::solved(A&, SolverBodies&);
PSIM_IMAGE_OF(Saver)
PSIM_IMAGE_OF(Loader)
#undef PSIM_IMAGE_OF

}  // namespace psim
