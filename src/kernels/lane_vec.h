// Short names for the registers of a lane type L, and vectors of registers: {x, y} of as many contacts,
// bodies or joints as a register has lanes.
#pragma once

#include <cstdint>

#include "block_layout.h"
#include "compiler.h"
#include "least.h"

namespace psim::kernels {
namespace {

template <class L>
using F = typename L::F;
template <class L>
using D = typename L::D;
template <class L>
using I = typename L::I;
template <class L>
using M = typename L::M;
template <class L>
using Rec = typename L::Rec;
template <class L>
using RecI = typename L::RecI;

/// Zero where |a| <= least; a NaN stays one.
template <class L>
PSIM_INLINE inline Rec<L> snapped(Rec<L> a, float least = kLeast) {
  return drop(abs(a) <= Rec<L>(least, least), a);
}
template <class L>
PSIM_INLINE inline F<L> snapped(F<L> a, F<L> least = kLeast) {
  return drop(abs(a) <= least, a);
}
/// |a|, or, if that is larger, a size whose square is no denormal.
template <class L>
PSIM_INLINE inline Rec<L> squarable(Rec<L> a) {
  return max(Rec<L>(kLeastOffset, kLeastOffset), abs(a));
}
template <class L>
PSIM_INLINE inline F<L> squarable(F<L> a) {
  return max(F<L>(kLeastOffset), abs(a));
}

/// A vector of registers, of floats (Vec) or of doubles (VecD).
template <class T>
struct Vec2 {
  T x, y;

  PSIM_INLINE friend Vec2 operator+(Vec2 a, Vec2 b) { return {a.x + b.x, a.y + b.y}; }
  PSIM_INLINE friend Vec2 operator-(Vec2 a, Vec2 b) { return {a.x - b.x, a.y - b.y}; }
  PSIM_INLINE friend Vec2 operator-(Vec2 a) { return {-a.x, -a.y}; }
  PSIM_INLINE friend Vec2 operator*(T s, Vec2 a) { return {s * a.x, s * a.y}; }
  PSIM_INLINE friend T dot(Vec2 a, Vec2 b) { return a.x * b.x + a.y * b.y; }
  PSIM_INLINE friend T cross(Vec2 a, Vec2 b) { return a.x * b.y - a.y * b.x; }
  PSIM_INLINE friend T norm2(Vec2 a) { return dot(a, a); }
  PSIM_INLINE friend T norm(Vec2 a) { return sqrt(norm2(a)); }
  /// A quarter turn to the left.
  PSIM_INLINE friend Vec2 left_of(Vec2 a) { return {-a.y, a.x}; }
  template <class Mask>
  PSIM_INLINE friend Vec2 select(Mask m, Vec2 yes, Vec2 no) {
    return {select(m, yes.x, no.x), select(m, yes.y, no.y)};
  }
};

template <class L>
using Vec = Vec2<F<L>>;
template <class L>
using VecD = Vec2<D<L>>;

template <class L>
PSIM_INLINE inline Vec<L> load_vec(const float* x, const float* y, std::size_t k) {
  return {L::load(x + k), L::load(y + k)};
}
template <class L>
PSIM_INLINE inline void store_vec(float* x, float* y, std::size_t k, Vec<L> v) {
  L::store(x + k, v.x);
  L::store(y + k, v.y);
}
/// The records of some lanes' bodies; lane k is at slots[kStep * k].
template <class L, int kStep>
PSIM_INLINE inline Vec<L> gather(const float* records, const std::uint32_t* slots) {
  Vec<L> v;
  L::template gather<kStep>(records, slots, v.x, v.y);
  return v;
}
template <class L, int kStep>
PSIM_INLINE inline void scatter(float* records, const std::uint32_t* slots, Vec<L> v) {
  L::template scatter<kStep>(records, slots, v.x, v.y);
}

}  // namespace
}  // namespace psim::kernels
