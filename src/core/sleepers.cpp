#include "sleepers.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <type_traits>

namespace psim {
namespace {

std::size_t mixed(std::uint64_t key) {
  key = (key ^ (key >> 30)) * 0xBF58476D1CE4E5B9u;
  key = (key ^ (key >> 27)) * 0x94D049BB133111EBu;
  return static_cast<std::size_t>(key ^ (key >> 31));
}

std::size_t size_for(std::size_t touches) {
  std::size_t size = 64;
  while (size < 4 * touches) size *= 2;
  return size;
}

}  // namespace

void TouchMemory::add(const Touch& touch) {
  if (2 * (list_.size() + 1) > slot_.size()) rehash(size_for(list_.size() + 1));
  std::size_t at = mixed(touch.key) & (slot_.size() - 1);
  for (; slot_[at] != kNoSlot; at = (at + 1) & (slot_.size() - 1)) {
    if (list_[slot_[at]].key != touch.key) continue;
    list_[slot_[at]] = touch;
    return;
  }
  slot_[at] = static_cast<std::uint32_t>(list_.size());
  list_.push_back(touch);
}

void TouchMemory::rehash(std::size_t size) {
  slot_.assign(size, kNoSlot);
  for (std::size_t k = 0; k < list_.size(); ++k) {
    std::size_t at = mixed(list_[k].key) & (size - 1);
    while (slot_[at] != kNoSlot) at = (at + 1) & (size - 1);
    slot_[at] = static_cast<std::uint32_t>(k);
  }
}

void TouchMemory::make_room(std::size_t touches) {
  list_.reserve(touches);
  const std::size_t size = size_for(touches / 2 + 1);  // half full
  if (size > slot_.size()) rehash(size);
}

const Touch* TouchMemory::find(std::uint64_t key) const {
  if (list_.empty()) return nullptr;
  for (std::size_t at = mixed(key) & (slot_.size() - 1); slot_[at] != kNoSlot;
       at = (at + 1) & (slot_.size() - 1)) {
    if (list_[slot_[at]].key == key) return &list_[slot_[at]];
  }
  return nullptr;
}

void TouchMemory::clear() {
  if (list_.empty()) return;
  list_.clear();
  std::fill(slot_.begin(), slot_.end(), kNoSlot);
}

bool Sleepers::anyone_slow(const BodyStore& b) const {
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
  float most_spin = 0;  // m/s: of the rim
  int shift[2] = {};    // a unit of its middle: 2^shift lattice steps
  double unit[2] = {};  // and m

  Ball(const Surface& surface, const Lattice& lattice, bool wide) {
    const bool smooth = wide && surface.friction == 0;
    far = wide ? Sleepers::wide_ball(surface.radius, smooth) : Sleepers::ball(surface.radius);
    most_spin = far * static_cast<float>(1 / (smooth ? kLooseTime : kRestTime));
    const double size = static_cast<double>(far) / 64;
    const double pitch[2] = {lattice.pitch_x(), lattice.pitch_y()};
    for (const int axis : {0, 1}) {
      shift[axis] = of(size / pitch[axis]);
      unit[axis] = static_cast<double>(1 << shift[axis]) * pitch[axis];
    }
  }

  static int of(double steps) {  // the exponent
    return std::clamp(static_cast<int>(std::bit_cast<std::uint64_t>(steps) >> 52) - 1023, 0, 16);
  }
  std::uint16_t at(std::int32_t place, int axis) const {
    return static_cast<std::uint16_t>(static_cast<std::uint32_t>(place) >> shift[axis]);
  }
  // From the middle, m.
  float off(std::int32_t place, std::uint16_t middle, int axis) const {
    const auto units =
        static_cast<std::int16_t>(static_cast<std::uint16_t>(at(place, axis) - middle));
    return static_cast<float>(units * unit[axis]);
  }
  // Whether the i-th body is not in it, or turns too fast.
  bool left(const BodyStore& b, std::size_t i, const Rest& rest, bool wide) const {
    const float x = off(b.pos[2 * i], rest.x[wide], 0), y = off(b.pos[2 * i + 1], rest.y[wide], 1);
    if (x * x + y * y > far * far) return true;
    return !b.spin.empty() && std::fabs(b.spin[i]) > most_spin;
  }
};

bool Sleepers::left_ball(const BodyStore& b, const Lattice& lattice, std::size_t i,
                         bool wide) const {
  return Ball(b.surface(b.id[i]), lattice, wide).left(b, i, rest_[b.id[i]], wide);
}

// Both balls about a place.
Sleepers::Rest Sleepers::rest_at(const Surface& surface, const Lattice& lattice, std::int32_t x,
                                 std::int32_t y) {
  Rest rest;
  for (const bool wide : {false, true}) {
    const Ball ball(surface, lattice, wide);
    rest.x[wide] = ball.at(x, 0);
    rest.y[wide] = ball.at(y, 1);
  }
  return rest;
}

bool Sleepers::watch(const BodyStore& b, const Lattice& lattice, WorkerPool& pool) {
  const bool before = watching_;
  watching_ = !list.empty() || anyone_slow(b);
  if (!watching_) return false;
  rest_.reserve(b.id_count);
  const std::uint32_t blocks = b.blocks();
  pool.run(stream_tasks(blocks), [&](std::size_t t) {
    const BlockRange r = stream_range(t, blocks);
    const std::size_t end = std::min<std::size_t>(std::size_t{r.end} * kernels::kBlock, b.count);
    const Surface* last = nullptr;  // many in a row are alike
    std::array<Ball, 2> balls{Ball(Surface{}, lattice, false), Ball(Surface{}, lattice, true)};
    for (std::size_t i = std::size_t{r.begin} * kernels::kBlock; i < end; ++i) {
      if (b.id[i] == kNoSlot) continue;
      const Surface& surface = b.surface(b.id[i]);
      if (last != &surface) {
        last = &surface;
        balls = {Ball(surface, lattice, false), Ball(surface, lattice, true)};
      }
      Rest& rest = rest_[b.id[i]];
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

void Sleepers::make_room(const BodyStore& b, std::size_t fall_asleep, bool joined) {
  rest_.reserve(b.id_count);
  state_.reserve(kernels::round_up_block(b.count));
  const auto room = [](auto& values, std::size_t n) {
    if (n > values.capacity()) values.reserve(n + n / 8);
  };
  room(number, b.count);
  room(list, fall_asleep);
  room(touches, kTouchesOfBody * fall_asleep);
  recent.make_room(fall_asleep / 4);  // those of who falls asleep with who does not
  if (joined) {
    room(roots, b.id_count);
    room(wakeful, b.id_count);
  }
  room_of_ = b.count;
}

std::uint32_t Sleepers::needed(double dt, bool loose) {
  const double watches = std::ceil((loose ? kLooseTime : kRestTime) / (static_cast<double>(kWatchFrames) * dt));
  return static_cast<std::uint32_t>(std::clamp(watches, 2.0, 250.0));
}

void Sleepers::mark_woken(const BodyStore& b, const Lattice& lattice, std::uint32_t id, std::int32_t x, std::int32_t y) {
  rest_.reserve(std::size_t{id} + 1);
  rest_[id] = rest_at(b.surface(id), lattice, x, y);
  rest_[id].calm[0] = rest_[id].calm[1] = 1;
}

bool Sleepers::moves(const BodyStore& b, const Lattice& lattice, std::size_t slot, bool loose) const {
  const bool wide = loose || b.surface(b.id[slot]).friction > 0;
  return calm(b.id[slot], wide) == 0 || left_ball(b, lattice, slot, wide);
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

void Sleepers::pack(const BodyStore& bodies, WorkerPool& pool) {
  packs_.resize((list.size() + SleeperPack::kEach - 1) / SleeperPack::kEach);
  pool.run(packs_.size(), [&](std::size_t k) {
    if (!packs_[k].stale) return;
    pack_sleepers(*this, bodies, k * SleeperPack::kEach, packs_[k].bytes);
    packs_[k].stale = false;
  });
}

void Sleepers::release() {
  const auto drop = [](auto&... lists) { (std::remove_reference_t<decltype(lists)>().swap(lists), ...); };
  drop(list, touches, queue, found, number, roots, wakeful, pieces, kept_, packs_, rests_, recent_);
  if (recent.empty()) recent = TouchMemory();
  rest_.release();
  state_.release();
  watching_ = false;
  room_of_ = 0;
}

std::size_t Sleepers::bytes() const {
  const auto of = [](const auto&... lists) { return ((lists.capacity() * sizeof(lists[0])) + ...); };
  std::size_t packed = 0;
  for (const SleeperPack& pack : packs_) packed += pack.bytes.capacity();
  return of(list, touches, queue, found, number, roots, wakeful, pieces, kept_, packs_, rests_, recent_) + recent.bytes() + packed;
}

}  // namespace psim
