// Every kernel over bodies on every instruction set against the scalar one (kernel_exact.h).
#include "kernel_exact.h"

#include <cstddef>

namespace psim::test::exact {
namespace {

TEST(KernelExactSets, PsimFindsTheVariantsOfThisCpu) {
  std::vector<Isa> expected = wide_isas();
  expected.insert(expected.begin(), Isa::scalar);
  EXPECT_EQ(available_isas(), expected);
  EXPECT_EQ(best_isa(), expected.back());
}

// The kernel that runs is the one that was asked for: no entry of a table is another variant's.
TEST(KernelExactSets, VariantsShareNoFunction) {
  using Function = void (*)();
  constexpr std::size_t kFirst = offsetof(KernelTable, kick_first);
  constexpr std::size_t kFunctions = (sizeof(KernelTable) - kFirst) / sizeof(Function);
  const auto functions_of = [](Isa isa) {
    std::vector<Function> functions(kFunctions);
    std::memcpy(functions.data(), reinterpret_cast<const char*>(&kernels_of(isa)) + kFirst,
                kFunctions * sizeof(Function));
    return functions;
  };
  for (const Isa isa : kAllIsas) {
    if (isa_lanes(isa) == 0) continue;  // not in this build
    EXPECT_EQ(kernels_of(isa).width, static_cast<std::uint32_t>(isa_lanes(isa)));
    for (const Isa other : kAllIsas) {
      if (isa == other || isa_lanes(other) == 0) continue;
      const std::vector<Function> of_isa = functions_of(isa), of_other = functions_of(other);
      for (std::size_t k = 0; k < kFunctions; ++k) {
        ASSERT_NE(of_isa[k], nullptr) << isa_name(isa) << " function " << k;
        ASSERT_NE(of_isa[k], of_other[k]) << isa_name(isa) << " and " << isa_name(other) << " function " << k;
      }
    }
  }
}

enum class Linked { none, all, mixed };

/// Streams: block ranges 0..3 long inside five blocks, plain and nasty columns, linked bytes.
template <class Each>
void for_streams(std::uint64_t seed, const Each& each) {
  for (int round = 0; round < 24 && !::testing::Test::HasFailure(); ++round) {
    Random random(seed + static_cast<std::uint64_t>(round));
    State s;
    s.b = Bodies(random, 40);
    const double chances[] = {0, 0.1, 0.6};
    if (round % 3 > 0) s.b.be_nasty(random, chances[round % 3]);
    const auto linked = static_cast<Linked>(round / 3 % 3);
    for (std::uint8_t& l : s.b.linked) {
      if (linked != Linked::mixed) l = linked == Linked::all ? 0xFF : 0;
    }
    s.key.assign(s.b.linked.size(), 0xABCD1234u);
    const StreamParams p = stream_params(random);
    for (std::uint32_t begin = 0; begin < 3; ++begin) {
      for (std::uint32_t n = 0; n <= 3; ++n) {
        SCOPED_TRACE("round " + std::to_string(round) + " blocks " + std::to_string(begin) + " to " +
                     std::to_string(begin + n));
        each(s, p, begin, begin + n);
      }
    }
  }
}

TEST_F(KernelExact, Kicks) {
  for_streams(100, [](const State& s, const StreamParams& p, std::uint32_t i, std::uint32_t n) {
    for (const bool own : {false, true}) {
      compare(s, [&](const KernelTable& k, State& at) { k.kick_first(at.b.view(own), p, i, n); });
      compare(s, [&](const KernelTable& k, State& at) { k.kick_again(at.b.view(own), p, i, n); });
    }
    compare(s, [&](const KernelTable& k, State& at) {
      BodyView v = at.b.view(true);
      v.vel_remainder = at.b.vel_remainder.data();
      k.kick_first(v, p, i, n);
    });
  });
}

TEST_F(KernelExact, Drift) {
  for_streams(200, [](const State& s, const StreamParams& p, std::uint32_t i, std::uint32_t n) {
    for (const bool own : {false, true}) {
      compare(s, [&](const KernelTable& k, State& at) { k.drift(at.b.view(own), p, i, n); });
    }
  });
}

TEST_F(KernelExact, Accelerate) {
  for_streams(210, [](const State& s, const StreamParams&, std::uint32_t i, std::uint32_t n) {
    Random random(211);
    const FieldSet fields(random);
    for (const int drag : {0, 1}) {
      for (const bool scales : {false, true}) {
        compare(s,
                [&](const KernelTable& k, State& at) { k.accelerate[drag](at.b.field_view(scales), fields.p, i, n); });
      }
    }
  });
}

TEST_F(KernelExact, Advance) {
  for_streams(220, [](const State& s, const StreamParams&, std::uint32_t i, std::uint32_t n) {
    Random random(221);
    const FieldSet weak(random), strong(random, 100, 30);
    for (const FieldSet* fields : {&weak, &strong}) {
      for (int method = 0; method < kernels::kMethods; ++method) {
        for (const int drag : {0, 1}) {
          compare(s, [&](const KernelTable& k, State& at) {
            k.advance[method][drag](at.b.field_view(fields == &weak), fields->p, i, n);
          });
        }
      }
    }
  });
}

TEST_F(KernelExact, DriftBent) {
  for_streams(230, [](const State& s, const StreamParams&, std::uint32_t i, std::uint32_t n) {
    Random random(231);
    FieldSet fields(random);
    for (const double smooth : {fields.p.smooth, 1.0, -1.0}) {
      fields.p.smooth = smooth;
      compare(s, [&](const KernelTable& k, State& at) { k.drift_corrected(at.b.field_view(false), fields.p, i, n); });
    }
  });
}

TEST_F(KernelExact, Integrate) {
  bool fine = false, bad = false;
  for_streams(300, [&](const State& s, const StreamParams& p, std::uint32_t i, std::uint32_t n) {
    for (const bool own : {false, true}) {
      for (const float far : {1e30f, 0.01f}) {
        StreamParams q = p;
        q.far_x = q.far_y = far;
        const State done =
            compare(s, [&](const KernelTable& k, State& at) { at.flag = k.integrate(at.b.view(own), q, i, n); });
        (done.flag ? fine : bad) = true;
      }
    }
  });
  EXPECT_TRUE(fine && bad);
}

TEST_F(KernelExact, ListAgeAndReaches) {
  for_streams(400, [](const State& s, const StreamParams& p, std::uint32_t i, std::uint32_t n) {
    compare(s, [&](const KernelTable& k, State& at) {
      at.value = k.list_age(at.b.view(), at.b.built.data(), at.b.radius.data(), at.b.reach.data(), p, 0.02f, i, n);
    });
    compare(s, [&](const KernelTable& k, State& at) {
      at.value = k.reaches(at.b.view(), at.b.radius.data(),
                           {.skin = 0.1f, .time = 0.02f, .common_x = 3, .common_y = -1}, at.b.reach.data(), i, n);
    });
  });
}

TEST_F(KernelExact, LookAhead) {
  for_streams(450, [](const State& s, const StreamParams& p, std::uint32_t i, std::uint32_t n) {
    for (const float ahead : {0.01f, 1e30f}) {
      compare(s,
              [&](const KernelTable& k, State& at) { k.look_ahead(at.b.view(), p, ahead, at.b.built.data(), i, n); });
    }
  });
}

TEST_F(KernelExact, ExtentAndCellKeys) {
  for_streams(500, [](const State& s, const StreamParams&, std::uint32_t i, std::uint32_t n) {
    for (const std::int32_t wide : {0, 1000000, INT32_MAX}) {
      State start = s;
      start.low_high = {-wide, 1 - wide, wide - 1, wide};
      compare(start, [&](const KernelTable& k, State& at) { k.extent(at.b.pos.data(), at.low_high.data(), i, n); });
    }
    kernels::GridView g;
    g.mid_x = 1234567;
    g.mid_y = -7654321;
    g.scale_x = g.scale_y = 3 * kPitch;
    g.offset_x = 7;
    g.offset_y = 7.5f;
    g.cols = 13;
    g.rows = 17;
    g.stride = 15;
    compare(s, [&](const KernelTable& k, State& at) { k.cell_keys(at.b.pos.data(), g, at.key.data(), i, n); });
  });
}

}  // namespace
}  // namespace psim::test::exact
