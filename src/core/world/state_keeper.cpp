// World::save and restore: the state of a whole world, part by part. Each part describes its own
// (state/describe_*.cpp).
//
// A state is written between steps. Lists that last are made again from where the bodies were when they were made, with
// the same code in the same order, so that every pair gets its impulse back and every colour is the same. A step that a
// governor spread over frames is saved as a list of what was done of it, and done again as far. A state is read into
// the world itself, which is saved before: if the state proves unsound, the world goes back to what it was.
#include <utility>

#include "base/invariant.h"
#include "manifolds/manifolds_around.h"
#include "state/describe.h"
#include "state/saved_contacts.h"
#include "world/world_impl.h"

namespace psim {

constexpr std::uint64_t last_of(Enum<ListState>) { return static_cast<std::uint64_t>(ListState::sorted); }
constexpr std::uint64_t last_of(Enum<ContactState>) { return static_cast<std::uint64_t>(ContactState::replaced); }
constexpr std::uint64_t last_of(Enum<ListMode>) { return static_cast<std::uint64_t>(ListMode::one_step); }

static auto fields(Traits& t) {
  return std::tie(t.moving, t.discs, t.kinematic_discs, t.rough_discs, t.same_mass, t.same_radius, t.same_properties,
                  t.moving_bounce, t.moving_rough, t.kinematic, t.odd_gravity, t.fixed, t.fixed_bounce, t.fixed_rough,
                  t.cornered, t.filtered, t.sensors, t.moving_sensors, t.bullets, t.special, t.asking, t.restrained,
                  t.one_rubs, t.joints, t.exclusions, t.turning, t.walls, t.wall_bounce, t.wall_rough, t.wall_special,
                  t.mass_ratio, t.gravity, t.fields, t.pushed, t.media, t.integrator, t.damping, t.events, t.sleeping);
}
static auto fields(Plan& p) {
  return std::tie(p.forces, p.fields, p.scales, p.integrator, p.friction, p.restitution, p.masses, p.uneven, p.loads,
                  p.radii, p.materials, p.rotation, p.manifolds, p.filters, p.joints, p.turns, p.continuous, p.bullets,
                  p.restraints, p.surfaces, p.sleep, p.events, p.model.model, p.model.bounce);
}

namespace {

// A state begins with the description of its world, which is read first.
struct StateLoader : Loader {
  explicit StateLoader(std::span<const std::byte> state) : Loader(state) { values(*this, desc); }
  WorldDesc desc;
};

class StateKeeper {
 public:
  explicit StateKeeper(Owners& world) : w_(world) {}

  void save(std::vector<std::byte>& out) {
    const WorkerPool::Awake awake(w_.pool, WorkerPool::Work::other);
    const PairTable& table = lists_.table;
    // Where nobody is awake, no contact of before is anybody's.
    const bool moved = w_.progress.sorted() || lists_.broad.origin.moved_on();
    if (moved && w_.bodies.count != 0) lists_.broad.origin.copy(origin_);
    const bool stale = lists_.stale;
    turn_back(w_);  // to the contacts of the last step
    const struct TurnAgain {
      StepContext& w;
      bool stale;
      ~TurnAgain() {
        w.neighbours.stale = stale;
        turn_back(w);
      }
    } again{w_, stale};
    lists_.made.candidates = count_work(w_).lists.candidates;
    lists_.stale = stale || w_.progress.makes_lists();
    last_ = !lists_.stale && lists_.mode != ListMode::one_step && w_.bodies.count != 0 && w_.bodies.dead == 0 &&
            table.body_count != 0;
    const bool any = lasting() || (w_.contacts.impulses_valid && table.body_count != 0);
    carried_.gather(table, w_.contacts.discs, any, !lasting(), !w_.sleep.sleepers.empty(),
                    moved ? nullptr : w_.bodies.id.data());
    if (w_.plan.manifolds) w_.contacts.manifolds.keep_impulses();
    Saver saver(std::move(out));
    values(saver, w_.desc);
    describe(saver);
    w_.contacts.manifolds.describe(saver, around_manifolds());
    out = saver.finish();
  }

  /// Reads the rest of a state. What is wrong is told to the loader; the world is of no use then.
  void load(StateLoader& loader) {
    const WorkerPool::Awake awake(w_.pool, WorkerPool::Work::other);
    w_.desc = loader.desc;
    const bool snapshots = w_.population.traits.snapshots;
    lists_.table.body_count = lists_.old_table.body_count = 0;
    lists_.table.strips.clear();
    lists_.candidates.strips.clear();
    lists_.renewal.forget();
    describe(loader);
    w_.population.traits.snapshots = w_.plan.publish = snapshots;
    if (!loader.ok()) return;
    w_.dynamics.forces.reset();
    if (!w_.plan_stale) apply_plan(w_);  // else the columns are there, and wait for the next plan
    if (w_.bodies.count != 0) w_.bodies.pad_tail();
    w_.contacts.discs.give_up();
    w_.contacts.manifolds.forget();  // of bodies that may not be
    w_.contacts.stacks.forget();
    StepProgress& now = w_.progress;
    if (now.contacts == ContactState::replaced) now.contacts = ContactState::due;
    lists_.broad.origin.set(origin_);
    w_.contacts.bare = true;
    w_.observers.placed = true;
    w_.observers.queries.forget(QueryIndex::kMoving, QueryIndex::kSleeping, QueryIndex::kFixed);
    // Work that is done again is not counted again.
    const ListNumbers made = lists_.made;
    const double visits = w_.contacts.loads.visits;
    const std::uint64_t builds = w_.contacts.discs.builds();
    if (lasting()) {
      remake_lists(loader);
    } else {
      carried_.make_table(lists_.table, w_.contacts.discs);
      if (last_) lists_.broad.build_again(lists_.candidates);
    }
    Manifolds& manifolds = w_.contacts.manifolds;
    manifolds.describe(loader, around_manifolds());
    if (lasting() && w_.sorts_out()) loader.require(manifolds.fit(lists_.table.strips.size()));
    loader.require(loader.left() == 0);
    if (loader.ok() && now.part > part_named("count")) redo_work(loader);
    loader.require(!loader.ok() || now.at == 0 || (!all_done(now) && now.at <= step_parts()[now.part].pieces(w_)));
    lists_.made = made;
    w_.contacts.loads.visits = visits;
    w_.contacts.discs.set_builds(builds);
  }

 private:
  // How far the present step is, and what was measured for the next ones.
  void describe_progress(Archive& a) {
    StepProgress& now = w_.progress;
    Dynamics& dynamics = w_.dynamics;
    values(a, last_, w_.ledger.frames, w_.ledger.steps, w_.quarantine.escaped, dynamics.stiff_substep,
           dynamics.last_substep, dynamics.substeps, w_.plan_stale);
    values(a, now.part, now.at, now.lists, now.contacts, now.spread, now.waits, now.spoiled, now.horizon);
    a.require(dynamics.substeps >= 1 && dynamics.substeps <= StepDetail::kMostSubsteps && dynamics.last_substep >= 0 &&
              dynamics.stiff_substep >= 0 && now.horizon >= 1 && now.waits < 255 && now.part <= step_parts().size());
    a.require(!now.untouched() || now.at == 0);
    ListNumbers& made = lists_.made;
    values(a, lists_.mode, lists_.stale, made.impact_rate, made.frames, made.speed, made.crowding, made.reach,
           made.skin, made.span, made.selected_span, made.candidates);
    a.require(made.span >= 0 && made.selected_span >= 0 && made.skin > 0);
    // Of bodies whose numbers are broken, these may be none.
    for (const double measured : {made.impact_rate, made.frames, made.speed, made.crowding, made.reach}) {
      a.require(!(measured < 0));
    }
    values(a, w_.contacts.impulses_valid, w_.contacts.kept, w_.contacts.softness_laid, w_.population.traits, w_.plan);
  }

  // All but the contacts of shapes, which are read once the lists are there.
  void describe(Archive& a) {
    describe_progress(a);
    const StepProgress& now = w_.progress;
    BodyStore& bodies = w_.bodies;
    describe_population(a, w_.population, last_ || now.makes_lists());
    w_.sleep.sleepers.describe(a, bodies, w_.statics);
    a.list(w_.quarantine.doubtful, [&](BodyId& id) {
      a.index(bodies.id_count, id.index);
      a.value(id.generation);
    });
    a.list(w_.done_so_far, [&](WorkDone& d) {
      values(a, d.part, d.at, d.span, d.id, d.before.vx, d.before.vy, d.before.rim_speed);
      a.require(d.part <= step_parts().size() && d.span >= 0 && d.span <= 1e30 &&
                (d.span > 0 || d.id < bodies.id_count));
      if (d.span == 0) a.require(a.ok() && bodies.info[d.id].place == Place::moving);
    });
    describe_lists(a);
    values(a, w_.contacts.discs, w_.contacts.solved, w_.contacts.loads, w_.dynamics.solver, w_.dynamics.continuous);
    a.require(w_.contacts.loads.sound());
    w_.joints.describe(a);
    w_.fluids.describe(a, w_.desc.bounds, w_.desc.boundary);
    w_.observers.events.describe(a, bodies.id_count);
    if (a.loading()) check(a);
  }

  void describe_lists(Archive& a) {
    const StepProgress& now = w_.progress;
    const BodyStore& bodies = w_.bodies;
    a.require(!last_ || bodies.count != 0);
    // Lists that are to be used are there; only such that last are renewed.
    a.require(last_ || lists_.stale || lists_.mode == ListMode::one_step || bodies.count == 0);
    a.require(now.part != part_named("renew") || lasting());
    const bool cells = last_ || (now.makes_lists() && now.part > part_named("count"));
    lists_.broad.describe(a, w_.desc.boundary == Boundary::periodic, cells);
    if (lasting()) lists_.renewal.describe(a, bodies.count);
    if (!lasting()) describe_strips(a, lists_.table);
    carried_.describe(a, lists_.table, w_.statics, !lasting());
    a.packed(origin_);
    a.require(origin_.size() <= bodies.count &&
              std::all_of(origin_.begin(), origin_.end(), [&](auto slot) { return slot == kNoSlot || a.fits(slot); }));
    a.require(lasting() || now.sorted() || !origin_.empty() || lists_.table.body_count <= bodies.count ||
              carried_.empty());
  }

  // What the plan follows from is counted again. What is looked up when a plan is made stays as it was.
  void check(Archive& a) const {
    if (!a.ok()) return;
    Traits traits = w_.population.recounted();
    traits.joints = w_.joints.count();
    take_traits(w_.desc, traits);
    a.require(traits == w_.population.traits);
    a.require(traits.pushed || w_.population.applied.empty());
    a.require(w_.population.kinematics.size() == traits.kinematic && w_.population.bullets.size() == traits.bullets &&
              w_.population.restraints.size() == traits.restrained);
    for (std::size_t k = 0; k < w_.bodies.count && w_.quarantine.doubtful.empty(); ++k) {
      a.require(w_.bodies.id[k] == kNoSlot ||
                (std::isfinite(w_.bodies.disp[2 * k]) && std::isfinite(w_.bodies.disp[2 * k + 1])));
    }
    a.require(!w_.plan.rotation || w_.bodies.count == 0 || !w_.bodies.rim_speed.empty());
    if (w_.plan_stale) return;
    Plan wanted = make_plan(traits);
    wanted.publish = w_.plan.publish;
    wanted.events = w_.plan.events;
    a.require(wanted == w_.plan && (w_.contacts.discs.model() == w_.plan.model || lists_.stale));
  }

  ManifoldsAround around_manifolds() const {
    const StepProgress& now = w_.progress;
    const bool in_order = !now.sorted() && origin_.empty();
    return {.numbered = in_order ? w_.bodies.count : std::max(w_.bodies.count, lists_.table.body_count),
            .wanted = w_.plan.manifolds,
            .fresh = !lists_.stale,
            .carried = w_.contacts.impulses_valid,
            .spread = now.makes_lists() || !now.untouched(),
            .lists = last_,
            .in_place = w_.bodies.dead == 0 && w_.quarantine.doubtful.empty()};
  }

  // Lists that last, and what their contacts carry.
  void remake_lists(Loader& loader) {
    StepProgress& now = w_.progress;
    const StepProgress kept = now;
    std::vector<WorkDone> done = std::exchange(w_.done_so_far, {});
    lists_.renewal.turn_back();
    lists_.broad.build_again(lists_.table);
    lists_.stale = w_.contacts.impulses_valid = true;
    now = {.part = part_named("group"), .contacts = ContactState::due};
    StepReport ignored;
    while (now.part < part_named("look")) run_part(w_, {}, ignored, step_parts()[now.part].pieces(w_));
    accept_work(w_);
    if (lists_.renewal.renewed() != 0) {
      w_.contacts.discs.lift(lists_.table);
      lists_.renewal.look_again(lists_.table);
      put_renewed(w_, lists_.broad.margin());
    }
    loader.require(carried_.put_back(lists_.table, w_.contacts.discs));
    now = kept;
    w_.done_so_far = std::move(done);
  }

  // What was done of the present step, from where its bodies are saved or its lists serve; everybody as fast as then.
  void redo_work(Loader& loader) {
    StepProgress& now = w_.progress;
    BodyStore& bodies = w_.bodies;
    now.at = 0;
    if (now.sorted()) {
      if (!lists_.selects()) {
        std::swap(lists_.table, lists_.old_table);
        now.contacts = ContactState::replaced;
      }
      lists_.broad.move_again(lists_.found());
      now.part = part_named("search");
    } else if (now.makes_lists()) {
      lists_.broad.count_again();
      now.part = part_named("move");
    } else {
      loader.require(last_);  // lists that are kept are there
      if (!loader.ok()) return;
      now.part = next_part(w_, part_named(lists_.selects() ? "select" : "look"));
    }
    bodies.find_slots();
    const auto swap_motion = [&](WorkDone& push) {
      if (push.span > 0) return;
      const std::size_t slot = bodies.info[push.id].slot;
      std::swap(bodies.vel[2 * slot], push.before.vx);
      std::swap(bodies.vel[2 * slot + 1], push.before.vy);
      if (!bodies.rim_speed.empty()) std::swap(bodies.rim_speed[slot], push.before.rim_speed);
    };
    std::for_each(w_.done_so_far.rbegin(), w_.done_so_far.rend(), swap_motion);
    StepReport ignored;
    const PreSolve host = std::exchange(w_.pre_solve, {});  // it answered already
    for (WorkDone& done : w_.done_so_far) {
      swap_motion(done);
      while (done.span > 0 && !all_done(now) && (now.part < done.part || (now.part == done.part && now.at < done.at))) {
        const std::size_t end = step_parts()[now.part].pieces(w_);
        run_part(w_, {done.span, done.span}, ignored,
                 now.part == done.part ? std::min<std::size_t>(end, done.at) : end);
      }
    }
    w_.pre_solve = host;
  }

  bool lasting() const { return last_ && !lists_.selects(); }

  Owners& w_;
  NeighbourLists& lists_ = w_.neighbours;
  bool last_ = false;  // lists, or those to select from, last and are made again
  SavedContacts carried_;
  std::vector<std::uint32_t> origin_;  // where bodies lay when the contacts were laid out, if they moved on
};

}  // namespace

void save(Owners& w, std::vector<std::byte>& out) { StateKeeper(w.settled()).save(out); }

void go_back(Owners& w, std::span<const std::byte> state) {
  const FloatSettings settings;
  StateLoader loader(state);
  StateKeeper(w).load(loader);
  PSIM_ASSERT(loader.ok());
}

void Owners::go_back_or_lose(std::span<const std::byte> state) {
  const std::size_t most = std::exchange(memory.most, SIZE_MAX);
  for (int tries = 0; tries < 2; ++tries) {  // what a first one made room for, is there for the second one
    try {
      go_back(*this, state);
      memory.most = most;
      return;
    } catch (const std::bad_alloc&) {
    }
  }
  memory.most = most;
  broken = true;
  population.lose_all();
  sleep.sleepers.list.clear();
  joints.lose_all();
  fluids.clear();
  observers.events.clear();
  observers.queries.forget(QueryIndex::kMoving, QueryIndex::kSleeping, QueryIndex::kFixed);
  ledger.steps = 0;
  throw std::bad_alloc();
}

void World::save(std::vector<std::byte>& out) try {
  const FloatSettings settings;
  psim::save(*impl_, out);
} catch (const std::bad_alloc&) {
  out.clear();
  impl_->recover();
}

bool World::restore(std::span<const std::byte> state, std::string& error) try {
  Owners& w = *impl_;
  const FloatSettings settings;  // as in a step: what is made here is what a step would make
  StateLoader loader(state);
  WorldDesc& read = loader.desc;
  error = loader.error();
  const bool fits = fields(read.bounds) == fields(w.desc.bounds) && read.boundary == w.desc.boundary;
  if (error.empty() && !fits) error = "the saved world has other bounds or another boundary";
  if (error.empty()) error = check(read, w.options);
  if (!error.empty()) return false;
  std::vector<std::byte> before;
  psim::save(w, before);
  or_else([&] { w.go_back_or_lose(before); }, [&] { StateKeeper(w).load(loader); });
  error = loader.error();
  if (!error.empty()) w.go_back_or_lose(before);
  return error.empty();
} catch (const std::bad_alloc&) {
  say_no_room(*impl_, "a state", error);
  return impl_->ran_out(false);
}

std::unique_ptr<World> World::from_state(std::span<const std::byte> state, const RunOptions& options,
                                         std::string& error) try {
  const FloatSettings settings;
  StateLoader loader(state);
  error = loader.error();
  if (!error.empty()) return nullptr;
  auto world = create(loader.desc, options, error);
  if (!world || !world->restore(state, error)) return nullptr;
  return world;
} catch (const std::bad_alloc&) {
  ran_out_of_memory() = true;
  error = "no room";
  return nullptr;
}

}  // namespace psim
