// How many threads a step has: after a worker that lost its core, and for steps too small to share.
#include "base/thread_choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <functional>

namespace psim::test {
namespace {

using namespace std::chrono_literals;

// Lets steps run that take as long as `time` says for a number of threads; returns how many of them had one.
int alone_of(int steps, ThreadChoice& choice, const std::function<ThreadChoice::Duration(std::size_t)>& time) {
  int alone = 0;
  for (int k = 0; k < steps; ++k) {
    alone += choice.active() == 1;
    choice.note(time(choice.active()), 0us);
  }
  return alone;
}

TEST(ThreadChoice, LongStepsHaveAllThreads) {
  ThreadChoice choice(8, false);
  EXPECT_EQ(choice.active(), 8u);
  EXPECT_EQ(alone_of(3000, choice, [](std::size_t threads) { return threads == 1 ? 1100us : 1200us; }), 0);
}

TEST(ThreadChoice, ASmallStepHasOneThreadWhereThatIsSooner) {
  for (const std::size_t threads : {std::size_t{2}, std::size_t{16}}) {
    ThreadChoice choice(threads, false);
    EXPECT_GE(alone_of(10'000, choice, [](std::size_t n) { return n == 1 ? 49us : 76us; }), 9'300) << threads;
  }
}

TEST(ThreadChoice, ASmallStepHasAllThreadsWhereThatIsSooner) {
  ThreadChoice choice(2, false);
  EXPECT_LE(alone_of(10'000, choice, [](std::size_t n) { return n == 1 ? 90us : 60us; }), 200);
}

// One step in three makes lists, which takes longer: the shortest of some are compared.
TEST(ThreadChoice, StepsThatMakeListsDoNotDecide) {
  ThreadChoice choice(2, false);
  int n = 0;
  const auto time = [&](std::size_t threads) {
    const auto lists = ++n % 3 == 0 ? 70us : 0us;
    return (threads == 1 ? 49us : 76us) + lists;
  };
  EXPECT_GE(alone_of(10'000, choice, time), 9'500);
}

TEST(ThreadChoice, AStepThatGrowsHasAllThreadsAtOnce) {
  ThreadChoice choice(4, false);
  alone_of(100, choice, [](std::size_t n) { return n == 1 ? 20us : 40us; });
  ASSERT_EQ(choice.active(), 1u);
  choice.note(250us, 0us);  // one such step is chance
  for (int k = 0; k < 12; ++k) choice.note(20us, 0us);
  choice.note(250us, 0us);
  EXPECT_EQ(choice.active(), 1u);
  choice.note(250us, 0us);
  EXPECT_EQ(choice.active(), 4u);
  EXPECT_LE(alone_of(1000, choice, [](std::size_t n) { return n == 1 ? 800us : 240us; }), 12);
}

TEST(ThreadChoice, LongStepsHaveAllThreadsWhateverLiesBetween) {
  ThreadChoice choice(2, false);
  int alone = 0;
  for (int k = 0; k < 3000; ++k) {
    alone += choice.active() == 1;
    choice.note(k % 2 == 0 ? 3000us : 30us, 0us);
  }
  EXPECT_EQ(alone, 0);
}

// Three threads are tried as three, two and one.
TEST(ThreadChoice, NoNumberIsLeftOutOnTheWayDown) {
  ThreadChoice choice(3, false);
  int best = 0;
  for (int k = 0; k < 5000; ++k) {
    best += choice.active() == 2;
    choice.note(choice.active() == 2 ? 50us : 100us, 0us);
  }
  EXPECT_GE(best, 4800);
}

TEST(ThreadChoice, NumbersThatAreFarWorseAreNotTriedToTheEnd) {
  ThreadChoice choice(16, false);
  EXPECT_EQ(alone_of(10'000, choice, [](std::size_t n) { return std::chrono::microseconds(90 + 810 / n); }), 0);
}

// From 120 us on one thread, by a tenth after each 100 steps, to where two are sooner.
TEST(ThreadChoice, AStepThatGrowsSlowlyIsTriedAgain) {
  ThreadChoice choice(2, false);
  double work = 120;
  int worse = 0;
  for (int k = 0; k < 3000; ++k) {
    if (k % 100 == 99) work *= 1.1;
    const double one = work, two = 100 + work / 2;
    const auto took = std::chrono::duration_cast<ThreadChoice::Duration>(
        std::chrono::duration<double, std::micro>(choice.active() == 1 ? one : two));
    worse += (choice.active() == 1 ? one : two) > 1.5 * std::min(one, two);
    choice.note(took, 0us);
  }
  EXPECT_LE(worse, 24);  // but in trials
  EXPECT_EQ(choice.active(), 2u);
}

TEST(ThreadChoice, TheBestNumberMayLieBetween) {
  ThreadChoice choice(16, false);
  const auto time = [](std::size_t n) { return n == 4 ? 100us : n == 1 ? 300us : n == 16 ? 260us : 160us; };
  int best = 0;
  for (int k = 0; k < 10'000; ++k) {
    best += choice.active() == 4;
    choice.note(time(choice.active()), 0us);
  }
  EXPECT_GE(best, 9'500);
}

TEST(ThreadChoice, WhatWasSoonerIsTriedAgain) {
  ThreadChoice choice(2, false);
  alone_of(100, choice, [](std::size_t n) { return n == 1 ? 20us : 40us; });
  ASSERT_EQ(choice.active(), 1u);
  const auto now = [](std::size_t n) { return n == 1 ? 140us : 80us; };
  alone_of(1100, choice, now);
  EXPECT_EQ(choice.active(), 2u);
  EXPECT_LE(alone_of(1000, choice, now), 8);
}

TEST(ThreadChoice, HalfOfTheThreadsAfterAStepThatWasHeldUp) {
  ThreadChoice choice(8, false);
  choice.note(10ms, 4ms);
  EXPECT_EQ(choice.active(), 8u);
  for (const int steps : {4, 8, 16, 32, 64, 64}) {
    choice.note(10ms, 6ms);
    for (int k = 0; k < steps; ++k) {
      EXPECT_EQ(choice.active(), 4u) << steps;
      choice.note(10ms, 6ms);
    }
    EXPECT_EQ(choice.active(), 8u) << steps;
  }
}

TEST(ThreadChoice, OneThreadAndMoreThreadsThanCoresStayAsTheyAre) {
  ThreadChoice one(1, false), crowded(4, true);
  for (int k = 0; k < 100; ++k) {
    one.note(20us, 0us);
    crowded.note(10ms, 9ms);
    ASSERT_EQ(one.active(), 1u);
    ASSERT_EQ(crowded.active(), 4u);
  }
}

}  // namespace
}  // namespace psim::test
