#include "joints/articulation_rows.h"

#include <cmath>

namespace psim {

using kernels::JointKind;

namespace {

// The arm which, turned by a right angle and times the turn, is the way of the anchor.
Vec2 mean_arm(const JointedMotion& from, const JointedMotion& to, Vec2 anchor) {
  const double half = 0.5 * (to.angle - from.angle);
  const SineCosine q = sine_cosine(half);
  const double chord = std::fabs(half) > 1e-4 ? q.sine / half : 1 - half * half / 6;  // over the arc
  return chord * turned(q, turned(from.turn, anchor));
}

}  // namespace

void find_middle(const JointGeometry& joint, const JointedMotion& a0, const JointedMotion& b0, const JointedMotion& a,
                 const JointedMotion& b, JointRow& row) {
  if (joint.kind != JointKind::spring) return;
  const auto apart = [&](const JointedMotion& from, const JointedMotion& to) {
    return joint.base + (to.at - from.at) + (turned(to.turn, joint.anchor[1]) - turned(from.turn, joint.anchor[0]));
  };
  const Vec2 d0 = apart(a0, b0), d = apart(a, b);
  const double both = length_of(d0) + length_of(d);
  if (both < 1e-12) return;
  row.n = (1 / both) * (d0 + d);
  row.arm_a = cross(mean_arm(a0, a, joint.anchor[0]), row.n);
  row.arm_b = cross(mean_arm(b0, b, joint.anchor[1]), row.n);
}

void find_rows(const JointGeometry& joint, const JointedMotion& a, const JointedMotion& b, JointRow* rows) {
  const Vec2 arm_a = turned(a.turn, joint.anchor[0]), arm_b = turned(b.turn, joint.anchor[1]);
  const Vec2 apart = joint.base + (b.at - a.at) + (arm_b - arm_a);
  // A row of the anchors along n. `reach`: from A's centre to the point whose way counts.
  const auto along = [&](double error, Vec2 n, Vec2 reach) { *rows++ = {error, n, cross(reach, n), cross(arm_b, n)}; };
  const auto turn = [&] { *rows++ = {(b.angle - a.angle) - joint.reference, {0, 0}, 1, 1}; };
  if (joint.kind == JointKind::rod || joint.kind == JointKind::spring) {
    const double far = length_of(apart);
    const Vec2 n = far > 1e-12 ? Vec2{apart.x / far, apart.y / far} : Vec2{0, 1};
    return along(far - joint.length, n, arm_a);
  }
  if (joint.kind == JointKind::slide) {
    const Vec2 axis = turned(a.turn, joint.axis), reach = arm_a + apart;
    along(cross(axis, apart), {-axis.y, axis.x}, reach);
    turn();
    return along(dot(axis, apart) - joint.length, axis, reach);
  }
  along(apart.x, {1, 0}, arm_a);
  along(apart.y, {0, 1}, arm_a);
  if (joint.kind != JointKind::pin) turn();
}

}  // namespace psim
