// The search for pairs and the passes over contacts on every instruction set against the scalar one (kernel_exact.h).
#include "kernel_exact.h"
#include "kernel_grid.h"

namespace psim::test::exact {
namespace {

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
  const auto found_by = [&](const KernelTable& table) {
    Found f(capacity, bodies);
    kernels::PairList list = f.list();
    f.complete = run(table, list);
    f.count = list.count;
    return f;
  };
  const Found scalar = found_by(kernels_of(Isa::scalar));
  for (const Isa isa : wide_isas()) same_lists(scalar, found_by(wide_kernels(isa)), isa_name(isa).data());
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
              const Found f = compare_lists(room, g.size(), [&](const KernelTable& k, kernels::PairList& list) {
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
        const auto selected_by = [&](const KernelTable& table) {
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
          const std::uint32_t count = table.select_pairs(b.view(), s, begin, begin + n);
          for (std::size_t k = n + kBlock; k < i.size(); ++k) {
            EXPECT_EQ(i[k], Found::kGuard);
            EXPECT_EQ(j[k], Found::kGuard);
          }
          i.resize(count);
          j.resize(count);
          return std::pair{i, j};
        };
        const auto scalar = selected_by(kernels_of(Isa::scalar));
        for (const Isa isa : wide_isas()) {
          EXPECT_EQ(scalar, selected_by(wide_kernels(isa))) << isa_name(isa) << " of " << n;
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
          SCOPED_TRACE("used " + std::to_string(used) + " nasty " + std::to_string(nasty) + " blocks " +
                       std::to_string(n) + (own ? " own acc" : ""));
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
  static auto solve(const KernelTable& k, std::size_t m, Bounce b) { return k.solve[m][static_cast<int>(b)]; }
  static auto relax(const KernelTable& k, std::size_t m, Bounce b) { return k.relax[m][static_cast<int>(b)]; }
  static auto spend(const KernelTable& k, std::size_t m) { return k.spend[m]; }
  static auto sweep(const KernelTable& k, std::size_t m, Sweep kind) { return k.sweep[m][static_cast<int>(kind)]; }
};
template <>
struct Kind<false> {
  static StaticContactView view(State& s, Model m, bool bounce) { return s.c.static_contacts(m, bounce); }
  static auto warm(const KernelTable& k, std::size_t m) { return k.warm_static[m]; }
  static auto solve(const KernelTable& k, std::size_t m, Bounce b) { return k.solve_static[m][static_cast<int>(b)]; }
  static auto relax(const KernelTable& k, std::size_t m, Bounce b) { return k.relax_static[m][static_cast<int>(b)]; }
  static auto spend(const KernelTable& k, std::size_t m) { return k.spend_static[m]; }
  static auto sweep(const KernelTable& k, std::size_t m, Sweep kind) {
    return k.sweep_static[m][static_cast<int>(kind)];
  }
};

template <bool Pairs>
void compare_passes(std::uint64_t seed) {
  using Of = Kind<Pairs>;
  const ContactParams p = contact_params();
  for_contacts(seed, Pairs, [&](const State& s, bool own, std::uint32_t i, std::uint32_t n) {
    for (const Model model : kAllModels) {
      const std::size_t m = index_of(model);
      const bool rim_speed = model == Model::rough;
      compare(s, [&](const KernelTable& k, State& at) {
        Of::warm(k, m)(at.b.view(own, rim_speed), Of::view(at, model, false), p, i, n);
      });
      for (const Bounce kind : {Bounce::none, Bounce::edge, Bounce::inner}) {
        const bool bounce = kind != Bounce::none;
        compare(s, [&](const KernelTable& k, State& at) {
          Of::solve(k, m, kind)(at.b.view(own, rim_speed), Of::view(at, model, bounce), p, i, n);
        });
        compare(s, [&](const KernelTable& k, State& at) {
          Of::relax(k, m, kind)(at.b.view(own, rim_speed), Of::view(at, model, bounce), p, i, n);
        });
      }
      compare(s, [&](const KernelTable& k, State& at) {
        Of::spend(k, m)(at.b.view(own, rim_speed), Of::view(at, model, true), p, i, n);
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
      const bool rim_speed = model == Model::rough;
      const auto sweep = [&](const State& from, Sweep kind, bool last) {
        ContactParams p = contact_params();
        p.least_e = last ? 1.0f : 0.0f;
        return compare(from, [&](const KernelTable& k, State& at) {
          at.flag = Of::sweep(k, index_of(model), kind)(at.b.view(own, rim_speed, true), Of::view(at, model, true), p,
                                                        i, n, &at.virial);
        });
      };
      sweep(s, Sweep::first, true);
      const State swept = sweep(s, Sweep::first, false);
      hits += swept.flag;
      for (const bool last : {false, true}) {
        for (const Sweep kind : {Sweep::later, Sweep::sliced}) later_hits += sweep(swept, kind, last).flag;
      }
    }
  });
  EXPECT_GT(hits, 100);
  EXPECT_GT(later_hits, 10);
}

TEST_F(KernelExact, Prepare) {
  const ContactParams p = contact_params();
  for_contacts(800, true, [&](const State& s, bool, std::uint32_t i, std::uint32_t n) {
    compare(s,
            [&](const KernelTable& k, State& at) { k.prepare(at.b.view(), at.c.pairs(Model::plain, false), p, i, n); });
  });
}

TEST_F(KernelExact, ContactPasses) { compare_passes<true>(900); }
TEST_F(KernelExact, StaticPasses) { compare_passes<false>(1000); }
TEST_F(KernelExact, ContactSweeps) { compare_sweeps<true>(1100); }
TEST_F(KernelExact, StaticSweeps) { compare_sweeps<false>(1200); }

}  // namespace
}  // namespace psim::test::exact
