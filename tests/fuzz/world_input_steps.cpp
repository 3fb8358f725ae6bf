// Steps, what must hold after them, and settings of running worlds.
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "world_descs.h"
#include "world_promises.h"
#include "world_session.h"

namespace psim::fuzz {
namespace {

constexpr std::size_t kFewBodies = 300;

// From the last job to the first.
JobSystem job_system() {
  return {[](std::size_t count, const std::function<void(std::size_t)>& job) {
            for (std::size_t k = count; k > 0; --k) job(k - 1);
          },
          2};
}

}  // namespace

void Session::step(double dt) {
  std::vector<StepReport> reports;
  say("step %d of %g s", steps_ + 1, dt);
  const std::uint64_t frame = worlds_.front()->frame();
  const bool usual = dt == worlds_.front()->desc().dt;
  step_all(reports, [&](auto& w) { return usual ? w.step() : w.step(dt); });
  if (worlds_.front()->frame() == frame) return require(!(dt >= 1e-300 && dt <= 10), "step: a dt that is refused");
  require(dt > 0 && dt <= 10, "step: a dt that is accepted");
  stepped(reports);
}

void Session::stepped(const std::vector<StepReport>& reports) {
  ++steps_;
  const StepReport& report = reports.front();
  const std::uint64_t points =
      report.awake + report.pairs + 8 * report.contacts + 4 * joints_.size() + report.fast * (16 + segments_ / 4);
  work_ += points * worlds_.size() * static_cast<std::uint64_t>(worlds_.front()->desc().substeps);
  World& world = *worlds_.front();
  for (std::size_t k = 1; k < worlds_.size(); ++k) {
    require(worlds_[k]->state_hash() == world.state_hash(), "two variants differ");
    const std::string one = report_answer(report), other = report_answer(reports[k]);
    require(one == other, "the reports of two variants differ: " + one + " and " + other);
    if (same_events(world, *worlds_[k])) continue;
    throw Fault{"the events of two variants differ: " + events_answer(world) + " and " + events_answer(*worlds_[k])};
  }
  require(report.no_room_for != nullptr || report.awake + report.asleep == world.dynamic_count(),
          "each body is awake or asleep");
  if (talks_) say_fastest(world);
  std::vector<BodyId> gone;
  for (const BodyId id : bodies_) {
    if (!world.is_valid(id)) gone.push_back(id);
  }
  require(gone.size() == report.escaped, "escaped bodies are those that are gone");
  require(gone.empty() || open_, "bodies escaped from a closed world");
  if (!gone.empty()) bury(gone);
  // Joints that contradict each other can throw bodies out of all numbers.
  if (in_.tame && !maybe_broken_ && !jointed_) {
    require(report.quarantined == broken_.size(), "quarantined: those that were broken");
  }
  broken_.clear();
  maybe_broken_ = false;
  look(bodies_.size() < kFewBodies || steps_ % 4 == 0);
}

void Session::say_fastest(World& world) const {
  BodyState fastest;
  for (const BodyId id : bodies_) {
    const auto s = world.body(id);
    if (s && std::hypot(s->vx, s->vy) >= std::hypot(fastest.vx, fastest.vy)) fastest = *s;
  }
  say("  fastest: body %u at %g %g angle %g velocity %g %g %g", fastest.id.index, fastest.x, fastest.y, fastest.angle,
      fastest.vx, fastest.vy, fastest.omega);
}

// With many bodies the questions about all of them would take longer than the steps: they are asked if `all`.
void Session::look(bool all) {
  World& world = *worlds_.front();
  require(world.body_count() == bodies_.size(), "body_count");
  std::erase_if(joints_, [&](JointId id) { return !world.is_valid_joint(id); });
  require(world.joint_count() == joints_.size(), "joint_count");
  for (auto& w : worlds_) {
    const std::string fault = broken_promise(*w, all);
    require(fault.empty(), fault);
  }
}

void Session::replay(std::optional<double> dt) {
  StepDetail detail;
  detail.substeps = static_cast<std::uint8_t>(in_.below(in_.tame ? 9 : 256));
  detail.solves = in_.chance(128);
  detail.wakes = in_.chance(in_.tame ? 0 : 16);
  detail.pieces = static_cast<std::uint32_t>(in_.below(in_.tame ? 40 : 256));
  detail.frames = static_cast<std::uint8_t>(in_.tame ? 1 + in_.below(3) : in_.byte() % 10);
  detail.horizon = static_cast<std::uint8_t>(in_.tame ? 1 + in_.below(4) : in_.byte() % 10);
  // Of a byte that was read already: old inputs stay what they are.
  detail.sweeps = static_cast<std::uint8_t>(detail.pieces % 3 == 0 ? detail.pieces / 3 % (in_.tame ? 16 : 20) : 0);
  detail.fluid_parts = static_cast<std::uint8_t>(detail.pieces % 5 == 0 ? detail.pieces / 5 % (in_.tame ? 4 : 5) : 0);
  std::vector<StepReport> reports;
  say("step %d: substeps %d solves %d wakes %d pieces %d frames %d horizon %d sweeps %d fluid_parts %d", steps_ + 1,
      detail.substeps, detail.solves, detail.wakes, static_cast<int>(detail.pieces), detail.frames, detail.horizon,
      detail.sweeps, detail.fluid_parts);
  const std::uint64_t frame = worlds_.front()->frame();
  step_all(reports, [&](auto& w) { return dt ? w.replay(detail, *dt) : w.replay(detail); });
  const auto frames = [](int n) { return n >= 1 && n <= 8; };
  if (detail.substeps > 64 || !frames(detail.frames) || !frames(detail.horizon) || (detail.solves && detail.wakes) ||
      detail.sweeps > 15 || detail.fluid_parts > 3) {
    return require(worlds_.front()->frame() == frame, "replay: a detail that no governor chooses");
  }
  if (dt && worlds_.front()->frame() == frame) {
    return require(!(*dt >= 1e-300 && *dt <= 10), "replay: a dt that is refused");
  }
  stepped(reports);
}

void Session::govern() {
  GovernorDesc d;
  d.on = in_.chance(200);
  d.budget_ms = one_of(in_, {16.0, 0.01, 0.05, 1.0});
  if (in_.chance(60)) d.budget_ms = in_.number(0, 20);
  CostModel::Numbers costs = d.costs.numbers();
  const std::size_t which = in_.below(static_cast<std::uint32_t>(costs.size()));
  if (in_.chance(60)) costs[which] = in_.number(0, 1000);
  d.costs = CostModel(costs);
  say("governor %d budget %g cost %zu is %g", d.on, d.budget_ms, which, costs[which]);
  const bool sane = d.budget_ms > 0 && std::isfinite(costs[which]) && costs[which] >= 0;
  for (auto& w : worlds_) require(w->set_governor(d) == sane, "set_governor");
  if (sane) governor_ = d;
}

void Session::change_options() {
  const std::size_t which = in_.below(8);
  const bool on = in_.chance(128);
  const Vec2 gravity = in_.vec2(-20, 20);
  const EventOptions events{in_.chance(200),
                            in_.chance(200),
                            in_.chance(100) ? in_.number(0, 5) : 1,
                            in_.chance(200),
                            in_.chance(200),
                            in_.chance(100),
                            on};
  const BodyId id = some_body();
  say("option %zu: %d, gravity %g %g, body %u", which, on, gravity.x, gravity.y, id.index);
  switch (which) {
    case 0: {
      const bool sound = limits::kGravity.contains(gravity);
      return require(change<bool>("set_gravity", [&](auto& w) { return w.set_gravity(gravity); }) == sound,
                     "set_gravity");
    }
    case 1:
      change<bool>("set_sleeping", [&](auto& w) { return w.set_sleeping(on), true; });
      return;
    case 2:
      return require(change<bool>("wake", [&](auto& w) { return w.wake(id); }) == is_live(id), "wake");
    case 5: {
      const bool sane = gravity.x >= 0.25 && gravity.x <= 4;
      require(change<bool>("set_skin", [&](auto& w) { return w.set_skin(gravity.x); }) == sane, "set_skin");
      break;
    }
    default:
      break;
  }
  for (auto& world : worlds_) {
    World& w = *world;
    switch (which) {
      case 3:
        require(w.why_awake(id).find('\n') == std::string::npos, "why_awake: one line");
        break;
      case 4:
        w.set_event_options(events);
        break;
      case 5:
        w.enable_snapshots(snapshots_ = on);
        break;
      case 6:
        if (world == worlds_.front()) w.set_job_system(on ? job_system() : JobSystem{});
        break;
      default:
        if (world == worlds_.front()) on ? w.start_trace() : void(w.take_trace());
    }
  }
}

}  // namespace psim::fuzz
