#include "sleep/sleepers.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <type_traits>

namespace psim {

bool Sleepers::anyone_slow() const {
  const BodyStore& b = b_;
  const std::uint32_t stride = std::max(1u, b.count / 2048);
  std::uint32_t slow = 0, seen = 0;
  for (std::size_t i = 0; i < b.count; i += stride) {
    if (b.id[i] == kNoSlot) continue;
    ++seen;
    slow += b.vel[2 * i] * b.vel[2 * i] + b.vel[2 * i + 1] * b.vel[2 * i + 1] < kSlow * kSlow;
  }
  return slow > 0 && slow * kFewSlow >= seen;
}

struct Sleepers::Ball {
  float far = 0;        // m
  float most_spin = 0;  // m/s: the fastest rim speed of a body at rest
  int shift[2] = {};    // the middle is stored in units of 2^shift lattice steps
  double unit[2] = {};  // the same in m

  Ball(const BodyProperties& properties, const Lattice& lattice, bool wide) {
    const bool smooth = wide && properties.friction == 0;
    far = wide ? Sleepers::wide_ball(properties.radius, smooth) : Sleepers::ball(properties.radius);
    most_spin = far * static_cast<float>(1 / (smooth ? kCreepTime : kRestTime));
    const double size = static_cast<double>(far) / 64;
    const double pitch[2] = {lattice.pitch_x(), lattice.pitch_y()};
    for (const int axis : {0, 1}) {
      shift[axis] = of(size / pitch[axis]);
      unit[axis] = static_cast<double>(1 << shift[axis]) * pitch[axis];
    }
  }

  static int of(double steps) {  // the exponent of the number
    return std::clamp(static_cast<int>(std::bit_cast<std::uint64_t>(steps) >> 52) - 1023, 0, 16);
  }
  std::uint16_t at(std::int32_t place, int axis) const {
    return static_cast<std::uint16_t>(static_cast<std::uint32_t>(place) >> shift[axis]);
  }
  // The distance of a place from the middle, m.
  float off(std::int32_t place, std::uint16_t middle, int axis) const {
    const auto units = static_cast<std::int16_t>(static_cast<std::uint16_t>(at(place, axis) - middle));
    return static_cast<float>(units * unit[axis]);
  }
  // Whether the i-th body is outside of the ball, or turns too fast.
  bool left(const BodyStore& b, std::size_t i, const Watched& rest, bool wide) const {
    const float x = off(b.pos[2 * i], rest.x[wide], 0), y = off(b.pos[2 * i + 1], rest.y[wide], 1);
    if (x * x + y * y > far * far) return true;
    return !b.rim_speed.empty() && std::fabs(b.rim_speed[i]) > most_spin;
  }
};

bool Sleepers::left_ball(std::size_t i, bool wide) const {
  return Ball(b_.properties(b_.id[i]), lattice_, wide).left(b_, i, watched_[b_.id[i]], wide);
}

bool Sleepers::watch() {
  const BodyStore& b = b_;
  const bool before = watching_;
  watching_ = !list.empty() || anyone_slow();
  if (!watching_) return false;
  watched_.reserve(b.id_count);
  const std::uint32_t blocks = b.blocks();
  pool_.run(stream_tasks(blocks), [&](std::size_t t) {
    const BlockRange r = stream_range(t, blocks);
    const std::size_t end = std::min<std::size_t>(std::size_t{r.end} * kernels::kBlock, b.count);
    const BodyProperties* last = nullptr;  // many bodies in a row have the same properties
    std::array<Ball, 2> balls{Ball(BodyProperties{}, lattice_, false), Ball(BodyProperties{}, lattice_, true)};
    for (std::size_t i = std::size_t{r.begin} * kernels::kBlock; i < end; ++i) {
      if (b.id[i] == kNoSlot) continue;
      const BodyProperties& properties = b.properties(b.id[i]);
      if (last != &properties) {
        last = &properties;
        balls = {Ball(properties, lattice_, false), Ball(properties, lattice_, true)};
      }
      Watched& rest = watched_[b.id[i]];
      for (const bool wide : {false, true}) {
        const Ball& ball = balls[wide];
        if (!before || ball.left(b, i, rest, wide)) {
          rest.x[wide] = ball.at(b.pos[2 * i], 0);
          rest.y[wide] = ball.at(b.pos[2 * i + 1], 1);
          rest.calm[wide] = 0;
        } else if (rest.calm[wide] != 255) {
          ++rest.calm[wide];
        }
      }
    }
  });
  return true;
}

void Sleepers::make_room(std::size_t fall_asleep, bool joined) {
  watched_.reserve(b_.id_count);
  state_.reserve(kernels::round_up_block(b_.count));
  const auto room = [](auto& values, std::size_t n) {
    if (n > values.capacity()) values.reserve(n + n / 8);
  };
  room(number, b_.count);
  room(list, fall_asleep);
  room(touches, kTouchesOfBody * fall_asleep);
  recent.make_room(fall_asleep / 4);  // contacts between bodies that fall asleep and others
  if (joined) {
    room(roots, b_.id_count);
    room(wakeful, b_.id_count);
  }
  room_of_ = b_.count;
}

std::uint32_t Sleepers::needed(double dt, bool creeps) {
  const double watches = std::ceil((creeps ? kCreepTime : kRestTime) / (static_cast<double>(kWatchFrames) * dt));
  return static_cast<std::uint32_t>(std::clamp(watches, 2.0, 250.0));
}

void Sleepers::mark_woken(std::uint32_t id, const LatticePoint& at) {
  watched_.reserve(std::size_t{id} + 1);
  for (const bool wide : {false, true}) {
    const Ball ball(b_.properties(id), lattice_, wide);
    watched_[id].x[wide] = ball.at(at.x, 0);
    watched_[id].y[wide] = ball.at(at.y, 1);
    watched_[id].calm[wide] = 1;
  }
}

bool Sleepers::moves(std::size_t slot, bool creeps) const {
  const bool wide = creeps || b_.properties(b_.id[slot]).friction > 0;
  return calm(b_.id[slot], wide) == 0 || left_ball(slot, wide);
}

void Sleepers::tidy() {
  std::size_t used = 0;
  for (const Sleeper& s : list) used += s.touches;
  if (touches.size() < 2 * used + 4096) return;
  kept_.clear();
  for (Sleeper& s : list) {
    const auto first = touches.begin() + s.first_touch;
    s.first_touch = static_cast<std::uint32_t>(kept_.size());
    kept_.insert(kept_.end(), first, first + s.touches);
  }
  touches.swap(kept_);
}

void Sleepers::release() {
  const auto drop = [](auto&... lists) { (std::remove_reference_t<decltype(lists)>().swap(lists), ...); };
  drop(list, touches, queue, found, number, roots, wakeful, pieces, kept_);
  if (recent.empty()) recent = TouchMemory();
  watched_.release();
  state_.release();
  watching_ = false;
  room_of_ = 0;
}

std::size_t Sleepers::bytes() const {
  const auto of = [](const auto&... lists) { return ((lists.capacity() * sizeof(lists[0])) + ...); };
  return of(list, touches, queue, found, number, roots, wakeful, pieces, kept_) + recent.bytes();
}

}  // namespace psim
