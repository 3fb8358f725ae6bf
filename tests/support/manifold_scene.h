// Blocks of manifolds over made-up bodies, for the tests of the passes over them.
#pragma once

#include "kernel_support.h"
#include "manifold_views.h"

namespace psim::test::manifold_scene {

using kernels::ManifoldBlock;

/// Blocks over distinct bodies of a world of 64, and everything that a pass can read or write.
struct Scene {
  Bodies bodies;
  std::vector<float> arm_change, angle_change, radius;
  std::vector<ManifoldBlock> blocks;
  std::vector<kernels::SurfaceBlock> surfaces;  // none, or one for each block

  kernels::SurfaceBlock* surface_blocks() { return surfaces.empty() ? nullptr : surfaces.data(); }
  BodyView view() {
    BodyView v = bodies.view(false, true, false);
    v.arm_change = arm_change.data();
    v.angle_change = angle_change.data();
    return v;
  }
};

struct Taste {
  bool fixed_a = false;
  bool bounce = false;
  bool inner = false;     // an inner sweep of a pass
  double lone = 0.3;      // chance of one point
  double padding = 0.15;  // of an empty lane
  double zero = 0.1;      // of a signed zero in an impulse
  double smooth = 0.3;    // of a lane without friction
  bool surfaces = false;  // that run or resist rolling
};

inline kernels::StreamParams turning(const ContactParams& p) {
  kernels::StreamParams turn;
  turn.h = p.h;
  turn.smooth_limit2 = 0.05f;
  return turn;
}

inline float signed_zero(Random& random) { return random.chance(0.5) ? 0.0f : -0.0f; }

inline void no_point(ManifoldBlock::Point& p, std::uint32_t l) {
  p.an[l] = p.at[l] = p.bn[l] = p.bt[l] = 0;
  p.gap[l] = 1e6f;
  p.impulse[l] = -0.0f;
  p.friction[l] = p.start[l] = 0;
}

inline Scene make_scene(std::uint64_t seed, std::size_t blocks, const Taste& taste) {
  Random random(seed);
  Scene s;
  constexpr std::size_t kCount = 64;
  s.bodies = Bodies(random, kCount);
  for (auto* c : {&s.bodies.vel, &s.bodies.vel0}) {
    for (std::size_t i = 0; i < 2 * kCount; ++i) {
      if (random.chance(0.7)) (*c)[i] *= 0.05f;
      if (random.chance(0.03)) (*c)[i] = signed_zero(random);
    }
  }
  for (std::size_t i = 0; i < 2; ++i) {  // resting dummies
    const std::size_t d = kCount + i;
    for (auto* c : {&s.bodies.vel, &s.bodies.vel0, &s.bodies.disp}) (*c)[2 * d] = (*c)[2 * d + 1] = 0;
  }
  s.arm_change.assign(s.bodies.vel.size(), 0);
  s.angle_change.assign(s.bodies.rim_speed.size(), 0);
  s.radius.assign(s.bodies.rim_speed.size(), 0);
  for (std::size_t i = 0; i < kCount; ++i) {
    s.radius[i] = uniform(random, 0.3, 2);
    s.angle_change[i] = uniform(random, -0.3, 0.3);
    s.arm_change[2 * i] = s.radius[i] * (std::cos(s.angle_change[i]) - 1);
    s.arm_change[2 * i + 1] = s.radius[i] * std::sin(s.angle_change[i]);
  }
  s.blocks.resize(blocks);
  for (ManifoldBlock& c : s.blocks) {
    std::vector<std::uint32_t> free(kCount);
    std::iota(free.begin(), free.end(), 0u);
    for (std::size_t k = free.size(); k > 1; --k) std::swap(free[k - 1], free[random.below(k)]);
    const std::uint32_t shared = free.back();  // a fixed body may be in many lanes
    for (std::uint32_t l = 0; l < kBlock; ++l) {
      const bool pad = random.chance(taste.padding);
      c.body[2 * l] = pad || (taste.fixed_a && random.chance(0.3)) ? kCount : taste.fixed_a ? shared : free[2 * l];
      c.body[2 * l + 1] = pad ? kCount + 1 : free[2 * l + 1];
      const double angle =
          random.chance(0.2) ? 0.5 * kPi * static_cast<double>(random.below(4)) : random.uniform(0, 2 * kPi);
      c.nx[l] = pad ? 0 : static_cast<float>(std::cos(angle));
      c.ny[l] = pad ? 1 : static_cast<float>(std::sin(angle));
      for (int k = 0; k < 2; ++k) {
        ManifoldBlock::Point& p = c.point[k];
        if (pad || (k == 1 && random.chance(taste.lone))) {
          no_point(p, l);
          continue;
        }
        p.an[l] = taste.fixed_a ? 0 : uniform(random, -1, 1);
        p.at[l] = taste.fixed_a ? 0 : uniform(random, -1, 1);
        p.bn[l] = uniform(random, -1, 1);
        p.bt[l] = uniform(random, -1, 1);
        if (k == 1 && random.chance(0.1)) {  // all but the same point
          p.bt[l] = c.point[0].bt[l];
          p.at[l] = c.point[0].at[l];
        }
        p.gap[l] = random.chance(0.1) ? signed_zero(random) : uniform(random, -0.01, 0.02);
        p.impulse[l] = random.chance(taste.zero) ? signed_zero(random)
                       : random.chance(0.2)      ? -0.0f
                                                 : uniform(random, 0, 0.3);
        p.friction[l] = random.chance(taste.zero) ? signed_zero(random) : uniform(random, -0.1, 0.1);
        p.start[l] = (random.chance(0.5) ? 1.0f : -1.0f) * (random.chance(0.5) ? 0 : uniform(random, 0, 0.2));
      }
      c.wa[l] = pad ? 1 : taste.fixed_a ? 0 : uniform(random, 0.1, 2);
      c.wb[l] = pad ? 1 : uniform(random, 0.1, 2);
      c.ga[l] = pad || taste.fixed_a ? 0 : uniform(random, 0, 4);
      c.gb[l] = pad ? 0 : uniform(random, 0, 4);
      c.share_a[l] = !pad && !taste.fixed_a && random.chance(0.3) ? 0.5f : 1;
      c.share_b[l] = !pad && !taste.fixed_a && random.chance(0.3) ? 0.5f : 1;
      c.round_a[l] = random.chance(0.5) || pad ? 0 : uniform(random, 0, 0.5);
      c.round_b[l] = random.chance(0.5) || pad ? 0 : uniform(random, 0, 0.5);
      c.lead_a[l] = random.chance(0.5) || pad ? 0 : uniform(random, -0.1, 0.1);
      c.lead_b[l] = random.chance(0.5) || pad ? 0 : uniform(random, -0.1, 0.1);
      const bool smooth = pad || random.chance(taste.smooth);
      c.mu[l] = smooth ? 0 : uniform(random, 0, 1);
      if (smooth) c.point[0].friction[l] = c.point[1].friction[l] = 0;
      c.e[l] = !pad && taste.bounce && random.chance(0.7) ? uniform(random, 0, 1) : 0;
      c.soft[l] = pad ? 0 : uniform(random, 0, 0.2);
      c.rate[l] = pad ? 0 : uniform(random, 0, 60);
    }
  }
  s.surfaces.resize(taste.surfaces ? blocks : 0);
  for (kernels::SurfaceBlock& of : s.surfaces) {
    for (std::uint32_t l = 0; l < kBlock; ++l) {
      of.belt[l] = random.chance(0.3) ? 0 : uniform(random, -2, 2);
      of.resist[l] = random.chance(0.3) ? 0 : uniform(random, 0, 0.2);
      of.inv_size_a[l] = taste.fixed_a && random.chance(0.5) ? 0 : uniform(random, 0.5, 3);
      of.inv_size_b[l] = uniform(random, 0.5, 3);
      of.roll[l] = random.chance(taste.zero) ? signed_zero(random) : uniform(random, -0.05, 0.05);
    }
  }
  return s;
}

struct Pass {
  const char* name;
  void (*run)(const KernelTable&, Scene&, const Taste&, const ContactParams&);
};

inline const Pass kPasses[] = {
    {"warm",
     [](const KernelTable& k, Scene& s, const Taste& t, const ContactParams& p) {
       k.warm_manifolds[t.fixed_a](s.view(), s.blocks.data(), s.surface_blocks(), p.warm, 0,
                                   static_cast<std::uint32_t>(s.blocks.size()));
     }},
    {"solve",
     [](const KernelTable& k, Scene& s, const Taste& t, const ContactParams& p) {
       k.solve_manifolds[t.fixed_a][t.bounce][t.inner](s.view(), s.blocks.data(), p, 0,
                                                       static_cast<std::uint32_t>(s.blocks.size()));
     }},
    {"relax",
     [](const KernelTable& k, Scene& s, const Taste& t, const ContactParams& p) {
       k.relax_manifolds[t.fixed_a][t.bounce][t.inner](s.view(), s.blocks.data(), s.surface_blocks(), p, 0,
                                                       static_cast<std::uint32_t>(s.blocks.size()));
     }},
    {"spend",
     [](const KernelTable& k, Scene& s, const Taste& t, const ContactParams& p) {
       k.spend_manifolds[t.fixed_a](s.view(), s.blocks.data(), p, 0, static_cast<std::uint32_t>(s.blocks.size()));
     }},
    {"angle_change", [](const KernelTable& k, Scene& s, const Taste&,
                        const ContactParams& p) { k.turn_bodies(s.view(), s.radius.data(), turning(p), 0, 9); }},
};

}  // namespace psim::test::manifold_scene
