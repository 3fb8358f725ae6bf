// The data of all substeps of a step, and how a pass goes over them: strip by strip, so that no two jobs of a phase
// share a body. For the files of the solver alone.
#pragma once

#include <bit>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/tasks.h"
#include "solver/solver.h"

namespace psim {

// All bits set if x >= least > 0, else 0. Made of bit operations, so that compilers make no branch, which would be
// taken at random: it is hard to guess which contacts press.
inline std::uint32_t mask_from(float x, float least) {
  const auto from = std::bit_cast<std::uint32_t>(least), inf = 0x7F800000u;
  return 0u - static_cast<std::uint32_t>(std::bit_cast<std::uint32_t>(x) - from <= inf - from);
}
inline constexpr float kTiniest =
    std::numeric_limits<float>::min();  // x >= kTiniest means x > 0, since denormals are zero

// The data of all substeps of a step, and the stages in the order of a substep.
class Solver::Run : SolverInput {
  using ContactParams = kernels::ContactParams;
  using StreamParams = kernels::StreamParams;
  using ManifoldBlock = kernels::ManifoldBlock;
  using FieldPass = void (*)(const kernels::BodyView&, const kernels::FieldParams&, std::uint32_t, std::uint32_t);
  using Clock = std::chrono::steady_clock;

 public:
  Run(Solver& solver, const SolverInput& in, const SolverParams& params);

  void substep(bool first_of_step);
  double swept() const { return swept_; }
  double forces_ms() const { return std::chrono::duration<double, std::milli>(forces_time_).count(); }

 private:
  void set_motion(const SolverParams& params);
  void set_contacts(const SolverParams& params);
  template <class Each>
  void for_pairs(const Each& each);
  template <class Each>
  void for_statics(const Each& each);
  template <class Pairs, class Statics>
  void for_loaded(const Pairs& pairs, const Statics& static_contacts);
  template <class Each>
  void go_over_manifolds(bool fixed, bool loaded, const Each& each);
  template <class Each>
  [[gnu::always_inline]] void for_manifolds(bool fixed, bool loaded, const Each& each) {
    if (manifolds.any()) go_over_manifolds(fixed, loaded, each);
  }
  template <class Each>
  void for_all_manifolds(const Each& each);
  template <class Each>
  void for_bodies(const Each& each);
  void force(FieldPass kernel);
  template <class Pairs, class Statics, class Blocks>
  void pass(const Pairs& pass_pairs, const Statics& pass_statics, const Blocks& pass_blocks, int outer);

  void set_floors();
  void impacts();
  void kick(bool first);
  void hold();
  void warm(bool first_of_step);
  void solve();
  void drift();
  void carry_kinematics();
  void relax();
  void spend();

  Solver& solver_;
  const bool joined_ = !joints.empty();
  const kernels::BodyView view_;
  const kernels::ContactView pairs_;
  const kernels::StaticContactView statics_;

  double h_;          // s
  double gravity_;    // m/s^2
  double threshold_;  // m/s
  StreamParams stream_, drift_;
  ContactParams pair_, static_, loaded_pair_, loaded_static_;
  std::size_t model_, bounce_;  // of the tables of kernels: bounce_ << 1 is Bounce::inner
  bool rough_, turns_;
  int slices_, loaded_sweeps_, impact_sweeps_;
  bool limited_ = false;  // the number of sweeps over impacts is limited
  bool varying_;          // accelerations are computed anew in every substep
  kernels::FieldParams field_;
  FieldPass accelerate_;
  FieldPass advance_ = nullptr;  // the kick of the integrator, if the world asks for another one than leapfrog
  double swept_ = 0;             // sweeps over impacts so far
  Clock::duration forces_time_{};
};

template <class Each>
void Solver::Run::for_pairs(const Each& each) {
  run_phases(table.strips.size(), pool, [&](std::size_t k) {
    const Strip& s = table.strips[k];
    if (s.blocks.begin != s.blocks.end) each(k, s);
  });
}

// Contacts with fixed shapes come last in every pass.
template <class Each>
void Solver::Run::for_statics(const Each& each) {
  pool.run(table.strips.size(), [&](std::size_t k) {
    const Strip& s = table.strips[k];
    if (s.static_blocks.begin != s.static_blocks.end) each(k, s);
  });
}

// One sweep over contacts under heavy loads: pairs in the order of for_pairs, then static contacts.
template <class Pairs, class Statics>
void Solver::Run::for_loaded(const Pairs& pairs, const Statics& static_contacts) {
  const std::vector<std::uint32_t>& loaded = solver_.loaded_;
  const auto run = [&](std::size_t begin, std::size_t end, const auto& each) {
    pool.run(end - begin, [&](std::size_t k) { each(table.strips[loaded[begin + k]]); });
  };
  run(0, solver_.loaded_odd_, pairs);
  run(solver_.loaded_odd_, solver_.loaded_large_, pairs);
  run(solver_.loaded_large_, loaded.size(), pairs);
  run(0, loaded.size(), static_contacts);
}

// Manifolds between moving bodies run in the order of for_pairs; those with a fixed side in that of static contacts. If
// some of these sides are kinematic, the other body may lie in the next strip, and they run in the order of for_pairs.
template <class Each>
void Solver::Run::go_over_manifolds(bool fixed, bool loaded, const Each& each) {
  const std::size_t kind = (fixed ? 2u : 0u) + (loaded ? 1u : 0u);
  const auto one = [&](std::size_t index) {
    Manifolds::StripBlocks& s = manifolds.strip(index);
    const std::uint32_t begin = kind == 0 ? 0 : s.end[kind - 1];
    if (begin != s.end[kind]) each(s.blocks.data(), begin, s.end[kind]);
  };
  if (fixed && kinematics.empty()) {
    pool.run(table.strips.size(), one);
  } else {
    run_phases(table.strips.size(), pool, one);
  }
}

// Calls each(fixed, blocks, begin, end) for all manifolds, those with a fixed side last.
template <class Each>
void Solver::Run::for_all_manifolds(const Each& each) {
  for (const bool fixed : {false, true}) {
    for (const bool loaded : {false, true}) {
      for_manifolds(fixed, loaded, [&](ManifoldBlock* blocks, std::uint32_t begin, std::uint32_t end) {
        each(fixed, blocks, begin, end);
      });
    }
  }
}

template <class Each>
void Solver::Run::for_bodies(const Each& each) {
  const std::uint32_t blocks = solved.blocks();
  pool.run(stream_tasks(blocks), [&](std::size_t t) {
    const BlockRange r = stream_range(t, blocks);
    each(r.begin, r.end);
  });
}

}  // namespace psim
