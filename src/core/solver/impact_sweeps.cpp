// Impacts: contacts with restitution whose bodies rest on nothing collide at their time within a substep, sweep after
// sweep; impacts that are left over are settled in the passes. docs/solver.md derives it.
#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <type_traits>

#include "base/elementary.h"
#include "solver/solver_run.h"

namespace psim {
namespace {

constexpr double kSlices = 20;  // a substep has so many slices for each impact of a body
constexpr int kMostSlices = 4;
constexpr int kImpactSweeps = 6;  // most in a substep without slices; usually the third finds nothing
// Factor by which the known number of sweeps fades with each substep that may not take as many as it needs.
constexpr double kForgetting = 31.0 / 32;

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
  return greater(gravity, sum / samples);
}

}  // namespace

void Solver::Run::set_sweeps() {
  sweeps_.slices = 1 + static_cast<int>(lesser(kSlices * params_.impacts, kMostSlices - 1));
  sweeps_.most = kImpactSweeps + sweeps_.slices - 1;
  sweeps_.limited = params_.most_sweeps != 0 && params_.most_sweeps < sweeps_.most;
  if (!sweeps_.limited) return;
  sweeps_.most = params_.most_sweeps;
  sweeps_.slices = std::min(sweeps_.slices, std::max(sweeps_.most / 2, 1));  // the last ones look for all that is left
}

void Solver::Run::set_floors() {
  const double pressed = pressing(s_.bodies, gravity_), threshold = params_.restitution_threshold;
  for (ContactParams* p : {&discs_.pair, &discs_.fixed, &loaded_.pair, &loaded_.fixed, &squeezed_}) {
    p->bounce_floor = static_cast<float>(greater(pressed * h_ / 2, threshold));
    p->impact_floor = static_cast<float>(greater(2 * pressed * h_, threshold));
  }
}

// Collisions at their time, sweep after sweep until one finds none. Where bodies have more than one
// a substep, the first sweeps take them slice by slice of its time.
void Solver::Run::impacts() {
  for_bodies([&](BlockRange r) {
    std::fill(view_.event_time + std::size_t{r.begin} * 8, view_.event_time + std::size_t{r.end} * 8, 0.0f);
  });
  // Relaxed, as is `last`: the next sweep is another run of the pool. A strip that sees a note of the present run looks
  // once more and finds nothing, so the result does not depend on when a note is seen.
  std::atomic<bool> any{true};
  std::vector<int>& last = solver_.last_sweep_;
  last.assign(table.strips.size(), -1);
  const auto note = [&](std::size_t strip, int sweep) {
    std::atomic_ref<int>(last[strip]).store(sweep, std::memory_order_relaxed);
    any.store(true, std::memory_order_relaxed);
  };
  // If there was no event around a strip since it was looked at, a second look would find the same.
  const auto asks = [&](std::size_t strip, int sweep) {
    return table.any_beside(strip, [&](std::size_t k) {
      return std::atomic_ref<int>(last[k]).load(std::memory_order_relaxed) + 1 >= sweep;
    });
  };
  const auto [slice_count, most, limited, done] = sweeps_;
  const auto slices = slice_count;  // lambdas of clang 14 take no structured bindings
  const auto later = static_cast<std::size_t>(slices > 1 ? kernels::Sweep::sliced : kernels::Sweep::later);
  auto kind = static_cast<std::size_t>(kernels::Sweep::first);
  const auto sweep_statics = [&](int sweep, bool all) {
    for_statics([&](const ContactBlocks& b, std::size_t strip) {
      if (!all && !asks(strip, sweep)) return;
      if (s_.kernels.sweep_static[model_][kind](view_, statics_, discs_.fixed, b.begin, b.end,
                                                &solver_.sums_[strip].virial)) {
        note(strip, sweep);
      }
    });
  };
  int sweep = 0;
  for (; sweep < most && any.load(); ++sweep) {
    any.store(false);
    if (sweep != 0) kind = later;
    // In the last sweep, what would still collide is left to the solver, unless it is elastic.
    discs_.pair.least_e = discs_.fixed.least_e = sweep + 1 == most ? 1.0f : 0.0f;
    discs_.pair.due = discs_.fixed.due =
        sweep + 1 < slices ? stream_.h * static_cast<float>(sweep + 1) / static_cast<float>(slices) : 1e30f;
    for_pairs([&](const ContactBlocks& b, std::size_t strip) {
      if (!asks(strip, sweep)) return;
      if (s_.kernels.sweep[model_][kind](view_, pairs_, discs_.pair, b.begin, b.end, &solver_.sums_[strip].virial)) {
        note(strip, sweep);
      }
    });
    sweep_statics(sweep, false);
    if (!contacts.manifolds.any()) continue;
    run_phases(table.strips.size(), s_.pool, [&](std::size_t strip) {
      if (asks(strip, sweep) && impact_shapes(strip, sweep == 0, sweep < slices)) note(strip, sweep);
    });
  }
  sweeps_.done = done + (limited && sweep == most ? std::max(kForgetting * solver_.sweeps_, 1.0 * sweep) : sweep);
  if (any.load()) {  // there were too many events: at least no body leaves through a wall
    discs_.fixed.least_e = 0;
    sweep_statics(most, true);
  }
}

void Solver::Run::spend() {
  const auto spend_blocks = [&](bool fixed, ManifoldBlock* blocks, SurfaceBlock*, std::uint32_t begin,
                                std::uint32_t end) {
    s_.kernels.spend_manifolds[fixed](view_, blocks, discs_.pair, begin, end);
  };
  once(discs_.pair, s_.kernels.spend, s_.kernels.spend_static, spend_blocks);
}

// Touches the bodies of contacts that press: who rests on something.
void Solver::touch_resting(const SolverInput& in) {
  const auto strips = static_cast<std::uint32_t>(in.table.strips.size());
  const std::uint32_t bodies = in.contacts.solved.dummies_of(strips) + 8;
  constexpr std::uint32_t kLine = 64;  // bytes: a strip marks bodies of no other strip in its own cache line
  touched_.resize(std::max<std::size_t>(touched_.size(), bodies + kLine * strips));
  std::fill(touched_.begin(), touched_.end(), std::uint8_t{0});
  // Relaxed: several strips may store the same 1, which is read after the run.
  const auto touch = [&](std::uint32_t slot) {
    std::atomic_ref<std::uint8_t>(touched_[slot]).store(1, std::memory_order_relaxed);
  };
  const auto any_presses = [](const float* impulse) {
    std::uint32_t any = 0;
    for (std::size_t l = 0; l < 8; ++l) any |= mask_from(impulse[l], kTiniest);
    return any != 0;
  };
  // Touches the bodies of all contacts that press, `sides` a contact, or else `nobody`.
  const auto touch_pressing = [&](const ContactLanes& c, const ContactBlocks& blocks, auto sides,
                                  std::uint32_t nobody) {
    const float* const impulse = c.impulse.data();
    const std::uint32_t* const body = c.body.data();
    bool any = false;
    for (std::size_t block = blocks.begin; block < blocks.end; ++block) {
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
  in.contacts.surroundings.pool.run(strips, [&](std::size_t index) {
    const Strip& s = in.table.strips[index];
    const std::uint32_t nobody = bodies + kLine * static_cast<std::uint32_t>(index);
    const bool pairs = touch_pressing(in.contacts.discs.pairs, s.blocks, kTwo, nobody);
    const bool fixed = touch_pressing(in.contacts.discs.fixed, s.static_blocks, kOne, nobody);
    bool shapes = false;
    if (in.contacts.manifolds.any()) {
      for (const std::uint32_t k : in.contacts.manifolds.strip(index).active) {
        const ManifoldPair& pair = in.contacts.manifolds.pairs()[k];
        const auto presses = [&](int p) {
          const kernels::ManifoldBlock& c = in.contacts.manifolds.strip(index).blocks[pair.lane / kernels::kBlock];
          return c.point[p].impulse[pair.lane % kernels::kBlock] > 0;
        };
        if (!presses(0) && !presses(1)) continue;
        shapes = true;
        touch(pair.b);
        if (!pair.of_piece()) touch(pair.a);
      }
    }
    pressing_[index] = pairs || fixed || shapes;
  });
}

// Marks the contacts that the impact sweeps may settle: those with restitution whose bodies both rest on nothing, and
// those that are fully elastic.
void Solver::mark_impacts(const SolverInput& in) {
  PairLanes& pairs = in.contacts.discs.pairs;
  StaticLanes& fixed = in.contacts.discs.fixed;
  touch_resting(in);
  // 0 means that it may be settled; resting is 0 or 1
  const auto mark = [](float e, std::uint32_t resting) {
    const std::uint32_t may = mask_from(e, kTiniest) & (mask_from(e, 1) | (resting - 1));
    return std::bit_cast<float>(std::bit_cast<std::uint32_t>(1.0f) & ~may);
  };
  const auto mark_lanes = [&](ContactLanes& c, const ContactBlocks& blocks, const auto& resting) {
    const std::size_t begin = std::size_t{blocks.begin} * 8, end = std::size_t{blocks.end} * 8;
    for (std::size_t k = begin; k < end; ++k) c.impact[k] = mark(c.e[k], resting(k));
  };
  in.contacts.surroundings.pool.run(in.table.strips.size(), [&](std::size_t index) {
    const Strip& s = in.table.strips[index];
    const bool any = in.table.any_beside(index, [&](std::size_t k) { return pressing_[k] != 0; });
    mark_lanes(pairs, s.blocks, [&, any](std::size_t k) -> std::uint32_t {
      return any ? touched_[pairs.body[2 * k]] | touched_[pairs.body[2 * k + 1]] : 0;
    });
    mark_lanes(fixed, s.static_blocks,
               [&, any](std::size_t k) -> std::uint32_t { return any ? touched_[fixed.body[k]] : 0; });
  });
  list_bouncing(in);
}

}  // namespace psim
