#include "step/step_table.h"

#include <algorithm>

namespace psim {
namespace {

// ---- what a part does

ListSettings list_settings(StepContext& c, const Span& span) {
  return {.desc = &c.desc,
          .least_radius = c.population.least_radius,
          .uneven = c.plan.uneven,
          .restitution = c.plan.restitution,
          .mixed_radii = c.plan.radii,
          .shapes = c.plan.manifolds,
          .link_all = c.plan.fields,
          .governed = c.governor.on(),
          .makes_room = c.detailed || c.governor.on() || span.step > span.frame,
          .step = c.ledger.steps};
}

// Kinematic and joined bodies are the solver's, whether or not the lists name them.
void link_bodies(StepContext& c) {
  if (c.population.kinematics.empty() && c.joints.empty() && !c.plan.restraints) return;
  c.bodies.find_slots();
  const auto link = [&bodies = c.bodies](std::uint32_t id) {
    if (bodies.info[id].place == Place::moving) bodies.linked[bodies.info[id].slot] = 0xFF;
  };
  for (const auto& [id, velocity] : c.population.kinematics) link(id);
  for (const std::uint32_t id : c.joints.bodies()) {
    if (!is_world(id)) link(id);
  }
  for (const Restraint& r : c.population.restraints) link(r.id);
}

// Finds the bodies whose lists must be made anew. False if they are too many.
bool find_renewed(StepContext& c, const Span& span) {
  const auto time = static_cast<float>(kMarginFrames * span.frame);
  return c.neighbours.renewal.find(time, c.contacts.manifolds.turned_parts(time));
}

// A function for each part, which does some of the pieces of that part, in order.
namespace run {

// Finds out whether the lists serve this step, some bodies must be renewed, or all lists must be made anew.
void check(StepContext& c, const Span& span, StepReport&, PieceRange) {
  NeighbourLists& lists = c.neighbours;
  if (c.sleep.sleepers.woke) c.sleep.keep_touches_of_woken(c.sleep_source(), c.contacts.impulses_valid);
  c.bodies.pad_tail();
  c.progress.lists = ListState::kept;
  if (!lists.stale) {
    const auto turning = static_cast<float>(lists.selects() ? span.step : kMarginFrames * span.frame);
    if (lists.mode == ListMode::one_step) {
      lists.stale = true;
    } else if (lists.may_renew() && !c.contacts.solved.compact()) {
      lists.stale = !find_renewed(c, span);
    } else {
      lists.stale =
          !lists.serve(lists.selects() ? span.step : span.frame) || !c.contacts.manifolds.turned_parts(turning).empty();
    }
    lists.stale = lists.stale || !c.contacts.manifolds.parts_serve(turning);
  }
  c.progress.contacts = lists.stale || lists.selects() ? ContactState::due : ContactState::kept;
  if (lists.stale || (!lists.selects() && lists.renewal.any())) return;
  c.ledger.skip(Skip::broad_phase);
  c.ledger.skip(Skip::colouring, !lists.selects());
}

// Makes the lists of those bodies anew that used up their margin; of all, if they are too many.
void renew(StepContext& c, const Span& span, StepReport& report, PieceRange) {
  NeighbourLists& lists = c.neighbours;
  ListRenewal& renewal = lists.renewal;
  lists.stale = !renewal.known() && !find_renewed(c, span);
  const std::uint32_t found = renewal.count();
  if (!lists.stale) {
    c.contacts.discs.lift(lists.table);
    kernels::ReachParams margin = lists.broad.margin();
    margin.time = static_cast<float>(kMarginFrames * ListRenewal::kFrames * span.frame);
    const HeavyLoads* const loads = c.plan.loads ? &c.contacts.loads : nullptr;
    lists.stale = !renewal.look(loads, margin, lists.table) || !put_renewed(c, margin);
  }
  c.progress.contacts = lists.stale ? ContactState::due : ContactState::kept;
  if (!lists.stale) report.renewed = found;
}

void measure(StepContext& c, const Span& span, StepReport&, PieceRange) {
  if (!c.bodies.rim_speed.empty()) c.bodies.keep_rotation(true);
  c.neighbours.measure(list_settings(c, span), span.step);
  c.neighbours.made.span = span.step / span.frame;
  c.progress.lists = ListState::begun;
}

void count(StepContext& c, const Span&, StepReport&, PieceRange) { c.neighbours.broad.count(); }

void move(StepContext& c, const Span&, StepReport&, PieceRange p) {
  if (c.plan.fields && p.begin == 0) make_room_for_remainders(c.bodies);
  if (!c.neighbours.move(p.begin, p.end)) return;
  c.progress.lists = ListState::sorted;  // before anything runs out of memory
  if (!c.neighbours.selects()) c.progress.contacts = ContactState::replaced;
  if (c.plan.fields) move_remainders(c.bodies, c.neighbours.broad.cells().from().data(), c.pool);
  c.neighbours.broad.open(c.neighbours.found());
}

void search(StepContext& c, const Span&, StepReport&, PieceRange p) {
  c.neighbours.broad.search(c.neighbours.found(), p.begin, p.end);
}

void near(StepContext& c, const Span&, StepReport& report, PieceRange p) {
  c.neighbours.broad.find_near(c.neighbours.found(), !c.neighbours.selects(), p.begin, p.end);
  if (p.end == c.neighbours.broad.near().pieces()) report.rebuilt = true;
}

void select(StepContext& c, const Span& span, StepReport&, PieceRange p) {
  c.progress.contacts = ContactState::replaced;
  c.neighbours.made.selected_span = span.step / span.frame;
  c.neighbours.select(list_settings(c, span), span.step, p.begin, p.end);
}

void pack(StepContext& c, const Span&, StepReport&, PieceRange p) { c.neighbours.pack(p.begin, p.end); }

void group(StepContext& c, const Span&, StepReport&, PieceRange) {
  Contacts& contacts = c.contacts;
  NeighbourLists& lists = c.neighbours;
  link_bodies(c);
  if (!contacts.impulses_valid) {
    lists.old_table.body_count = 0;
    lists.old_table.strips.clear();
    if (c.sorts_out()) contacts.manifolds.forget();
  }
  if (c.plan.turns) c.bodies.keep_turns(true);
  const bool copies = lists.selects() && !c.plan.forces && !c.plan.turns && !c.plan.restraints;
  contacts.solved.choose(lists.table, copies, c.plan.restitution);
  if (c.plan.loads) {
    contacts.loads.begin(c.bodies, lists.table, c.pool, !c.sleep.sleepers.empty());
  } else {
    contacts.loads.forget();
  }
}

void loads(StepContext& c, const Span&, StepReport&, PieceRange p) {
  c.contacts.loads.go_on(c.neighbours.table, c.pool, p.begin, p.end);
}

void gather(StepContext& c, const Span& span, StepReport&, PieceRange) {
  const BroadPhase& broad = c.neighbours.broad;
  const auto step = static_cast<float>(c.neighbours.selects() ? span.step : 0);
  c.contacts.manifolds.begin_collect({c.plan.filters, c.walls, broad.margin(), broad.ahead(), c.plan.surfaces,
                                      c.population.traits.wall_special, step, c.desc.gravity},
                                     c.neighbours.table, c.neighbours.stale);
  if (c.joints.empty()) return;
  for (const std::uint32_t id : c.joints.bodies()) {
    const bool moves = !is_world(id) && c.bodies.info[id].place == Place::moving;
    if (moves) c.contacts.manifolds.note_tied(c.bodies.info[id].slot);
  }
}

void sort_out(StepContext& c, const Span&, StepReport&, PieceRange p) {
  const Joined joined = [&c](std::uint32_t a, std::uint32_t b) { return c.joints.joined(a, b); };
  c.contacts.manifolds.sort_out(c.joints.any_exclusions() ? &joined : nullptr, c.neighbours.table, p.begin, p.end);
}

void keep(StepContext& c, const Span&, StepReport&, PieceRange p) {
  c.contacts.manifolds.keep(c.sleep.sleepers.recent, p.begin, p.end);
}

void colour(StepContext& c, const Span&, StepReport&, PieceRange p) {
  Contacts& contacts = c.contacts;
  if (p.begin == 0) {
    const BodyProperties* const alike = c.plan.materials ? nullptr : &c.population.first_properties;
    contacts.discs.begin(c.plan.model, alike, c.neighbours.table);
  }
  contacts.discs.colour(c.neighbours.table, p.begin, p.end);
}

void lay_out(StepContext& c, const Span&, StepReport&, PieceRange p) {
  NeighbourLists& lists = c.neighbours;
  const std::uint32_t* const from = lists.stale ? lists.broad.origin.slots().data() : nullptr;
  c.contacts.discs.lay_out(lists.table, lists.old_table, from, c.sleep.sleepers.recent, p.begin, p.end);
  if (p.end != lists.table.strips.size()) return;
  if (lists.stale) c.dynamics.forces_stale = true;
  lists.stale = false;
}

void look(StepContext& c, const Span& span, StepReport&, PieceRange p) {
  Manifolds& manifolds = c.contacts.manifolds;
  const bool in_place = !c.progress.makes_lists() && !c.neighbours.selects();
  if (p.begin == 0 && c.progress.spread && in_place) manifolds.remember();
  manifolds.refresh(c.manifold_params(span.step), p.begin, p.end);
}

void stand(StepContext& c, const Span& span, StepReport&, PieceRange) {
  Manifolds& manifolds = c.contacts.manifolds;
  manifolds.ties.clear();
  if (!c.joints.empty() && manifolds.footing_is_old()) {
    c.bodies.find_slots();
    const auto end_of = [&](std::uint32_t id) {
      if (is_world(id)) return ManifoldPair::kNone;
      const bool moves = c.bodies.info[id].place == Place::moving && c.bodies.properties(id).inv_mass > 0;
      return moves ? c.bodies.info[id].slot : ManifoldPair::kNone;
    };
    c.joints.each_tie([&](std::uint32_t a, std::uint32_t b) { manifolds.ties.push_back({end_of(a), end_of(b)}); });
  }
  manifolds.find_footing();
  c.contacts.stacks.find(c.manifold_params(span.step));
}

}  // namespace run

// ---- when a part applies
bool always(const StepContext&) { return true; }
bool lists_renewed(const StepContext& c) {
  return !c.neighbours.stale && !c.neighbours.selects() && c.neighbours.renewal.any();
}
bool lists_made(const StepContext& c) { return c.neighbours.stale; }
bool pairs_selected(const StepContext& c) { return c.neighbours.selects(); }
bool laid_out(const StepContext& c) { return c.neighbours.stale || c.neighbours.selects(); }
bool loads_found(const StepContext& c) { return laid_out(c) && c.plan.loads; }
bool sorted_out(const StepContext& c) { return laid_out(c) && c.sorts_out(); }
bool shapes_move(const StepContext& c) { return c.plan.manifolds; }

// ---- how many pieces a part has
std::size_t one(const StepContext&) { return 1; }
std::size_t moves(const StepContext& c) { return c.neighbours.broad.cells().moves(); }
std::size_t searches(const StepContext& c) { return c.neighbours.broad.pairs().searches(); }
std::size_t nears(const StepContext& c) { return c.neighbours.broad.near().pieces(); }
std::size_t found_strips(const StepContext& c) { return c.neighbours.found().strips.size(); }
std::size_t strips(const StepContext& c) { return c.neighbours.table.strips.size(); }
std::size_t load_pieces(const StepContext& c) { return c.contacts.loads.pieces(); }
std::size_t looks(const StepContext& c) { return c.contacts.manifolds.look_pieces(); }

using namespace cost;

// ---- what a part costs: piece_* is one piece, whole_* all of it where only counts are known
double pairs(const Strip& s) { return n(s.pair_end - s.pair_begin); }
double strip_pairs(const StepContext& c, std::size_t strip) { return pairs(c.neighbours.table.strips[strip]); }

// Manifolds of the large bodies' strip. Where large bodies consist of several hulls a pair has several manifolds.
double large_manifolds(const StepContext& c, std::size_t strip) {
  const Manifolds& m = c.contacts.manifolds;
  if (strip + 1 != c.neighbours.table.strips.size() || m.strip_count() == 0) return 0;
  return n(m.count_of(m.strip_count() - 1));
}

// The share of contacts that press, where bodies of several sizes bounce; else 0.
double crowded(const WorkCounts& w) {
  return w.has.mixed && w.sweeps > 0 ? std::min(n(w.touching) / std::max(n(w.contacts), 1.0), 1.0) : 0;
}

// ns of a candidate, of a contact of discs that is laid out, and of finding how fast bodies move in their strips.
double select_ns(const UnitCosts& ns, const WorkCounts& w) { return ns.select * (1 + kMixedSelect * crowded(w)); }
double lay_out_ns(const UnitCosts& ns, const WorkCounts& w) {
  return (w.has.rough || w.sweeps > 0 ? ns.lay_out_rough : ns.lay_out) * (1 + kMixedPressing * crowded(w)) *
         (w.has.loads ? kLoads : 1);
}
double speeds_ns(const UnitCosts& ns, const WorkCounts& w) {
  return kSpeeds * ns.sort * n(w.bodies) + (w.has.uneven ? kSegmentSpeeds * ns.select * n(w.lists.candidates) : 0);
}

double check_bodies(const UnitCosts& ns, const StepContext& c) {
  return (c.neighbours.broad.common().on() ? kCommonCheck : 1) * ns.check * n(c.bodies.count);
}
double piece_check(const UnitCosts& ns, const StepContext& c, const WorkCounts& w, std::size_t) {
  return check_bodies(ns, c) + (c.sleep.sleepers.woke ? ns.sleep * n(w.contacts + 6 * w.manifolds.pairs) : 0);
}
double whole_check(const UnitCosts& ns, const WorkCounts& w) { return ns.check * n(w.bodies); }

double piece_renew(const UnitCosts& ns, const StepContext& c, const WorkCounts& w, std::size_t) {
  return 2 * ns.search * n(c.neighbours.renewal.count()) + check_bodies(ns, c) +
         (c.sorts_out() ? kGather * ns.group * n(w.manifolds.pairs) : 0);
}

double piece_measure(const UnitCosts& ns, const StepContext& c, const WorkCounts&, std::size_t) {
  return kMeasure * ns.sort * n(c.bodies.count);
}
double whole_measure(const UnitCosts& ns, const WorkCounts& w) { return kMeasure * ns.sort * n(w.bodies); }

double piece_count(const UnitCosts& ns, const StepContext& c, const WorkCounts&, std::size_t) {
  const double share = c.neighbours.broad.cells().listed() ? kListedCount : c.plan.radii ? kMixedCount : kCount;
  return share * ns.sort * n(c.bodies.count) + ns.cell * n(c.neighbours.broad.cells().cell_count());
}
double whole_count(const UnitCosts& ns, const WorkCounts& w) {
  return kCount * ns.sort * n(w.bodies) + ns.cell * n(w.lists.cells);
}

double piece_move(const UnitCosts& ns, const StepContext& c, const WorkCounts&, std::size_t) {
  return (c.plan.radii ? kMixedMove : kMove) * ns.sort * n(c.bodies.count) / n(c.neighbours.broad.cells().moves());
}
double whole_move(const UnitCosts& ns, const WorkCounts& w) { return kMove * ns.sort * n(w.bodies); }

double piece_search(const UnitCosts& ns, const StepContext& c, const WorkCounts& w, std::size_t piece) {
  const BroadPhase& broad = c.neighbours.broad;
  const PairSearch::Work s = broad.pairs().work_of(piece, c.neighbours.found());
  const double each = s.large ? 2 * ns.strip + (ns.pair + 12 * ns.test) * s.pairs + 1.75 * ns.test * s.others
                              : ns.search + ns.test * broad.cells().tests() + ns.pair * s.pairs;
  const double longer = broad.cells().listed() ? 1 + kListedCrowd * crowded(w) : 1;
  return longer * each * s.bodies + ns.strip;
}
double whole_search(const UnitCosts& ns, const WorkCounts& w) {
  const double found = n(w.lists.candidates != 0 ? w.lists.candidates : w.contacts + w.manifolds.pairs);
  return ns.search * n(w.bodies) + ns.pair * found + ns.test * w.lists.tests + ns.strip * n(w.lists.strips);
}

double piece_near(const UnitCosts& ns, const StepContext& c, const WorkCounts& w, std::size_t piece) {
  const NearSearch::Piece& near = c.neighbours.broad.near().piece(piece);
  const double each =
      w.has.fixed ? ns.near_fixed + ns.near_shape * c.neighbours.broad.near().expected(near.strip) : ns.near;
  return each * n(near.end - near.begin) + ns.strip;
}
double whole_near(const UnitCosts& ns, const WorkCounts& w) {
  return (w.has.fixed ? ns.near_fixed : ns.near) * n(w.bodies) + (w.has.fixed ? ns.near_shape * n(w.lists.near) : 0) +
         ns.strip * n(w.lists.strips);
}

double piece_select(const UnitCosts& ns, const StepContext& c, const WorkCounts& w, std::size_t piece) {
  return (piece == 0 ? speeds_ns(ns, w) : 0) + select_ns(ns, w) * pairs(c.neighbours.candidates.strips[piece]) +
         ns.strip;
}
double whole_select(const UnitCosts& ns, const WorkCounts& w) {
  return w.lists.candidates == 0 ? 0 : speeds_ns(ns, w) + select_ns(ns, w) * n(w.lists.candidates);
}

double piece_pack(const UnitCosts& ns, const StepContext& c, const WorkCounts&, std::size_t piece) {
  const Strip& s = c.neighbours.found().strips[piece];
  return ns.pack * (strip_pairs(c, piece) + 0.3 * n(s.body_end - s.body_begin)) + ns.strip;
}
double whole_pack(const UnitCosts& ns, const WorkCounts& w) {
  return w.lists.candidates == 0 ? 0 : ns.pack * (n(w.contacts) + n(w.bodies));
}

double piece_group(const UnitCosts& ns, const StepContext& c, const WorkCounts&, std::size_t) {
  return (c.plan.loads ? ns.load * n(c.bodies.count) : 0) + (c.neighbours.selects() ? ns.pack * n(c.bodies.count) : 0);
}

double piece_loads(const UnitCosts& ns, const StepContext& c, const WorkCounts&, std::size_t piece) {
  return 0.6 * ns.load * n(c.contacts.loads.pairs_in(c.neighbours.table, piece)) + ns.strip;
}
double whole_loads(const UnitCosts& ns, const WorkCounts& w) {
  return (w.has.loads ? ns.load * w.lists.visits : 0) * n(w.contacts);
}

template <const double& kShare>
double whole_group(const UnitCosts& ns, const WorkCounts& w) {
  return kShare * ns.group * n(w.manifolds.pairs);
}

double piece_sort_out(const UnitCosts& ns, const StepContext& c, const WorkCounts& w, std::size_t piece) {
  const double shaped = n(w.manifolds.pairs) / std::max(n(w.manifolds.pairs + w.contacts), 1.0);  // of the pairs, about
  return kSortOut * ns.group * std::max(shaped * strip_pairs(c, piece), large_manifolds(c, piece)) + ns.strip;
}

double piece_keep(const UnitCosts& ns, const StepContext& c, const WorkCounts&, std::size_t piece) {
  return kKeep * ns.group * n(c.contacts.manifolds.count_of(piece));
}

// Pieces are strips in the order of phases, not of the table; one strip costs about as much as another.
double piece_colour(const UnitCosts& ns, const StepContext& c, const WorkCounts&, std::size_t piece) {
  return ns.colour * strip_pairs(c, piece) + ns.strip;
}
double whole_colour(const UnitCosts& ns, const WorkCounts& w) {
  return ns.colour * n(w.contacts) + ns.strip * n(w.lists.strips);
}

double piece_lay_out(const UnitCosts& ns, const StepContext& c, const WorkCounts& w, std::size_t piece) {
  const double contacts = strip_pairs(c, piece) + n(c.neighbours.table.static_contacts[piece].size());
  return lay_out_ns(ns, w) * contacts + 3 * ns.strip;
}
double whole_lay_out(const UnitCosts& ns, const WorkCounts& w) {
  return lay_out_ns(ns, w) * n(w.contacts) + kLayOutStrips * ns.strip * n(w.lists.strips);
}

double whole_look(const UnitCosts& ns, const WorkCounts& w) {
  const std::uint64_t anew = std::min(w.manifolds.looks, w.manifolds.pairs);
  return (w.has.long_lists ? kLongLooks : 1.0) * (ns.look * n(anew) + ns.keep * n(w.manifolds.pairs - anew));
}
double piece_look(const UnitCosts& ns, const StepContext& c, const WorkCounts& w, std::size_t piece) {
  if (w.manifolds.pairs == 0) return 0;
  return whole_look(ns, w) / n(w.manifolds.pairs) * n(c.contacts.manifolds.pairs_in(piece));
}

double whole_stand(const UnitCosts& ns, const WorkCounts& w) { return ns.stand * n(w.manifolds.pairs); }
double nothing(const UnitCosts&, const WorkCounts&) { return 0; }

constexpr Stage kLists = Stage::broad_phase, kPairs = Stage::narrow_phase, kColours = Stage::colouring;

// clang-format off
constexpr StepPart kParts[] = {
    {"check", kLists, "do the lists serve?", "one",
     always, one, run::check, piece_check, whole_check},
    {"renew", kLists, "persistent lists: those of bodies that used up their margin", "one",
     lists_renewed, one, run::renew, piece_renew, nothing},
    {"measure", kLists, "how new lists are made, how far bodies reach", "one",
     lists_made, one, run::measure, piece_measure, whole_measure},
    {"count", kLists, "the cells of bodies", "one",
     lists_made, one, run::count, piece_count, whole_count},
    {"move", kLists, "bodies in cell order", "4,096 bodies",
     lists_made, moves, run::move, piece_move, whole_move},
    {"search", kLists, "pairs of bodies that may meet while the lists last", "a strip, or 16 large bodies",
     lists_made, searches, run::search, piece_search, whole_search},
    {"near", kLists, "bodies near fixed shapes; which bodies take substeps", "a strip, or 32 bodies",
     lists_made, nears, run::near, piece_near, whole_near},
    {"select", kPairs, "lists with a selection: pairs that can meet in this step", "a strip",
     pairs_selected, found_strips, run::select, piece_select, whole_select},
    {"pack", kPairs, "closes up what was selected", "a strip",
     pairs_selected, found_strips, run::pack, piece_pack, whole_pack},
    {"group", kColours, "which bodies the solver has", "one",
     laid_out, one, run::group, piece_group, nothing},
    {"loads", kColours, "bodies under much heavier ones, where the plan asks", "a strip, for each pass",
     loads_found, load_pieces, run::loads, piece_loads, whole_loads},
    {"gather", kColours, "shapes, filters, joints: what is known of the manifolds of before", "one",
     sorted_out, one, run::gather, nullptr, whole_group<kGather>},
    {"sort_out", kColours, "takes manifolds, and pairs that must not collide, out of the lists of discs", "a strip",
     sorted_out, strips, run::sort_out, piece_sort_out, whole_group<kSortOut>},
    {"keep", kColours, "gives manifolds what is known of them", "a strip",
     sorted_out, strips, run::keep, piece_keep, whole_group<kKeep>},
    {"colour", kColours, "colours of contacts of discs", "a strip",
     laid_out, strips, run::colour, piece_colour, whole_colour},
    {"lay_out", kColours, "blocks of 8 lanes that share no body, with the impulses of before", "a strip",
     laid_out, strips, run::lay_out, piece_lay_out, whole_lay_out},
    {"look", kPairs, "shapes: who touches, where, how far apart", "some pairs of a strip",
     shapes_move, looks, run::look, piece_look, whole_look, true},
    {"stand", kPairs, "shapes: which bodies stand on each other one by one", "one",
     shapes_move, one, run::stand, nullptr, whole_stand, true},
};
// clang-format on

}  // namespace

std::span<const StepPart> step_parts() { return kParts; }

std::uint8_t part_named(std::string_view name) {
  const auto* const found =
      std::find_if(std::begin(kParts), std::end(kParts), [&](const StepPart& p) { return p.name == name; });
  return static_cast<std::uint8_t>(found - std::begin(kParts));
}

std::uint8_t next_part(const StepContext& c, std::uint8_t row) {
  while (row < std::size(kParts) && !kParts[row].applies(c)) ++row;
  return row;
}

double ahead_ns(const UnitCosts& ns, const WorkCounts& work, bool in_place) {
  double sum = 0;
  for (const StepPart& part : kParts) {
    if (part.in_place || !in_place) sum += part.whole_ns(ns, work);
  }
  return sum;
}

}  // namespace psim
