#include "query/publish.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace psim {
namespace {

struct Row {
  float x = 0, y = 0, angle = 0, speed = 0;  // m from the lattice centre, radians, m/s
};

Row row_of(std::uint32_t id, const BodyStore& b, const std::vector<FixedBody>& fixed,
           const std::vector<BodyState>& frozen, const std::vector<Sleeper>& sleepers, const Lattice& lattice) {
  const BodyInfo& info = b.info[id];
  if (info.place == Place::asleep) {
    const Sleeper& s = sleepers[info.slot];
    const Vec2 arm = arm_of(b.kind(id), s.angle);
    return {static_cast<float>(s.at.x * lattice.pitch_x() + static_cast<double>(s.at.dx) - arm.x),
            static_cast<float>(s.at.y * lattice.pitch_y() + static_cast<double>(s.at.dy) - arm.y),
            static_cast<float>(s.angle), 0};
  }
  if (info.place == Place::moving) {
    const std::size_t i = info.slot;
    const Vec2 arm = b.angle.empty() ? Vec2{} : arm_of(b.kind(id), b.angle[i]);
    return {static_cast<float>(b.pos[2 * i] * lattice.pitch_x() + static_cast<double>(b.disp[2 * i]) - arm.x),
            static_cast<float>(b.pos[2 * i + 1] * lattice.pitch_y() + static_cast<double>(b.disp[2 * i + 1]) - arm.y),
            b.angle.empty() ? 0.0f : static_cast<float>(b.angle[i]),
            std::sqrt(b.vel[2 * i] * b.vel[2 * i] + b.vel[2 * i + 1] * b.vel[2 * i + 1])};
  }
  const Vec2 centre = lattice.centre();
  const auto still = [&](const auto& f) -> Row {
    return {static_cast<float>(f.x - centre.x), static_cast<float>(f.y - centre.y), static_cast<float>(f.angle), 0};
  };
  return info.place == Place::fixed ? still(fixed[info.slot]) : still(frozen[info.slot]);
}

// The place before, moved to the side of a periodic seam on which `now` is: a body that crosses the seam does not fly
// back through the world between two frames. The period of a world without seams is infinite.
float near_to(float now, float before, float period) {
  if (now - before > period / 2) return before + period;
  if (before - now > period / 2) return before - period;
  return before;
}

}  // namespace

void Publisher::look(const BodyStore& b, const std::vector<FixedBody>& fixed, const std::vector<BodyState>& frozen,
                     const std::vector<Sleeper>& sleepers, const Lattice& lattice) {
  b.find_slots();
  for (std::vector<float>* c : {&last_x_, &last_y_, &last_angle_}) c->resize(b.id_count);
  for (std::uint32_t id = 0; id < b.id_count; ++id) {
    if (b.info[id].place == Place::none) continue;
    const Row row = row_of(id, b, fixed, frozen, sleepers, lattice);
    last_x_[id] = row.x;
    last_y_[id] = row.y;
    last_angle_[id] = row.angle;
  }
}

void Publisher::publish(const BodyStore& b, const std::vector<FixedBody>& fixed, const std::vector<BodyState>& frozen,
                        const std::vector<Sleeper>& sleepers, const Lattice& lattice, std::uint64_t frame,
                        WorkerPool& pool) {
  b.find_slots();
  Snapshot& s = frames_[back_];
  const std::size_t n = b.living;
  s.frame = frame;
  s.origin = lattice.centre();
  s.id.resize(n);
  for (std::vector<float>* c : {&s.x, &s.y, &s.x_prev, &s.y_prev, &s.angle, &s.angle_prev, &s.radius, &s.speed}) {
    c->resize(n);
  }
  s.asleep.resize(n);
  std::uint32_t row = 0;
  for (std::uint32_t id = 0; id < b.id_count; ++id) {
    if (b.info[id].place != Place::none) s.id[row++] = id;
  }
  const float far = std::numeric_limits<float>::infinity();
  const auto period_x = lattice.wraps() ? static_cast<float>(lattice.pitch_x() * 0x1p32) : far;
  const auto period_y = lattice.wraps() ? static_cast<float>(lattice.pitch_y() * 0x1p32) : far;
  constexpr std::size_t kRows = 8192;
  pool.run((n + kRows - 1) / kRows, [&](std::size_t task) {
    for (std::size_t r = task * kRows; r < std::min(n, (task + 1) * kRows); ++r) {
      const std::uint32_t id = s.id[r];
      const Row now = row_of(id, b, fixed, frozen, sleepers, lattice);
      s.x[r] = now.x;
      s.y[r] = now.y;
      s.x_prev[r] = near_to(now.x, last_x_[id], period_x);
      s.y_prev[r] = near_to(now.y, last_y_[id], period_y);
      s.angle[r] = now.angle;
      s.angle_prev[r] = last_angle_[id];
      s.radius[r] = b.property_table[b.info[id].properties].radius;
      s.speed[r] = now.speed;
      s.asleep[r] = b.info[id].place == Place::asleep;
      last_x_[id] = now.x;
      last_y_[id] = now.y;
      last_angle_[id] = now.angle;
    }
  });
  back_ = middle_.exchange(back_ | kFresh, std::memory_order_acq_rel) & 3u;
}

const Snapshot* Publisher::latest() {
  unsigned seen = middle_.load(std::memory_order_relaxed);
  while ((seen & kFresh) != 0) {  // the flag is gone if release() came between
    if (!middle_.compare_exchange_weak(seen, front_, std::memory_order_acq_rel, std::memory_order_relaxed)) continue;
    front_ = seen & 3u;
    any_ = true;
    break;
  }
  return any_ ? &frames_[front_] : nullptr;
}

void Publisher::release() {
  for (std::vector<float>* c : {&last_x_, &last_y_, &last_angle_}) std::vector<float>().swap(*c);
  frames_[back_] = {};
  back_ = middle_.exchange(back_, std::memory_order_acq_rel) & 3u;  // there is nothing fresh for the reader
  frames_[back_] = {};
}

std::size_t Publisher::bytes() const {
  std::size_t sum = (last_x_.capacity() * 4) * 3;
  for (const Snapshot& s : frames_) sum += s.id.capacity() * 4 + s.x.capacity() * (4 * 8 + 1);
  return sum;
}

}  // namespace psim
