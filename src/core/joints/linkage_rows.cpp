// The rows of linkages and their masses.
#include <cmath>
#include <limits>

#include "base/elementary.h"
#include "joints/linkage.h"

namespace psim {
namespace {

// Of a row that can move something is always left; a rest of rounding is none.
constexpr double kRest = 1e-9;
constexpr double kShort = 1e-12;  // m: a line that is shorter has no direction

// The anchors of a part, and the way from one to the other.
struct Anchors {
  const LinkagePart& part;
  const JointedMotion &a, &b;
  Vec2 arm[2];
  Vec2 apart;

  Anchors(const LinkagePart& of, const JointedMotion* motion)
      : part(of),
        a(motion[of.end[0]]),
        b(motion[of.end[1]]),
        arm{turned(a.turn, of.anchor[0]), turned(b.turn, of.anchor[1])},
        apart(of.base + (b.at - a.at) + (arm[1] - arm[0])) {}
};

// Adds a row of the anchors along n, times `weight`. `reach`: from A's centre to the point whose way counts.
void add_along(LinkageRow& row, const Anchors& at, double weight, Vec2 n, Vec2 reach, double value) {
  Lever &a = row.lever[at.part.end[0]], &b = row.lever[at.part.end[1]];
  a.n = a.n - weight * n;
  a.arm -= weight * cross(reach, n);
  b.n = b.n + weight * n;
  b.arm += weight * cross(at.arm[1], n);
  row.value += weight * value;
}

void add_line(LinkageRow& row, const Anchors& at, double weight) {
  const double far = length_of(at.apart);
  const Vec2 n = far > kShort ? (1 / far) * at.apart : Vec2{0, 1};
  add_along(row, at, weight, n, at.arm[0], far);
  row.bend = greater(row.bend, far > kShort ? std::fabs(weight) / far : 0);
}

void add_axis(LinkageRow& row, const Anchors& at, double weight, bool across) {
  const Vec2 axis = turned(at.a.turn, at.part.axis), n = across ? upright(axis) : axis;
  add_along(row, at, weight, n, at.arm[0] + at.apart, dot(n, at.apart));
}

void add_turn(LinkageRow& row, const Anchors& at, double weight) {
  row.lever[at.part.end[0]].arm -= weight;
  row.lever[at.part.end[1]].arm += weight;
  row.value += weight * ((at.b.angle - at.a.angle) - at.part.reference);
}

// The coordinate of a joint that a gear ties.
void add_way(LinkageRow& row, const Anchors& at, double weight) {
  if (at.part.type == JointType::revolute) return add_turn(row, at, weight);
  add_axis(row, at, weight, false);
}

double couple(const Linkage& l, const LinkageRow& a, const LinkageRow& b) {
  double sum = 0;
  for (std::uint32_t e = 0; e < l.ends; ++e) {
    sum += l.end[e].inverse_mass * dot(a.lever[e].n, b.lever[e].n) + l.end[e].turning * a.lever[e].arm * b.lever[e].arm;
  }
  return sum;
}

// A load P on an arm turns the body back like a spring. What h cannot resolve would gain energy, so such bodies turn as
// slowly as h can follow (as slow_turns() in joint_pin_kernel.h).
void slow_turns(Linkage& l, double h) {
  for (std::uint32_t e = 0; e < l.ends; ++e) {
    LinkageEnd& end = l.end[e];
    double load = 0;
    for (std::uint32_t r = 0; r < l.rows; ++r) load += std::fabs(l.row[r].impulse) * length_of(l.row[r].lever[e].n);
    end.turning = end.inverse_inertia / greater(h * load * length_of(end.arm) * end.inverse_inertia, 1);
  }
}

}  // namespace

void Linkage::set_type(JointType of) {
  type = of;
  part[0].type = of;
  const auto shape = [this](std::uint32_t rigid_rows, std::uint32_t other_rows) {
    rigid = rigid_rows;
    drives = other_rows;
    rows = rigid + drives;
    for (std::uint32_t d = 0; d < drives; ++d) drive[d].row = rigid + d;
  };
  paired = of == JointType::motor || of == JointType::target || of == JointType::weld;
  switch (of) {
    case JointType::revolute:
    case JointType::prismatic:
      return shape(2, 1);
    case JointType::wheel:
      return shape(1, 2);
    case JointType::motor:
    case JointType::weld:
      return shape(0, 3);
    case JointType::target:
      return shape(0, 2);
    case JointType::gear:
      return shape(1, 0);
    default:
      return shape(0, 1);
  }
}

void find_rows(Linkage& l, const JointedMotion* motion) {
  const Anchors at(l.part[0], motion);
  for (std::uint32_t r = 0; r < l.rows; ++r) {
    l.row[r].lever = {};
    l.row[r].value = l.row[r].bend = 0;
  }
  const auto set_arms = [&l](const Anchors& of) {
    for (const int side : {0, 1}) l.end[of.part.end[side]].arm = of.arm[side];
  };
  set_arms(at);
  auto& row = l.row;
  switch (l.type) {
    case JointType::revolute:
    case JointType::weld:
    case JointType::motor:
    case JointType::target:
      add_along(row[0], at, 1, {1, 0}, at.arm[0], at.apart.x);
      add_along(row[1], at, 1, {0, 1}, at.arm[0], at.apart.y);
      if (l.rows == 3) add_turn(row[2], at, 1);
      break;
    case JointType::prismatic:
      add_axis(row[0], at, 1, true);
      add_turn(row[1], at, 1);
      add_axis(row[2], at, 1, false);
      break;
    case JointType::wheel:
      add_axis(row[0], at, 1, true);
      add_axis(row[1], at, 1, false);
      add_turn(row[2], at, 1);
      break;
    case JointType::gear:
    case JointType::pulley: {
      const auto add = l.type == JointType::gear ? add_way : add_line;
      const Anchors other(l.part[1], motion);
      set_arms(other);
      add(row[0], at, 1);
      add(row[0], other, l.ratio);
      break;
    }
    default:
      add_line(row[0], at, 1);
  }
  row[0].value -= l.length;
}

void find_masses(Linkage& l, double h) {
  slow_turns(l, h);
  auto& row = l.row;
  const auto inverse_of = [](double of, double alone) { return of > kRest * alone ? 1 / of : 0; };
  l.inverse[0] = l.inverse[1] = l.inverse[2] = 0;
  if (l.rigid == 2 || l.paired) {
    const double xx = couple(l, row[0], row[0]), xy = couple(l, row[0], row[1]), yy = couple(l, row[1], row[1]);
    // A row that nothing moves holds by itself.
    const double x = xx > 0 ? xx : 1, y = yy > 0 ? yy : 1;
    const double inverse = inverse_of(x * y - xy * xy, x * y);
    l.inverse[0] = xx > 0 ? y * inverse : 0;
    l.inverse[1] = -xy * inverse;
    l.inverse[2] = yy > 0 ? x * inverse : 0;
    if (l.paired) {  // the lightest direction
      const double most = (xx + yy) / 2 + std::sqrt((xx - yy) * (xx - yy) / 4 + xy * xy);
      row[0].mass = row[1].mass = most > 0 ? 1 / most : 0;
    }
  } else if (l.rigid == 1) {
    l.inverse[0] = inverse_of(couple(l, row[0], row[0]), 0);
  }
  for (std::uint32_t r = l.paired ? 2 : l.rigid; r < l.rows; ++r) {
    double with[2] = {};
    for (std::uint32_t k = 0; k < l.rigid; ++k) with[k] = couple(l, row[k], row[r]);
    row[r].held[0] = -(l.inverse[0] * with[0] + l.inverse[1] * with[1]);
    row[r].held[1] = -(l.inverse[1] * with[0] + l.inverse[2] * with[1]);
    const double alone = couple(l, row[r], row[r]);
    row[r].mass = inverse_of(alone + row[r].held[0] * with[0] + row[r].held[1] * with[1], alone);
  }
}

}  // namespace psim
