#include "solver/continuous.h"

#include <algorithm>
#include <cmath>

#include "base/rotor.h"

namespace psim {
namespace {

constexpr float kFast = 0.5f;  // a body is fast if it moves by more than this share of its inner radius in a step
// A body may come this deep, as a share of its inner radius: contacts see to less, and to bodies that only tip, slide
// or land.
constexpr float kDeep = 0.5f;
constexpr std::size_t kTask = 512;

// How far the points of a body moved in the step, m.
float way_of(const BodyStore& b, std::size_t i) {
  const float x = b.disp[2 * i], y = b.disp[2 * i + 1];
  const float swing = b.angle_change.empty() ? 0.0f : b.angle_change[i];
  return std::sqrt(x * x + y * y) + std::fabs(swing) * b.radius[i];
}

void cut(BodyStore& b, std::size_t i, float share) {
  b.disp[2 * i] *= share;
  b.disp[2 * i + 1] *= share;
  if (b.angle_change.empty() || b.angle.empty()) return;
  b.angle[i] -= static_cast<double>(b.angle_change[i]) * (1 - static_cast<double>(share));
  b.angle_change[i] *= share;
}

}  // namespace

void Continuous::stop_at_fixed(BodyStore& b, const Manifolds& manifolds, const StaticShapes& statics,
                               const Lattice& lattice, bool filters, std::uint32_t slot,
                               std::vector<std::uint32_t>& near) {
  const std::size_t i = slot;
  const BodyKind& kind = b.kind(b.id[i]);
  const double px = lattice.pitch_x(), py = lattice.pitch_y();
  const float mx = b.disp[2 * i], my = b.disp[2 * i + 1];
  const auto half = [](float way,
                       double pitch) {  // bounded, since a body thrown out of the world may have moved by any amount
    const double steps = std::nearbyint(static_cast<double>(way) / 2 / pitch);
    return static_cast<std::int32_t>(std::clamp(steps, -0x1p30, 0x1p30));
  };
  const float reach = b.radius[i] + 0.5f * std::sqrt(mx * mx + my * my);
  near.clear();
  statics.near(wrap_add(b.pos[2 * i], half(mx, px)), wrap_add(b.pos[2 * i + 1], half(my, py)), reach, near);
  const double swing = static_cast<double>(b.angle_change[i]), angle = b.angle[i] - swing;
  float first = 1;
  for (const std::uint32_t k : near) {
    const StaticShape& s = statics[k];
    if (s.face || manifolds.is_ghost(slot, k)) continue;
    if (filters && !meet(kind.filter, b.kind(s.owner).filter)) continue;
    const Hull piece = statics.seen_from(k, {b.pos[2 * i], b.pos[2 * i + 1], 0, 0}, 4 * static_cast<double>(reach));
    for (std::uint32_t part = 0; part < kind.hull_count; ++part) {
      const Hull& mine = b.hulls[kind.first_hull + part];
      const float t = time_of_impact(piece, Rotor{}, mine, angle, swing, 0, 0, mx, my, -kDeep * kind.inner);
      first = std::fmin(first, t);
    }
  }
  if (first < 1) cut(b, i, first);
}

// Sweeps a bullet against another moving body, whose rotation is neglected.
void Continuous::stop_at_moving(BodyStore& b, const Lattice& lattice, std::uint32_t bullet, std::uint32_t other) {
  const std::size_t i = bullet, j = other;
  const BodyKind &mine = b.kind(b.id[i]), &theirs = b.kind(b.id[j]);
  const auto swing = [&](std::size_t k) {
    return b.angle_change.empty() ? 0.0 : static_cast<double>(b.angle_change[k]);
  };
  const auto angle = [&](std::size_t k) { return b.angle.empty() ? 0.0 : b.angle[k]; };
  const auto dx = static_cast<float>(wrap_sub(b.pos[2 * i], b.pos[2 * j]) * lattice.pitch_x());
  const auto dy = static_cast<float>(wrap_sub(b.pos[2 * i + 1], b.pos[2 * j + 1]) * lattice.pitch_y());
  const float mx = b.disp[2 * i] - b.disp[2 * j], my = b.disp[2 * i + 1] - b.disp[2 * j + 1];
  const Hull disc_i = disc_hull(b.radius[i]), disc_j = disc_hull(b.radius[j]);
  const float inner =
      std::fmin(mine.hull_count != 0 ? mine.inner : b.radius[i], theirs.hull_count != 0 ? theirs.inner : b.radius[j]);
  const Rotor q = theirs.hull_count != 0 ? rotor_of(angle(j) - swing(j)) : Rotor{};
  float first = 1;
  for (std::uint32_t p = 0; p < std::max(1u, theirs.hull_count); ++p) {
    const Hull& a = theirs.hull_count != 0 ? b.hulls[theirs.first_hull + p] : disc_j;
    for (std::uint32_t o = 0; o < std::max(1u, mine.hull_count); ++o) {
      const Hull& hull = mine.hull_count != 0 ? b.hulls[mine.first_hull + o] : disc_i;
      first =
          std::fmin(first, time_of_impact(a, q, hull, angle(i) - swing(i), swing(i), dx, dy, mx, my, -kDeep * inner));
    }
  }
  if (first < 1) cut(b, i, first);
}

std::uint32_t Continuous::stop(BodyStore& b, const Manifolds& manifolds, const PairTable& table,
                               const StaticShapes& statics, const Lattice& lattice,
                               const std::vector<std::uint32_t>& bullets, bool filters, WorkerPool& pool) {
  const std::vector<std::uint32_t>& slots = manifolds.shaped();
  const std::size_t tasks = (slots.size() + kTask - 1) / kTask;
  near_.resize(std::max(near_.size(), tasks));
  cut_.assign(tasks, 0);
  looks_.assign(tasks, 0);
  found_fast_.assign(tasks, 0);
  if (statics.any()) {
    pool.run(tasks, [&](std::size_t t) {
      const std::size_t end = std::min(slots.size(), (t + 1) * kTask);
      for (std::size_t n = t * kTask; n < end; ++n) {
        const std::uint32_t i = slots[n];
        if (b.id[i] == kNoSlot || b.linked[i] == 0) continue;
        const float way = way_of(b, i);
        const BodyKind& kind = b.kind(b.id[i]);
        if (!(way > kFast * kind.inner) || !std::isfinite(way) || kind.sensor ||
            b.properties(b.id[i]).type != BodyType::dynamic_body) {
          continue;
        }
        const float before = b.disp[2 * std::size_t{i}] + b.disp[2 * std::size_t{i} + 1];
        ++found_fast_[t];
        stop_at_fixed(b, manifolds, statics, lattice, filters, i, near_[t]);
        looks_[t] += static_cast<std::uint32_t>(near_[t].size());
        if (b.disp[2 * std::size_t{i}] + b.disp[2 * std::size_t{i} + 1] != before) ++cut_[t];
      }
    });
  }
  std::uint32_t sum = 0;
  for (const std::uint32_t n : cut_) sum += n;
  looked_ = 0;
  for (const std::uint32_t n : looks_) looked_ += n;
  fast_count_ = 0;
  for (const std::uint32_t n : found_fast_) fast_count_ += n;
  if (!bullets.empty()) stop_bullets(b, manifolds, table, lattice, bullets);
  return sum;
}

// Stops fast bullets at other moving bodies. They are few: one by one, in the order of the lists.
void Continuous::stop_bullets(BodyStore& b, const Manifolds& manifolds, const PairTable& table, const Lattice& lattice,
                              const std::vector<std::uint32_t>& bullets) {
  fast_.assign(b.count, 0);
  bool any = false;
  for (const std::uint32_t id : bullets) {
    if (b.info[id].place != Place::moving) continue;  // it sleeps
    const std::uint32_t i = b.info[id].slot;
    const BodyKind& kind = b.kind(id);
    const float inner = kind.hull_count != 0 ? kind.inner : b.radius[i];
    if (!(way_of(b, i) > kFast * inner)) continue;
    fast_[i] = any = true;
    ++fast_count_;
  }
  if (!any) return;
  const auto meet_pair = [&](std::uint32_t i, std::uint32_t j) {
    if (fast_[i] != 0) stop_at_moving(b, lattice, i, j);
    if (fast_[j] != 0) stop_at_moving(b, lattice, j, i);
  };
  for (const ManifoldPair& pair : manifolds.pairs()) {
    if (pair.a != ManifoldPair::kNone && pair.part_a == 0 && pair.part_b == 0) {
      meet_pair(pair.a, pair.b);
    }
  }
  for (const Strip& s : table.strips) {
    for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) meet_pair(table.owner[p], table.other[p]);
  }
}

}  // namespace psim
