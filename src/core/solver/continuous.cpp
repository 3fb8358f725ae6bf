#include "solver/continuous.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "base/rotor.h"
#include "base/tasks.h"

namespace psim {
namespace {

constexpr float kFast = 0.5f;  // a body is fast if it moves by more than this share of its inner radius in a step
// A body may come this deep, as a share of its inner radius: contacts see to less, and to bodies that only tip, slide
// or land.
constexpr float kDeep = 0.5f;
constexpr std::size_t kTask = 512;

// Whether the points of a body moved far for its size.
bool is_fast(const BodyStore& b, std::size_t i, float inner) {
  const float x = b.disp[2 * i], y = b.disp[2 * i + 1];
  const float swing = b.angle_change.empty() ? 0.0f : b.angle_change[i];
  const float way = std::sqrt(x * x + y * y) + std::fabs(swing) * b.radius[i];  // m
  return way > kFast * inner && std::isfinite(way);
}

void cut(BodyStore& b, std::size_t i, float share) {
  if (!(share < 1)) return;
  b.disp[2 * i] *= share;
  b.disp[2 * i + 1] *= share;
  if (b.angle_change.empty() || b.angle.empty()) return;
  b.angle[i] -= static_cast<double>(b.angle_change[i]) * (1 - static_cast<double>(share));
  b.angle_change[i] *= share;
}

// A body as a sweep sees it: its hulls, or one disc.
struct Swept {
  Swept(const BodyStore& b, std::size_t i)
      : kind(b.kind(b.id[i])),
        hulls(kind.hull_count != 0 ? &b.hulls[kind.first_hull] : &disc.emplace(disc_hull(b.radius[i])),
              std::max(1u, kind.hull_count)),
        inner(kind.hull_count != 0 ? kind.inner : b.radius[i]),
        swing(b.angle_change.empty() ? 0.0 : static_cast<double>(b.angle_change[i])),
        angle(b.angle_of(i) - swing) {}

  const BodyKind& kind;
  std::optional<Hull> disc;  // made for a disc alone
  const std::span<const Hull> hulls;
  const float inner;          // m: to the nearest point of the surface
  const double swing, angle;  // rad: in the step, and at its start
};

// Appends the fixed shapes near the way of a body, and cuts the way at the first of them.
void stop_at_fixed(const Contacts& contacts, bool filters, std::uint32_t i, std::vector<std::uint32_t>& near) {
  const auto& [memory, lattice, b, statics, kernels, pool] = contacts.surroundings;
  const float mx = b.disp[2 * i], my = b.disp[2 * i + 1];
  // Bounded, since a body thrown out of the world may have moved by any amount.
  const auto half = [](float way, double pitch) {
    const double steps = std::nearbyint(static_cast<double>(way) / 2 / pitch);
    return static_cast<std::int32_t>(std::clamp(steps, -0x1p30, 0x1p30));
  };
  const float reach = b.radius[i] + 0.5f * std::sqrt(mx * mx + my * my);
  statics.near(wrap_add(b.pos[2 * i], half(mx, lattice.pitch_x())),
               wrap_add(b.pos[2 * i + 1], half(my, lattice.pitch_y())), reach, near);
  if (near.empty()) return;
  const Swept mine(b, i);
  float first = 1;
  for (const std::uint32_t k : near) {
    const StaticShape& s = statics[k];
    if (s.face || contacts.manifolds.is_ghost(i, k)) continue;
    if (filters && !meet(mine.kind.filter, b.kind(s.owner).filter)) continue;
    const Hull piece = statics.seen_from(k, {b.pos[2 * i], b.pos[2 * i + 1], 0, 0}, 4 * static_cast<double>(reach));
    for (const Hull& hull : mine.hulls) {
      first = std::fmin(
          first, time_of_impact(piece, Rotor{}, hull, mine.angle, mine.swing, 0, 0, mx, my, -kDeep * mine.kind.inner));
    }
  }
  cut(b, i, first);
}

// Sweeps a bullet against another moving body, whose rotation is neglected.
void stop_at_moving(const Surroundings& s, std::size_t i, std::size_t j) {
  BodyStore& b = s.bodies;
  const Swept mine(b, i), theirs(b, j);
  const auto dx = static_cast<float>(wrap_sub(b.pos[2 * i], b.pos[2 * j]) * s.lattice.pitch_x());
  const auto dy = static_cast<float>(wrap_sub(b.pos[2 * i + 1], b.pos[2 * j + 1]) * s.lattice.pitch_y());
  const float mx = b.disp[2 * i] - b.disp[2 * j], my = b.disp[2 * i + 1] - b.disp[2 * j + 1];
  const Rotor q = theirs.kind.hull_count != 0 ? rotor_of(theirs.angle) : Rotor{};
  const float slack = -kDeep * std::fmin(mine.inner, theirs.inner);
  float first = 1;
  for (const Hull& a : theirs.hulls) {
    for (const Hull& hull : mine.hulls) {
      first = std::fmin(first, time_of_impact(a, q, hull, mine.angle, mine.swing, dx, dy, mx, my, slack));
    }
  }
  cut(b, i, first);
}

}  // namespace

std::uint32_t Continuous::stop(const Contacts& contacts, const PairTable& table,
                               const std::vector<std::uint32_t>& bullets, bool filters) {
  const BodyStore& b = contacts.surroundings.bodies;
  const std::vector<std::uint32_t>& slots = contacts.manifolds.shaped();
  const std::size_t shapes = contacts.surroundings.statics.any() ? slots.size() : 0;
  jobs_.resize(std::max(jobs_.size(), jobs_for(slots.size(), kTask)));
  for (Job& job : jobs_) job.fast = job.looks = job.cut = 0;
  run_each(shapes, kTask, contacts.surroundings.pool, [&](std::size_t k, std::size_t n) {
    Job& job = jobs_[n];
    const std::uint32_t i = slots[k];
    if (b.id[i] == kNoSlot || b.linked[i] == 0) return;
    const BodyKind& kind = b.kind(b.id[i]);
    const bool dynamic = b.properties(b.id[i]).type == BodyType::dynamic_body;
    if (kind.sensor || !dynamic || !is_fast(b, i, kind.inner)) return;
    const float before = b.disp[2 * std::size_t{i}] + b.disp[2 * std::size_t{i} + 1];
    job.near.clear();
    stop_at_fixed(contacts, filters, i, job.near);
    ++job.fast;
    job.looks += static_cast<std::uint32_t>(job.near.size());
    if (b.disp[2 * std::size_t{i}] + b.disp[2 * std::size_t{i} + 1] != before) ++job.cut;
  });
  Job sum;
  for (const Job& job : jobs_) {
    sum.fast += job.fast;
    sum.looks += job.looks;
    sum.cut += job.cut;
  }
  fast_count_ = sum.fast;
  looked_ = sum.looks;
  if (!bullets.empty()) stop_bullets(contacts, table, bullets);
  return sum.cut;
}

// Stops fast bullets at other moving bodies. They are few: one by one, in the order of the lists.
void Continuous::stop_bullets(const Contacts& contacts, const PairTable& table,
                              const std::vector<std::uint32_t>& bullets) {
  const BodyStore& b = contacts.surroundings.bodies;
  fast_.assign(b.count, 0);
  bool any = false;
  for (const std::uint32_t id : bullets) {
    if (b.info[id].place != Place::moving) continue;  // it sleeps
    const std::uint32_t i = b.info[id].slot;
    if (!is_fast(b, i, Swept(b, i).inner)) continue;
    fast_[i] = any = true;
    ++fast_count_;
  }
  if (!any) return;
  const auto meet_pair = [&](std::uint32_t i, std::uint32_t j) {
    if (fast_[i] != 0) stop_at_moving(contacts.surroundings, i, j);
    if (fast_[j] != 0) stop_at_moving(contacts.surroundings, j, i);
  };
  for (const ManifoldPair& pair : contacts.manifolds.pairs()) {
    if (pair.a != ManifoldPair::kNone && pair.part_a == 0 && pair.part_b == 0) meet_pair(pair.a, pair.b);
  }
  for (const Strip& s : table.strips) {
    for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) meet_pair(table.owner[p], table.other[p]);
  }
}

}  // namespace psim
