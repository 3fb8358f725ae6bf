#include "geometry/turning.h"

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

// Along a direction towards the other outline: how far a corner lies, how fast it goes, and what the turning bends.
struct Corner {
  double height = 0, rate = 0, bend = 0;
};
struct Corners {
  Corner list[Hull::kMost];
  int count = 0;
};

// Of an outline that does not turn, the foremost corner stands for all.
Corners corners_of(const Turning& turning, const Outline& now, double share, Vec2 ahead) {
  Corners corners;
  for (int k = 0; k < now.count; ++k) {
    const Vec2 r = now.v[k] - turning.place_at(share);
    const Corner corner{dot(ahead, now.v[k]), dot(ahead, turning.way) + turning.rotation * dot(ahead, upright(r)),
                        turning.rotation * turning.rotation * length_of(r) / 2};
    if (turning.rotation != 0 || k == 0) {
      corners.list[corners.count++] = corner;
    } else if (corner.height > corners.list[0].height) {
      corners.list[0] = corner;
    }
  }
  return corners;
}

// A look at the two at one time.
struct Look {
  Gap gap;
  bool nears = false;  // two corners that touch come nearer
  double step = 0;     // share of the way that is safe
};

Look look(const Turning& a, const Turning& b, double share) {
  const Outline now_a = a.outline_at(share), now_b = b.outline_at(share);
  Look out{gap_between(now_a, now_b)};
  const Vec2 n = out.gap.normal;
  const Corners of_a = corners_of(a, now_a, share, -1 * n), of_b = corners_of(b, now_b, share, n);
  const double round = now_a.radius + now_b.radius;
  const bool touches = out.gap.distance <= kTouch;
  out.step = 1e300;
  for (int j = 0; j < of_b.count; ++j) {
    const Corner& other = of_b.list[j];
    for (int k = 0; k < of_a.count; ++k) {
      const Corner& mine = of_a.list[k];
      const double gap = -mine.height - (other.height + round), rate = -(mine.rate + other.rate);
      if (touches && gap <= 2 * kTouch && rate < 0) out.nears = true;
      // From a distance up to half the tolerance; what touches and leaves may come nearer by the tolerance.
      const double room = touches ? greater(gap, 0.0) + kTouch : gap - kTouch / 2;
      const double step = time_to_close(room, rate, mine.bend + other.bend);
      if (step < out.step) out.step = step;
    }
  }
  return out;
}

}  // namespace

RayEntry touch_turning(const Turning& a, const Turning& b, double limit) {
  double share = 0;
  Look now;
  for (int looks = 0; looks < kMostLooks; ++looks) {
    now = look(a, b, share);
    if (looks == 0 && now.gap.distance < 0) return {0, {}};
    if (now.nears) break;
    share += now.step;
    if (!(share <= limit)) return {};
  }
  return {share, now.gap.normal};
}

}  // namespace psim
