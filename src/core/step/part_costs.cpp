#include "step/part_costs.h"

#include <algorithm>

#include "step/forecast.h"

namespace psim::part_costs {
namespace {

// Shares of UnitCosts::sort that the parts of sorting bodies take; more where radii differ or cells are listed.
constexpr double kMeasure = 0.2, kCount = 0.3, kMove = 0.5;
constexpr double kMixedCount = 0.6, kListedCount = 2, kMixedMove = 1;
// Shares of UnitCosts::group that the parts of taking manifolds out of the lists take.
constexpr double kGather = 0.25, kSortOut = 0.35, kKeep = 0.4;
// Bodies of several sizes that press each other are searched for longer in cells that are listed.
constexpr double kListedCrowd = 3.2;
// Strips that the parts go through, all in all, on UnitCosts::strip.
constexpr double kSearchStrips = 1, kNearStrips = 1, kColourStrips = 1, kLayOutStrips = 2;

double pairs(const Strip& s) { return n(s.pair_end - s.pair_begin); }
double strip_pairs(const StepContext& c, std::size_t strip) { return pairs(c.neighbours.table.strips[strip]); }

// Manifolds of the large bodies' strip. Where large bodies consist of several hulls a pair has several manifolds.
double large_manifolds(const StepContext& c, std::size_t strip) {
  const Manifolds& m = c.contacts.manifolds;
  if (strip + 1 != c.neighbours.table.strips.size() || m.strip_count() == 0) return 0;
  return n(m.count_of(m.strip_count() - 1));
}

}  // namespace

double piece_check(const StepContext& c, const WorkCounts& w, std::size_t) {
  const UnitCosts& ns = c.governor.costs();
  return ns.check * n(c.bodies.count) + (c.sleepers.woke ? ns.sleep * n(w.contacts + 6 * w.manifolds.pairs) : 0);
}
double whole_check(const UnitCosts& ns, const WorkCounts& w) { return ns.check * n(w.bodies); }

double piece_renew(const StepContext& c, const WorkCounts& w, std::size_t) {
  const UnitCosts& ns = c.governor.costs();
  return 2 * ns.search * n(c.neighbours.renewal.count()) + ns.check * n(c.bodies.count) +
         (c.sorts_out() ? kGather * ns.group * n(w.manifolds.pairs) : 0);
}

double piece_measure(const StepContext& c, const WorkCounts&, std::size_t) {
  return kMeasure * c.governor.costs().sort * n(c.bodies.count);
}
double whole_measure(const UnitCosts& ns, const WorkCounts& w) { return kMeasure * ns.sort * n(w.bodies); }

double piece_count(const StepContext& c, const WorkCounts&, std::size_t) {
  const UnitCosts& ns = c.governor.costs();
  const double share = c.neighbours.broad.listed() ? kListedCount : c.plan.radii ? kMixedCount : kCount;
  return share * ns.sort * n(c.bodies.count) + ns.cell * n(c.neighbours.broad.cell_count());
}
double whole_count(const UnitCosts& ns, const WorkCounts& w) {
  return kCount * ns.sort * n(w.bodies) + ns.cell * n(w.lists.cells);
}

double piece_move(const StepContext& c, const WorkCounts&, std::size_t) {
  return (c.plan.radii ? kMixedMove : kMove) * c.governor.costs().sort * n(c.bodies.count) /
         n(c.neighbours.broad.moves());
}
double whole_move(const UnitCosts& ns, const WorkCounts& w) { return kMove * ns.sort * n(w.bodies); }

double piece_search(const StepContext& c, const WorkCounts& w, std::size_t piece) {
  const UnitCosts& ns = c.governor.costs();
  const BroadPhase& broad = c.neighbours.broad;
  const BroadPhase::Search s = broad.search_at(piece, c.neighbours.found());
  const double each = s.large ? 2 * ns.strip + (ns.pair + 12 * ns.test) * s.pairs + 1.75 * ns.test * s.others
                              : ns.search + ns.test * broad.tests() + ns.pair * s.pairs;
  const double longer = broad.listed() ? 1 + kListedCrowd * crowded(w) : 1;
  return longer * each * s.bodies + ns.strip;
}
double whole_search(const UnitCosts& ns, const WorkCounts& w) {
  const double found = n(w.lists.candidates != 0 ? w.lists.candidates : w.contacts + w.manifolds.pairs);
  return ns.search * n(w.bodies) + ns.pair * found + ns.test * w.lists.tests +
         kSearchStrips * ns.strip * n(w.lists.strips);
}

double piece_near(const StepContext& c, const WorkCounts& w, std::size_t piece) {
  const UnitCosts& ns = c.governor.costs();
  const BroadPhase::Near& near = c.neighbours.broad.near_at(piece);
  const double each =
      w.has.fixed ? ns.near_fixed + ns.near_shape * c.neighbours.broad.expected_near(near.strip) : ns.near;
  return each * n(near.end - near.begin) + ns.strip;
}
double whole_near(const UnitCosts& ns, const WorkCounts& w) {
  return (w.has.fixed ? ns.near_fixed : ns.near) * n(w.bodies) + (w.has.fixed ? ns.near_shape * n(w.lists.near) : 0) +
         kNearStrips * ns.strip * n(w.lists.strips);
}

double piece_select(const StepContext& c, const WorkCounts& w, std::size_t piece) {
  const UnitCosts& ns = c.governor.costs();
  return (piece == 0 ? speeds_ns(ns, w) : 0) + select_ns(ns, w) * pairs(c.neighbours.candidates.strips[piece]) +
         ns.strip;
}
double whole_select(const UnitCosts& ns, const WorkCounts& w) {
  return w.lists.candidates == 0 ? 0 : speeds_ns(ns, w) + select_ns(ns, w) * n(w.lists.candidates);
}

double piece_pack(const StepContext& c, const WorkCounts&, std::size_t piece) {
  const UnitCosts& ns = c.governor.costs();
  const Strip& s = c.neighbours.found().strips[piece];
  return ns.pack * (strip_pairs(c, piece) + 0.3 * n(s.body_end - s.body_begin)) + ns.strip;
}
double whole_pack(const UnitCosts& ns, const WorkCounts& w) {
  return w.lists.candidates == 0 ? 0 : ns.pack * (n(w.contacts) + n(w.bodies));
}

double piece_group(const StepContext& c, const WorkCounts&, std::size_t) {
  const UnitCosts& ns = c.governor.costs();
  return (c.plan.loads ? ns.load * n(c.bodies.count) : 0) + (c.neighbours.selects() ? ns.pack * n(c.bodies.count) : 0);
}

double piece_loads(const StepContext& c, const WorkCounts&, std::size_t piece) {
  const UnitCosts& ns = c.governor.costs();
  return 0.6 * ns.load * n(c.contacts.loads.pairs_in(c.neighbours.table, piece)) + ns.strip;
}
double whole_loads(const UnitCosts& ns, const WorkCounts& w) {
  return (w.has.loads ? ns.load * w.lists.visits : 0) * n(w.contacts);
}

double piece_gather(const StepContext& c, const WorkCounts& w, std::size_t) {
  return whole_gather(c.governor.costs(), w);
}
double whole_gather(const UnitCosts& ns, const WorkCounts& w) { return kGather * ns.group * n(w.manifolds.pairs); }

double piece_sort_out(const StepContext& c, const WorkCounts& w, std::size_t piece) {
  const UnitCosts& ns = c.governor.costs();
  const double shaped = n(w.manifolds.pairs) / std::max(n(w.manifolds.pairs + w.contacts), 1.0);  // of the pairs, about
  return kSortOut * ns.group * std::max(shaped * strip_pairs(c, piece), large_manifolds(c, piece)) + ns.strip;
}
double whole_sort_out(const UnitCosts& ns, const WorkCounts& w) { return kSortOut * ns.group * n(w.manifolds.pairs); }

double piece_keep(const StepContext& c, const WorkCounts&, std::size_t piece) {
  return kKeep * c.governor.costs().group * n(c.contacts.manifolds.count_of(piece));
}
double whole_keep(const UnitCosts& ns, const WorkCounts& w) { return kKeep * ns.group * n(w.manifolds.pairs); }

// Pieces are strips in the order of phases, not of the table; one strip costs about as much as another.
double piece_colour(const StepContext& c, const WorkCounts&, std::size_t piece) {
  const UnitCosts& ns = c.governor.costs();
  return ns.colour * strip_pairs(c, piece) + ns.strip;
}
double whole_colour(const UnitCosts& ns, const WorkCounts& w) {
  return ns.colour * n(w.contacts) + kColourStrips * ns.strip * n(w.lists.strips);
}

double piece_lay_out(const StepContext& c, const WorkCounts& w, std::size_t piece) {
  const UnitCosts& ns = c.governor.costs();
  const double contacts = strip_pairs(c, piece) + n(c.neighbours.table.static_contacts[piece].size());
  return lay_out_ns(ns, w) * contacts + 3 * ns.strip;
}
double whole_lay_out(const UnitCosts& ns, const WorkCounts& w) {
  return lay_out_ns(ns, w) * n(w.contacts) + kLayOutStrips * ns.strip * n(w.lists.strips);
}

double piece_look(const StepContext& c, const WorkCounts& w, std::size_t piece) {
  if (w.manifolds.pairs == 0) return 0;
  return look_ns(c.governor.costs(), w) / n(w.manifolds.pairs) * n(c.contacts.manifolds.pairs_in(piece));
}

double piece_stand(const StepContext& c, const WorkCounts& w, std::size_t) {
  return whole_stand(c.governor.costs(), w);
}
double whole_stand(const UnitCosts& ns, const WorkCounts& w) { return ns.stand * n(w.manifolds.pairs); }

}  // namespace psim::part_costs
