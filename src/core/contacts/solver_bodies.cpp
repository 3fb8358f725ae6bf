#include "contacts/solver_bodies.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

#include "base/tasks.h"
#include "compiler.h"

namespace psim {

using kernels::kBlock;

// If more than 0.6 of all bodies are linked, copying them costs more than it saves. Copies begin below one share of
// linked bodies and end above another one, because each change makes room in other columns.
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

template <class T>
void copy_record(const Column<T>& from, std::size_t i, Column<T>& to, std::size_t n) {
  to[2 * n] = from[2 * i];
  to[2 * n + 1] = from[2 * i + 1];
}

}  // namespace

// Uses the columns of all bodies as they stand.
void SolverBodies::take_all(std::size_t strips, bool impacts) {
  compact_ = false;
  count_ = b_.count;
  const std::size_t all = dummies() + kernels::round_up_block(2 * strips);
  const auto add_dummies = [&](std::size_t width, auto&... columns) {
    (columns.reserve(width * all), ...);
    (std::fill(columns.data() + width * dummies(), columns.data() + width * all, 0), ...);
  };
  add_dummies(2, b_.pos, b_.vel, b_.disp, b_.vel0);
  if (!b_.rim_speed.empty()) add_dummies(1, b_.rim_speed, b_.rim_speed0);
  if (!b_.angle_change.empty()) add_dummies(1, b_.angle_change);
  if (!b_.arm_change.empty()) add_dummies(2, b_.arm_change);
  if (impacts) add_dummies(1, b_.event_time);
  if (impacts && !b_.rim_speed.empty()) {
    b_.rim_way.reserve(all);
    std::fill(b_.rim_way.data(), b_.rim_way.data() + all, 0.0f);
  }
}

void SolverBodies::choose(const PairTable& table, bool compact, bool impacts) {
  const std::size_t strips = table.strips.size();
  std::uint32_t linked = 0;
  if (compact) {
    strip_begin_.assign(strips, 0);
    pool_.run(strips, [&](std::size_t s) {
      strip_begin_[s] = count_marks(b_.linked.data(), table.strips[s].body_begin, table.strips[s].body_end);
    });
    for (std::uint32_t& begin : strip_begin_) linked += std::exchange(begin, linked);
  }
  if (!compact || linked > (compact_ ? kCompactUntil : kCompactBelow) * b_.count) return take_all(strips, impacts);
  compact_ = true;
  count_ = linked;
  number_.reserve(kernels::round_up_block(b_.count));
  make_room(count_, dummies() + kernels::round_up_block(2 * strips), !b_.rim_speed.empty(), impacts);
  pool_.run(strips, [&](std::size_t s) {
    std::uint32_t n = strip_begin_[s];
    for_marks(b_.linked.data(), table.strips[s].body_begin, table.strips[s].body_end, [&](std::uint32_t i) {
      number_[i] = n;
      slot_[n++] = i;
    });
  });
  std::fill(linked_.data(), linked_.data() + count_, std::uint8_t{0xFF});
}

// Makes room for copies of so many bodies, and resting records up to `all`.
void SolverBodies::make_room(std::size_t bodies, std::size_t all, bool turning, bool impacts) {
  const auto fit = [&](std::size_t width, auto&... columns) {
    (columns.reserve_loosely(width * all), ...);
    (std::fill(columns.data() + width * bodies, columns.data() + width * all, 0), ...);
  };
  fit(2, pos_, vel_, disp_, vel0_);
  fit(1, slot_, linked_);
  if (turning) fit(1, rim_speed_, rim_speed0_);
  if (impacts) fit(1, event_time_);
  if (impacts && turning) {
    rim_way_.reserve_loosely(all);
    std::fill(rim_way_.data(), rim_way_.data() + all, 0.0f);
  }
}

// Calls each(number, slot, soon) for all copies, where `soon` is the slot of one that comes later.
template <class Each>
void SolverBodies::each_copy(const Each& each) const {
  if (!compact_) return;
  run_stream(blocks(), pool_, [&](BlockRange r) {
    const std::size_t end = std::min(count_, r.end * kBlock);
    for (std::size_t n = std::size_t{r.begin} * kBlock; n < end; ++n) {
      each(n, slot_[n], slot_[std::min(n + kAhead, end - 1)]);
    }
  });
}

void SolverBodies::load() {
  const bool turning = turns();
  each_copy([&, turning](std::size_t n, std::size_t i, std::size_t soon) {
    PSIM_PREFETCH(b_.pos.data() + 2 * soon);
    PSIM_PREFETCH(b_.vel.data() + 2 * soon);
    PSIM_PREFETCH(b_.disp.data() + 2 * soon);
    copy_record(b_.pos, i, pos_, n);
    copy_record(b_.vel, i, vel_, n);
    copy_record(b_.disp, i, disp_, n);
    if (turning) rim_speed_[n] = b_.rim_speed[i];
  });
}

void SolverBodies::store() const {
  const bool turning = turns();
  each_copy([&, turning](std::size_t n, std::size_t i, std::size_t soon) {
    PSIM_PREFETCH_TO_WRITE(b_.vel.data() + 2 * soon);
    PSIM_PREFETCH_TO_WRITE(b_.disp.data() + 2 * soon);
    copy_record(vel_, n, b_.vel, i);
    copy_record(disp_, n, b_.disp, i);
    if (turning) b_.rim_speed[i] = rim_speed_[n];
  });
}

kernels::BodyView SolverBodies::view() {
  if (!compact_) return b_.view();
  return {.pos = pos_.data(),
          .vel = vel_.data(),
          .vel0 = vel0_.data(),
          .disp = disp_.data(),
          .rim_speed = turns() ? rim_speed_.data() : nullptr,
          .rim_speed0 = turns() ? rim_speed0_.data() : nullptr,
          .event_time = event_time_.data(),
          .rim_way = rim_way_.data(),
          .linked = linked_.data()};
}

}  // namespace psim
