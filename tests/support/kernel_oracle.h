// What the KernelOracle tests share: the scalar kernels against the equations of their comments, written
// anew in double precision and one body or contact at a time. (kernel_exact_test.cpp extends what holds
// for them to every variant.)
#pragma once

#include "kernel_support.h"

namespace psim::test {

inline const KernelTable& scalar() { return kernels_of(Isa::scalar); }

struct Vec {
  double x = 0, y = 0;
};
inline Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y}; }
inline Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y}; }
inline Vec operator*(double s, Vec a) { return {s * a.x, s * a.y}; }
inline double dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y; }
inline double length(Vec a) { return std::hypot(a.x, a.y); }
inline Vec left_of(Vec n) { return {-n.y, n.x}; }

template <class T>
Vec record(const std::vector<T>& column, std::size_t i) {
  return {double(column[2 * i]), double(column[2 * i + 1])};
}
inline Vec place(const Bodies& b, std::size_t i) { return double{kPitch} * record(b.pos, i) + record(b.disp, i); }

inline void expect_near(Vec got, Vec want, double tolerance) {
  EXPECT_NEAR(got.x, want.x, tolerance);
  EXPECT_NEAR(got.y, want.y, tolerance);
}

/// One contact in doubles. A fixed partner has inverse mass 0, and stands still.
struct Contact {
  Vec n, va, vb, da, db, va0, vb0;
  double gap, radius, l, w_a, w_b, m, mu, t, mt, q_a, q_b, u_a, u_b, e, start;
};

inline Contact contact_of(const Bodies& b, const Contacts& c, std::size_t k, Model model) {
  Contact x{};
  const bool pair = c.step == 2;
  const std::size_t i = c.body[c.step * k], j = c.body[c.step * k + c.step - 1];
  x.n = {c.nx[k], c.ny[k]};
  x.gap = c.gap[k];
  x.radius = c.rsum[k];
  x.l = c.impulse[k];
  if (pair) {
    x.va = record(b.vel, i), x.da = record(b.disp, i), x.va0 = record(b.vel0, i);
    x.w_a = model == Model::plain ? 1 : c.wa[k];
  }
  x.vb = record(b.vel, j), x.db = record(b.disp, j), x.vb0 = record(b.vel0, j);
  x.w_b = model == Model::plain ? 1 : c.wb[k];
  x.m = 1 / (x.w_a + x.w_b);
  x.e = c.e[k];
  x.start = c.start[k];
  if (model == Model::rough) {
    x.mu = c.mu[k], x.t = c.friction[k], x.mt = c.tmass[k], x.q_b = c.qb[k], x.u_b = b.rim_speed[j];
    if (pair) x.q_a = c.qa[k], x.u_a = b.rim_speed[i];
  }
  return x;
}

}  // namespace psim::test
