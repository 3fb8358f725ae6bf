// The work of a step before its substeps, in parts of many pieces each, which a governor can spread over frames
// (docs/governor.md):
//
//   check    do the lists serve?                                 one piece
//   renew    lists that last: bodies that used up their margin     one piece
//   measure  how the lists are made, how far bodies reach        one piece
//   count    the cells of bodies                                 one piece
//   move     bodies in cell order                                a piece 4,096 bodies
//   search   candidate pairs                                     a piece a strip or 16 large bodies
//   near     bodies near fixed shapes; who is linked             a piece a strip or 32 bodies
//   select   loose scenes: who may meet in this step             a piece a strip, and so on
//   pack     closes up what was selected
//   group    which bodies the solver has                         one piece
//   loads    who carries much heavier bodies                     a piece a strip for each pass over them
//   gather   what is known of the manifolds that there were      one piece
//   sort_out manifolds, and pairs that must not collide, leave the lists of discs
//   keep     what is known of manifolds that were there before
//   colour   contacts of discs: colours
//   lay_out  and lanes, with the impulses of before
//   look     manifolds: where they touch
//   stand    columns                                             one piece
//
// A part that the scene does not need is left out. However many pieces are done at a time, the lists come out the
// same. If the host changes bodies in between, what was made is thrown away and the contacts' impulses stay with the
// table that they were laid out by (spoil_lists).
#include <algorithm>

#include "stage_timer.h"
#include "world_impl.h"

namespace psim {
namespace {

// Frames of its motion that a renewed body has room for: few want many partners, many want it seldom.
constexpr double kRenewedFrames = 2.5;

}  // namespace

// What was made for this step is thrown away: all is as the last one left it, but bodies may lie in another order,
// which the broad phase knows.
void World::Impl::spoil_lists() {
  turn_back();
  contacts.give_up();
  manifolds.accept();
  if (ahead.sorted) broad.keep_origin();
  lists_stale = true;
  if (ahead.waits != 0 && (ahead.part != Part::check || ahead.at != 0)) ++ahead.spoiled;
  saved.done.clear();
  ahead.part = Part::check;
  ahead.at = 0;
  ahead.sorted = ahead.swapped = ahead.built = false;
}

// To the contacts of the last step, and back to those of this one, as far as there are any.
void World::Impl::turn_back() {
  contacts.turn_back();
  manifolds.turn_back();
  if (ahead.swapped) table.swap(old_table);
}

// The contacts of this step count from now on: those of the last one go.
void World::Impl::accept_work() {
  contacts.accept();
  manifolds.accept();
  if (ahead.laid) {
    if (!sleepers.recent.empty()) {
      sleepers.recent.clear();
      if (!plan.sleep) sleepers.recent = TouchMemory();
    }
    impulses_valid = true;
    saved.bare = false;
  }
  if (ahead.built) {
    broad.forget_origin();
    broad.finish(bodies, kernels, pool);
  }
  saved.done.clear();
  ahead.part = Part::check;
  ahead.at = 0;
  ahead.sorted = ahead.swapped = ahead.built = ahead.laid = false;
}

// A body's velocity was changed by the host: lists and manifolds that were made for this step do not serve it
// if it is much faster now.
void World::Impl::pushed(std::uint32_t id, const Motion& before) {
  if (ahead.part == Part::check) return;
  renewal.doubt();
  if (ahead.built && !ahead.sorted) return spoil_lists();  // it may be copied already
  const std::uint32_t slot = bodies.info[id].slot;
  const double gain = static_cast<double>(speed_of(slot) - before.fastest());
  const double way = kMarginFrames * desc.dt * std::max<int>(ahead.horizon, ahead.waits + 1) * gain;
  if (!(way <= 0.02 * static_cast<double>(bodies.radius[slot]))) return spoil_lists();
  Saved::Done push;
  push.id = id;
  push.vx = before.vx;
  push.vy = before.vy;
  push.spin = before.spin;
  saved.done.push_back(push);
}

// A frame's work on a step that waits ends here.
void World::Impl::note_work(const Span& span) {
  if (ahead.part == Part::check) return;
  if (saved.done.empty() || saved.done.back().span != span.step) {
    saved.done.emplace_back();
    saved.done.back().span = span.step;
  }
  saved.done.back().part = static_cast<std::uint32_t>(ahead.part);
  saved.done.back().at = ahead.at;
}

// Whether the table, the contacts and the bodies' slots belong together.
bool World::Impl::contacts_stand() const {
  return !ahead.swapped && !ahead.sorted && !broad.has_moved_on();
}

// Of the present part.
std::size_t World::Impl::pieces() const {
  switch (ahead.part) {
    case Part::check:
    case Part::renew:
    case Part::measure:
    case Part::count:
    case Part::group:
    case Part::gather:
    case Part::stand:
      return 1;
    case Part::loads:
      return loads.pieces();
    case Part::move:
      return broad.moves();
    case Part::search:
      return broad.searches();
    case Part::near:
      return broad.nears();
    case Part::select:
    case Part::pack:
      return loose ? candidates.strips.size() : table.strips.size();
    case Part::sort_out:
    case Part::keep:
    case Part::colour:
    case Part::lay_out:
      return table.strips.size();
    case Part::look:
      return manifolds.look_pieces();
    case Part::done:
      break;
  }
  return 0;
}

namespace {

Stage stage_of(Part part) {
  switch (part) {
    case Part::select:
    case Part::pack:
    case Part::look:
    case Part::stand:
      return Stage::narrow_phase;
    case Part::group:
    case Part::loads:
    case Part::gather:
    case Part::sort_out:
    case Part::keep:
    case Part::colour:
    case Part::lay_out:
      return Stage::colouring;
    default:
      return Stage::broad_phase;
  }
}

}  // namespace

// Does the pieces of the present part up to the `end`-th; after the last one the next part is the present one.
void World::Impl::work(const Span& span, StepReport& report, std::size_t end) {
  const std::size_t begin = ahead.at;
  const StageTimer timer(report, tracer, stage_of(ahead.part));
  PairTable& fresh = loose ? candidates : table;
  switch (ahead.part) {
    case Part::check:
      check_lists(span);
      break;
    case Part::renew:
      renew_lists(span, report);
      break;
    case Part::measure:
      measure_bodies(span);
      list_span = span.step / span.frame;
      break;
    case Part::count:
      broad.count(bodies, kernels, pool);
      break;
    case Part::move:
      move_bodies(begin, end);
      break;
    case Part::search:
      broad.search(bodies, kernels, pool, fresh, begin, end);
      break;
    case Part::near:
      broad.find_near(bodies, shapes, pool, fresh, begin, end);
      break;
    case Part::select: {
      if (begin == 0) {
        table.swap(old_table);
        ahead.swapped = true;
      }
      select_span = span.step / span.frame;
      if (begin == 0) measure_speeds(span.step);
      for (std::size_t s = begin; s < end; ++s) slack[s] = static_cast<float>(slack_of(s, span.step));
      broad.select(bodies, static_cast<float>(kMarginFrames * span.step), slack, plan.fields,
                   candidates, table, kernels, pool, begin, end);
      break;
    }
    case Part::pack:
      broad.pack(bodies, candidates, table, pool, begin, end);
      break;
    case Part::group:
      choose_solved();
      break;
    case Part::loads:
      loads.go_on(table, pool, begin, end);
      break;
    case Part::gather:
      manifolds.begin_collect(bodies, plan.filters, table, lists_stale, pool);
      break;
    case Part::sort_out: {
      const Joined joined = [this](std::uint32_t a, std::uint32_t b) {
        return joints.joined(a, b);
      };
      manifolds.sort_out(bodies, shapes, joints.any_exclusions() ? &joined : nullptr, table, begin,
                         end, pool);
      break;
    }
    case Part::keep:
      manifolds.keep(bodies, shapes, sleepers.recent, begin, end, pool);
      break;
    case Part::colour:
      if (begin == 0) {
        contacts.begin(bodies, solved, plan.model, plan.surfaces ? nullptr : &first_surface, loads,
                       table, pool);
      }
      contacts.colour(table, begin, end, pool);
      break;
    case Part::lay_out:
      contacts.lay_out(bodies, shapes, desc.wall, table, old_table,
                       lists_stale ? broad.origin() : nullptr, sleepers.recent, begin, end, pool);
      break;
    case Part::look:
      if (begin == 0 && ahead.spread && !ahead.built && !loose) manifolds.remember(pool);
      manifolds.refresh(bodies, manifold_params(span.step), begin, end, pool);
      break;
    case Part::stand:
      columns.find(bodies, manifolds, manifold_params(span.step), table, pool);
      break;
    case Part::done:
      break;
  }
  ahead.at = static_cast<std::uint32_t>(end);
  if (end == pieces()) finish_part(report);
}

void World::Impl::finish_part(StepReport& report) {
  Part next = Part::done;
  switch (ahead.part) {
    case Part::check:
      if (lists_stale) {
        next = Part::measure;
      } else if (!loose && renewal.any()) {
        next = Part::renew;
      } else {
        ++skipped_frames[1];
        if (!loose) ++skipped_frames[3];
        next = after_check();
      }
      break;
    case Part::renew:
      next = lists_stale ? Part::measure : after_check();
      break;
    case Part::measure:
      next = Part::count;
      break;
    case Part::count:
      next = Part::move;
      break;
    case Part::move:
      next = Part::search;
      break;
    case Part::search:
      next = Part::near;
      break;
    case Part::near:
      report.rebuilt = true;
      next = loose ? Part::select : Part::group;
      break;
    case Part::select:
      next = Part::pack;
      break;
    case Part::pack:
      next = Part::group;
      break;
    case Part::group:
      next = plan.loads ? Part::loads : after_loads();
      break;
    case Part::loads:
      next = after_loads();
      break;
    case Part::gather:
      next = Part::sort_out;
      break;
    case Part::sort_out:
      next = Part::keep;
      break;
    case Part::keep:
      next = Part::colour;
      break;
    case Part::colour:
      next = Part::lay_out;
      break;
    case Part::lay_out:
      if (lists_stale) forces_stale = true;
      lists_stale = false;
      next = after_contacts();
      break;
    case Part::look:
      next = Part::stand;
      break;
    case Part::stand:
    case Part::done:
      break;
  }
  ahead.part = next;
  ahead.at = 0;
}

// All that is left of the work.
void World::Impl::finish_work(const Span& span, StepReport& report) {
  while (ahead.part != Part::done) work(span, report, pieces());
}

// Whether the lists can serve dt seconds more.
bool World::Impl::lists_serve(double dt) {
  const double time = (loose ? 1.0 : kMarginFrames) * dt;
  return broad.lists_serve(bodies, static_cast<float>(time), kernels, pool);
}

// Sets lists_stale to whether there must be new lists.
void World::Impl::check_lists(const Span& span) {
  carry_woken();
  bodies.pad_tail();
  ahead.built = ahead.laid = false;
  if (!lists_stale) {
    lists_stale = once || !(may_renew() ? renewal.find(bodies, lattice, static_cast<float>(kMarginFrames * span.frame),
                                                       kernels, pool)
                                        : lists_serve(loose ? span.step : span.frame));
  }
  ahead.laid = lists_stale || loose;
}

// Whether lists can be made anew for a few bodies.
bool World::Impl::may_renew() const {
  return !loose && bodies.count >= BroadPhase::kSmallWorld && bodies.count == table.body_count && !solved.compact();
}

// Lists of those bodies that used up their margin; of all, if they are too many.
void World::Impl::renew_lists(const Span& span, StepReport& report) {
  if (!renewal.known()) lists_stale = !renewal.find(bodies, lattice, renewal.time(), kernels, pool);
  const std::uint32_t found = renewal.count();
  if (!lists_stale) {
    contacts.lift(table);
    kernels::ReachParams margin = broad.margin();
    margin.time = static_cast<float>(kMarginFrames * kRenewedFrames * span.frame);
    lists_stale =
        !renewal.look(broad, bodies, shapes, plan.loads ? &loads : nullptr, margin, kernels, pool, table) || !put_renewed();
  }
  ahead.laid = lists_stale;
  if (lists_stale) return;
  report.renewed = found;
}

// What they are near now comes into the lists. False if all lists must be made again.
bool World::Impl::put_renewed() {
  if (sorts_out()) {
    const Joined joined = [this](std::uint32_t a, std::uint32_t b) { return joints.joined(a, b); };
    manifolds.sort_out_renewed(bodies, shapes, joints.any_exclusions() ? &joined : nullptr, renewal.pairs(),
                               renewal.near(), pool);
  }
  if (!renewal.put(bodies, table)) return false;
  if (sorts_out()) manifolds.put_renewed([this](std::uint32_t slot) { return renewal.found(slot); });
  renewal.finish();
  contacts.renew(bodies, shapes, desc.wall, renewal.singles_changed(), table, pool);
  return true;
}

// Colouring, what comes before the colours: which bodies the solver has.
void World::Impl::choose_solved() {
  if (!held.empty()) {  // kinematic bodies are the solver's
    bodies.find_slots();
    for (const auto& [id, velocity] : held) bodies.linked[bodies.info[id].slot] = 0xFF;
  }
  if (!joints.empty()) {  // so are joined ones
    bodies.find_slots();
    for (const std::uint32_t id : joints.bodies()) {
      if (bodies.info[id].place == Place::moving) bodies.linked[bodies.info[id].slot] = 0xFF;
    }
  }
  if (!impulses_valid) {
    old_table.body_count = 0;
    old_table.strips.clear();
    if (sorts_out()) manifolds.forget();
  }
  if (plan.turns) bodies.keep_turns(true);
  solved.choose(bodies, table, loose && !plan.forces && !plan.turns, plan.restitution, pool);
  if (plan.loads) {
    loads.begin(bodies, table, pool);
  } else {
    loads.forget();
  }
}

}  // namespace psim
