// In: pairs of hulls. Out: their manifolds. A batch takes 1.3 KB on the stack of its owner.
#include "collide/collide_batch.h"

#include <cstddef>

namespace psim {
namespace {

using kernels::HullPairs;
using kernels::kBlock;

// The kernel reads hulls in place, so that it must know their layout.
static_assert(Hull::kMost == 8 && offsetof(Hull, x) == sizeof(float) * kernels::kHullX &&
              offsetof(Hull, y) == sizeof(float) * kernels::kHullY &&
              offsetof(Hull, nx) == sizeof(float) * kernels::kHullNx &&
              offsetof(Hull, ny) == sizeof(float) * kernels::kHullNy &&
              offsetof(Hull, radius) == sizeof(float) * kernels::kHullRound &&
              offsetof(Hull, reach) == offsetof(Hull, radius) + sizeof(float) &&
              sizeof(Hull) >= sizeof(float) * (kernels::kHullRound + 4));

/// Fewer pairs than this cost less if they are done one by one, since a kernel computes both sides of every branch. A
/// kernel on one lane gains nothing.
constexpr std::uint32_t fewest_of(std::uint32_t width) { return width == 1 ? kBlock + 1 : width == 4 ? 5 : 3; }

}  // namespace

std::uint32_t CollideBatch::kind_of(const Hull& a, const Hull& b) {
  const auto size_of = [](const Hull& h) { return h.count == 1 ? 0u : h.count == 2 ? 1u : h.count <= 4 ? 2u : 3u; };
  const std::uint32_t of_a = size_of(a), of_b = size_of(b);
  if (of_a + of_b == 0) return kKinds;
  return of_a == 0 ? kSizes * (of_b - 1) : kSizes * (of_a - 1) + of_b;
}

void CollideBatch::add(const Hull& a, Rotor qa, const Hull& b, Rotor qb, float dx, float dy, float margin) {
  if (a.count == 1 && b.count != 1) {  // the kernel takes a disc as B
    swapped_ |= 1u << count_;
    return add(b, qb, a, qa, -dx, -dy, margin);
  }
  const std::uint32_t k = count_++;
  a_[k] = &a;
  b_[k] = &b;
  block_.a[k] = a.x;
  block_.b[k] = b.x;
  block_.vertices_a[k] = static_cast<float>(a.count);
  block_.vertices_b[k] = static_cast<float>(b.count);
  block_.ac[k] = qa.c;
  block_.as[k] = qa.s;
  block_.bc[k] = qb.c;
  block_.bs[k] = qb.s;
  block_.dx[k] = dx;
  block_.dy[k] = dy;
  block_.margin[k] = margin;
}

bool CollideBatch::solve(const kernels::KernelTable& kernels, std::uint32_t kind) {
  if (count_ < fewest_of(kernels.width)) {
    block_.hard = 0xFF;
    return false;
  }
  for (std::uint32_t k = count_; k < kBlock; ++k) {  // the kernel looks at all eight
    block_.a[k] = block_.a[0];
    block_.b[k] = block_.b[0];
    for (float* of : {block_.vertices_a, block_.vertices_b, block_.ac, block_.as, block_.bc, block_.bs, block_.dx,
                      block_.dy, block_.margin}) {
      of[k] = of[0];
    }
  }
  kernels.collide[kind / kSizes][kind % kSizes](&block_, 0, 1);
  return true;
}

Manifold CollideBatch::manifold(std::uint32_t k) const {
  const HullPairs& c = block_;
  Manifold m;
  if ((c.hard >> k & 1) != 0) {
    m = collide(*a_[k], {c.ac[k], c.as[k]}, *b_[k], {c.bc[k], c.bs[k]}, c.dx[k], c.dy[k], c.margin[k]);
  } else {
    m.nx = c.nx[k];
    m.ny = c.ny[k];
    if ((c.has[0] >> k & 1) == 0) m.point[0].gap = c.apart[k];
    for (int n = 0; n < 2 && (c.has[n] >> k & 1) != 0; ++n) {
      const HullPairs::Point& p = c.point[n];
      const auto feature = static_cast<std::uint16_t>(p.feature[k]);
      m.point[m.count++] = {p.ax[k], p.ay[k], p.bx[k], p.by[k], p.gap[k], feature};
    }
  }
  return (swapped_ >> k & 1) != 0 ? swapped(m) : m;
}

}  // namespace psim
