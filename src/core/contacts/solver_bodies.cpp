#include "contacts/solver_bodies.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "base/tasks.h"

namespace psim {

using kernels::kBlock;

// If more than 0.6 of all bodies are linked, copying them costs more than it saves. Each way has columns of its own, so
// that the present one is kept for a while.
constexpr double kCompactBelow = 0.5, kCompactUntil = 0.75;
constexpr std::size_t kAhead = 24;  // a copy prefetches the body that comes so many bodies later

namespace {

constexpr std::uint64_t kOnes = 0x0101010101010101;

// Gathers eight marks, each in the lowest bit of its byte, into one byte.
std::uint64_t eight_marks(const std::uint8_t* linked) {
  std::uint64_t marks;
  std::memcpy(&marks, linked, sizeof marks);
  return marks & kOnes;
}

std::uint32_t count_marks(const std::uint8_t* linked, std::uint32_t begin, std::uint32_t end) {
  std::uint32_t n = 0, i = begin;
  for (; i + 8 <= end; i += 8) n += static_cast<std::uint32_t>(eight_marks(linked + i) * kOnes >> 56);
  for (; i < end; ++i) n += linked[i] & 1u;
  return n;
}

template <class Each>
void for_marks(const std::uint8_t* linked, std::uint32_t begin, std::uint32_t end, const Each& each) {
  std::uint32_t i = begin;
  for (; i + 8 <= end; i += 8) {
    for (std::uint64_t m = eight_marks(linked + i); m != 0; m &= m - 1) {
      each(i + static_cast<std::uint32_t>(std::countr_zero(m)) / 8);
    }
  }
  for (; i < end; ++i) {
    if ((linked[i] & 1u) != 0) each(i);
  }
}

}  // namespace

// Uses the columns of all bodies as they stand.
void SolverBodies::take_all(BodyStore& b, std::size_t strips, bool impacts) {
  const bool turning = !b.rim_speed.empty();
  compact_ = false;
  count_ = b.count;
  const std::size_t all = dummies() + kernels::round_up_block(2 * strips);
  b.pos.reserve(2 * all);
  b.vel.reserve(2 * all);
  b.disp.reserve(2 * all);
  b.vel0.reserve(2 * all);
  if (turning) {
    b.rim_speed.reserve(all);
    b.rim_speed0.reserve(all);
  }
  if (impacts) b.event_time.reserve(all);
  const bool swinging = !b.arm_change.empty();
  if (swinging) {
    b.arm_change.reserve(2 * all);
    b.angle_change.reserve(all);
  }
  for (std::size_t d = dummies(); d < all; ++d) {
    b.pos[2 * d] = b.pos[2 * d + 1] = 0;
    b.vel[2 * d] = b.vel[2 * d + 1] = b.disp[2 * d] = b.disp[2 * d + 1] = 0;
    b.vel0[2 * d] = b.vel0[2 * d + 1] = 0;
    if (turning) b.rim_speed[d] = b.rim_speed0[d] = 0;
    if (swinging) b.arm_change[2 * d] = b.arm_change[2 * d + 1] = b.angle_change[d] = 0;
    if (impacts) b.event_time[d] = 0;
  }
}

// Counts the linked bodies strip by strip: strip_begin_[s] is the number of the first one of s.
void SolverBodies::count_linked(const BodyStore& b, const PairTable& table, WorkerPool& pool) {
  const std::size_t strips = table.strips.size();
  strip_begin_.assign(strips + 1, 0);
  pool.run(strips, [&](std::size_t s) {
    const Strip& strip = table.strips[s];
    strip_begin_[s + 1] = count_marks(b.linked.data(), strip.body_begin, strip.body_end);
  });
  for (std::size_t s = 0; s < strips; ++s) strip_begin_[s + 1] += strip_begin_[s];
}

void SolverBodies::choose(BodyStore& b, const PairTable& table, bool compact, bool impacts, WorkerPool& pool) {
  const std::size_t strips = table.strips.size();
  const bool turning = !b.rim_speed.empty();
  if (compact) count_linked(b, table, pool);
  if (!compact || strip_begin_[strips] > (compact_ ? kCompactUntil : kCompactBelow) * b.count) {
    take_all(b, strips, impacts);
    return;
  }
  compact_ = true;
  number_.reserve(kernels::round_up_block(b.count));
  count_ = strip_begin_[strips];
  const std::size_t all = dummies() + kernels::round_up_block(2 * strips);
  make_room(all, turning, impacts);
  pool.run(strips, [&](std::size_t s) {
    const Strip& strip = table.strips[s];
    std::uint32_t n = strip_begin_[s];
    for_marks(b.linked.data(), strip.body_begin, strip.body_end, [&](std::uint32_t i) {
      number_[i] = n;
      slot_[n++] = i;
    });
  });
  std::fill(linked_.data(), linked_.data() + count_, std::uint8_t{0xFF});
  std::fill(linked_.data() + count_, linked_.data() + all, std::uint8_t{0});
  for (std::size_t d = count_; d < all; ++d) {
    pos_[2 * d] = pos_[2 * d + 1] = 0;
    vel_[2 * d] = vel_[2 * d + 1] = disp_[2 * d] = disp_[2 * d + 1] = 0;
    vel0_[2 * d] = vel0_[2 * d + 1] = 0;
    if (turning) spin_[d] = spin0_[d] = 0;
    if (impacts) event_time_[d] = 0;
  }
}

void SolverBodies::make_room(std::size_t all, bool turning, bool impacts) {
  slot_.reserve_loosely(all);
  pos_.reserve_loosely(2 * all);
  vel_.reserve_loosely(2 * all);
  disp_.reserve_loosely(2 * all);
  vel0_.reserve_loosely(2 * all);
  linked_.reserve_loosely(all);
  if (turning) {
    spin_.reserve_loosely(all);
    spin0_.reserve_loosely(all);
  }
  if (impacts) event_time_.reserve_loosely(all);
}

void SolverBodies::spare(std::size_t bodies, bool turning, bool impacts) {
  number_.reserve(kernels::round_up_block(bodies));
  make_room(bodies, turning, impacts);
}

template <bool kTurns>
void SolverBodies::load_range(const BodyStore& b, BlockRange r) {
  const std::size_t end = std::min(count_, r.end * kBlock);
  for (std::size_t n = std::size_t{r.begin} * kBlock; n < end; ++n) {
    const std::size_t i = slot_[n], soon = slot_[std::min(n + kAhead, end - 1)];
    __builtin_prefetch(b.pos.data() + 2 * soon);
    __builtin_prefetch(b.vel.data() + 2 * soon);
    __builtin_prefetch(b.disp.data() + 2 * soon);
    pos_[2 * n] = b.pos[2 * i];
    pos_[2 * n + 1] = b.pos[2 * i + 1];
    vel_[2 * n] = b.vel[2 * i];
    vel_[2 * n + 1] = b.vel[2 * i + 1];
    disp_[2 * n] = b.disp[2 * i];
    disp_[2 * n + 1] = b.disp[2 * i + 1];
    if constexpr (kTurns) spin_[n] = b.rim_speed[i];
  }
}

void SolverBodies::load(const BodyStore& b, WorkerPool& pool) {
  if (!compact_) return;
  const auto load = turns(b) ? &SolverBodies::load_range<true> : &SolverBodies::load_range<false>;
  pool.run(stream_tasks(blocks()), [&](std::size_t t) { (this->*load)(b, stream_range(t, blocks())); });
}

template <bool kTurns>
void SolverBodies::store_range(BodyStore& b, BlockRange r) const {
  const std::size_t end = std::min(count_, r.end * kBlock);
  for (std::size_t n = std::size_t{r.begin} * kBlock; n < end; ++n) {
    const std::size_t i = slot_[n], soon = slot_[std::min(n + kAhead, end - 1)];
    __builtin_prefetch(b.vel.data() + 2 * soon, 1);
    __builtin_prefetch(b.disp.data() + 2 * soon, 1);
    b.vel[2 * i] = vel_[2 * n];
    b.vel[2 * i + 1] = vel_[2 * n + 1];
    b.disp[2 * i] = disp_[2 * n];
    b.disp[2 * i + 1] = disp_[2 * n + 1];
    if constexpr (kTurns) b.rim_speed[i] = spin_[n];
  }
}

void SolverBodies::store(BodyStore& b, WorkerPool& pool) const {
  if (!compact_) return;
  const auto store = turns(b) ? &SolverBodies::store_range<true> : &SolverBodies::store_range<false>;
  pool.run(stream_tasks(blocks()), [&](std::size_t t) { (this->*store)(b, stream_range(t, blocks())); });
}

void SolverBodies::forget(bool rotation, bool impacts) {
  if (rotation) {
    spin_.release();
    spin0_.release();
  }
  if (impacts) event_time_.release();
}

kernels::BodyView SolverBodies::view(BodyStore& b) {
  if (!compact_) return b.view();
  kernels::BodyView v;
  v.pos = pos_.data();
  v.vel = vel_.data();
  v.vel0 = vel0_.data();
  v.disp = disp_.data();
  v.rim_speed = turns(b) ? spin_.data() : nullptr;
  v.rim_speed0 = turns(b) ? spin0_.data() : nullptr;
  v.event_time = event_time_.empty() ? nullptr : event_time_.data();
  v.linked = linked_.data();
  return v;
}

}  // namespace psim
