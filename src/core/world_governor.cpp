// How much of a step is done in a frame, by the governor's choice or as in another run; what work costs on this
// machine, measured on a heap.
#include <algorithm>
#include <cmath>
#include <ctime>

#include "world_impl.h"

namespace psim {
namespace {

// A heap of touching discs, or of boxes, in a box.
std::unique_ptr<World> heap(const RunOptions& options, std::size_t discs, bool boxes) {
  const auto columns = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(discs))));
  WorldDesc desc;
  const double width = static_cast<double>(columns);
  desc.bounds = {0, 0, width, 2 * width};
  desc.dt = 1e-4;  // nothing moves far: lists are made when they are told to be
  desc.sleeping = false;
  std::string error;
  auto world = World::create(desc, options, error);
  if (!world) return nullptr;
  if (boxes) {
    desc.bounds = {0, 0, width + 1, 2 * width};
    BodyDesc body;
    body.shape = BoxShape{0.99, 0.99, 0};
    body.material.friction = 0.5;
    for (std::size_t k = 0; k < discs; ++k) {
      const std::size_t row = k / columns;
      body.position = {0.6 + static_cast<double>(k % columns) + (row % 2 == 1 ? 0.3 : 0.0),
                       0.495 + 0.99 * static_cast<double>(row)};
      world->add_body(body, error);
    }
    return world;
  }
  std::vector<double> x, y;
  for (std::size_t k = 0; k < discs; ++k) {
    const std::size_t row = k / columns;
    x.push_back(0.5 + static_cast<double>(k % columns) * (width - 1.5) / (width - 1) +
                (row % 2 == 1 ? 0.5 : 0.0));
    y.push_back(0.5 + static_cast<double>(row) * 0.87);
  }
  const double radius = 0.4995;
  DiscBatch batch;
  batch.x = x;
  batch.y = y;
  batch.radius = {&radius, 1};
  std::uint32_t first = 0;
  world->add_discs(batch, first, error);
  return world;
}

// ns that the calling thread worked: what it waits for others, while their programs run, does not count.
double worked_ns() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e9 + static_cast<double>(now.tv_nsec);
}

// The lower quartile: other programs only ever add.
double quiet(std::vector<double> of) {
  std::nth_element(of.begin(), of.begin() + static_cast<std::ptrdiff_t>(of.size() / 4), of.end());
  return of[of.size() / 4];
}

}  // namespace

bool World::set_governor(const GovernorDesc& desc) {
  const CostModel& c = desc.costs;
  for (const double cost :
       {c.step,  c.check,      c.sort,         c.search,        c.test,   c.pair,
        c.near,  c.near_fixed, c.near_shape,   c.select,        c.pack,   c.group,
        c.load,  c.colour,     c.lay_out,      c.lay_out_rough, c.keep,   c.look,
        c.stand, c.column,     c.narrow,       c.load_body,     c.move,   c.stop,
        c.sleep, c.joint,      c.joint_sorted, c.body_pass,     c.pass,   c.touch,
        c.sweep, c.shape_pass, c.joint_pass,   c.cell,          c.flight, c.strip}) {
    if (!(cost >= 0) || !std::isfinite(cost)) return false;
  }
  if (!(desc.budget_ms > 0)) return false;
  impl_->settle_lists();
  impl_->governor.set(desc);
  return true;
}

StepReport World::replay(const StepDetail& detail) { return replay(detail, impl_->desc.dt); }

StepReport World::replay(const StepDetail& detail, double dt) {
  const auto frames = [](int n) { return n >= 1 && n <= StepDetail::kMostFrames; };
  if (detail.substeps > StepDetail::kMostSubsteps || !frames(detail.frames) || !frames(detail.horizon) ||
      (detail.solves && detail.wakes) || detail.sweeps > StepDetail::kMostSweeps) {
    return {};
  }
  return impl_->step(dt, detail, false);
}

namespace {

// Frames after which a step that the host makes begin again is done at once, whatever it costs.
constexpr int kPatience = 3;
// Bodies of several sizes that press each other are searched for longer in cells that are listed.
constexpr double kListedCrowd = 3.2;
// Manifolds that are made for several frames last less often.
constexpr double kLongLooks = 1.4;
// Of a manifold under a heavy load, few of which share a block.
constexpr std::uint64_t kLoadedLanes = 2;
// Room for so many is made in small worlds, too: bodies come together.
constexpr std::size_t kFewPairs = 32768, kFewStrips = 256;

}  // namespace

// Lanes of the manifolds that were looked at for this step, those under heavy loads as often as they are swept;
// 0 if there are none of those.
std::uint64_t World::Impl::loaded_shape_lanes() const {
  if (ahead.part != Part::done || !loads.any()) return 0;
  std::uint64_t active = 0, loaded = 0;
  for (const ManifoldPair& pair : manifolds.pairs()) {
    if (!pair.active) continue;
    ++active;
    if (pair.column != ManifoldPair::kLoose) continue;
    loaded += (pair.a != ManifoldPair::kNone && loads.at(pair.a)) || loads.at(pair.b);
  }
  return loaded == 0 ? 0 : active + kLoadedLanes * (HeavyLoads::kSweeps - 1) * loaded;
}

WorkCounts World::Impl::count_work() const {
  WorkCounts work;
  work.bodies = bodies.count - bodies.dead;
  work.solved = solved.count();
  if (loose) {
    if (candidates.strips.empty()) work.candidates = saved.candidates;
    for (const Strip& s : candidates.strips) work.candidates += s.pair_end - s.pair_begin;
  }
  work.contacts = contacts.pair_count() + contacts.single_count();
  work.manifolds = manifolds.pair_count();
  work.lanes = kernels::kBlock * contacts.pass_blocks();
  work.loaded_lanes = kernels::kBlock * contacts.loaded_blocks();
  work.shape_lanes = std::max(kernels::kBlock * manifolds.pass_blocks(), loaded_shape_lanes());
  if (ahead.part == Part::done) work.shape_lanes = std::max(work.shape_lanes, manifolds.expected_lanes());
  work.writes = ahead.part == Part::done ? manifolds.expected_writes() : lists_stale || ahead.built ? work.manifolds : work.looks;
  work.touching = solver.closed();
  work.sweeps = plan.restitution ? solver.sweeps() : 0;
  work.strips = table.strips.size();
  work.cells = broad.cell_count();
  work.visits = loads.visits();
  work.tests = broad.tests() * static_cast<double>(work.bodies);
  work.near = broad.near_pairs();
  work.looks = manifolds.expected_looks();
  work.joints = joints.count();
  work.sorted = ahead.built;
  work.fixed = shapes.any();
  work.loads = plan.loads;
  work.rough = plan.model.model == kernels::Model::rough;
  work.mixed = loose && plan.radii;
  work.uneven = plan.uneven;
  work.copies = solved.compact();
  work.stops = plan.continuous;
  work.flights = continuous.looked();
  const std::uint64_t met = work.contacts + 4 * work.manifolds;
  if (plan.sleep) {  // World::Impl::rest
    if (!sleepers.empty()) work.sleep_looks += 2 * met;
    if ((steps + 1) % Sleepers::kWatchFrames == 0) work.sleep_looks += work.bodies;
    if ((steps + 1) % (2 * Sleepers::kWatchFrames) == 0)
      work.sleep_looks += 2 * work.bodies + 2 * met;
  }
  return work;
}

// How much more lists for so many frames hold than the present ones.
Governor::Growth World::Impl::list_growth(int frames) const {
  if (!loose || !(list_reach > 0)) return {};
  const double touching = 2 * static_cast<double>(least_radius);
  const double a_frame = std::max(list_reach - touching, 0.0) / (list_span * std::max(list_frames, 1.0));
  const double reach = touching + a_frame * std::max<double>(frames, list_frames);
  return {reach * reach / (list_reach * list_reach), frames / select_span};
}

// Of the present part.
double World::Impl::piece_ns(const WorkCounts& counts, std::size_t piece) const {
  const CostModel& c = governor.costs();
  const auto n = [](std::size_t count) { return static_cast<double>(count); };
  const auto pairs = [&](const Strip& s) { return n(s.pair_end - s.pair_begin); };
  const auto strip_bodies = [&](std::size_t strip) {
    const Strip& s = (loose ? candidates : table).strips[strip];
    return n(s.body_end - s.body_begin);
  };
  // Parts of the large bodies make several of a pair.
  const auto large_manifolds = [&](std::size_t strip) {
    if (strip + 1 != table.strips.size() || manifolds.strip_count() == 0) return 0.0;
    return n(manifolds.count_of(manifolds.strip_count() - 1));
  };
  // Of the pairs, about.
  const double shaped = n(counts.manifolds) / std::max(n(counts.manifolds + counts.contacts), 1.0);
  switch (ahead.part) {
    case Part::check:
      return c.check * n(bodies.count) +
             (sleepers.woke ? c.sleep * n(counts.contacts + 6 * counts.manifolds) : 0);
    case Part::renew:
      return 2 * c.search * n(renewal.count()) + c.check * n(bodies.count) +
             (sorts_out() ? 0.25 * c.group * n(counts.manifolds) : 0);
    case Part::measure:
      return 0.2 * c.sort * n(bodies.count);
    case Part::count:
      return (broad.lists_cells() ? 2
              : plan.radii        ? 0.6
                                  : 0.3) *
                 c.sort * n(bodies.count) +
             c.cell * n(broad.cell_count());
    case Part::move:
      return (plan.radii ? 1.0 : 0.5) * c.sort * n(bodies.count) / n(broad.moves());
    case Part::search: {
      const BroadPhase::Search s = broad.search_at(piece, loose ? candidates : table);
      const double each = s.large ? 2 * c.strip + (c.pair + 12 * c.test) * s.pairs + 1.75 * c.test * s.others
                                  : c.search + c.test * broad.tests() + c.pair * s.pairs;
      const double longer = broad.lists_cells() ? 1 + kListedCrowd * Governor::crowded(counts) : 1;
      return longer * each * s.bodies + c.strip;
    }
    case Part::near:
      return (counts.fixed ? c.near_fixed + c.near_shape * broad.expected_near(broad.near_at(piece).strip)
                           : c.near) *
                 n(broad.near_at(piece).end - broad.near_at(piece).begin) +
             c.strip;
    case Part::select:
      return (piece == 0 ? governor.speeds_ns(counts) : 0) + governor.select(counts) * pairs(candidates.strips[piece]) + c.strip;
    case Part::pack:
      return c.pack * (pairs(table.strips[piece]) + 0.3 * strip_bodies(piece)) + c.strip;
    case Part::group:
      return (plan.loads ? c.load * n(bodies.count) : 0) + (loose ? c.pack * n(bodies.count) : 0);
    case Part::loads:
      return 0.6 * c.load * n(loads.pairs_in(table, piece)) + c.strip;
    case Part::gather:
      return 0.25 * c.group * n(counts.manifolds);
    case Part::sort_out:
      return 0.35 * c.group *
                 std::max(shaped * pairs(table.strips[piece]), large_manifolds(piece)) +
             c.strip;
    case Part::keep:
      return 0.4 * c.group * n(manifolds.count_of(piece));
    case Part::stand:
      return c.stand * n(counts.manifolds);
    case Part::colour:
      return c.colour * pairs(table.strips[piece]) +
             c.strip;  // strips are in another order here: alike
    case Part::lay_out:
      return governor.lay_out(counts) *
                 (pairs(table.strips[piece]) + n(table.singles[piece].size())) +
             3 * c.strip;
    case Part::look:
      return counts.manifolds == 0
                 ? 0
                 : (ahead.horizon > 1 ? kLongLooks : 1.0) * governor.look_ns(counts) /
                       n(counts.manifolds) * n(manifolds.pairs_in(piece));
    case Part::done:
      break;
  }
  return 0;
}

// Does of a step's work what fits into a frame of dt seconds. Chooses the detail: whether the rest of the step
// fits, too, with how many substeps, and how many frames it makes up for.
void World::Impl::choose_detail(double dt, StepReport& report) {
  StepDetail& detail = report.detail;
  const int elapsed = ahead.waits + 1;
  if (bodies.count == bodies.dead) return;
  const int most = std::min(desc.substeps, 255);
  const bool first = frame == 0;  // its lists belong to making ready (World::prepare)
  if (ahead.part == Part::check) {
    const auto growth = [this](int frames) { return list_growth(frames); };
    ahead.horizon = static_cast<std::uint8_t>(first ? 1 : governor.horizon(count_work(), most, growth));
  }
  detail.horizon = ahead.horizon;
  const Span span{dt, dt * detail.horizon};
  const bool late = ahead.spoiled != 0 && ahead.waits >= kPatience;
  const double room = governor.room_ns();
  double spent = governor.costs().step;
  const double base = spent;
  if (first) finish_work(span, report);
  while (ahead.part != Part::done) {
    const std::size_t all = pieces();
    const WorkCounts counts = count_work();
    const bool looks = !ahead.built && !loose && (ahead.part == Part::look || ahead.part == Part::stand);
    if (looks && ahead.part == Part::look && ahead.at == 0) {
      const double rest = (ahead.horizon > 1 ? kLongLooks : 1.0) * governor.look_ns(counts) +
                          governor.costs().stand * static_cast<double>(counts.manifolds) +
                          governor.rest_ns(counts) + governor.substep_ns(counts);
      ahead.spread = elapsed > 1 || spent + rest > room;
      if (ahead.spread)
        spent += 0.6 * governor.costs().keep * static_cast<double>(counts.manifolds);
    }
    const bool whole = late || (looks && !ahead.spread);  // they were not kept as they were before: they cannot wait
    std::size_t end = ahead.at;
    for (; end < all; ++end) {
      const double cost = piece_ns(counts, end);
      if (spent + cost > room && spent > base && !whole) break;
      spent += cost;
    }
    if (end == ahead.at && all != 0) break;
    detail.pieces += static_cast<std::uint32_t>(end - ahead.at);
    work(span, report, end);
  }
  const WorkCounts counts = count_work();
  detail.solves = false;
  if (ahead.part == Part::done) {
    int horizon = ahead.horizon;
    if (elapsed > 1 && horizon > 1 && !loose && !ahead.built &&
        !lists_serve(dt * std::min(elapsed, horizon)))
      horizon = 1;
    const Governor::Choice choice = governor.choose(counts, room - spent, elapsed, horizon, most);
    const bool looked = plan.shapes && !loose && !ahead.built && !ahead.spread;
    detail.solves = choice.solves || late || looked || first;
    if (detail.solves) {
      detail.substeps = static_cast<std::uint8_t>(std::max(choice.substeps, 1));
      detail.frames = static_cast<std::uint8_t>(choice.frames);
      const bool few = choice.solves ? choice.sweeps != 0 : counts.sweeps > Governor::kFewSweeps;
      detail.sweeps = few ? Governor::kFewSweeps : 0;
      spent += governor.rest_ns(counts) +
               detail.substeps * governor.substep_ns(with_sweeps(counts, detail.sweeps));
      detail.pieces = 0;
    }
  }
  if (!detail.solves) note_work(span);
  report.predicted_ms = spent * 1e-6;
}

// Lists of several frames are longer, and to make room for them takes longer than a frame may: it is made before the
// first.
void World::Impl::spare_room() {
  const std::size_t each = plan.radii ? 20 : 12;
  const std::size_t pairs = std::max<std::size_t>(
      2 * std::max(table.pair_room, candidates.pair_room), each * bodies.count + kFewPairs);
  for (PairTable* of : {&table, &old_table, &candidates}) of->spare(bodies.count, pairs);
  const std::size_t all = kernels::round_up_block(bodies.count) + 2 * table.strips.size() + kFewStrips;
  broad.spare(bodies.count, all, pairs);
  if (bodies.count >= BroadPhase::kSmallWorld) renewal.spare(bodies.count);
  for (Column<float>* of : {&bodies.vel, &bodies.disp, &bodies.vel0}) of->reserve(2 * all);
  bodies.pos.reserve(2 * all);
  if (plan.shapes && !table.strips.empty()) {
    const std::size_t cornered = traits.cornered;
    const std::size_t most = std::min(24 * cornered, 6 * cornered + kFewPairs);
    manifolds.spare(std::max<std::size_t>(2 * manifolds.pair_count(), most), table.strips.size());
  }
  contacts.spare(std::max<std::size_t>(2 * kernels::kBlock * contacts.pair_blocks(),
                                       (plan.radii ? 8 : 5) * std::size_t{bodies.count}),
                 2 * kernels::kBlock * contacts.single_blocks() + 1024);
  if (!plan.forces && !plan.turns) {
    solved.spare(kernels::round_up_block(bodies.count) + 1024, !bodies.spin.empty(),
                 plan.restitution);
  }
}

// Whether new lists fit beside what is predicted already; if not, the substeps will not be done either.
bool World::Impl::fits_again(StepReport& report) const {
  const WorkCounts work = count_work();
  double spent = report.predicted_ms * 1e6;
  if (spent + governor.ahead_ns(work) + governor.rest_ns(work) <= governor.room_ns()) return true;
  spent -= report.detail.substeps * governor.substep_ns(with_sweeps(work, report.detail.sweeps));
  report.predicted_ms = spent * 1e-6;
  return false;
}

// Does as many pieces of a step's work as the detail says.
void World::Impl::work_ahead(double dt, StepReport& report) {
  if (bodies.count == bodies.dead) return;
  const Span span{dt, dt * report.detail.horizon};
  ahead.horizon = report.detail.horizon;
  ahead.spread = true;
  for (std::size_t left = report.detail.pieces; left != 0 && ahead.part != Part::done;) {
    const std::size_t end = std::min(pieces(), ahead.at + left);
    left -= end - ahead.at;
    work(span, report, end);
  }
  note_work(span);
}

namespace {

// What a heap costs against the default model, part by part.
struct Shares {
  double build = 0, rest = 0, pass = 0;

  // Steps with and without new lists, and with many substeps: the differences tell the parts apart.
  template <class Spoil, class Count>
  void measure(World& world, const Spoil& spoil, const Count& count) {
    constexpr int kFew = 2, kMany = 8;
    const auto step = [&](int substeps) {
      StepDetail detail;
      detail.substeps = static_cast<std::uint8_t>(substeps);
      const double begin = worked_ns();
      world.replay(detail);
      return worked_ns() - begin;
    };
    std::vector<double> anew, few, many;
    for (int k = 0; k < 9; ++k) {
      spoil();
      const double with_lists = step(kFew), without = step(kFew), longer = step(kMany);
      if (k < 2) continue;  // memory comes, caches fill
      anew.push_back(with_lists);
      few.push_back(without);
      many.push_back(longer);
    }
    const Governor governor;
    const WorkCounts work = count();
    const double still = quiet(few), pass_ns = (quiet(many) - still) / (kMany - kFew);
    const double every = governor.look_ns(work) +
                         governor.costs().stand * static_cast<double>(work.manifolds) +
                         governor.costs().check * static_cast<double>(work.bodies);
    build = std::max((quiet(anew) - still) / (governor.ahead_ns(work) - every), 0.1);
    rest = std::max(
        (still - kFew * pass_ns) / (governor.costs().step + governor.rest_ns(work) + every), 0.1);
    pass = std::max(pass_ns / governor.substep_ns(work), 0.1);
  }
};

}  // namespace

// The default model has the proportions of one machine; what heaps cost here scales them, apart for lists, passes and
// the rest, and for discs and shapes.
CostModel World::measure_costs(const RunOptions& options, std::size_t bodies, std::size_t shapes) {
  CostModel model;
  const auto scaled = [](std::initializer_list<double*> costs, double measured, double by_default) {
    for (double* cost : costs) *cost *= measured / by_default;
  };
  const auto measure = [&](std::size_t count, bool boxes) {
    Shares shares;
    if (const auto world =
            heap(options, std::clamp<std::size_t>(count, 1000, boxes ? 30000 : 100000), boxes)) {
      Impl& w = *world->impl_;
      shares.measure(
          *world, [&] { w.spoil_lists(); }, [&] { return w.count_work(); });
    }
    return shares;
  };
  // What the heaps cost by the default model on the machine that it was made on.
  constexpr double kBuild = 0.79, kRest = 1.05, kPass = 0.74, kGroup = 1.1, kLook = 0.73,
                   kShapePass = 0.91;
  Shares discs = measure(bodies, false);
  if (discs.pass == 0) return model;
  scaled({&model.check, &model.sort, &model.search, &model.pair, &model.near, &model.near_fixed,
          &model.near_shape, &model.cell, &model.strip, &model.select, &model.pack, &model.load,
          &model.colour, &model.lay_out, &model.lay_out_rough},
         discs.build, kBuild);
  scaled({&model.narrow, &model.load_body, &model.move, &model.stop, &model.flight, &model.sleep},
         discs.rest, kRest);
  scaled({&model.body_pass, &model.pass, &model.touch, &model.sweep, &model.joint_pass,
          &model.joint, &model.joint_sorted},
         discs.pass, kPass);
  if (shapes == 0) return model;
  Shares boxes = measure(shapes, true);
  if (boxes.pass == 0) return model;
  scaled({&model.group}, boxes.build, kGroup);
  scaled({&model.keep, &model.look, &model.stand, &model.column}, boxes.rest, kLook);
  scaled({&model.shape_pass}, boxes.pass, kShapePass);
  return model;
}

}  // namespace psim
