#include "joints/articulation_rows.h"

namespace psim {

using kernels::JointKind;

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
