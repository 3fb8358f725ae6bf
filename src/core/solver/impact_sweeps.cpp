// Impacts: contacts with restitution whose bodies rest on nothing collide at their time within a substep, sweep after
// sweep; impacts that are left over are settled in the passes. docs/solver.md derives it.
#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <type_traits>

#include "solver/solver_run.h"

namespace psim {
namespace {

constexpr double kForgetting =
    31.0 / 32;  // factor on the number of sweeps in a substep that may not take as many as it needs

// The acceleration that presses resting bodies together, m/s^2: gravity or, with fields, the mean acceleration of the
// bodies if it is larger. An approach that is slower than what it adds in a substep is no impact.
double pressing(const BodyStore& b, double gravity) {
  if (b.acc.empty() || b.count == 0) return gravity;
  const std::uint32_t stride = std::max(1u, b.count / 1024);
  double sum = 0, samples = 0;
  for (std::size_t i = 0; i < b.count; i += stride, samples += 1) {
    const double x = static_cast<double>(b.acc[2 * i]), y = static_cast<double>(b.acc[2 * i + 1]);
    sum += std::sqrt(x * x + y * y);
  }
  return std::fmax(gravity, sum / samples);
}

}  // namespace

void Solver::Run::set_floors() {
  const double pressed = pressing(bodies, gravity_);
  for (ContactParams* p : {&pair_, &static_, &loaded_pair_, &loaded_static_}) {
    p->bounce_floor = static_cast<float>(std::fmax(pressed * h_ / 2, threshold_));
    p->impact_floor = static_cast<float>(std::fmax(2 * pressed * h_, threshold_));
  }
}

// Collisions at their time, sweep after sweep until one finds none. Where bodies have more than one
// a substep, the first sweeps take them slice by slice of its time.
void Solver::Run::impacts() {
  for_bodies([&](std::uint32_t begin, std::uint32_t end) {
    std::fill(view_.event_time + std::size_t{begin} * 8, view_.event_time + std::size_t{end} * 8, 0.0f);
  });
  std::atomic<bool> any{true};
  SweepMemory& memory = solver_.sweep_memory_;
  memory.start(table.strips.size());
  const std::size_t later = static_cast<std::size_t>(slices_ > 1 ? kernels::Sweep::sliced : kernels::Sweep::later);
  std::size_t kind = static_cast<std::size_t>(kernels::Sweep::first);
  const auto sweep_statics = [&](int sweep, bool all) {
    for_statics([&](std::size_t strip, const Strip& s) {
      if (!all && !memory.asks_static(strip, sweep)) return;
      if (kernels.sweep_static[model_][kind](view_, statics_, static_, s.static_blocks.begin, s.static_blocks.end,
                                             &solver_.virial_[strip])) {
        memory.static_pair[strip] = sweep;
        any.store(true, std::memory_order_relaxed);
      }
    });
  };
  const int sweeps = impact_sweeps_;
  int sweep = 0;
  for (; sweep < sweeps && any.load(); ++sweep) {
    any.store(false);
    if (sweep != 0) kind = later;
    // In the last sweep, what would still collide is left to the solver, unless it is elastic.
    pair_.least_e = static_.least_e = sweep + 1 == sweeps ? 1.0f : 0.0f;
    pair_.due = static_.due =
        sweep + 1 < slices_ ? stream_.h * static_cast<float>(sweep + 1) / static_cast<float>(slices_) : 1e30f;
    for_pairs([&](std::size_t strip, const Strip& s) {
      if (!memory.asks_pairs(strip, sweep)) return;
      if (kernels.sweep[model_][kind](view_, pairs_, pair_, s.blocks.begin, s.blocks.end, &solver_.virial_[strip])) {
        memory.pairs[strip] = sweep;
        any.store(true, std::memory_order_relaxed);
      }
    });
    sweep_statics(sweep, false);
  }
  swept_ += limited_ && sweep == sweeps ? std::max(kForgetting * solver_.sweeps_, 1.0 * sweep) : sweep;
  if (any.load()) {  // there were too many events: at least no body leaves through a wall
    static_.least_e = 0;
    sweep_statics(sweeps, true);
  }
}

void Solver::Run::spend() {
  for_pairs(
      [&](std::size_t, const Strip& s) { kernels.spend[model_](view_, pairs_, pair_, s.blocks.begin, s.blocks.end); });
  for_all_manifolds([&](bool fixed, ManifoldBlock* blocks, std::uint32_t begin, std::uint32_t end) {
    kernels.spend_manifolds[fixed](view_, blocks, begin, end);
  });
  for_statics([&](std::size_t, const Strip& s) {
    kernels.spend_static[model_](view_, statics_, static_, s.static_blocks.begin, s.static_blocks.end);
  });
}

// Touches the bodies of contacts that press: who rests on something.
void Solver::touch_resting(const SolverInput& in) {
  const ContactStore& c = in.contacts;
  const auto strips = static_cast<std::uint32_t>(in.table.strips.size());
  const std::uint32_t bodies = in.solved.dummies() + 2 * strips + 8;
  constexpr std::uint32_t kLine = 64;  // bytes: a strip marks bodies of no other strip in its own cache line
  touched_.resize(std::max<std::size_t>(touched_.size(), bodies + kLine * strips));
  std::fill(touched_.begin(), touched_.end(), std::uint8_t{0});
  const auto touch = [&](std::uint32_t slot) {
    std::atomic_ref<std::uint8_t>(touched_[slot]).store(1, std::memory_order_relaxed);
  };
  const auto any_presses = [](const float* impulse) {
    std::uint32_t any = 0;
    for (std::size_t l = 0; l < 8; ++l) any |= mask_from(impulse[l], kTiniest);
    return any != 0;
  };
  // Touches the bodies of all contacts of blocks [begin, end) that press, `sides` a contact, or else `nobody`.
  const auto touch_pressing = [&](const float* impulse, const std::uint32_t* body, auto sides, std::uint32_t nobody,
                                  std::size_t begin, std::size_t end) {
    bool any = false;
    for (std::size_t block = begin; block < end; ++block) {
      if (!any_presses(impulse + 8 * block)) continue;
      any = true;
      for (std::size_t k = 8 * block; k < 8 * block + 8; ++k) {
        const std::uint32_t presses = mask_from(impulse[k], kTiniest);
        for (std::size_t side = 0; side < sides; ++side) {
          touch(nobody ^ ((nobody ^ body[sides * k + side]) & presses));
        }
      }
    }
    return any;
  };
  constexpr std::integral_constant<std::size_t, 1> kOne;
  constexpr std::integral_constant<std::size_t, 2> kTwo;
  pressing_.assign(strips, 0);
  in.pool.run(strips, [&](std::size_t index) {
    const Strip& s = in.table.strips[index];
    const std::uint32_t nobody = bodies + kLine * static_cast<std::uint32_t>(index);
    const bool pairs =
        touch_pressing(c.pairs.impulse.data(), c.pairs.body.data(), kTwo, nobody, s.blocks.begin, s.blocks.end);
    const bool fixed = touch_pressing(c.fixed.impulse.data(), c.fixed.body.data(), kOne, nobody, s.static_blocks.begin,
                                      s.static_blocks.end);
    pressing_[index] = pairs || fixed;
  });
}

// Marks the contacts that the impact sweeps may settle: those with restitution whose bodies both rest on nothing, and
// those that are fully elastic.
void Solver::mark_impacts(const SolverInput& in) {
  ContactStore& c = in.contacts;
  touch_resting(in);
  // 0 means that it may be settled; resting is 0 or 1
  const auto mark = [](float e, std::uint32_t resting) {
    const std::uint32_t may = mask_from(e, kTiniest) & (mask_from(e, 1) | (resting - 1));
    return std::bit_cast<float>(std::bit_cast<std::uint32_t>(1.0f) & ~may);
  };
  const auto mark_lanes = [&](float* impact, const float* e, std::size_t begin, std::size_t end, const auto& resting) {
    for (std::size_t k = 8 * begin; k < 8 * end; ++k) impact[k] = mark(e[k], resting(k));
  };
  in.pool.run(in.table.strips.size(), [&](std::size_t index) {
    const Strip& s = in.table.strips[index];
    const auto mark_both = [&](const auto& pair_rests, const auto& body_rests) {
      mark_lanes(c.pairs.impact.data(), c.pairs.e.data(), s.blocks.begin, s.blocks.end, pair_rests);
      mark_lanes(c.fixed.impact.data(), c.fixed.e.data(), s.static_blocks.begin, s.static_blocks.end, body_rests);
    };
    if (in.table.any_beside(index, [&](std::size_t k) { return pressing_[k] != 0; })) {
      mark_both(
          [&](std::size_t k) -> std::uint32_t {
            return touched_[c.pairs.body[2 * k]] | touched_[c.pairs.body[2 * k + 1]];
          },
          [&](std::size_t k) -> std::uint32_t { return touched_[c.fixed.body[k]]; });
    } else {
      const auto none = [](std::size_t) { return 0u; };
      mark_both(none, none);
    }
  });
}

}  // namespace psim
