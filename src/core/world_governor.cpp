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
    x.push_back(0.5 + static_cast<double>(k % columns) * (width - 1.5) / (width - 1) + (row % 2 == 1 ? 0.5 : 0.0));
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
       {c.step, c.check, c.sort, c.search, c.test, c.pair, c.near, c.near_fixed, c.near_shape, c.select, c.pack, c.group,
        c.load, c.colour, c.lay_out, c.lay_out_rough, c.keep, c.look, c.stand, c.column, c.narrow, c.load_body, c.move,
        c.stop, c.sleep, c.joint, c.joint_sorted, c.body_pass, c.pass, c.bounce_pass, c.shape_pass, c.joint_pass}) {
    if (!(cost >= 0) || !std::isfinite(cost)) return false;
  }
  if (!(desc.budget_ms > 0)) return false;
  impl_->governor.set(desc);
  return true;
}

StepReport World::replay(const StepDetail& detail) { return replay(detail, impl_->desc.dt); }

StepReport World::replay(const StepDetail& detail, double dt) {
  const auto frames = [](int n) { return n >= 1 && n <= Governor::kMostFrames; };
  if (detail.substeps > 64 || !frames(detail.frames) || !frames(detail.horizon) || (detail.solves && detail.wakes)) {
    return {};
  }
  return impl_->step(dt, detail, false);
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
    const double every = governor.look_ns(work) + governor.costs().stand * static_cast<double>(work.manifolds) +
                         governor.costs().check * static_cast<double>(work.bodies);
    build = std::max((quiet(anew) - still) / (governor.ahead_ns(work) - every), 0.1);
    rest = std::max((still - kFew * pass_ns) / (governor.costs().step + governor.rest_ns(work) + every), 0.1);
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
    if (const auto world = heap(options, std::clamp<std::size_t>(count, 1000, boxes ? 30000 : 100000), boxes)) {
      Impl& w = *world->impl_;
      shares.measure(*world, [&] { w.spoil_lists(); }, [&] { return w.count_work(); });
    }
    return shares;
  };
  // What the heaps cost by the default model on the machine that it was made on.
  constexpr double kBuild = 0.79, kRest = 1.05, kPass = 0.6, kGroup = 1.3, kLook = 0.57, kShapePass = 1.27;
  Shares discs = measure(bodies, false);
  if (discs.pass == 0) return model;
  scaled({&model.check, &model.sort, &model.search, &model.pair, &model.near, &model.near_fixed, &model.near_shape,
          &model.select, &model.pack, &model.load, &model.colour, &model.lay_out, &model.lay_out_rough},
         discs.build, kBuild);
  scaled({&model.narrow, &model.load_body, &model.move, &model.stop, &model.sleep}, discs.rest, kRest);
  scaled({&model.body_pass, &model.pass, &model.bounce_pass, &model.joint_pass, &model.joint,
          &model.joint_sorted}, discs.pass, kPass);
  if (shapes == 0) return model;
  Shares boxes = measure(shapes, true);
  if (boxes.pass == 0) return model;
  scaled({&model.group}, boxes.build, kGroup);
  scaled({&model.keep, &model.look, &model.stand, &model.column}, boxes.rest, kLook);
  scaled({&model.shape_pass}, boxes.pass, kShapePass);
  return model;
}

}  // namespace psim
