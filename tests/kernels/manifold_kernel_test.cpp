// The passes over manifolds: every instruction set against the scalar one, bit by bit over whole blocks
// and body columns.
#include "manifold_scene.h"

namespace psim::test::manifold_scene {
namespace {

bool same_bits(const Scene& a, const Scene& b) {
  const auto same = [](const auto& x, const auto& y) {
    return x.empty() || std::memcmp(x.data(), y.data(), x.size() * sizeof(x[0])) == 0;
  };
  // There is no NaN in these scenes, and signed zeros of velocities are alike, as in state_hash.
  return same(a.blocks, b.blocks) && same(a.surfaces, b.surfaces) && a.bodies.vel == b.bodies.vel &&
         a.bodies.vel0 == b.bodies.vel0 && a.bodies.rim_speed == b.bodies.rim_speed &&
         a.bodies.rim_speed0 == b.bodies.rim_speed0 && same(a.bodies.disp, b.bodies.disp) &&
         same(a.arm_change, b.arm_change) && same(a.angle_change, b.angle_change);
}

std::vector<Taste> tastes() {
  std::vector<Taste> all;
  for (const bool fixed_a : {false, true}) {
    for (const bool bounce : {false, true}) {
      for (const double padding : {0.0, 0.3}) {
        for (const double smooth : {0.0, 0.5, 1.0}) {
          Taste t;
          t.fixed_a = fixed_a;
          t.bounce = bounce;
          t.padding = padding;
          t.smooth = smooth;
          for (const bool surfaces : {false, true}) {
            t.surfaces = surfaces;
            all.push_back(t);
          }
        }
      }
    }
  }
  return all;
}

std::string describe(const Taste& t) {
  return std::string(t.fixed_a ? "fixed A" : "moving A") + (t.bounce ? ", bounce" : "") + ", padding " +
         std::to_string(t.padding) + ", smooth " + std::to_string(t.smooth) + (t.surfaces ? ", surfaces" : "");
}

TEST(ManifoldExact, EveryPassAloneGivesTheBitsOfTheScalarOne) {
  const ContactParams p = contact_params();
  for (Taste taste : tastes()) {
    for (const bool inner : {false, true}) {
      taste.inner = inner;
      for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        const Scene scene = make_scene(seed, 3, taste);
        for (const Pass& pass : kPasses) {
          Scene truth = scene;
          pass.run(kernels_of(Isa::scalar), truth, taste, p);
          for (const Isa isa : available_isas()) {
            Scene wide = scene;
            pass.run(kernels_of(isa), wide, taste, p);
            ASSERT_TRUE(same_bits(truth, wide)) << pass.name << " on " << isa_name(isa) << ", seed " << seed << ", "
                                                << describe(taste) << (inner ? ", inner" : "");
          }
        }
      }
    }
  }
}

TEST(ManifoldExact, ManySubstepsGiveTheBitsOfTheScalarOne) {
  for (const Taste& taste : tastes()) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const auto play = [&](Isa isa) {
        Scene s = make_scene(seed, 4, taste);
        const KernelTable& k = kernels_of(isa);
        ContactParams p = contact_params();
        for (int substep = 0; substep < 6; ++substep) {
          for (const int pass : {0, 1, 4, 2, 3}) {
            p.warm = substep == 0 ? 0.8f : 1;
            kPasses[pass].run(k, s, taste, p);
          }
        }
        return s;
      };
      const Scene truth = play(Isa::scalar);
      for (const Isa isa : available_isas()) {
        ASSERT_TRUE(same_bits(truth, play(isa))) << isa_name(isa) << ", seed " << seed << ", " << describe(taste);
      }
    }
  }
}

TEST(ManifoldExact, FixedBodiesAndPaddingAreNeverWritten) {
  Taste taste;
  taste.fixed_a = true;
  taste.padding = 0.4;
  taste.surfaces = true;
  for (const bool bounce : {false, true}) {
    taste.bounce = bounce;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      for (const Isa isa : available_isas()) {
        const Scene before = make_scene(seed, 2, taste);
        Scene after = before;
        for (int pass = 0; pass < 4; ++pass) {
          kPasses[pass].run(kernels_of(isa), after, taste, contact_params());
        }
        std::vector<bool> is_b(66);
        for (const ManifoldBlock& c : before.blocks) {
          for (std::uint32_t l = 0; l < kBlock; ++l) is_b[c.body[2 * l + 1]] = true;
        }
        for (std::size_t i = 0; i < 66; ++i) {
          if (is_b[i] && i < 64) continue;
          ASSERT_EQ(after.bodies.vel[2 * i], before.bodies.vel[2 * i]) << i;
          ASSERT_EQ(after.bodies.vel[2 * i + 1], before.bodies.vel[2 * i + 1]) << i;
          ASSERT_EQ(after.bodies.rim_speed[i], before.bodies.rim_speed[i]) << i;
        }
      }
    }
  }
}

}  // namespace
}  // namespace psim::test::manifold_scene
