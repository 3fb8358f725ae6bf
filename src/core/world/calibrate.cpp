// World::measure_costs: what work costs on this machine. It runs a heap of discs and one of boxes with and without new
// lists and with few and many substeps; the differences tell lists, passes and the rest apart, and scale the costs of
// cost_table.h. It counts the time that the calling thread worked, so that other programs do not spoil it.
#include <algorithm>
#include <cmath>

#include "base/os.h"
#include "world/world_impl.h"

namespace psim {
namespace {

// A heap of touching discs, or of boxes, in a box.
std::unique_ptr<World> heap(const RunOptions& options, std::size_t bodies, bool boxes) {
  const double width = std::ceil(std::sqrt(static_cast<double>(bodies)));
  WorldDesc desc;
  desc.bounds = {0, 0, width, 2 * width};
  desc.dt = 1e-4;  // nothing moves far: lists are made when they are told to be
  desc.sleeping = false;
  std::string error;
  auto world = World::create(desc, options, error);
  if (!world) return nullptr;
  BodyDesc body;
  if (boxes) {
    body.shape = BoxShape{0.99, 0.99, 0};
    body.material.friction = 0.5;
  } else {
    body.shape = DiscShape{0.4995};
  }
  const Vec2 first = boxes ? Vec2{0.6, 0.495} : Vec2{0.5, 0.5};
  const Vec2 pitch = boxes ? Vec2{1, 0.99} : Vec2{(width - 1.5) / (width - 1), 0.87};
  const double shift = boxes ? 0.3 : 0.5;  // of every other row
  for (std::size_t k = 0; k < bodies; ++k) {
    const double row = std::floor(static_cast<double>(k) / width), column = static_cast<double>(k) - row * width;
    body.position = {first.x + column * pitch.x + std::fmod(row, 2) * shift, first.y + row * pitch.y};
    world->add_body(body, error);
  }
  return world;
}

// The lower quartile: other programs only ever add.
double quiet(std::vector<double> of) {
  // Total order: equal times are alike.
  std::nth_element(of.begin(), of.begin() + static_cast<std::ptrdiff_t>(of.size() / 4), of.end());
  return of[of.size() / 4];
}

// What a heap costs as shares of what the default costs predict. It takes steps with and without new lists, and with
// many substeps: the differences tell the parts apart.
HeapShares shares_of(Owners& w) {
  constexpr int kFew = 2, kMany = 8;
  const auto step_ns = [&w](int substeps) {
    const StepDetail detail{.substeps = static_cast<std::uint8_t>(substeps)};
    const double begin = os::thread_work_ns();
    step(w, w.desc.dt, &detail);
    return os::thread_work_ns() - begin;
  };
  std::vector<double> anew, few, many;
  for (int k = 0; k < 9; ++k) {
    spoil_work(w);
    const double with_lists = step_ns(kFew), without = step_ns(kFew), longer = step_ns(kMany);
    if (k < 2) continue;  // memory comes, caches fill
    anew.push_back(with_lists);
    few.push_back(without);
    many.push_back(longer);
  }
  const UnitCosts costs;
  const WorkCounts work = count_work(w);
  const double still = quiet(few), pass_ns = (quiet(many) - still) / (kMany - kFew);
  const double every = ahead_ns(costs, work, true) + costs.check * static_cast<double>(work.bodies);
  return {.lists = std::max((quiet(anew) - still) / (ahead_ns(costs, work) - every), 0.1),
          .rest = std::max((still - kFew * pass_ns) / (costs.step + rest_ns(costs, work) + every), 0.1),
          .pass = std::max(pass_ns / substep_ns(costs, work), 0.1)};
}

// A tank of water at rest; null if there is no memory.
std::unique_ptr<World> tank(const RunOptions& options) {
  constexpr double kPace = 0.02;
  WorldDesc desc;
  desc.bounds = {0, 0, 200 * kPace, 100 * kPace};
  desc.sleeping = false;
  std::string error;
  auto world = World::create(desc, options, error);
  if (!world) return nullptr;
  const FluidId water = world->add_fluid({.spacing = kPace}, error);
  std::vector<Vec2> places(16000);
  for (std::size_t k = 0; k < places.size(); ++k) {
    places[k] = {kPace * (static_cast<double>(k % 200) + 0.5), kPace * (static_cast<double>(k / 200) + 0.5)};
  }
  return world->add_particles(water, places, {}, error) ? std::move(world) : nullptr;
}

// What a step of it costs as a share of what the default costs predict.
double share_of(Owners& tank) {
  std::vector<double> times;
  for (int k = 0; k < 9; ++k) {
    const double begin = os::thread_work_ns();
    step(tank, tank.desc.dt, nullptr);
    if (k >= 2) times.push_back(os::thread_work_ns() - begin);
  }
  const FluidWork work = tank.fluids.work(tank.desc.dt, tank.desc.gravity);
  return std::max(quiet(times) / (work.parts * fluid_part_ns(UnitCosts{}, tank.fluids.size(), work)), 0.05);
}

}  // namespace

// The table has the proportions of one machine; what heaps cost here scales it, apart for lists, passes and the rest,
// and for discs and shapes.
CostModel World::measure_costs(const RunOptions& options, std::size_t bodies, std::size_t statics) {
  UnitCosts c;
  const auto scale = [](std::initializer_list<double*> costs, double measured, double by_default) {
    for (double* cost : costs) *cost *= measured / by_default;
  };
  const auto measure = [&](std::size_t count, bool boxes) {
    const auto world = heap(options, std::clamp<std::size_t>(count, 1000, boxes ? 30000 : 100000), boxes);
    return world ? shares_of(*world->impl_) : HeapShares{};
  };
  if (const auto water = tank(options)) scale({&c.particle}, share_of(*water->impl_), kTank);
  const HeapShares discs = measure(bodies, false);
  if (discs.pass == 0) return cost_model(c);
  scale({&c.check, &c.sort, &c.search, &c.pair, &c.near, &c.near_fixed, &c.near_shape, &c.cell, &c.strip, &c.select,
         &c.pack, &c.load, &c.colour, &c.lay_out, &c.lay_out_rough},
        discs.lists, kDiscHeap.lists);
  scale({&c.narrow, &c.load_body, &c.move, &c.stop, &c.flight, &c.sleep}, discs.rest, kDiscHeap.rest);
  scale({&c.body_pass, &c.pass, &c.touch, &c.sweep, &c.joint_pass, &c.joint, &c.joint_sorted}, discs.pass,
        kDiscHeap.pass);
  if (statics == 0) return cost_model(c);
  const HeapShares boxes = measure(statics, true);
  if (boxes.pass == 0) return cost_model(c);
  scale({&c.group}, boxes.lists, kBoxHeap.lists);
  scale({&c.keep, &c.look, &c.stand, &c.column}, boxes.rest, kBoxHeap.rest);
  scale({&c.shape_pass}, boxes.pass, kBoxHeap.pass);
  return cost_model(c);
}

}  // namespace psim
