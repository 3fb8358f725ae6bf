// Every kernel on every instruction set against the scalar one, bit by bit over whole columns:
// what a kernel must not touch is compared like what it computes. One thing may differ: which NaN a
// NaN is, because the compiler may swap the operands of a sum. Two NaNs count as equal.
#include "kernel_support.h"

namespace psim::test {
namespace {

std::vector<Isa> wide_isas() {
  std::vector<Isa> isas;
  for (const Isa isa : available_isas()) {
    if (isa != Isa::scalar) isas.push_back(isa);
  }
  return isas;
}

bool same_float(float a, float b) {
  return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b) ||
         (std::isnan(a) && std::isnan(b));
}

/// Index of the first difference, or the size.
std::size_t difference(const std::vector<float>& a, const std::vector<float>& b) {
  if (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0) return a.size();
  std::size_t i = 0;
  while (i < a.size() && same_float(a[i], b[i])) ++i;
  return i;
}

/// All that a kernel can read or write, and what it returned.
struct State {
  Bodies b;
  Contacts c;
  std::vector<std::uint32_t> key;
  std::vector<std::int32_t> low_high;
  bool flag = false;
  float value = 0;
  double virial = 0;
};

template <class Columns>
bool same_columns(const Columns& a, const Columns& b, const char* isa) {
  const auto fa = a.floats(), fb = b.floats();
  for (std::size_t f = 0; f < fa.size(); ++f) {
    const std::size_t at = difference(*fa[f].second, *fb[f].second);
    if (at == fa[f].second->size()) continue;
    ADD_FAILURE() << isa << ": " << fa[f].first << "[" << at << "] = " << (*fb[f].second)[at]
                  << ", scalar " << (*fa[f].second)[at];
    return false;
  }
  return true;
}

bool same_state(const State& scalar, const State& wide, const char* isa) {
  EXPECT_EQ(scalar.b.pos, wide.b.pos) << isa;
  EXPECT_EQ(scalar.b.built, wide.b.built) << isa;
  EXPECT_EQ(scalar.b.linked, wide.b.linked) << isa;
  EXPECT_EQ(scalar.c.body, wide.c.body) << isa;
  EXPECT_EQ(scalar.key, wide.key) << isa;
  EXPECT_EQ(scalar.low_high, wide.low_high) << isa;
  EXPECT_EQ(scalar.flag, wide.flag) << isa;
  // Of a maximum, the sign of a zero may depend on the order.
  EXPECT_TRUE(scalar.value == wide.value || same_float(scalar.value, wide.value))
      << isa << ": returned " << wide.value << ", scalar " << scalar.value;
  EXPECT_TRUE(scalar.virial == wide.virial || (std::isnan(scalar.virial) && std::isnan(wide.virial)))
      << isa << ": virial " << wide.virial << ", scalar " << scalar.virial;
  return same_columns(scalar.b, wide.b, isa) && same_columns(scalar.c, wide.c, isa) &&
         !::testing::Test::HasFailure();
}

/// Runs a kernel on copies of the state, one for each instruction set. Returns what scalar made.
template <class Run>
State compare(const State& initial, const Run& run) {
  State scalar = initial;
  run(kernels_of(Isa::scalar), scalar);
  for (const Isa isa : wide_isas()) {
    State wide = initial;
    run(kernels_of(isa), wide);
    if (!same_state(scalar, wide, isa_name(isa).data())) break;
  }
  return scalar;
}

class KernelExact : public ::testing::Test {
 protected:
  void SetUp() override {
    if (wide_isas().empty()) GTEST_SKIP() << "this CPU has the scalar variant only";
  }
};

// Asked of the compiler's run-time library, not of psim, so that a fault in the detection cannot
// leave the suite empty.
TEST(KernelExactSets, EveryVariantOfThisCpuIsCompared) {
  std::string compared;
  for (const Isa isa : kAllIsas) {
    if (isa_available(isa)) {
      compared += std::string(" ") + std::string(isa_name(isa));
    } else {
      std::printf("NOT COMPARED, this CPU lacks it: %s\n", isa_name(isa).data());
    }
  }
  std::printf("compared:%s\n", compared.c_str());
  EXPECT_EQ(isa_available(Isa::sse), __builtin_cpu_supports("sse4.1") != 0);
  EXPECT_EQ(isa_available(Isa::avx2), __builtin_cpu_supports("avx2") != 0);
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
      v.vel_rest = at.b.vel_rest.data();
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
        compare(s, [&](const KernelTable& k, State& at) {
          k.accelerate[drag](at.b.field_view(scales), fields.p, i, n);
        });
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
      compare(s, [&](const KernelTable& k, State& at) {
        k.drift_bent(at.b.field_view(false), fields.p, i, n);
      });
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
        const State done = compare(s, [&](const KernelTable& k, State& at) {
          at.flag = k.integrate(at.b.view(own), q, i, n);
        });
        (done.flag ? fine : bad) = true;
      }
    }
  });
  EXPECT_TRUE(fine && bad);
}

TEST_F(KernelExact, ListAgeAndReaches) {
  for_streams(400, [](const State& s, const StreamParams& p, std::uint32_t i, std::uint32_t n) {
    compare(s, [&](const KernelTable& k, State& at) {
      at.value = k.list_age(at.b.view(), at.b.built.data(), at.b.radius.data(), at.b.reach.data(),
                            p, 0.02f, i, n);
    });
    compare(s, [&](const KernelTable& k, State& at) {
      at.value = k.reaches(at.b.view(), at.b.radius.data(), {0.1f, 0.02f, 3, -1}, at.b.reach.data(), i, n);
    });
  });
}

TEST_F(KernelExact, LookAhead) {
  for_streams(450, [](const State& s, const StreamParams& p, std::uint32_t i, std::uint32_t n) {
    for (const float ahead : {0.01f, 1e30f}) {
      compare(s, [&](const KernelTable& k, State& at) {
        k.look_ahead(at.b.view(), p, ahead, at.b.built.data(), i, n);
      });
    }
  });
}

TEST_F(KernelExact, ExtentAndCellKeys) {
  for_streams(500, [](const State& s, const StreamParams&, std::uint32_t i, std::uint32_t n) {
    for (const std::int32_t wide : {0, 1000000, INT32_MAX}) {
      State start = s;
      start.low_high = {-wide, 1 - wide, wide - 1, wide};
      compare(start, [&](const KernelTable& k, State& at) {
        k.extent(at.b.pos.data(), at.low_high.data(), i, n);
      });
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
    compare(s, [&](const KernelTable& k, State& at) {
      k.cell_keys(at.b.pos.data(), g, at.key.data(), i, n);
    });
  });
}

// ---- pair search --------------------------------------------------------------------------------

/// The written part of two lists, and that nothing was written beyond the capacity.
void same_lists(const Found& scalar, const Found& wide, const char* isa) {
  EXPECT_EQ(scalar.complete, wide.complete) << isa;
  EXPECT_EQ(scalar.count, wide.count) << isa;
  for (std::size_t i = wide.capacity; i < wide.owner.size(); ++i) {
    EXPECT_EQ(wide.owner[i], Found::kGuard) << isa << " wrote beyond the list";
    EXPECT_EQ(wide.other[i], Found::kGuard) << isa << " wrote beyond the list";
  }
  if (!scalar.complete || ::testing::Test::HasFailure()) return;
  EXPECT_EQ(scalar.first, wide.first) << isa;
  const std::size_t bytes = scalar.count * sizeof(std::uint32_t);
  EXPECT_EQ(std::memcmp(scalar.owner.data(), wide.owner.data(), bytes), 0) << isa;
  EXPECT_EQ(std::memcmp(scalar.other.data(), wide.other.data(), bytes), 0) << isa;
}

template <class Run>
Found compare_lists(std::uint32_t capacity, std::size_t bodies, const Run& run) {
  const auto found_by = [&](Isa isa) {
    Found f(capacity, bodies);
    kernels::PairList list = f.list();
    f.complete = run(kernels_of(isa), list);
    f.count = list.count;
    return f;
  };
  const Found scalar = found_by(Isa::scalar);
  for (const Isa isa : wide_isas()) same_lists(scalar, found_by(isa), isa_name(isa).data());
  return scalar;
}

// Sparse to crowded grids: up to twenty bodies a cell, so that the loops after the first vector run.
TEST_F(KernelExact, FindPairsOverRowsWithAndWithoutSeams) {
  std::uint64_t pairs = 0;
  bool full = false;
  for (const bool periodic : {false, true}) {
    for (const std::size_t bodies : {0u, 5u, 60u, 250u, 500u}) {
      Random random(bodies + periodic);
      Grid g(random, 5, 5, bodies, periodic);
      for (const bool nasty : {false, true}) {
        if (nasty) make_nasty(random, g.reach, g.size(), 0.2);
        for (std::uint32_t r = 0; r < g.rows; ++r) {
          const std::uint32_t begin = g.row_begin[r];
          std::vector<std::uint32_t> ends = {g.row_begin[r + 1]};
          for (std::uint32_t n = 0; n <= 17; ++n) {
            if (begin + n < g.row_begin[r + 1]) ends.push_back(begin + n);
          }
          for (const std::uint32_t end : ends) {
            for (const std::uint32_t room : {0u, 8u, 45u, 20000u}) {
              const Found f = compare_lists(
                  room, g.size(), [&](const KernelTable& k, kernels::PairList& list) {
                    return k.find_pairs(g.row(r), begin, end, list);
                  });
              pairs += f.complete ? f.count : 0;
              full = full || !f.complete;
            }
            if (HasFailure()) return;
          }
        }
      }
    }
  }
  EXPECT_GT(pairs, 1000u);
  EXPECT_TRUE(full);
}

TEST_F(KernelExact, FindNearForEveryTail) {
  Random random(6);
  Grid g(random, 2, 2, 64, false);
  g.pos[10] = INT32_MAX, g.pos[11] = INT32_MIN;
  g.pos[20] = INT32_MIN, g.pos[21] = INT32_MAX;
  for (const bool nasty : {false, true}) {
    if (nasty) make_nasty(random, g.reach, g.size(), 0.3);
    for (std::uint32_t i = 0; i < 16; ++i) {
      for (std::uint32_t n = 0; n <= 17; ++n) {
        for (const std::uint32_t room : {8u, 16u, 100u}) {
          compare_lists(room, g.size(), [&](const KernelTable& k, kernels::PairList& list) {
            return k.find_near(g.row(0), i, 2 * i, 2 * i + n, list);
          });
        }
      }
    }
  }
}

TEST_F(KernelExact, SelectPairsForEveryTail) {
  for (int round = 0; round < 12; ++round) {
    Random random(700 + static_cast<std::uint64_t>(round));
    Bodies b(random, 40);
    if (round % 2 == 1) b.be_nasty(random, 0.2);
    std::vector<std::uint32_t> owner, other;
    for (int p = 0; p < 24; ++p) {
      owner.push_back(static_cast<std::uint32_t>(random.below(40)));
      other.push_back(static_cast<std::uint32_t>(random.below(40)));
    }
    for (std::uint32_t begin = 0; begin < 5; ++begin) {
      for (std::uint32_t n = 0; n <= 17; ++n) {
        const auto selected_by = [&](Isa isa) {
          std::vector<std::uint32_t> i(n + kBlock + 8, Found::kGuard), j = i;
          // Beyond the end lies no slot: a kernel that follows one leaves the columns.
          const std::vector<std::uint32_t> from(owner.begin(), owner.begin() + begin + n);
          const std::vector<std::uint32_t> to(other.begin(), other.begin() + begin + n);
          kernels::PairSelection s;
          s.owner = from.data();
          s.other = to.data();
          s.radius = b.radius.data();
          s.pitch_x = s.pitch_y = kPitch;
          s.time = 0.01f;
          s.slack = 0.05f;
          s.out_owner = i.data();
          s.out_other = j.data();
          const std::uint32_t count = kernels_of(isa).select_pairs(b.view(), s, begin, begin + n);
          for (std::size_t k = n + kBlock; k < i.size(); ++k) {
            EXPECT_EQ(i[k], Found::kGuard);
            EXPECT_EQ(j[k], Found::kGuard);
          }
          i.resize(count);
          j.resize(count);
          return std::pair{i, j};
        };
        const auto scalar = selected_by(Isa::scalar);
        for (const Isa isa : wide_isas()) {
          EXPECT_EQ(scalar, selected_by(isa)) << isa_name(isa) << " of " << n;
        }
      }
    }
  }
}

// ---- contacts -----------------------------------------------------------------------------------

/// Contacts: every count of used lanes, from all padding to full blocks; ranges of 0..3 blocks
/// inside five; plain and nasty columns; uniform and own accelerations.
template <class Each>
void for_contacts(std::uint64_t seed, bool pairs, const Each& each) {
  for (std::size_t used = 0; used <= kBlock && !::testing::Test::HasFailure(); ++used) {
    for (const double nasty : {0.0, 0.05, 0.4}) {
      Random random(seed + used);
      State s;
      s.b = Bodies(random, 18);  // few: a body is in most blocks
      if (nasty > 0) s.b.be_nasty(random, nasty);
      s.c = Contacts(random, s.b, pairs, 5, used);
      if (nasty > 0) s.c.be_nasty(random, nasty);
      for (std::uint32_t n = 0; n <= 3; ++n) {
        for (const bool own : {false, true}) {
          SCOPED_TRACE("used " + std::to_string(used) + " nasty " + std::to_string(nasty) +
                       " blocks " + std::to_string(n) + (own ? " own acc" : ""));
          each(s, own, 1, 1 + n);
        }
      }
    }
  }
}

/// Contact kernels of a kind, by name: pairs or singles.
template <bool Pairs>
struct Kind;
template <>
struct Kind<true> {
  static ContactView view(State& s, Model m, bool bounce) { return s.c.pairs(m, bounce); }
  static auto warm(const KernelTable& k, std::size_t m) { return k.warm[m]; }
  static auto solve(const KernelTable& k, std::size_t m, bool b) { return k.solve[m][b]; }
  static auto relax(const KernelTable& k, std::size_t m, bool b) { return k.relax[m][b]; }
  static auto spend(const KernelTable& k, std::size_t m) { return k.spend[m]; }
  static auto sweep(const KernelTable& k, std::size_t m) { return k.sweep[m]; }
};
template <>
struct Kind<false> {
  static SingleView view(State& s, Model m, bool bounce) { return s.c.singles(m, bounce); }
  static auto warm(const KernelTable& k, std::size_t m) { return k.warm_single[m]; }
  static auto solve(const KernelTable& k, std::size_t m, bool b) { return k.solve_single[m][b]; }
  static auto relax(const KernelTable& k, std::size_t m, bool b) { return k.relax_single[m][b]; }
  static auto spend(const KernelTable& k, std::size_t m) { return k.spend_single[m]; }
  static auto sweep(const KernelTable& k, std::size_t m) { return k.sweep_single[m]; }
};

template <bool Pairs>
void compare_passes(std::uint64_t seed) {
  using Of = Kind<Pairs>;
  const ContactParams p = contact_params();
  for_contacts(seed, Pairs, [&](const State& s, bool own, std::uint32_t i, std::uint32_t n) {
    for (const Model model : kAllModels) {
      const std::size_t m = index_of(model);
      const bool spin = model == Model::rough;
      compare(s, [&](const KernelTable& k, State& at) {
        Of::warm(k, m)(at.b.view(own, spin), Of::view(at, model, false), p, i, n);
      });
      for (const bool bounce : {false, true}) {
        compare(s, [&](const KernelTable& k, State& at) {
          Of::solve(k, m, bounce)(at.b.view(own, spin), Of::view(at, model, bounce), p, i, n);
        });
        compare(s, [&](const KernelTable& k, State& at) {
          Of::relax(k, m, bounce)(at.b.view(own, spin), Of::view(at, model, bounce), p, i, n);
        });
      }
      compare(s, [&](const KernelTable& k, State& at) {
        Of::spend(k, m)(at.b.view(own, spin), Of::view(at, model, true), p, i, n);
      });
    }
  });
}

// A later sweep may skip what no event has changed, register by register, so it is compared on
// columns that a first sweep has left.
template <bool Pairs>
void compare_sweeps(std::uint64_t seed) {
  using Of = Kind<Pairs>;
  int hits = 0, later_hits = 0;
  for_contacts(seed, Pairs, [&](const State& s, bool own, std::uint32_t i, std::uint32_t n) {
    for (const Model model : kAllModels) {
      const bool spin = model == Model::rough;
      const auto sweep = [&](const State& from, bool first, bool last) {
        ContactParams p = contact_params();
        p.first_sweep = first;
        p.last_sweep = last;
        return compare(from, [&](const KernelTable& k, State& at) {
          at.flag = Of::sweep(k, index_of(model))(at.b.view(own, spin, true),
                                                  Of::view(at, model, true), p, i, n, &at.virial);
        });
      };
      sweep(s, true, true);
      const State swept = sweep(s, true, false);
      hits += swept.flag;
      for (const bool last : {false, true}) later_hits += sweep(swept, false, last).flag;
    }
  });
  EXPECT_GT(hits, 100);
  EXPECT_GT(later_hits, 10);
}

TEST_F(KernelExact, Prepare) {
  const ContactParams p = contact_params();
  for_contacts(800, true, [&](const State& s, bool, std::uint32_t i, std::uint32_t n) {
    compare(s, [&](const KernelTable& k, State& at) {
      k.prepare(at.b.view(), at.c.pairs(Model::plain, false), p, i, n);
    });
  });
}

TEST_F(KernelExact, ContactPasses) { compare_passes<true>(900); }
TEST_F(KernelExact, SinglePasses) { compare_passes<false>(1000); }
TEST_F(KernelExact, ContactSweeps) { compare_sweeps<true>(1100); }
TEST_F(KernelExact, SingleSweeps) { compare_sweeps<false>(1200); }

}  // namespace
}  // namespace psim::test
