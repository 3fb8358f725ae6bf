#include "sleep/sleepers.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <span>

#include "base/elementary.h"

namespace psim {

bool Sleepers::anyone_slow() const {
  std::uint32_t slow = 0, seen = 0;
  b_.each_sampled([&](std::size_t i) {
    ++seen;
    slow += b_.vel[2 * i] * b_.vel[2 * i] + b_.vel[2 * i + 1] * b_.vel[2 * i + 1] < kSlow * kSlow;
  });
  return slow > 0 && slow * kFewSlow >= seen;
}

struct Sleepers::Ball {
  BallKind kind = kRest;
  float far = 0;        // m
  float most_spin = 0;  // m/s: the fastest rim speed of a body at rest
  int shift[2] = {};    // the middle is stored in units of 2^shift lattice steps
  double unit[2] = {};  // the same in m
  static constexpr float kUnits = 64;
  double rim_units = 0;  // a turn by 1 rad: kUnits are as far as the ball reaches

  Ball(const BodyProperties& properties, const Lattice& lattice, BallKind which) : kind(which) {
    const bool smooth = kind == kWide && properties.friction == 0;
    far = kind == kRest      ? ball(properties.radius)
          : kind == kTremble ? lesser(kTrembleOfRadius * properties.radius, kLargestTremble)
                             : wide_ball(properties.radius, smooth);
    most_spin = far * static_cast<float>(1 / (smooth ? kCreepTime : kind == kTremble ? kTrembleTime : kRestTime));
    const double size = static_cast<double>(far / kUnits);
    rim_units = static_cast<double>(properties.radius) / size;
    const double pitch[2] = {lattice.pitch_x(), lattice.pitch_y()};
    for (const int axis : {0, 1}) {
      const int exponent = static_cast<int>(std::bit_cast<std::uint64_t>(size / pitch[axis]) >> 52) - 1023;
      shift[axis] = std::clamp(exponent, 0, 16);
      unit[axis] = static_cast<double>(1 << shift[axis]) * pitch[axis];
    }
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
  bool left(const BodyStore& b, std::size_t i, const Watched& rest) const {
    const float x = off(b.pos[2 * i], rest.x[kind], 0), y = off(b.pos[2 * i + 1], rest.y[kind], 1);
    if (x * x + y * y > far * far) return true;
    if (kind == kTremble) {
      const auto turn = static_cast<std::int16_t>(static_cast<std::uint16_t>(way_of(b.angle[i]) - rest.turned));
      return std::fabs(static_cast<float>(turn)) > kUnits;
    }
    return !b.rim_speed.empty() && std::fabs(b.rim_speed[i]) > most_spin;
  }
  // How far the rim of a body with this angle went, in units. It stands still at an angle of 1e300: no turn changes that.
  std::uint16_t way_of(double angle) const {
    const double way = std::remainder(angle * rim_units, 65536.0);
    return std::isfinite(way) ? static_cast<std::uint16_t>(static_cast<std::int32_t>(way)) : std::uint16_t{0};
  }
  // Puts the middle at a place and an angle, where the body has stayed for `calm` watches.
  void put(Watched& rest, std::int32_t x, std::int32_t y, double angle, std::uint8_t calm) const {
    if (kind == kTremble) rest.turned = way_of(angle);
    rest.x[kind] = at(x, 0);
    rest.y[kind] = at(y, 1);
    rest.calm[kind] = calm;
  }
};

bool Sleepers::watch() {
  const BodyStore& b = b_;
  const bool before = watching_, turns = !b.arm_change.empty();  // turns: shapes or joints
  watching_ = !list.empty() || anyone_slow();
  if (!watching_) return false;
  watched_.reserve(b.id_count);
  run_stream(b.blocks(), s_.pool, [&](BlockRange r) {
    const std::size_t end = std::min<std::size_t>(std::size_t{r.end} * kernels::kBlock, b.count);
    const BodyProperties* last = nullptr;  // many bodies in a row have the same properties
    const auto balls_of = [&](const BodyProperties& p) {
      return std::array{Ball(p, s_.lattice, kRest), Ball(p, s_.lattice, kWide), Ball(p, s_.lattice, kTremble)};
    };
    auto balls = balls_of({});
    for (std::size_t i = std::size_t{r.begin} * kernels::kBlock; i < end; ++i) {
      if (b.id[i] == kNoSlot) continue;
      const BodyProperties& properties = b.properties(b.id[i]);
      if (last != &properties) {
        last = &properties;
        balls = balls_of(properties);
      }
      Watched& rest = watched_[b.id[i]];
      if (!turns) rest.calm[kTremble] = 0;
      for (const Ball& ball : std::span(balls).first(turns ? 3 : 2)) {
        if (!before || ball.left(b, i, rest)) {
          ball.put(rest, b.pos[2 * i], b.pos[2 * i + 1], turns ? b.angle[i] : 0.0, 0);
        } else if (rest.calm[ball.kind] != 255) {
          ++rest.calm[ball.kind];
        }
      }
    }
  });
  return true;
}

void Sleepers::make_room(std::size_t fall_asleep, bool joined) {
  watched_.reserve(b_.id_count);
  state.reserve(kernels::round_up_block(b_.count));
  const auto room = [](auto& values, std::size_t n) {
    if (n > values.capacity()) values.reserve(n + n / 8);
  };
  room(list, fall_asleep);
  room(touches, kTouchesOfBody * fall_asleep);
  recent.make_room(fall_asleep / 4);  // contacts between bodies that fall asleep and others
  if (joined) room(roots, b_.id_count);
  room_of_ = b_.count;
}

void Sleepers::make_room_for_more(std::size_t bodies, std::size_t with_touches, std::size_t of_awake) {
  const auto room = [](auto& values, std::size_t more) {
    const std::size_t n = values.size() + more;
    if (n > values.capacity()) values.reserve(std::max(n, 2 * values.size()));
  };
  room(list, bodies);
  room(touches, with_touches);
  recent.make_room_for_more(of_awake);
}

std::uint32_t Sleepers::needed(double dt, double time) {
  const double watches = std::ceil(time / (static_cast<double>(kWatchFrames) * dt));
  return static_cast<std::uint32_t>(std::clamp(watches, 2.0, 250.0));
}

void Sleepers::mark_woken(std::uint32_t id, const LatticePoint& at, double angle) {
  watched_.reserve(std::size_t{id} + 1);
  for (const BallKind kind : {kRest, kWide, kTremble}) {
    Ball(b_.properties(id), s_.lattice, kind).put(watched_[id], at.x, at.y, angle, 1);
  }
}

bool Sleepers::moves(std::size_t slot, bool creeps) const {
  const std::uint32_t id = b_.id[slot];
  const BodyProperties& properties = b_.properties(id);
  const bool rough = properties.friction > 0, turns = !b_.arm_change.empty();
  const BallKind kind = creeps && turns ? restless(properties) : creeps || rough ? kWide : kRest;
  return calm(id, kind) == 0 || Ball(properties, s_.lattice, kind).left(b_, slot, watched_[id]);
}

void Sleepers::tidy() {
  const std::size_t used = touches.size() - dropped;
  if (touches.size() < 2 * used + 4096) return;
  kept_.clear();
  try {
    kept_.reserve(used);
  } catch (const std::bad_alloc&) {
    return;  // another time
  }
  for (Sleeper& s : list) {
    const auto first = touches.begin() + s.first_touch;
    s.first_touch = static_cast<std::uint32_t>(kept_.size());
    kept_.insert(kept_.end(), first, first + s.touches);
  }
  touches.swap(kept_);
  dropped = 0;
}

void Sleepers::release() {
  give_back(list, touches, queue, found, roots, pieces, presses, kept_, watched_, state);
  if (recent.empty()) give_back(recent);
  watching_ = false;
  room_of_ = 0;
  dropped = 0;
}

std::size_t Sleepers::bytes() const {
  return bytes_of(list, touches, queue, found, roots, pieces, presses, kept_) + recent.bytes();
}

}  // namespace psim
