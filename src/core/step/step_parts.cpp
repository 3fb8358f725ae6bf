#include "step/step_parts.h"

#include "bodies/body_store.h"
#include "step/step_work.h"

namespace psim {
namespace {

// Frames of its motion that a renewed body has room for: few bodies are renewed, so that much room costs little, and
// they are renewed seldom.
constexpr double kRenewedFrames = 2.5;

Joined joined_in(const JointStore& joints) {
  return [&joints](std::uint32_t a, std::uint32_t b) { return joints.joined(a, b); };
}

ListSettings list_settings(const StepContext& c, const Span& span) {
  ListSettings s;
  s.desc = &c.desc;
  s.broad = &c.neighbours.broad;
  s.least_radius = c.population.least_radius;
  s.uneven = c.plan.uneven;
  s.restitution = c.plan.restitution;
  s.mixed_radii = c.plan.radii;
  s.link_all = c.plan.fields;
  s.governed = c.governor.on();
  s.makes_room = c.detailed || c.governor.on() || span.step > span.frame;
  s.selected = c.neighbours.selects();
  s.frames = c.neighbours.made.frames;
  return s;
}

bool find_renewed(const StepContext& c, float seconds) { return c.neighbours.renewal.find(seconds); }

// Kinematic and joined bodies are the solver's, whether or not the lists name them.
void link_bodies(const StepContext& c) {
  if (!c.population.kinematics.empty()) {
    c.bodies.find_slots();
    for (const auto& [id, velocity] : c.population.kinematics) c.bodies.linked[c.bodies.info[id].slot] = 0xFF;
  }
  if (!c.joints.empty()) {
    c.bodies.find_slots();
    for (const std::uint32_t id : c.joints.bodies()) {
      if (c.bodies.info[id].place == Place::moving) c.bodies.linked[c.bodies.info[id].slot] = 0xFF;
    }
  }
}

}  // namespace

bool put_renewed(const StepContext& c) {
  ListRenewal& renewal = c.neighbours.renewal;
  Manifolds& manifolds = c.contacts.manifolds;
  if (c.sorts_out()) {
    const Joined joined = joined_in(c.joints);
    manifolds.sort_out_renewed(c.bodies, c.statics, c.joints.any_exclusions() ? &joined : nullptr, renewal.pairs(),
                               renewal.near(), c.pool);
  }
  if (!renewal.put(c.neighbours.table)) return false;
  if (c.sorts_out()) manifolds.put_renewed([&renewal](std::uint32_t slot) { return renewal.found(slot); });
  renewal.finish();
  c.contacts.discs.renew(renewal.statics_changed(), c.neighbours.table);
  return true;
}

namespace step_parts_run {

// Finds out whether there must be new lists.
void check(const StepContext& c, const Span& span, StepReport&, PieceRange) {
  NeighbourLists& lists = c.neighbours;
  c.keep_touches_of_woken();
  c.bodies.pad_tail();
  c.progress.lists = ListState::kept;
  if (!lists.stale) {
    if (lists.mode == ListMode::one_step) {
      lists.stale = true;
    } else if (lists.may_renew() && !c.contacts.solved.compact()) {
      lists.stale = !find_renewed(c, static_cast<float>(kMarginFrames * span.frame));
    } else {
      lists.stale = !lists.serve(lists.selects() ? span.step : span.frame);
    }
  }
  c.progress.contacts = lists.stale || lists.selects() ? ContactState::due : ContactState::kept;
  if (lists.stale || (!lists.selects() && lists.renewal.any())) return;
  c.ledger.skip(Skip::broad_phase);
  c.ledger.skip_if(!lists.selects(), Skip::colouring);
}

// Makes the lists of those bodies anew that used up their margin; of all, if they are too many.
void renew(const StepContext& c, const Span& span, StepReport& report, PieceRange) {
  NeighbourLists& lists = c.neighbours;
  ListRenewal& renewal = lists.renewal;
  if (!renewal.known()) lists.stale = !find_renewed(c, renewal.time());
  const std::uint32_t found = renewal.count();
  if (!lists.stale) {
    c.contacts.discs.lift(lists.table);
    kernels::ReachParams margin = lists.broad.margin();
    margin.time = static_cast<float>(kMarginFrames * kRenewedFrames * span.frame);
    const HeavyLoads* const loads = c.plan.loads ? &c.contacts.loads : nullptr;
    lists.stale = !renewal.look(loads, margin, lists.table) || !put_renewed(c);
  }
  c.progress.contacts = lists.stale ? ContactState::due : ContactState::kept;
  if (!lists.stale) report.renewed = found;
}

void measure(const StepContext& c, const Span& span, StepReport&, PieceRange) {
  if (!c.bodies.rim_speed.empty()) c.bodies.add_rotation();
  c.neighbours.measure(list_settings(c, span), span.step);
  c.neighbours.made.span = span.step / span.frame;
  c.progress.lists = ListState::begun;
}

void count(const StepContext& c, const Span&, StepReport&, PieceRange) { c.neighbours.broad.count(); }

void move(const StepContext& c, const Span&, StepReport&, PieceRange p) {
  if (!c.neighbours.move(p.begin, p.end)) return;
  if (c.plan.fields) move_remainders(c.bodies, c.neighbours.broad.from(), c.pool);
  c.progress.lists = ListState::sorted;
  if (!c.neighbours.selects()) c.progress.contacts = ContactState::replaced;
}

void search(const StepContext& c, const Span&, StepReport&, PieceRange p) {
  c.neighbours.broad.search(c.neighbours.found(), p.begin, p.end);
}

void near(const StepContext& c, const Span&, StepReport& report, PieceRange p) {
  c.neighbours.broad.find_near(c.neighbours.found(), p.begin, p.end);
  if (p.end == c.neighbours.broad.nears()) report.rebuilt = true;
}

void select(const StepContext& c, const Span& span, StepReport&, PieceRange p) {
  c.progress.contacts = ContactState::replaced;
  c.neighbours.made.selected_span = span.step / span.frame;
  c.neighbours.select(list_settings(c, span), span.step, p.begin, p.end);
}

void pack(const StepContext& c, const Span&, StepReport&, PieceRange p) {
  c.neighbours.broad.pack(c.neighbours.candidates, c.neighbours.table, p.begin, p.end);
}

void group(const StepContext& c, const Span&, StepReport&, PieceRange) {
  Contacts& contacts = c.contacts;
  NeighbourLists& lists = c.neighbours;
  link_bodies(c);
  if (!contacts.impulses_valid) {
    lists.old_table.body_count = 0;
    lists.old_table.strips.clear();
    if (c.sorts_out()) contacts.manifolds.forget();
  }
  if (c.plan.turns) c.bodies.keep_turns(true);
  const bool copies = lists.selects() && !c.plan.forces && !c.plan.turns;
  contacts.solved.choose(lists.table, copies, c.plan.restitution);
  if (c.plan.loads) {
    contacts.loads.begin(c.bodies, lists.table, c.pool);
  } else {
    contacts.loads.forget();
  }
}

void loads(const StepContext& c, const Span&, StepReport&, PieceRange p) {
  c.contacts.loads.go_on(c.neighbours.table, c.pool, p.begin, p.end);
}

void gather(const StepContext& c, const Span&, StepReport&, PieceRange) {
  c.contacts.manifolds.begin_collect(c.bodies, c.plan.filters, c.neighbours.table, c.neighbours.stale, c.pool);
}

void sort_out(const StepContext& c, const Span&, StepReport&, PieceRange p) {
  const Joined joined = joined_in(c.joints);
  c.contacts.manifolds.sort_out(c.bodies, c.statics, c.joints.any_exclusions() ? &joined : nullptr, c.neighbours.table,
                                p.begin, p.end, c.pool);
}

void keep(const StepContext& c, const Span&, StepReport&, PieceRange p) {
  c.contacts.manifolds.keep(c.bodies, c.statics, c.sleepers.recent, p.begin, p.end, c.pool);
}

void colour(const StepContext& c, const Span&, StepReport&, PieceRange p) {
  Contacts& contacts = c.contacts;
  if (p.begin == 0) {
    const BodyProperties* const alike = c.plan.materials ? nullptr : &c.population.first_properties;
    contacts.discs.begin(c.plan.model, alike, c.neighbours.table);
  }
  contacts.discs.colour(c.neighbours.table, p.begin, p.end);
}

void lay_out(const StepContext& c, const Span&, StepReport&, PieceRange p) {
  NeighbourLists& lists = c.neighbours;
  const std::uint32_t* const from = lists.stale ? lists.broad.origin() : nullptr;
  c.contacts.discs.lay_out(lists.table, lists.old_table, from, c.sleepers.recent, p.begin, p.end);
  if (p.end != lists.table.strips.size()) return;
  if (lists.stale) c.dynamics.forces_stale = true;
  lists.stale = false;
}

void look(const StepContext& c, const Span& span, StepReport&, PieceRange p) {
  Manifolds& manifolds = c.contacts.manifolds;
  const bool in_place = !c.progress.makes_lists() && !c.neighbours.selects();
  if (p.begin == 0 && c.progress.spread && in_place) manifolds.remember(c.pool);
  manifolds.refresh(c.bodies, c.manifold_params(span.step), p.begin, p.end, c.pool);
}

void stand(const StepContext& c, const Span& span, StepReport&, PieceRange) {
  c.contacts.stacks.find(c.bodies, c.contacts.manifolds, c.manifold_params(span.step), c.neighbours.table, c.pool);
}

}  // namespace step_parts_run
}  // namespace psim
