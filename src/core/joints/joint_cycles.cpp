// Cycles of swept joints (docs/joints.md, "Cycles"). Under a large load a link swings faster across its line than a
// substep resolves, and sweeps then leave it stretched. So the joints go through the substep in shorter steps, with the
// passes of a substep in each, and the drift leads to where the last one ends.
#include "joints/joint_cycles.h"

#include <algorithm>
#include <cmath>

#include "base/tasks.h"
#include "joints/joint_store.h"
#include "least.h"

namespace psim {

using kernels::kBlock;

namespace {

// h^2 T w / L of a link of length L with the tension T and inverse masses w: the square of the angle by which it swings
// on in h. Above kMostSwing there are cycles, and as many that kFineSwing is left.
constexpr double kMostSwing = 0.1, kFineSwing = 0.04;
constexpr std::uint32_t kMostInCycles = 32768;  // of joints in all cycles of a substep, as long as there are two
constexpr std::size_t kBodiesOfJob = 512;       // bodies of a job
constexpr std::size_t kBlocksOfJob = 64;        // blocks of a job

}  // namespace

void JointCycles::make_room(std::size_t bodies) {
  blocks = static_cast<std::uint32_t>((bodies + kBlock - 1) / kBlock);
  const std::size_t all = std::size_t{blocks + 1} * kBlock;
  for (Column<float>* c : {&vel, &vel0, &disp, &acc, &start, &after, &arm_change}) {
    c->reserve(2 * all);
    std::fill_n(c->data(), 2 * all, 0.0f);
  }
  for (Column<float>* c : {&rim_speed, &rim_speed0}) {
    c->reserve(all);
    std::fill_n(c->data(), all, 0.0f);
  }
  linked.reserve(all);
  std::fill_n(linked.data(), all, std::uint8_t{0xFF});
}

// The largest T w / L of a rod or tether, 1/s^2, by the impulses of the last step.
double JointStore::largest_load() const {
  double most = 0;
  for (const bool held : {false, true}) {
    const auto& rods = lists_.rods(held);
    std::vector<double> of_job((rods.size() + kBlocksOfJob - 1) / kBlocksOfJob);
    run_each(rods.size(), kBlocksOfJob, s_.pool, [&](std::size_t n, std::size_t job) {
      const kernels::LineBlock& b = rods[n];
      for (std::uint32_t k = 0; k < kBlock; ++k) {
        const double length = static_cast<double>(b.far0[k]) - static_cast<double>(b.c0[k]);
        const double load = std::fabs(static_cast<double>(b.l[k])) * static_cast<double>(b.wa[k] + b.wb[k]);
        if (length > 0 && load > of_job[job] * length) of_job[job] = load / length;
      }
    });
    for (const double load : of_job) most = std::max(most, load);
  }
  return most * cycles_.count / h_;
}

// Whether the swept joints are rods, ropes and springs between centres of bodies: no body turns with such a joint.
bool JointStore::swept_at_centres() const {
  if (linkages_.count() != 0) return false;
  for (std::uint32_t list = 0; list < kLists; ++list) {
    const bool line = list < JointLists::list_of(kernels::JointKind::pin, false);
    if (!line && blocks_of(list) != 0) return false;
    for (std::size_t lane = 0; line && lane < lanes_[list].size(); ++lane) {
      if (lanes_[list][lane] == kNoSlot) continue;
      const Ends& ends = ends_[list][lane];
      for (const std::uint32_t side : {0u, 1u}) {
        const JointMember& m = members_[ends.body[side]];
        const Vec2 arm = ends.anchor[side] - m.centre;
        if (!m.rests && (arm.x != 0 || arm.y != 0)) return false;
      }
    }
  }
  return true;
}

// How many cycles a substep of h seconds takes. `fresh`: the blocks are new and know no loads.
std::uint32_t JointStore::cycles_needed(double h, bool fresh) const {
  if (!(h_ > 0)) return 1;
  if (fresh) return cycles_.on() && swept_at_centres() ? cycles_.count : 1;
  const double turn = h * h * largest_load();
  if (!(turn > kMostSwing) || !swept_at_centres()) return 1;
  std::uint32_t n = 2;
  while (n < JointCycles::kMost && n * n * kFineSwing < turn && (n + 2) * work_blocks() <= kMostInCycles) n += 2;
  return n;
}

// Decides on the cycles of a step, and which numbers the sweeps use for the bodies.
void JointStore::set_cycles(double h, bool fresh, const SolverBodies& solved) {
  const std::uint32_t now = cycles_needed(h, fresh);
  cycles_.scale = static_cast<float>(cycles_.count) / static_cast<float>(now);
  cycles_.count = now;
  if (cycles_.on()) cycles_.make_room(members_.size());
  const std::uint32_t resting = cycles_.blocks * kBlock;
  for (std::size_t n = 0; n < members_.size(); ++n) {
    JointMember& m = members_[n];
    m.swept = !cycles_.on() ? m.number : m.number < solved.dummies() ? static_cast<std::uint32_t>(n) : resting;
  }
}

// Copies bodies into the columns of the cycles. Each cycle gets its share of what gravity and contacts did.
void JointStore::begin_cycles(const kernels::BodyView& view) {
  const float share = 1 / static_cast<float>(cycles_.count);
  run_each(members_.size(), kBodiesOfJob, s_.pool, [&](std::size_t n, std::size_t) {
    const JointMember& m = members_[n];
    if (m.rests) return;
    for (std::size_t to = 2 * n, from = 2 * std::size_t{m.number}; to < 2 * n + 2; ++to, ++from) {
      const float kick = kernels::snapped((view.vel[from] - view.vel0[from]) * share);
      cycles_.vel0.data()[to] = view.vel0[from];
      cycles_.vel.data()[to] = view.vel0[from] + kick;
      cycles_.start.data()[to] = cycles_.disp.data()[to] = view.disp[from];
      if (view.acc != nullptr) cycles_.acc.data()[to] = view.acc[from];
    }
  });
}

// One cycle: a substep of the joints alone.
void JointStore::cycle(const kernels::BodyView& view, const kernels::StreamParams& drift, bool first) {
  const auto all = [&](auto kernel) {
    run_stream(cycles_.blocks, s_.pool, [&](BlockRange r) { kernel(view, drift, r.begin, r.end); });
  };
  if (first) {
    warm_sweeps(view, cycles_.warm * cycles_.scale);
    cycles_.warm = cycles_.scale = 1;
  } else {
    all(s_.kernels.kick_again);
  }
  solve_sweeps(view);
  hold_sweeps(view, drift);
  all(s_.kernels.drift);
  let_go_sweeps(view);
  relax_sweeps(view);
}

// The drift of the substep leads to where the cycles end; what their last velocities are more is added after it. As with
// articulations, the velocity before the kick changes as well, so that the next kick repeats nothing of it.
void JointStore::end_cycles(const kernels::BodyView& view, double drift, double smooth_limit2) {
  run_each(members_.size(), kBodiesOfJob, s_.pool, [&](std::size_t n, std::size_t) {
    const JointMember& m = members_[n];
    if (m.inverse_mass == 0) return;
    const std::size_t from = 2 * std::size_t{m.number}, at = 2 * n;
    const auto record = [](const float* of, std::size_t k) {
      return Vec2{static_cast<double>(of[k]), static_cast<double>(of[k + 1])};
    };
    const Vec2 v = record(view.vel, from), kick = v - record(view.vel0, from);
    const Vec2 a = view.acc != nullptr ? record(view.acc, from) : Vec2{};
    const bool smooth = dot(kick, kick) <= smooth_limit2 + 4 * drift * drift * dot(a, a);
    const Vec2 way = record(cycles_.disp.data(), at) - record(cycles_.start.data(), at);
    const Vec2 led = (1 / drift) * way + (smooth ? 0.5 : 0.0) * kick, gain = led - v;
    const Vec2 rest = record(cycles_.vel.data(), at) - led;
    const auto add = [](float& to, double x) { to = kernels::snapped(static_cast<double>(to) + x); };
    add(view.vel[from], gain.x), add(view.vel[from + 1], gain.y);
    add(view.vel0[from], gain.x), add(view.vel0[from + 1], gain.y);
    cycles_.after.data()[at] = kernels::snapped(rest.x);
    cycles_.after.data()[at + 1] = kernels::snapped(rest.y);
  });
}

void JointStore::run_cycles(const kernels::BodyView& view, float drift, float smooth_limit2) {
  begin_cycles(view);
  const kernels::BodyView own = cycles_.view(view.acc != nullptr);
  const auto count = static_cast<float>(cycles_.count);
  kernels::StreamParams p;
  p.h = drift / count;
  p.smooth_limit2 = smooth_limit2 / (count * count);
  for (std::uint32_t k = 0; k < cycles_.count; ++k) cycle(own, p, k == 0);
  end_cycles(view, static_cast<double>(drift), static_cast<double>(smooth_limit2));
}

// After the drift.
void JointStore::leave_cycles(const kernels::BodyView& view) {
  run_each(members_.size(), kBodiesOfJob, s_.pool, [&](std::size_t n, std::size_t) {
    const JointMember& m = members_[n];
    if (m.inverse_mass == 0) return;
    for (std::size_t from = 2 * n, to = 2 * std::size_t{m.number}; from < 2 * n + 2; ++from, ++to) {
      view.vel[to] += cycles_.after.data()[from];
      view.vel0[to] += cycles_.after.data()[from];
    }
  });
}

}  // namespace psim
