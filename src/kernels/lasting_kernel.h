// Whether manifolds last: the bodies of a contact have hardly moved or turned against each other since their hulls were
// looked at, so that normal and arms stay and only the gaps are computed anew. Manifolds::Look::lasts and judge do the
// same for one contact, in the same bits (docs/decisions/034-manifolds-in-lanes.md).
//
//   move   m, of B against A since then; T the turn of each body since then, r its arm with the rounding
//   gap    gap then + n.move + n.(T_B - 1) r_B - n.(T_A - 1) r_A
//
// kFixedA: A is fixed geometry.
#pragma once

#include "lane_vec.h"
#include "lasting_views.h"
#include "manifold_views.h"
#include "views.h"

namespace psim::kernels {
namespace {

/// A body of some lanes: how far its hull has turned since then.
template <class L>
struct Turn {
  F<L> c, s;     // cosine, and sine, of the angle in between
  F<L> swing_c;  // cosine - 1

  PSIM_INLINE Turn(const float* rotor, const std::uint32_t* slot, const float* then_c, const float* then_s) {
    F<L> to_c, to_s;
    L::template gather<2>(rotor, slot, to_c, to_s);
    const auto from_c = L::load(then_c), from_s = L::load(then_s);
    c = from_c * to_c + from_s * to_s;
    s = from_c * to_s - from_s * to_c;
    swing_c = c - F<L>(1);
  }
  /// How far an arm went along n.
  PSIM_INLINE F<L> swung(Vec<L> n, Vec<L> arm) const {
    return n.x * (swing_c * arm.x - s * arm.y) + n.y * (s * arm.x + swing_c * arm.y);
  }
};

/// Computes the gaps of the lanes that last and count in this step as they did in the last one, and returns a bit for each.
/// Other lanes stay as they are.
template <class L, bool kFixedA>
PSIM_INLINE inline std::uint32_t last_some(const BodyView& b, const LastingColumns& of, ManifoldBlock& c,
                                           const LastingBlock& then, const LastingParams& p, std::uint32_t k) {
  const std::uint32_t* slot = then.body + 2 * k;
  const auto margin = L::load(then.margin + k);
  const F<L> zero = 0;
  const auto known = zero <= margin;
  if (!any(known)) return 0;
  I<L> x, y, ax, ay;
  L::template gather_int<2>(b.pos, slot + 1, x, y);
  auto rest = gather<L, 2>(b.disp, slot + 1), v = gather<L, 2>(b.vel, slot + 1);
  auto rim = abs(L::template gather1<2>(b.rim_speed, slot + 1));
  auto inner = L::template gather1<2>(of.inner, slot + 1);
  if constexpr (!kFixedA) {
    L::template gather_int<2>(b.pos, slot, ax, ay);
    x = x - ax;
    y = y - ay;
    rest = rest - gather<L, 2>(b.disp, slot);
    v = v - gather<L, 2>(b.vel, slot);
    rim = rim + abs(L::template gather1<2>(b.rim_speed, slot));
    inner = min(inner, L::template gather1<2>(of.inner, slot));
  }
  const Vec<L> move = {to_float(x - L::load_int(then.x + k)) * p.pitch_x + (rest.x - L::load(then.dx + k)),
                       to_float(y - L::load_int(then.y + k)) * p.pitch_y + (rest.y - L::load(then.dy + k))};
  const auto closing = norm(v) + rim + p.fall;
  const auto wanted = p.nearby * inner + p.ahead * closing;
  const Turn<L> turn_b(of.rotor, slot + 1, then.bc + k, then.bs + k);
  auto moved = norm(move) + L::template gather1<2>(of.radius, slot + 1) * abs(turn_b.s);
  const Vec<L> n = load_vec<L>(then.nx, then.ny, k);
  const auto along = n.x * move.x + n.y * move.y;
  F<L> gap[2];
  for (int point = 0; point < 2; ++point) {
    gap[point] = L::load(then.gap[point] + k) + along;
    gap[point] += turn_b.swung(n, load_vec<L>(then.bx[point], then.by[point], k));
  }
  if constexpr (!kFixedA) {
    const Turn<L> turn_a(of.rotor, slot, then.ac + k, then.as + k);
    moved = moved + L::template gather1<2>(of.radius, slot) * abs(turn_a.s);
    for (int point = 0; point < 2; ++point) {
      gap[point] -= turn_a.swung(n, load_vec<L>(then.ax[point], then.ay[point], k));
    }
  }
  const auto least = min(gap[0], gap[1]), most = max(gap[0], gap[1]);
  const auto serves = known & (wanted + moved <= margin) & (moved < p.lasting * inner);
  const auto rocks = (p.rocking * inner < rim * p.dt) & (F<L>(10) * least < most) & (most < p.ahead * closing);
  const auto touches = least <= max(p.apart * inner, min(F<L>(p.sinks), p.fallen * inner));
  auto steady = but_not(serves & touches, rocks);
  if constexpr (kFixedA) {
    steady = steady & (p.dt * closing <= p.slow * inner) & (L::load(then.deepest + k) <= least);
  }
  for (int point = 0; point < 2; ++point) {
    float* const to = c.point[point].gap + k;
    L::store(to, select(steady & (gap[point] < F<L>(kNoPoint)), gap[point], L::load(to)));
  }
  return bits(steady);
}

/// steady: by block, a bit for each lane.
template <class L, bool kFixedA>
void last_manifolds(const BodyView& b, const LastingColumns& of, ManifoldBlock* blocks, const LastingBlock* then,
                    const LastingParams& p, std::uint8_t* steady, std::uint32_t begin, std::uint32_t end) {
  for (std::uint32_t block = begin; block != end; ++block) {
    std::uint32_t lanes = 0;
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      lanes |= last_some<L, kFixedA>(b, of, blocks[block], then[block], p, k) << k;
    }
    steady[block] = static_cast<std::uint8_t>(lanes);
  }
}

}  // namespace
}  // namespace psim::kernels
