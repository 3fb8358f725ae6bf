// The World's face: creation and the small questions. Bodies: world_bodies.cpp. The step: step.cpp. What is read out:
// world_queries.cpp.
#include "psim/world.h"

#include <cmath>
#include <utility>

#include "world/world_impl.h"

namespace psim {
namespace {

bool is_skin(double factor) { return factor >= 0.25 && factor <= 4; }

}  // namespace

std::string check(const WorldDesc& d, const RunOptions& o) {
  const Bounds& b = d.bounds;
  const auto finite = [](double v) { return std::isfinite(v); };
  if (!finite(b.xmin) || !finite(b.ymin) || !finite(b.xmax) || !finite(b.ymax) || !(b.xmin < b.xmax) ||
      !(b.ymin < b.ymax)) {
    return "bounds must be finite with xmin < xmax and ymin < ymax";
  }
  if (std::fmax(b.xmax - b.xmin, b.ymax - b.ymin) > 1e12) return "bounds must span at most 1e12 m";
  if (std::fmax(b.xmax - b.xmin, b.ymax - b.ymin) < 1e-9) return "bounds must span at least 1e-9 m";
  if (!finite(d.gravity.x) || !finite(d.gravity.y)) return "gravity must be finite";
  if (!(d.dt > 0 && d.dt <= 10)) return "dt must be above 0 and at most 10 s";
  if (d.substeps < 1 || d.substeps > 64) return "substeps must be 1 to 64";
  if (!(d.linear_damping >= 0 && finite(d.linear_damping))) {
    return "linear damping must be 0 or more, and finite";
  }
  if (!(d.restitution_threshold >= 0 && finite(d.restitution_threshold))) {
    return "restitution threshold must be 0 or more, and finite";
  }
  if (!is_skin(d.skin)) return "skin must be 0.25 to 4";
  if (!(d.wall.restitution >= 0 && d.wall.restitution <= 1)) return "wall restitution must be 0 to 1";
  if (!(d.wall.friction >= 0 && d.wall.friction <= 1000)) return "wall friction must be 0 to 1000";
  for (const Field& f : d.fields) {
    if (const auto* w = std::get_if<WellField>(&f)) {
      if (!finite(w->position.x) || !finite(w->position.y) || !finite(w->strength) ||
          !(w->softening >= 0 && finite(w->softening)) || !(w->range >= 0 && finite(w->range))) {
        return "a well needs a finite position and strength, softening and range 0 or more";
      }
      if (!(w->exponent >= 0 && w->exponent <= 16)) return "a well's exponent must be 0 to 16";
    } else {
      const auto& drag = std::get<DragField>(f);
      if (!(drag.linear >= 0 && finite(drag.linear)) || !(drag.quadratic >= 0 && finite(drag.quadratic))) {
        return "drag coefficients must be 0 or more, and finite";
      }
    }
  }
  if (o.threads < 1 || o.threads > 256) return "threads must be 1 to 256";
  if (!isa_available(o.isa)) {
    return "this CPU has no " + std::string(isa_name(o.isa)) + "; the best it has is " +
           std::string(isa_name(best_isa()));
  }
  return {};
}

World::Impl::Impl(const WorldDesc& d, const RunOptions& o)
    : desc(d),
      options(o),
      kernels(kernels_of(o.isa)),
      lattice(d.bounds, d.boundary == Boundary::periodic),
      population(desc, lattice, memory),
      neighbours({memory, lattice, population.bodies, population.statics, kernels, pool}),
      contacts({memory, lattice, population.bodies, population.statics, kernels, pool}, desc.wall),
      joints(memory),
      sleep({memory, lattice, population.bodies, population.statics, kernels, pool}),
      pool(o.threads) {
  pool.set_tracer(&tracer);
  const Lattice edges(d.bounds, false);  // walls never wrap
  walls.low = edges.to_lattice({d.bounds.xmin, d.bounds.ymin});
  walls.high = edges.to_lattice({d.bounds.xmax, d.bounds.ymax});
  Traits& traits = population.traits;
  traits.walls = d.boundary == Boundary::walls;
  traits.wall_bounce = d.wall.restitution > 0;
  traits.wall_rough = d.wall.friction > 0;
  traits.gravity = d.gravity.x != 0 || d.gravity.y != 0;
  traits.fields = needs_forces(d.fields);
  traits.integrator = d.integrator;
  traits.sleeping = d.sleeping;
  traits.damping = d.linear_damping > 0 || linear_drag(d.fields) > 0;
}

std::unique_ptr<World> World::create(const WorldDesc& desc, const RunOptions& options, std::string& error) {
  error = check(desc, options);
  if (!error.empty()) return nullptr;
  return std::unique_ptr<World>(new World(std::make_unique<Impl>(desc, options)));
}

World::World(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
World::~World() = default;

void World::prepare() { impl_->prepare(); }
StepReport World::step() { return impl_->step(impl_->desc.dt); }
StepReport World::step(double dt) { return impl_->step(dt); }

bool World::set_governor(const GovernorDesc& desc) {
  if (!Governor::sound(desc)) return false;
  impl_->settled().governor.set(desc);
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

bool World::set_skin(double factor) {
  Impl& w = *impl_;
  if (!is_skin(factor)) return false;
  if (factor == w.desc.skin) return true;
  w.settled().spoil_lists();
  w.desc.skin = factor;
  return true;
}

bool World::set_gravity(Vec2 gravity) {
  Impl& w = *impl_;
  if (!std::isfinite(gravity.x) || !std::isfinite(gravity.y)) return false;
  if (gravity.x == w.desc.gravity.x && gravity.y == w.desc.gravity.y) return true;
  w.settled();
  if (!w.step_work.untouched()) w.spoil_lists();  // they were made for the old gravity
  w.desc.gravity = gravity;
  w.population.traits.gravity = gravity.x != 0 || gravity.y != 0;
  w.dynamics.forces.reset();
  w.plan_stale = w.dynamics.forces_stale = true;
  w.note_sleep(w.sleep.wake_all(w.sleep_source()));
  return true;
}

void World::set_sleeping(bool on) {
  Impl& w = *impl_;
  if (on == w.desc.sleeping) return;
  w.settled();
  w.desc.sleeping = w.population.traits.sleeping = on;
  w.plan_stale = true;
  if (!on) w.note_sleep(w.sleep.wake_all(w.sleep_source()));
}

std::size_t World::body_count() const { return impl_->population.bodies.living(); }
std::size_t World::dynamic_count() const { return impl_->population.traits.moving; }
std::size_t World::shape_count() const { return impl_->population.traits.cornered; }
std::size_t World::static_count() const { return impl_->population.fixed.size(); }
std::uint64_t World::frame() const { return impl_->frame; }
std::uint64_t World::escaped_total() const { return impl_->quarantine.escaped; }
const WorldDesc& World::desc() const { return impl_->desc; }
Isa World::isa() const { return impl_->options.isa; }
int World::threads() const { return impl_->options.threads; }
LaneCounts World::lane_counts() const { return impl_->ledger.lanes; }

std::vector<std::pair<std::string, std::uint64_t>> World::skipped() const {
  std::vector<std::pair<std::string, std::uint64_t>> out;
  for (std::size_t i = 0; i < kSkipNames.size(); ++i) {
    const std::uint64_t steps = impl_->ledger.skipped_steps()[i];
    if (steps != 0) out.emplace_back(std::string(kSkipNames[i]), steps);
  }
  return out;
}

void World::enable_snapshots(bool on) {
  impl_->settled().population.traits.snapshots = on;
  impl_->placed = true;
}

const Snapshot* World::latest_snapshot() { return impl_->observers.publisher.latest(); }

void World::set_job_system(JobSystem jobs) { impl_->pool.set_job_system(std::move(jobs)); }

void World::count_lane_use() {
  if (impl_->options.isa != Isa::scalar) impl_->ledger.survey_lanes();
}
std::vector<LaneUse> World::lane_use() const { return impl_->ledger.lane_use(); }

void World::start_trace() { impl_->tracer.start(); }
void World::stop_trace() { impl_->tracer.stop(); }
std::vector<TraceEvent> World::take_trace() { return impl_->tracer.take(); }

// The columns of a disc in a gas, with room for lists (docs/memory.md).
std::size_t estimate_memory_bytes(std::size_t discs) { return discs * 220 + (std::size_t{1} << 20); }

}  // namespace psim
