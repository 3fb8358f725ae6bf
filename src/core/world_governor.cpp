// What work costs on this machine, measured on a heap of discs; details chosen in another run.
#include <algorithm>
#include <cmath>

#include "world_impl.h"

namespace psim {
namespace {

// A heap of touching discs in a box, as many as fit a world that is asked about.
std::unique_ptr<World> heap(const RunOptions& options, std::size_t discs) {
  const auto columns = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(discs))));
  WorldDesc desc;
  const double width = static_cast<double>(columns);
  desc.bounds = {0, 0, width, 2 * width};
  desc.sleeping = false;
  std::string error;
  auto world = World::create(desc, options, error);
  if (!world) return nullptr;
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

double stage(const StepReport& report, Stage which) {
  return report.stage_ms[static_cast<std::size_t>(which)] * 1e6;
}

// The lower quartile: other programs only ever add.
double quiet(std::vector<double> of) {
  std::nth_element(of.begin(), of.begin() + static_cast<std::ptrdiff_t>(of.size() / 4), of.end());
  return of[of.size() / 4];
}

}  // namespace

bool World::set_governor(const GovernorDesc& desc) {
  const CostModel& c = desc.costs;
  for (const double cost : {c.step, c.check, c.build, c.select, c.colour, c.narrow, c.look, c.body_pass, c.pass,
                            c.bounce_pass, c.shape_pass, c.joint_pass}) {
    if (!(cost >= 0) || !std::isfinite(cost)) return false;
  }
  if (!(desc.budget_ms > 0)) return false;
  impl_->governor.set(desc);
  return true;
}

StepReport World::replay(const StepDetail& detail) { return replay(detail, impl_->desc.dt); }

StepReport World::replay(const StepDetail& detail, double dt) {
  if (detail.substeps > 64 || detail.parts == 0 || detail.parts > StepDetail::kAll || detail.frames < 1 ||
      detail.frames > 3) {
    return {};
  }
  return impl_->step(dt, detail, false);
}

// The default model has the proportions of one machine; what a heap costs here scales them, apart for lists
// and for passes.
CostModel World::measure_costs(const RunOptions& options, std::size_t bodies) {
  CostModel model;
  const std::size_t n = std::clamp<std::size_t>(bodies, 1000, 100000);
  const auto world = heap(options, n);
  if (!world) return model;
  std::vector<double> build, pass, flow;
  WorkCounts work;
  for (int k = 0; k < 16; ++k) {
    const bool anew = k % 4 == 0;
    if (anew) world->impl_->spoil_lists();
    const StepReport report = world->replay({});
    if (k < 4) continue;  // memory comes, caches fill
    work = world->impl_->count_work();
    work.builds = work.lays_out = anew;
    Governor governor;
    governor.set({true, 1, model});
    if (anew) {
      build.push_back((stage(report, Stage::broad_phase) + stage(report, Stage::colouring)) /
                      (model.build * static_cast<double>(work.bodies) + model.colour * static_cast<double>(work.contacts)));
    }
    pass.push_back(stage(report, Stage::solver) / (world->desc().substeps * governor.substep_ns(work)));
    flow.push_back((stage(report, Stage::integrate) + stage(report, Stage::narrow_phase)) /
                   (model.check * static_cast<double>(work.bodies) + model.narrow * static_cast<double>(work.contacts)));
  }
  // What the heap costs by the default model on the machine that it was made on.
  constexpr double kLists = 0.68, kPasses = 1.05, kFlows = 0.72;
  const double lists = quiet(build) / kLists, passes = quiet(pass) / kPasses, flows = quiet(flow) / kFlows;
  for (double* cost : {&model.build, &model.select, &model.colour}) *cost *= lists;
  for (double* cost : {&model.check, &model.narrow, &model.look}) *cost *= flows;
  for (double* cost : {&model.body_pass, &model.pass, &model.bounce_pass, &model.shape_pass, &model.joint_pass}) *cost *= passes;
  return model;
}

}  // namespace psim
