#include "query/turning.h"

#include <cmath>

#include "base/elementary.h"

namespace psim {
namespace {

constexpr double kTouch = 1e-7;   // m: outlines no farther apart touch
constexpr int kMostLooks = 4096;  // a shape that turns along a surface for as long counts as touching there

// The least h > 0 with c0 + c1 h - c2 h^2 = 0, for c0 > 0 and c2 >= 0; infinite if there is none.
double time_to_close(double c0, double c1, double c2) {
  const double root = std::sqrt(c1 * c1 + 4 * c2 * c0);
  return c1 < 0 ? 2 * c0 / (root - c1) : (c1 + root) / (2 * c2);
}

// A look at the two at one time.
struct Look {
  Gap gap;
  bool nears = false;  // a corner that touches comes nearer
  double step = 0;     // share of the way that is safe
};

Look look(const Turning& turning, const Outline& other, double share) {
  const Outline mine = turning.outline_at(share);
  Look out{gap_between(mine, other)};
  const Vec2 n = out.gap.normal;
  double face = -1e300;
  for (int k = 0; k < other.count; ++k) face = greater(dot(n, other.v[k]), face);
  face += mine.radius + other.radius;
  const bool touches = out.gap.distance <= kTouch;
  out.step = 1e300;
  for (int k = 0; k < mine.count; ++k) {
    const Vec2 r = mine.v[k] - share * turning.way;
    const double gap = dot(n, mine.v[k]) - face;
    const double rate = dot(n, turning.way) + turning.rotation * dot(n, upright(r));
    const double bend = turning.rotation * turning.rotation * length_of(r) / 2;
    if (touches && gap <= 2 * kTouch && rate < 0) out.nears = true;
    // From a distance up to half the tolerance; what touches and leaves may come nearer by the tolerance.
    const double room = touches ? greater(gap, 0.0) + kTouch : gap - kTouch / 2;
    const double step = time_to_close(room, rate, bend);
    if (step < out.step) out.step = step;
  }
  return out;
}

}  // namespace

RayEntry touch_turning(const Turning& turning, const Outline& other, double limit) {
  double share = 0;
  Look now;
  for (int looks = 0; looks < kMostLooks; ++looks) {
    now = look(turning, other, share);
    if (looks == 0 && now.gap.distance < 0) return {0, {}};
    if (now.nears) break;
    share += now.step;
    if (!(share <= limit)) return {};
  }
  return {share, now.gap.normal};
}

}  // namespace psim
