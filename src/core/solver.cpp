#include "solver.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>

#include "tasks.h"

namespace psim {
namespace {

using kernels::ContactParams;
using kernels::StreamParams;
using Clock = std::chrono::steady_clock;

// Contact stiffness: frequency kStiffness / h, damping ratio kDamping. The highest at which one
// solve pass a substep stays quiet in deep piles (docs/decisions/003-contact-scheme.md).
constexpr double kStiffness = 0.2;
constexpr double kDamping = 10;
constexpr double kFixedStiffness = 2;  // contacts with fixed shapes, times stiffer
// Under heavy loads: stiffer, and as many more sweeps a pass as that needs to converge.
constexpr double kLoadedStiffness = 0.9;
constexpr int kLoadedSweeps = 16;
constexpr double kPush = 3;            // m/s, fastest push-out
constexpr double kSlices = 20;         // slices of a substep for each impact that a body has in it
constexpr int kMostSlices = 4;
constexpr int kSweeps = 6;             // impact sweeps a substep at most; usually the third is idle

void set_soft(ContactParams& p, double h, double frequency) {
  constexpr double kPi = 3.14159265358979323846;
  const double omega = 2 * kPi * frequency;
  const double a1 = 2 * kDamping + h * omega;
  const double a2 = h * omega * a1;
  const double a3 = 1 / (1 + a2);
  p.soft_rate = static_cast<float>(a2 * a3 * omega / a1);
  p.soft_mass = static_cast<float>(a2 * a3);
  p.soft_impulse = static_cast<float>(a3);
}

}  // namespace

// Even strips, then odd ones, then the large bodies' group: no two jobs of a phase share a body.
template <class Each>
void Solver::for_pairs(const PairTable& table, WorkerPool& pool, const Each& each) {
  const std::size_t strips = table.strips.size() - 1;
  for (std::size_t parity = 0; parity < 2; ++parity) {
    pool.run((strips + 1 - parity) / 2, [&](std::size_t k) {
      const Strip& s = table.strips[2 * k + parity];
      if (s.block_begin != s.block_end) each(2 * k + parity, s);
    });
  }
  const Strip& large = table.strips.back();
  if (large.block_begin != large.block_end) each(strips, large);
}

// Contacts with fixed shapes have the last word of every pass.
template <class Each>
void Solver::for_singles(const PairTable& table, WorkerPool& pool, const Each& each) {
  pool.run(table.strips.size(), [&](std::size_t k) {
    const Strip& s = table.strips[k];
    if (s.single_begin != s.single_end) each(k, s);
  });
}

// Strips with contacts under heavy loads: even ones, odd ones, the large bodies' group.
void Solver::find_loaded(const PairTable& table) {
  loaded_.clear();
  const std::size_t strips = table.strips.size() - 1;
  for (std::size_t parity = 0; parity < 2; ++parity) {
    for (std::size_t k = parity; k < strips; k += 2) {
      if (table.strips[k].loaded) loaded_.push_back(static_cast<std::uint32_t>(k));
    }
    (parity == 0 ? loaded_odd_ : loaded_large_) = loaded_.size();
  }
  if (table.strips[strips].loaded) loaded_.push_back(static_cast<std::uint32_t>(strips));
}

// One sweep over contacts under heavy loads: pairs as in for_pairs, then singles.
template <class Pairs, class Singles>
void Solver::for_loaded(const PairTable& table, WorkerPool& pool, const Pairs& pairs,
                        const Singles& singles) {
  const auto run = [&](std::size_t begin, std::size_t end, const auto& each) {
    pool.run(end - begin, [&](std::size_t k) { each(table.strips[loaded_[begin + k]]); });
  };
  run(0, loaded_odd_, pairs);
  run(loaded_odd_, loaded_large_, pairs);
  run(loaded_large_, loaded_.size(), pairs);
  run(0, loaded_.size(), singles);
}

// Which contacts the impact sweeps may settle: with restitution, and none of the bodies resting on
// something (or fully elastic).
void Solver::mark_impacts(const SolverBodies& b, PairTable& table, ContactStore& c, WorkerPool& pool) {
  touched_.resize(std::max<std::size_t>(touched_.size(),
                                        b.dummies() + 2 * table.strips.size() + 8));
  std::fill(touched_.begin(), touched_.end(), std::uint8_t{0});
  const auto touch = [&](std::uint32_t slot) {
    std::atomic_ref<std::uint8_t>(touched_[slot]).store(1, std::memory_order_relaxed);
  };
  pool.run(table.strips.size(), [&](std::size_t index) {
    const Strip& s = table.strips[index];
    for (std::size_t k = std::size_t{s.block_begin} * 8; k < std::size_t{s.block_end} * 8; ++k) {
      if (c.impulse[k] > 0) {
        touch(c.body[2 * k]);
        touch(c.body[2 * k + 1]);
      }
    }
    for (std::size_t k = std::size_t{s.single_begin} * 8; k < std::size_t{s.single_end} * 8; ++k) {
      if (c.s_impulse[k] > 0) touch(c.s_body[k]);
    }
  });
  pool.run(table.strips.size(), [&](std::size_t index) {
    const Strip& s = table.strips[index];
    for (std::size_t k = std::size_t{s.block_begin} * 8; k < std::size_t{s.block_end} * 8; ++k) {
      const bool resting = touched_[c.body[2 * k]] != 0 || touched_[c.body[2 * k + 1]] != 0;
      c.impact[k] = c.e[k] > 0 && (c.e[k] >= 1 || !resting) ? 0.0f : 1.0f;
    }
    for (std::size_t k = std::size_t{s.single_begin} * 8; k < std::size_t{s.single_end} * 8; ++k) {
      const bool resting = touched_[c.s_body[k]] != 0;
      c.s_impact[k] = c.s_e[k] > 0 && (c.s_e[k] >= 1 || !resting) ? 0.0f : 1.0f;
    }
  });
}

SolverReport Solver::run(BodyStore& b, SolverBodies& solved, PairTable& table, ContactStore& contacts,
                         const SolverParams& params, Forces* forces,
                         const std::vector<std::pair<std::uint32_t, Vec2>>& held,
                         const kernels::KernelTable& k, WorkerPool& pool) {
  const double h = params.dt / params.substeps;
  const double g = std::sqrt(params.gravity.x * params.gravity.x +
                             params.gravity.y * params.gravity.y);
  StreamParams stream;
  stream.h = static_cast<float>(h);
  stream.damp = static_cast<float>(std::exp(-params.damping * h));
  stream.damp_rest =
      static_cast<float>(std::exp(-params.damping * h) - static_cast<double>(stream.damp));
  // With damping c: dv = g (1 - exp(-ch))/c, and the drift covers (1 - exp(-ch))/c at the velocity
  // before damping, which v0 has already lost.
  const double c = params.damping;
  const double span = c > 0 ? -std::expm1(-c * h) / c : h;
  stream.kick_x = static_cast<float>(params.gravity.x * span);
  stream.kick_y = static_cast<float>(params.gravity.y * span);
  stream.coast = static_cast<float>(span);
  StreamParams drift = stream;
  drift.h = static_cast<float>(c > 0 ? span / std::exp(-c * h) : h);
  drift.smooth_limit2 = forces ? 0.0f : static_cast<float>(4 * g * g * h * h);
  ContactParams pairs;
  pairs.h = stream.h;
  pairs.inv_h = static_cast<float>(1 / h);
  pairs.pitch_x = static_cast<float>(params.pitch_x);
  pairs.pitch_y = static_cast<float>(params.pitch_y);
  pairs.push = static_cast<float>(kPush);
  pairs.refresh = params.refresh;
  pairs.warm = params.warm;
  pairs.gravity_x = static_cast<float>(params.gravity.x);
  pairs.gravity_y = static_cast<float>(params.gravity.y);
  pairs.bounce_floor = static_cast<float>(std::fmax(g * h / 2, params.restitution_threshold));
  pairs.impact_floor = static_cast<float>(std::fmax(2 * g * h, params.restitution_threshold));
  ContactParams singles = pairs;
  set_soft(pairs, h, kStiffness / params.stiff_substep);
  set_soft(singles, h, kFixedStiffness * kStiffness / params.stiff_substep);
  ContactParams loaded = pairs, loaded_singles = singles;
  set_soft(loaded, h, kLoadedStiffness / params.stiff_substep);
  set_soft(loaded_singles, h, kFixedStiffness * kLoadedStiffness / params.stiff_substep);
  find_loaded(table);
  const int loaded_sweeps = loaded_.empty() ? 0 : kLoadedSweeps;

  const auto model = static_cast<std::size_t>(params.model.model);
  const std::size_t bounce = params.model.bounce ? 1 : 0;
  const bool rough = params.model.model == kernels::Model::rough;
  const std::uint32_t blocks = solved.blocks();
  const std::size_t tasks = stream_tasks(blocks);
  const kernels::ContactView cv = contacts.pairs();
  const kernels::SingleView sv = contacts.singles();
  const kernels::BodyView view = solved.view(b);
  const bool varying = forces != nullptr && forces->varying();
  const kernels::FieldParams field = forces ? forces->params(h) : kernels::FieldParams{};
  const bool drag = field.quadratic != 0;
  // The kick of another integrator than leapfrog, if the world asks for one.
  const auto advance =
      varying && forces->method()
          ? k.advance[static_cast<std::size_t>(*forces->method())][drag || field.linear != 0]
          : nullptr;
  Clock::duration forces_time{};
  const auto streams = [&](auto&& each) {
    pool.run(tasks, [&](std::size_t t) {
      const BlockRange r = stream_range(t, blocks);
      each(r.begin, r.end);
    });
  };
  if (!held.empty()) b.find_slots();
  held_at_.resize(std::max(held_at_.size(), 2 * held.size()));
  virial_.assign(table.strips.size(), 0.0);
  closed_by_strip_.assign(table.strips.size(), 0);
  // Where bodies have more than one impact a substep, sweeps take them slice by slice of its time.
  const int slices = 1 + static_cast<int>(std::fmin(kSlices * params.impacts, kMostSlices - 1));
  if (bounce) mark_impacts(solved, table, contacts, pool);

  for (int substep = 0; substep < params.substeps; ++substep) {
    const bool first = substep == 0 || varying;
    const auto force = [&](const auto kernel) {
      const Clock::time_point start = Clock::now();
      streams([&](std::uint32_t begin, std::uint32_t end) { kernel(view, field, begin, end); });
      forces_time += Clock::now() - start;
    };
    if (varying && (!advance || bounce)) force(k.accelerate[drag]);
    if (bounce) {
      streams([&](std::uint32_t begin, std::uint32_t end) {
        std::fill(view.event_time + std::size_t{begin} * 8, view.event_time + std::size_t{end} * 8,
                  0.0f);
      });
      const auto sweep_singles = [&](std::atomic<bool>& any) {
        for_singles(table, pool, [&](std::size_t strip, const Strip& s) {
          if (k.sweep_single[model](view, sv, singles, s.single_begin, s.single_end,
                                    &virial_[strip])) {
            any.store(true, std::memory_order_relaxed);
          }
        });
      };
      std::atomic<bool> any{true};
      const int sweeps = kSweeps + slices - 1;
      for (int sweep = 0; sweep < sweeps && any.load(); ++sweep) {
        any.store(false);
        pairs.first_sweep = singles.first_sweep = sweep == 0;
        pairs.last_sweep = singles.last_sweep = sweep + 1 == sweeps;
        pairs.due = singles.due =
            sweep + 1 < slices ? stream.h * static_cast<float>(sweep + 1) / static_cast<float>(slices) : 1e30f;
        for_pairs(table, pool, [&](std::size_t strip, const Strip& s) {
          if (k.sweep[model](view, cv, pairs, s.block_begin, s.block_end, &virial_[strip])) {
            any.store(true, std::memory_order_relaxed);
          }
        });
        sweep_singles(any);
      }
      if (any.load()) {  // too many events: at least nobody leaves through a wall
        singles.last_sweep = false;
        sweep_singles(any);
      }
    }
    if (advance) force(advance);
    streams([&](std::uint32_t begin, std::uint32_t end) {
      if (!advance) (first ? k.kick_first : k.kick_again)(view, stream, begin, end);
      if (!rough) return;
      for (std::size_t i = std::size_t{begin} * 8; i < std::size_t{end} * 8; ++i) {
        const float u = view.spin[i];
        view.spin[i] = first ? u : u + (u - view.spin0[i]);
        view.spin0[i] = u;
      }
    });
    for (std::size_t n = 0; n < held.size(); ++n) {
      const std::size_t i = b.info[held[n].first].slot;
      b.vel[2 * i] = b.vel0[2 * i] = static_cast<float>(held[n].second.x);
      b.vel[2 * i + 1] = b.vel0[2 * i + 1] = static_cast<float>(held[n].second.y);
      held_at_[2 * n] = b.disp[2 * i];
      held_at_[2 * n + 1] = b.disp[2 * i + 1];
    }
    if (first) {
      ContactParams warm_pairs = pairs, warm_singles = singles;
      if (substep > 0) warm_pairs.warm = warm_singles.warm = 1;
      for_pairs(table, pool, [&](std::size_t, const Strip& s) {
        k.warm[model](view, cv, warm_pairs, s.block_begin, s.block_end);
      });
      for_singles(table, pool, [&](std::size_t, const Strip& s) {
        k.warm_single[model](view, sv, warm_singles, s.single_begin, s.single_end);
      });
    }
    for_pairs(table, pool, [&](std::size_t, const Strip& s) {
      k.solve[model][bounce](view, cv, pairs, s.block_begin, s.loaded_begin);
    });
    for (int sweep = 0; sweep < loaded_sweeps; ++sweep) {
      loaded.again = loaded_singles.again = sweep != 0;
      for_loaded(
          table, pool,
          [&](const Strip& s) {
            k.solve[model][bounce](view, cv, loaded, s.loaded_begin, s.block_end);
          },
          [&](const Strip& s) {
            k.solve_single[model][bounce](view, sv, loaded_singles, s.single_loaded_begin, s.single_end);
          });
    }
    for_singles(table, pool, [&](std::size_t, const Strip& s) {
      k.solve_single[model][bounce](view, sv, singles, s.single_begin, s.single_loaded_begin);
    });
    streams([&](std::uint32_t begin, std::uint32_t end) {
      if (advance) {
        k.drift_bent(view, field, begin, end);
      } else {
        k.drift(view, drift, begin, end);
      }
      if (b.spin.empty()) return;
      for (std::uint32_t n = begin * 8; n < std::min(end * 8, solved.count()); ++n) {
        if (view.linked[n] == 0) continue;
        const std::size_t i = solved.slot(n);
        b.angle[i] += h * (static_cast<double>(view.spin[n]) / static_cast<double>(b.radius[i]));
      }
    });
    for (std::size_t n = 0; n < held.size(); ++n) {  // they go straight on: nothing damps them
      const std::size_t i = b.info[held[n].first].slot;
      b.clear_rests(i);
      b.disp[2 * i] = held_at_[2 * n] + stream.h * b.vel[2 * i];
      b.disp[2 * i + 1] = held_at_[2 * n + 1] + stream.h * b.vel[2 * i + 1];
    }
    for_pairs(table, pool, [&](std::size_t, const Strip& s) {
      k.relax[model][bounce](view, cv, pairs, s.block_begin, s.loaded_begin);
    });
    for (int sweep = 0; sweep < loaded_sweeps; ++sweep) {
      loaded.more = loaded_singles.more = sweep + 1 != loaded_sweeps;
      for_loaded(
          table, pool,
          [&](const Strip& s) {
            k.relax[model][bounce](view, cv, loaded, s.loaded_begin, s.block_end);
          },
          [&](const Strip& s) {
            k.relax_single[model][bounce](view, sv, loaded_singles, s.single_loaded_begin, s.single_end);
          });
    }
    for_singles(table, pool, [&](std::size_t, const Strip& s) {
      k.relax_single[model][bounce](view, sv, singles, s.single_begin, s.single_loaded_begin);
    });
    if (bounce) {
      for_pairs(table, pool, [&](std::size_t, const Strip& s) {
        k.spend[model](view, cv, pairs, s.block_begin, s.block_end);
      });
      for_singles(table, pool, [&](std::size_t, const Strip& s) {
        k.spend_single[model](view, sv, singles, s.single_begin, s.single_end);
      });
    }
  }
  solved.store(b, pool);
  // Solver impulses are those of the last substep; a step has that many of them.
  pool.run(table.strips.size(), [&](std::size_t index) {
    const Strip& s = table.strips[index];
    double sum = 0;
    std::uint64_t closed = 0;
    for (std::size_t l = std::size_t{s.block_begin} * 8; l < std::size_t{s.block_end} * 8; ++l) {
      closed += std::signbit(contacts.impulse[l]) ? 0 : 1;  // -0 marks an open contact
      if (contacts.impulse[l] > 0) {
        sum += static_cast<double>(contacts.impulse[l]) * static_cast<double>(contacts.rsum[l]);
      }
    }
    for (std::size_t l = std::size_t{s.single_begin} * 8; l < std::size_t{s.single_end} * 8; ++l) {
      closed += std::signbit(contacts.s_impulse[l]) ? 0 : 1;
      if (contacts.s_impulse[l] > 0 && contacts.s_refresh[l] < 1e30f) {  // round ones
        sum += static_cast<double>(contacts.s_impulse[l]) * static_cast<double>(contacts.s_rsum[l]);
      }
    }
    virial_[index] += sum * params.substeps;
    closed_by_strip_[index] = closed;
  });
  SolverReport report;
  report.forces_ms = std::chrono::duration<double, std::milli>(forces_time).count();
  closed_ = 0;
  for (std::size_t s = 0; s < virial_.size(); ++s) {
    report.virial += virial_[s];
    closed_ += closed_by_strip_[s];
  }
  return report;
}

}  // namespace psim
