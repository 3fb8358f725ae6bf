// Contacts with kinematic bodies that turn fast: normal and points are found anew in every substep, for the middle of it
// before the solve pass, and for its end before the relax pass.
// A manifold that stands still for a frame would let a body sink into an arm that turns by a part of a radian meanwhile.
#include <cmath>
#include <limits>

#include "base/elementary.h"
#include "contacts/contact_model.h"
#include "least.h"
#include "manifolds/manifold_look.h"

namespace psim {
namespace {

using kernels::kBlock;
using kernels::ManifoldBlock;
using kernels::snapped;

constexpr float kFastTurn = 0.01f;  // rad in a step: a body that turns less is as good as one that goes straight

// The sums of what the points of a lane do along the normal: their impulses, and those times their arms on B.
struct Push {
  double impulse = 0, turn = 0;
};
Push push_of(const ManifoldBlock& c, std::uint32_t l) {
  Push sum;
  for (const ManifoldBlock::Point& p : c.point) {
    sum.impulse += double{p.impulse[l]};
    sum.turn += double{p.impulse[l]} * double{p.bt[l]};
  }
  return sum;
}

}  // namespace

bool Manifolds::turns_fast(const ManifoldPair& pair, float dt) const {
  if (!pair.fixed_a || pair.of_piece() || s_.bodies.rim_speed.empty()) return false;
  const std::size_t i = pair.a;
  const BodyKind& kind = s_.bodies.kind(pair.id_a);
  return kind.hull_count == 1 && std::fabs(s_.bodies.rim_speed[i]) * dt > kFastTurn * s_.bodies.radius[i];
}

void Manifolds::list_turning(float dt) {
  turning_.clear();
  for (const std::uint64_t fixed : fixed_) {
    const auto k = static_cast<std::uint32_t>(fixed);
    if (pairs_[k].active && pairs_[k].lane != PairName::kNone && turns_fast(pairs_[k], dt)) turning_.push_back(k);
  }
}

// The velocity of B holds the impulses of the points: they turn with the normal.
void Manifolds::follow_turning(const kernels::BodyView& view, double ahead) {
  const BodyStore& b = s_.bodies;
  for (const std::uint32_t k : turning_) {
    ManifoldPair& pair = pairs_[k];
    const std::size_t i = pair.a, j = pair.b;
    ManifoldBlock& c = strips_[strip_of(k)].blocks[pair.lane / kBlock];
    const std::uint32_t l = pair.lane % kBlock;
    const auto record = [](const float* column, std::size_t n) { return Vec2{column[2 * n], column[2 * n + 1]}; };
    const auto turn_ahead = [&](std::size_t n) {
      return ahead * static_cast<double>(view.rim_speed[n]) / static_cast<double>(b.radius[n]);
    };
    const Vec2 moved = record(view.disp, j) - record(view.disp, i), u = record(view.vel, j) - record(view.vel, i);
    const Vec2 way = s_.lattice.steps(b.point(i), b.point(j)) + moved + ahead * u;
    std::optional<Hull> own_a, own_b;
    const auto hull_of = [&](std::size_t n, std::uint32_t part, std::optional<Hull>& own) -> const Hull& {
      return has_corners(n) ? b.hulls[b.kind(b.id[n]).first_hull + part] : own.emplace(disc_hull(b.radius[n]));
    };
    const auto rotor_at = [&](std::size_t n) {
      return has_corners(n) ? rotor_of(b.angle[n] + turn_ahead(n)) : Rotor{};
    };
    const Hull &hull_a = hull_of(i, pair.part_a, own_a), &hull_b = hull_of(j, pair.part_b, own_b);
    const Manifold m = collide(hull_a, rotor_at(i), hull_b, rotor_at(j), snapped(way.x, kernels::kLeastOffset),
                               snapped(way.y, kernels::kLeastOffset), std::numeric_limits<float>::infinity());
    if (m.count == 0) continue;
    const Push before = push_of(c, l);
    const Vec2 old{c.nx[l], c.ny[l]};
    put_turned(pair, m, c, l, view, moved, u, ahead);
    const Push now = push_of(c, l);
    const Vec2 change = now.impulse * Vec2{m.nx, m.ny} - before.impulse * old;
    const float x = snapped(c.wb[l] * change.x), y = snapped(c.wb[l] * change.y);
    const float turn = snapped(c.gb[l] * (now.turn - before.turn));
    if (ahead > 0) {  // what the kick repeated is to be along the new normal
      view.vel[2 * j] += x;
      view.vel[2 * j + 1] += y;
      view.rim_speed[j] += turn;
    } else {  // what was done is done, but the next kick shall repeat it along the new normal
      view.vel0[2 * j] -= x;
      view.vel0[2 * j + 1] -= y;
      view.rim_speed0[j] -= turn;
    }
    pair.manifold = m;
    pair.margin = -1;  // the hulls are looked at again in the next step
  }
}

void Manifolds::foretell(ManifoldPair& pair, ManifoldBlock& c, const Manifold& m, const kernels::BodyView& view, Vec2 u,
                         double ahead) const {
  const auto moved_of = [&](std::size_t n) { return Vec2{view.disp[2 * n], view.disp[2 * n + 1]}; };
  const Vec2 moved = moved_of(pair.b) - (pair.of_piece() ? Vec2{} : moved_of(pair.a));
  put_turned(pair, m, c, pair.lane % kBlock, view, moved, u, ahead);
  pair.manifold = m;
  pair.margin = -1;  // the hulls are looked at again in the next step
}

// Writes the manifold of a time that lies `ahead`, s, into the lane of its pair. Impulses follow their points by feature.
void Manifolds::put_turned(const ManifoldPair& pair, const Manifold& m, ManifoldBlock& c, std::uint32_t l,
                           const kernels::BodyView& view, Vec2 moved, Vec2 u, double ahead) const {
  const BodyStore& b = s_.bodies;
  const bool fixed = pair.of_piece();
  const std::size_t i = fixed ? 0 : pair.a, j = pair.b;
  float impulse[2] = {}, friction[2] = {};
  for (int k = 0; k < m.count; ++k) {
    for (int o = 0; o < pair.manifold.count; ++o) {
      if (pair.manifold.point[o].feature != m.point[k].feature) continue;
      impulse[k] = greater(c.point[o].impulse[l], 0.0f);
      friction[k] = c.point[o].friction[l];
    }
  }
  c.nx[l] = snapped(m.nx);
  c.ny[l] = snapped(m.ny);
  c.apart[l] = fixed ? 0.0f : m.nx * (m.point[0].ax - m.point[0].bx) + m.ny * (m.point[0].ay - m.point[0].by);
  const auto lead = [&](std::size_t n) {
    return snapped(view.angle_change[n] + static_cast<float>(ahead) * (view.rim_speed[n] / b.radius[n]));
  };
  c.lead_a[l] = fixed ? 0.0f : lead(i);
  c.lead_b[l] = lead(j);
  const auto along = [&](float x, float y) { return m.nx * x + m.ny * y; };
  const auto across = [&](float x, float y) { return x * m.ny - y * m.nx; };
  for (int k = 0; k < 2; ++k) {
    ManifoldBlock::Point& p = c.point[k];
    p.impulse[l] = impulse[k];
    p.friction[l] = friction[k];
    p.gap[l] = kNoGap;
    p.an[l] = p.at[l] = p.bn[l] = p.bt[l] = 0;
    if (k >= m.count) continue;
    const ManifoldPoint& from = m.point[k];
    p.an[l] = fixed ? 0.0f : snapped(along(from.ax, from.ay) / b.radius[i]);
    p.at[l] = fixed ? 0.0f : snapped(across(from.ax, from.ay) / b.radius[i]);
    p.bn[l] = snapped(along(from.bx, from.by) / b.radius[j]);
    p.bt[l] = snapped(across(from.bx, from.by) / b.radius[j]);
    // The gap is such that the kernel finds the separation that is right at that time.
    const float* const ta = view.arm_change + 2 * i;
    const float* const tb = view.arm_change + 2 * j;
    const float turned = (tb[0] + c.lead_b[l] * tb[1]) * (p.bn[l] + c.round_b[l]) + tb[1] * p.bt[l] -
                         (fixed ? 0.0f : (ta[0] + c.lead_a[l] * ta[1]) * (p.an[l] - c.round_a[l]) + ta[1] * p.at[l]);
    const float speed = along(static_cast<float>(u.x), static_cast<float>(u.y)) + view.rim_speed[j] * p.bt[l] -
                        (fixed ? 0.0f : view.rim_speed[i] * p.at[l]);
    p.gap[l] = from.gap - static_cast<float>(ahead) * speed -
               along(static_cast<float>(moved.x), static_cast<float>(moved.y)) - turned;
  }
}

}  // namespace psim
