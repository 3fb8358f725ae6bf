// What a step's substeps work on, and how a pass goes over it: strip by strip, so that no two jobs of a phase share a
// body. Only for the solver's own files.
#pragma once

#include <bit>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "solver.h"
#include "tasks.h"

namespace psim {

// All ones where x >= least > 0, else 0. Of bits, so that compilers make no branch of it: which contacts press is
// hard to guess.
inline std::uint32_t mask_from(float x, float least) {
  const auto from = std::bit_cast<std::uint32_t>(least), inf = 0x7F800000u;
  return 0u - static_cast<std::uint32_t>(std::bit_cast<std::uint32_t>(x) - from <= inf - from);
}
inline constexpr float kTiniest = std::numeric_limits<float>::min();  // x >= it: x > 0, since denormals are zero

// What a step's substeps work on, and their stages in the order of a substep.
class Solver::Run {
  using ContactParams = kernels::ContactParams;
  using StreamParams = kernels::StreamParams;
  using Clock = std::chrono::steady_clock;

 public:
  Run(Solver& solver, BodyStore& bodies, SolverBodies& solved, const PairTable& table,
      ContactStore& contacts, Manifolds& manifolds, Columns& columns, JointStore& joints,
      const SolverParams& params, const Forces* forces, const HeldBodies& held, const kernels::KernelTable& k,
      WorkerPool& pool);

  void substep(bool first_of_step);
  double swept() const { return swept_; }
  double forces_ms() const {
    return std::chrono::duration<double, std::milli>(forces_time_).count();
  }

 private:
  template <class Each>
  void for_pairs(const Each& each);
  template <class Each>
  void for_singles(const Each& each);
  template <class Pairs, class Singles>
  void for_loaded(const Pairs& pairs, const Singles& singles);
  template <class Each>
  void go_over_manifolds(bool fixed, bool loaded, const Each& each);
  template <class Each>
  [[gnu::always_inline]] void for_manifolds(bool fixed, bool loaded, const Each& each) {
    if (manifolds_.any()) go_over_manifolds(fixed, loaded, each);
  }
  template <class Each>
  void for_bodies(const Each& each);
  template <class Kernel>
  void force(Kernel kernel);

  void set_floors();
  void impacts();
  void kick(bool first);
  void hold();
  void warm(bool first_of_step);
  void solve();
  void drift();
  void carry_held();
  void relax();
  void spend();

  Solver& solver_;
  BodyStore& bodies_;
  SolverBodies& solved_;
  const PairTable& table_;
  Manifolds& manifolds_;
  Columns& columns_;
  JointStore& joints_;
  const bool joined_ = !joints_.empty();
  const HeldBodies& held_;
  const kernels::KernelTable& k_;
  WorkerPool& pool_;
  const kernels::BodyView view_;
  const kernels::ContactView pairs_;
  const kernels::SingleView singles_;

  double h_;          // s
  double gravity_;    // m/s^2
  double threshold_;  // m/s
  StreamParams stream_, drift_;
  ContactParams pair_, single_, loaded_pair_, loaded_single_;
  std::size_t model_, bounce_;
  bool rough_, turns_;
  int slices_, loaded_sweeps_, impact_sweeps_;
  bool limited_ = false;  // there may be fewer sweeps over impacts than it takes
  bool varying_;  // accelerations are taken anew in every substep
  kernels::FieldParams field_;
  void (*accelerate_)(const kernels::BodyView&, const kernels::FieldParams&, std::uint32_t,
                      std::uint32_t);
  // The kick of another integrator than leapfrog, if the world asks for one.
  void (*advance_)(const kernels::BodyView&, const kernels::FieldParams&, std::uint32_t,
                   std::uint32_t) = nullptr;
  double swept_ = 0;  // sweeps over impacts so far
  Clock::duration forces_time_{};
};

// Even strips, then odd ones, then the large bodies' group: no two jobs of a phase share a body.
template <class Each>
void Solver::Run::for_pairs(const Each& each) {
  const std::size_t strips = table_.strips.size() - 1;
  for (std::size_t parity = 0; parity < 2; ++parity) {
    pool_.run((strips + 1 - parity) / 2, [&](std::size_t k) {
      const Strip& s = table_.strips[2 * k + parity];
      if (s.block_begin != s.block_end) each(2 * k + parity, s);
    });
  }
  const Strip& large = table_.strips.back();
  if (large.block_begin != large.block_end) each(strips, large);
}

// Contacts with fixed shapes have the last word of every pass.
template <class Each>
void Solver::Run::for_singles(const Each& each) {
  pool_.run(table_.strips.size(), [&](std::size_t k) {
    const Strip& s = table_.strips[k];
    if (s.single_begin != s.single_end) each(k, s);
  });
}

// One sweep over contacts under heavy loads: pairs as in for_pairs, then singles.
template <class Pairs, class Singles>
void Solver::Run::for_loaded(const Pairs& pairs, const Singles& singles) {
  const std::vector<std::uint32_t>& loaded = solver_.loaded_;
  const auto run = [&](std::size_t begin, std::size_t end, const auto& each) {
    pool_.run(end - begin, [&](std::size_t k) { each(table_.strips[loaded[begin + k]]); });
  };
  run(0, solver_.loaded_odd_, pairs);
  run(solver_.loaded_odd_, solver_.loaded_large_, pairs);
  run(solver_.loaded_large_, loaded.size(), pairs);
  run(0, loaded.size(), singles);
}

// Manifolds between moving bodies as for_pairs; those with a fixed side as for_singles, unless some of
// those sides are kinematic: then the other one may lie in the next strip.
template <class Each>
void Solver::Run::go_over_manifolds(bool fixed, bool loaded, const Each& each) {
  const std::size_t kind = (fixed ? 2u : 0u) + (loaded ? 1u : 0u);
  const auto one = [&](std::size_t index) {
    Manifolds::StripBlocks& s = manifolds_.strip(index);
    const std::uint32_t begin = kind == 0 ? 0 : s.end[kind - 1];
    if (begin != s.end[kind]) each(s.blocks.data(), begin, s.end[kind]);
  };
  const std::size_t strips = table_.strips.size() - 1;
  if (fixed && held_.empty()) {
    pool_.run(strips + 1, one);
    return;
  }
  for (std::size_t parity = 0; parity < 2; ++parity) {
    pool_.run((strips + 1 - parity) / 2, [&](std::size_t k) { one(2 * k + parity); });
  }
  one(strips);
}

template <class Each>
void Solver::Run::for_bodies(const Each& each) {
  const std::uint32_t blocks = solved_.blocks();
  pool_.run(stream_tasks(blocks), [&](std::size_t t) {
    const BlockRange r = stream_range(t, blocks);
    each(r.begin, r.end);
  });
}

}  // namespace psim
