// Recordings of what happens, calls under a budget of memory, and what a world counts. Only rich inputs come here.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "world_descs.h"
#include "world_session.h"

namespace psim::fuzz {
namespace {

std::vector<BodyState> states_of(const World& w, const std::vector<BodyId>& bodies) {
  std::vector<BodyState> states;
  for (const BodyId id : bodies) states.push_back(w.body(id).value_or(BodyState{}));
  return states;
}

bool same_state(const BodyState& s, const BodyState& t) {
  const auto same = [](double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); };
  return s.id == t.id && same(s.x, t.x) && same(s.y, t.y) && same(s.angle, t.angle) && same(s.vx, t.vx) &&
         same(s.vy, t.vy) && same(s.omega, t.omega);
}

}  // namespace

void Session::start_recording() {
  end_recording();
  if (restores_) return;  // a world that is restored past its recorder is another one
  say("%s", "record");
  recorder_ = std::make_unique<Recorder>(*worlds_.back(), 1 + in_.below(20));
}

// The recording, replayed on another ISA, must end in the same state.
void Session::end_recording() {
  if (!recorder_) return;
  const std::vector<std::byte> recording = recorder_->recording();
  recorder_.reset();
  say("replay a recording of %zu bytes", recording.size());
  std::string error;
  const auto replay = Replay::open(recording, {isa_available(Isa::sse) ? Isa::sse : Isa::scalar, 1}, error);
  require(replay != nullptr, "Replay::open: the recording just made: " + error);
  while (replay->next()) {
  }
  require(replay->differs_at() == 0, "a replay differs at step " + std::to_string(replay->differs_at()));
  require(replay->complete() && replay->steps() == replay->steps_in_all(), "a replay ends early");
  require(replay->hashes() > 0, "a replay compared nothing");
  require(replay->world().state_hash() == worlds_.back()->state_hash(), "a replay ends in another state");
}

// With only a little more memory than the world has, a call does what it does elsewhere or changes nothing.
void Session::starve() {
  if (worlds_.size() > 1) return;  // worlds of other ISAs need other amounts
  end_recording();
  World& w = *worlds_.front();
  const std::size_t spare = 64 * in_.below_wide(2000), which = in_.below(3), count = 1 + in_.below_wide(2000);
  say("%zu spare bytes, call %zu", spare, which);
  const std::uint64_t frame = w.frame();
  const std::vector<BodyState> before = states_of(w, bodies_);
  std::string error;
  out_of_memory();
  w.set_max_bytes(w.memory_bytes() + spare);
  StepReport report;
  bool done = true;
  if (which == 0) {
    ++steps_;
    report = w.step();
    done = w.frame() != frame;
    require(done || report.no_room_for != nullptr, "a step without memory: no reason");
    over_ = report.no_room_for != nullptr && std::string_view(report.no_room_for) == "motion";
  } else if (which == 1) {
    // All in one place: each is near each other, and so many make half a million pairs.
    constexpr std::size_t kMostInOnePlace = 1000;
    const std::size_t n = std::min({count, kMostInOnePlace, most_bodies_ - std::min(most_bodies_, bodies_.size())});
    const std::vector<double> x(n, in_.home.x), y(n, in_.home.y), radius{0.2};
    DiscBatch batch;
    batch.x = x;
    batch.y = y;
    batch.radius = radius;
    std::uint32_t first = 0;
    done = w.add_discs(batch, first, error) == n;
    require(done == error.empty(), "add_discs without memory: " + error);
  } else if (bodies_.size() < most_bodies_) {
    done = w.add_body(body(in_), error) != kNoBody;
    require(done == error.empty(), "add_body without memory: " + error);
  }
  w.set_max_bytes(0);
  if (over_) return;
  if (!done) {
    // The hash may differ: a first step makes the columns of angles. What was given NaN is quarantined.
    require(report.quarantined != 0 || std::ranges::equal(states_of(w, bodies_), before, same_state),
            "a call without memory changed a body");
    require(w.body_count() == bodies_.size(), "a call without memory changed the number of bodies");
  } else if (which == 0) {
    stepped({report});
  }
  const PublishedState s = w.published();
  for (const std::uint32_t index : s.id) live(w.id_of(index));
}

void Session::count() {
  const BodyId id = some_body();
  const std::size_t which = in_.below(6), n = in_.below_wide(65536);
  say("count %zu", which);
  for (auto& world : worlds_) {
    World& w = *world;
    switch (which) {
      case 0:
        w.count_lane_use();
        break;
      case 1:
        for (const LaneUse& use : w.lane_use()) require(use.used <= use.lanes, "lane_use: more used than there are");
        require(w.isa() != Isa::scalar || w.lane_counts().vector == 0, "lane_counts: vectors on Isa::scalar");
        break;
      case 2:
        for (const auto& [stage, frames] : w.skipped()) {
          require(!stage.empty() && frames <= static_cast<std::uint64_t>(steps_),
                  "skipped: " + stage + " in " + std::to_string(frames) + " of " + std::to_string(steps_) + " steps");
        }
        break;
      case 3:
        w.stop_trace();
        for (const TraceEvent& e : w.take_trace()) require(e.begin_ns <= e.end_ns, "trace: ends before it begins");
        break;
      case 4:
        require(!w.is_awake(id) || is_live(id), "is_awake: a body that is not there");
        require(w.shape_count() <= w.dynamic_count(), "shape_count: more than moving bodies");
        require(w.threads() >= 1, "threads");
        require(w.escaped_total() == 0 || open_, "escaped_total: of a closed world");
        break;
      default:
        require(estimate_memory_bytes(n) <= estimate_memory_bytes(n + 1), "estimate_memory_bytes: falls");
    }
  }
  if (which == 5 && n % 64 == 0) {  // takes as long as many steps
    for (const double cost : World::measure_costs({best_isa(), 1}, 1).numbers()) {
      require(std::isfinite(cost) && cost >= 0, "measure_costs: no cost");
    }
  }
}

}  // namespace psim::fuzz
