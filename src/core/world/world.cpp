// The World's face: creation and the small questions. Bodies: world_bodies.cpp. The step: step.cpp. What is read out:
// world_queries.cpp.
#include "psim/world.h"
#include "base/elementary.h"

#include <cmath>
#include <utility>

#include "base/range_text.h"
#include "base/room.h"
#include "bodies/body_desc.h"
#include "psim/limits.h"
#include "world/world_impl.h"

namespace psim {
namespace {

void check_region(const char* what, const Bounds& b, RangeCheck& check) {
  check(what, Vec2{b.xmin, b.ymin}, limits::kCoordinate)(what, Vec2{b.xmax, b.ymax}, limits::kCoordinate);
  check(what, Vec2{b.xmax - b.xmin, b.ymax - b.ymin}, limits::kExtent);
}

struct FieldCheck {
  RangeCheck& check;
  void operator()(const WellField& well) const {
    check("a well's position", well.position, limits::kCoordinate);
    check("a well's strength", well.strength, limits::kWellStrength);
    check("a well's softening", well.softening, limits::kWellLength);
    check("a well's exponent", well.exponent, limits::kWellExponent);
    check("a well's range", well.range, limits::kWellLength);
  }
  void operator()(const DragField& drag) const {
    check("linear drag", drag.linear, limits::kDamping)("quadratic drag", drag.quadratic, limits::kDamping);
  }
  void operator()(const BuoyancyField& water) const {
    check_region("a corner, width or height of the water's region", water.region, check);
    check("the water's density", water.density, limits::kDensity);
    check("the water's linear damping", water.linear_damping, limits::kDamping);
    check("the water's angular damping", water.angular_damping, limits::kDamping);
    check("the water's flow", water.flow, limits::kVelocity);
  }
  void operator()(const WindField& wind) const {
    check("the wind's velocity", wind.velocity, limits::kVelocity)("the air's density", wind.density, limits::kDensity);
    check("the wind's drag", wind.drag, limits::kWindFactor)("the wind's lift", wind.lift, limits::kWindFactor);
    if (wind.region) check_region("a corner, width or height of the wind's region", *wind.region, check);
  }
};

std::string check_field(const Field& field) {
  RangeCheck check;
  std::visit(FieldCheck{check}, field);
  return check.error;
}

}  // namespace

std::string check(const std::vector<Field>& fields) {
  for (const Field& field : fields) {
    if (std::string error = check_field(field); !error.empty()) return error;
  }
  return {};
}

std::string check(const WorldDesc& d, const RunOptions& o) {
  const Bounds& b = d.bounds;
  RangeCheck check;
  check("boundary", d.boundary, Boundary::open)("integrator", d.integrator, Integrator::symplectic4);
  check("mixing of restitution", d.mixing.restitution, Mixing::geometric);
  check("mixing of friction", d.mixing.friction, Mixing::geometric);
  check("a corner of the bounds", Vec2{b.xmin, b.ymin}, limits::kCoordinate);
  check("a corner of the bounds", Vec2{b.xmax, b.ymax}, limits::kCoordinate);
  check("width and height of the bounds", Vec2{b.xmax - b.xmin, b.ymax - b.ymin}, limits::kExtent);
  check("gravity", d.gravity, limits::kGravity)("dt", d.dt, limits::kTimeStep);
  check("substeps", d.substeps, limits::kSubsteps)("linear damping", d.linear_damping, limits::kDamping);
  check("restitution threshold", d.restitution_threshold, limits::kSpeed)("skin", d.skin, limits::kSkin);
  check("wall restitution", d.wall.restitution, limits::kRestitution);
  check("wall tangent speed", d.wall.tangent_speed, limits::kTangentSpeed);
  check("wall rolling resistance", d.wall.rolling_resistance, limits::kRollingResistance);
  check("wall friction", d.wall.friction, limits::kFriction)("threads", o.threads, limits::kThreads);
  if (!check.error.empty()) return check.error;
  if (std::string error = psim::check(d.fields); !error.empty()) return error;
  if (!isa_available(o.isa)) {
    return "this CPU has no " + std::string(isa_name(o.isa)) + "; the best it has is " +
           std::string(isa_name(best_isa()));
  }
  return {};
}

std::unique_ptr<World> World::create(const WorldDesc& desc, const RunOptions& options, std::string& error) {
  const FloatSettings settings;
  error = check(desc, options);
  if (!error.empty()) return nullptr;
  try {
    return std::unique_ptr<World>(new World(std::make_unique<Impl>(desc, options)));
  } catch (const std::bad_alloc&) {
    ran_out_of_memory() = true;
    error = "no room";
    return nullptr;
  }
}

void say_no_room(const Owners& w, std::string_view what, std::string& error) try {
  error = "no room for " + std::string(what) + ": the world holds " + std::to_string(w.memory.bytes);
  error += w.desc.max_bytes != 0 ? " bytes and may hold " + std::to_string(w.desc.max_bytes)
                                 : " bytes, and the system gives no more";
} catch (const std::bad_alloc&) {
  error = "no room";  // so short a text is held in place
}

void Owners::recover() {
  ran_out_of_memory() = true;
  if (broken) return;
  spoil_work(*this);
  observers.queries.forget(QueryIndex::kMoving, QueryIndex::kSleeping, QueryIndex::kFixed);
  plan_stale = observers.placed = true;
}

World::World(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
World::~World() = default;

StepReport World::step() { return psim::step(*impl_, impl_->desc.dt); }
StepReport World::step(double dt) { return psim::step(*impl_, dt); }

bool World::set_governor(const GovernorDesc& desc) try {
  const FloatSettings settings;
  if (!Governor::sound(desc)) return false;
  impl_->settled().governor.set(desc);
  return true;
} catch (const std::bad_alloc&) {
  return impl_->ran_out(false);
}

StepReport World::replay(const StepDetail& detail) { return replay(detail, impl_->desc.dt); }

StepReport World::replay(const StepDetail& detail, double dt) {
  const auto frames = [](int n) { return n >= 1 && n <= StepDetail::kMostFrames; };
  if (detail.substeps > StepDetail::kMostSubsteps || !frames(detail.frames) || !frames(detail.horizon) ||
      (detail.solves && detail.wakes) || detail.sweeps > StepDetail::kMostSweeps ||
      detail.fluid_parts > StepDetail::kMostFluidParts) {
    return {};
  }
  return psim::step(*impl_, dt, &detail);
}

bool World::set_skin(double factor) try {
  const FloatSettings settings;
  if (!limits::kSkin.contains(factor)) return false;
  if (factor == impl_->desc.skin) return true;
  Owners& w = impl_->settled();
  spoil_work(w);
  w.desc.skin = factor;
  return true;
} catch (const std::bad_alloc&) {
  return impl_->ran_out(false);
}

void World::set_max_bytes(std::size_t bytes) {
  impl_->desc.max_bytes = bytes;
  impl_->memory.most = bytes != 0 ? bytes : SIZE_MAX;
}

bool World::set_gravity(Vec2 gravity) try {
  const FloatSettings settings;
  if (!limits::kGravity.contains(gravity)) return false;
  if (gravity.x == impl_->desc.gravity.x && gravity.y == impl_->desc.gravity.y) return true;
  Owners& w = impl_->settled();
  w.note_sleep(w.sleep.wake_all(w.sleep_source()));
  if (!w.progress.untouched()) spoil_work(w);  // they were made for the old gravity
  w.desc.gravity = gravity;
  take_traits(w.desc, w.population.traits);
  w.dynamics.forces.reset();
  w.plan_stale = true;
  return true;
} catch (const std::bad_alloc&) {
  return impl_->ran_out(false);
}

void World::set_sleeping(bool on) try {
  if (on == impl_->desc.sleeping) return;
  Owners& w = impl_->settled();
  if (!on) w.note_sleep(w.sleep.wake_all(w.sleep_source()));
  w.desc.sleeping = on;
  take_traits(w.desc, w.population.traits);
  w.plan_stale = true;
} catch (const std::bad_alloc&) {
  impl_->recover();
}

std::size_t World::body_count() const { return impl_->bodies.living(); }
std::size_t World::dynamic_count() const { return impl_->population.traits.moving; }
std::size_t World::shape_count() const { return impl_->population.traits.cornered; }
std::size_t World::static_count() const { return impl_->population.fixed.size(); }
std::uint64_t World::frame() const { return impl_->ledger.frames; }
std::uint64_t World::escaped_total() const { return impl_->quarantine.escaped; }
const WorldDesc& World::desc() const { return impl_->desc; }
Isa World::isa() const { return impl_->options.isa; }
int World::threads() const { return impl_->pool.threads(); }
LaneCounts World::lane_counts() const { return impl_->ledger.lanes; }

std::vector<std::pair<std::string, std::uint64_t>> World::skipped() const try {
  return impl_->ledger.skipped();
} catch (const std::bad_alloc&) {
  return nothing_found<std::vector<std::pair<std::string, std::uint64_t>>>();
}

void World::enable_snapshots(bool on) try {
  impl_->settled().population.traits.snapshots = on;
  impl_->observers.placed = true;
} catch (const std::bad_alloc&) {
  impl_->recover();
}

const Snapshot* World::latest_snapshot() { return impl_->observers.publisher.latest(); }

void World::set_pre_solve(PreSolve pre_solve) try {
  impl_->settled().pre_solve = std::move(pre_solve);
} catch (const std::bad_alloc&) {
  impl_->recover();
}
const PreSolve& World::pre_solve() const { return impl_->pre_solve; }

void World::set_job_system(JobSystem jobs) { impl_->pool.set_job_system(std::move(jobs)); }

void World::count_lane_use() try {
  if (impl_->options.isa != Isa::scalar) impl_->ledger.survey_lanes();
} catch (const std::bad_alloc&) {
  impl_->recover();
}
std::vector<LaneUse> World::lane_use() const try { return impl_->ledger.lane_use(); } catch (const std::bad_alloc&) {
  return nothing_found<std::vector<LaneUse>>();
}

void World::start_trace() try { impl_->tracer.start(); } catch (const std::bad_alloc&) {
  impl_->recover();
}
void World::stop_trace() { impl_->tracer.stop(); }
std::vector<TraceEvent> World::take_trace() try { return impl_->tracer.take(); } catch (const std::bad_alloc&) {
  return impl_->ran_out(std::vector<TraceEvent>());
}

// The columns of a disc in a gas, with room for lists (docs/memory.md).
std::size_t estimate_memory_bytes(std::size_t discs) { return discs * 220 + (std::size_t{1} << 20); }

}  // namespace psim
