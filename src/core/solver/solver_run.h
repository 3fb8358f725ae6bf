// The data of all substeps of a step, its stages, and how a pass goes over contacts: strip by strip, so that no two
// jobs of a phase share a body. For the files of the solver alone.
#pragma once

#include <bit>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/tasks.h"
#include "compiler.h"
#include "solver/solver.h"

namespace psim {

// All bits set if x >= least > 0, else 0. Made of bit operations, so that compilers make no branch, which would be
// taken at random: it is hard to guess which contacts press.
inline std::uint32_t mask_from(float x, float least) {
  const auto from = std::bit_cast<std::uint32_t>(least), inf = 0x7F800000u;
  return 0u - static_cast<std::uint32_t>(std::bit_cast<std::uint32_t>(x) - from <= inf - from);
}
inline constexpr float kTiniest = std::numeric_limits<float>::min();  // below it nothing presses

class Solver::Run : SolverInput {
  using ContactParams = kernels::ContactParams;
  using ManifoldBlock = kernels::ManifoldBlock;
  using SurfaceBlock = kernels::SurfaceBlock;
  using FieldPass = void (*)(const kernels::BodyView&, const kernels::FieldParams&, std::uint32_t, std::uint32_t);
  using Clock = std::chrono::steady_clock;

 public:
  Run(Solver& solver, const SolverInput& in, const SolverParams& params);

  void substep(bool first_of_step);
  double swept() const { return sweeps_.done; }
  double forces_ms() const { return std::chrono::duration<double, std::milli>(fields_.time).count(); }

 private:
  void set_contacts();
  void set_sweeps();
  template <class Each>
  void for_pairs(const Each& each) {
    run_phases(table.strips.size(), s_.pool, [&](std::size_t strip) {
      const ContactBlocks& b = table.strips[strip].blocks;
      if (b.begin != b.end) each(b, strip);
    });
  }
  // Contacts with fixed shapes come last in every pass.
  template <class Each>
  void for_statics(const Each& each) {
    s_.pool.run(table.strips.size(), [&](std::size_t strip) {
      const ContactBlocks& b = table.strips[strip].static_blocks;
      if (b.begin != b.end) each(b, strip);
    });
  }
  template <class Each>
  PSIM_INLINE void for_manifolds(bool fixed, bool loaded, const Each& each) {
    if (contacts.manifolds.any()) go_over_manifolds(fixed, loaded, each);
  }
  // Manifolds between moving bodies run in the order of for_pairs; those with a fixed side in that of static contacts.
  // If some of these sides are kinematic, the other body may lie in the next strip, and they run in the order of
  // for_pairs.
  template <class Each>
  void go_over_manifolds(bool fixed, bool loaded, const Each& each) {
    const std::size_t kind = (fixed ? 2u : 0u) + (loaded ? 1u : 0u);
    const auto one = [&](std::size_t index) {
      Manifolds::StripBlocks& s = contacts.manifolds.strip(index);
      const std::uint32_t begin = kind == 0 ? 0 : s.end[kind - 1];
      SurfaceBlock* const surfaces = s.surfaces.empty() ? nullptr : s.surfaces.data();
      if (begin != s.end[kind]) each(s.blocks.data(), surfaces, begin, s.end[kind]);
    };
    if (fixed && kinematics.empty()) {
      s_.pool.run(table.strips.size(), one);
    } else {
      run_phases(table.strips.size(), s_.pool, one);
    }
  }
  template <class Each>
  void for_bodies(const Each& each) {
    run_stream(contacts.solved.blocks(), s_.pool, each);
  }
  // Runs kernels once over all contacts: those of discs, then of shapes, then with fixed shapes.
  template <class Pairs, class Statics, class Blocks>
  void once(const ContactParams& p, const Pairs& pass_pairs, const Statics& pass_statics, const Blocks& pass_blocks) {
    for_pairs([&](const ContactBlocks& b, std::size_t) { pass_pairs[model_](view_, pairs_, p, b.begin, b.end); });
    for (const bool fixed : {false, true}) {
      for (const bool loaded : {false, true}) {
        for_manifolds(fixed, loaded,
                      [&](ManifoldBlock* blocks, SurfaceBlock* surfaces, std::uint32_t begin, std::uint32_t end) {
                        pass_blocks(fixed, blocks, surfaces, begin, end);
                      });
      }
    }
    for_statics([&](const ContactBlocks& b, std::size_t) { pass_statics[model_](view_, statics_, p, b.begin, b.end); });
  }
  template <class Pairs, class Statics, class Blocks>
  void pass(const Pairs& pass_pairs, const Statics& pass_statics, const Blocks& pass_blocks, int outer);

  void force(FieldPass kernel);
  void set_floors();
  void impacts();
  bool impact_shapes(std::size_t strip, bool first, bool all);
  void meet_shapes();
  void kick(bool first);
  void push_advanced();
  void spin(bool first);
  void hold();
  void find_restrained();
  void restrain(bool first);
  void hold_locked();
  void let_run_on();
  void warm(bool first_of_step);
  void solve();
  void drift();
  void turn_by_impacts(BlockRange r);
  static constexpr std::uint32_t kTurnChunk = 256;  // bodies: long enough for loops that compilers make vectors of
  void turn_angles(BlockRange r);
  void find_mean_rim_speeds(std::uint32_t begin, std::uint32_t n, float* mean) const;
  void carry_kinematics();
  void relax();
  void spend();

  Solver& solver_;
  const SolverParams& params_;
  const bool joined_ = !joints.empty();
  const Surroundings& s_ = contacts.surroundings;
  const kernels::BodyView view_ = contacts.solved.view();
  const kernels::ContactView pairs_ = contacts.discs.pairs.view();
  const kernels::StaticContactView statics_ = contacts.discs.fixed.view();
  const double h_ = params_.dt / params_.substeps;     // s
  const double gravity_ = length_of(params_.gravity);  // m/s^2
  // Of the tables of kernels; bounce_ << 1 is Bounce::inner.
  const std::size_t model_ = static_cast<std::size_t>(params_.model.model), bounce_ = params_.model.bounce ? 1 : 0;

  const kernels::StreamParams stream_;
  kernels::StreamParams drift_ = stream_, turn_ = stream_;  // nothing damps a rotation
  struct OfDiscs {
    ContactParams pair, fixed;
  };
  OfDiscs discs_, loaded_;    // `loaded_`: under heavy loads
  ContactParams squeezed_;    // of light bodies between heavy ones
  int loaded_sweeps_;         // number of sweeps over contacts under heavy loads in a pass
  int sweeps_of_shapes_ = 1;  // of a pass, over contacts of shapes under no heavy load
  struct {
    int slices = 1, most = 0;
    bool limited = false;  // the number of sweeps is limited
    double done = 0;       // so far
  } sweeps_;               // over impacts
  struct {
    kernels::FieldParams params;
    bool varying = false;  // accelerations are computed anew in every substep
    FieldPass accelerate = nullptr;
    FieldPass advance = nullptr;  // the kick of the integrator, if the world asks for another one than leapfrog
    Clock::duration time{};
  } fields_;
};

}  // namespace psim
