// Linkages of a world: which bodies they have, and once a frame their numbers. O(linkages).
#include <algorithm>

#include "base/elementary.h"
#include "joints/joint_store.h"

namespace psim {
namespace {

constexpr double kNone = 1e30;

void set_end(LinkageEnd& end, const JointMember& m) {
  end.number = m.number;
  end.inverse_mass = m.inverse_mass;
  end.inverse_inertia = m.inverse_mass > 0 ? m.rim_gain * m.inverse_radius * m.inverse_radius : 0;
  end.radius = 1 / m.inverse_radius;
  end.angle = m.angle;
}

// Of a joint with these anchors, as the frame begins.
void set_part(LinkagePart& part, const JointMember& a, const JointMember& b, const JointDesc& d,
              const Lattice& lattice) {
  part.type = d.type;
  part.base = lattice.way(a.at, b.at);
  part.anchor[0] = d.anchor_a - a.centre;
  part.anchor[1] = d.anchor_b - b.centre;
  part.axis = (1 / length_of(d.axis)) * d.axis;
  part.reference = d.reference.value_or(0);
}

void find_at_start(Linkage& l, double h) {
  JointedMotion at[Linkage::kMostEnds];
  for (std::uint32_t e = 0; e < l.ends; ++e) {
    at[e].angle = l.end[e].angle;
    at[e].turn = sine_cosine(at[e].angle);
  }
  find_rows(l, at);
  find_masses(l, h);
}

std::uint8_t add_end(Linkage& l, std::uint32_t id) {
  for (std::uint32_t e = 0; e < l.ends; ++e) {
    if (l.end[e].body == id) return static_cast<std::uint8_t>(e);
  }
  l.end[l.ends].body = id;
  return static_cast<std::uint8_t>(l.ends++);
}

void set_limits(LinkageDrive& drive, const JointDesc& d, double zero) {
  drive.lower = d.lower ? *d.lower - zero : -kNone;
  drive.upper = d.upper ? *d.upper - zero : kNone;
}

void set_motor(LinkageDrive& drive, double speed, double most, double h) {
  drive.speed = speed;
  drive.most = lesser(most * h, kNone);
}

}  // namespace

// The bodies of a linkage, and which of them are those of its parts.
void JointStore::find_ends(Linkage& l, const Joint& j) const {
  l.ends = 0;
  const auto set = [&l](int part, std::uint32_t a, std::uint32_t b) {
    l.part[part].end[0] = add_end(l, a);
    l.part[part].end[1] = add_end(l, b);
  };
  if (j.desc.type == JointType::pulley) {
    set(0, kWorldBody.index, j.desc.a.index);
    set(1, kWorldBody.index, j.desc.b.index);
  } else if (j.desc.type == JointType::gear) {
    for (const int part : {0, 1}) {
      const Basics& d = joints_[part_of_gear(j, part).index].desc;
      set(part, d.a.index, d.b.index);
    }
  } else {
    set(0, j.desc.a.index, j.desc.b.index);
  }
  for (std::uint32_t e = 0; e < l.ends; ++e) {
    l.end[e].member = member_of(l.end[e].body);
    l.end[e].inverse_mass = static_cast<double>(inverse_mass_of(l.end[e].body));
  }
}

void JointStore::lay_out_linkages() {
  linkages_.stop();
  std::vector<std::uint32_t> all;
  for (const Joint& j : joints_) {
    if (!j.alive || j.dormant || j.kind != kernels::JointKind::linkage) continue;
    const std::uint32_t number = extras_[j.extra].linkage;
    Linkage& l = linkages_[number];
    find_ends(l, j);
    for (std::uint32_t e = 0; e < l.ends; ++e) swept_[l.end[e].member] = 1;
    all.push_back(number);
  }
  if (!all.empty()) linkages_.lay_out(all, bodies_.size());
}

// Springs, ends and motors. The masses of the rows are known.
void JointStore::set_drives(Linkage& l, const JointDesc& d, std::uint32_t crowd) const {
  for (std::uint32_t n = 0; n < l.drives; ++n) {
    LinkageDrive& drive = l.drive[n];
    drive.lower = -kNone, drive.upper = kNone;
    drive.speed = drive.most = drive.rest = 0;
    drive.spring = {};
  }
  if (l.drives == 0) return;
  LinkageDrive& first = l.drive[0];
  if (d.type == JointType::pulley) {
    first.upper = 0;
    return;
  }
  if (d.type == JointType::motor) {
    set_motor(first, d.linear_velocity.x, d.force_limit, h_);
    set_motor(l.drive[1], d.linear_velocity.y, d.force_limit, h_);
    set_motor(l.drive[2], d.angular_velocity, d.torque_limit, h_);
    if (d.correction == 0) return;
    // What it misses of its place at the start of the step, it makes up in the step.
    const Vec2 offset = turned(sine_cosine(l.end[l.part[0].end[0]].angle), d.offset);
    const double rate = d.correction / (h_ * in_step_);
    first.speed -= rate * (l.row[0].value - offset.x);
    l.drive[1].speed -= rate * (l.row[1].value - offset.y);
    l.drive[2].speed -= rate * l.row[2].value;
    return;
  }
  if (d.type == JointType::weld) {
    first.spring = spring_of(d.linear_stiffness, d.linear_damping, l.row[first.row].mass, crowd);
    first.most = kNone;
    LinkageDrive& angle = l.drive[2];
    const bool rigid = !(d.stiffness > 0 || d.damping > 0);
    if (rigid) angle.lower = angle.upper = 0;
    if (!rigid) angle.spring = spring_of(d.stiffness, d.damping, l.row[angle.row].mass, crowd);
    return;
  }
  first.spring = spring_of(d.stiffness, d.damping, l.row[first.row].mass, crowd);
  if (d.type == JointType::target) {
    set_motor(first, 0, d.force_limit > 0 ? d.force_limit : kNone, h_);
    return;
  }
  set_limits(first, d, l.length);
  if (d.type == JointType::wheel) {
    set_motor(l.drive[1], d.motor_speed, d.motor_limit, h_);
  } else {
    first.rest = d.type == JointType::distance ? 0 : d.rest;
    set_motor(first, d.motor_speed, d.motor_limit, h_);
  }
}

void JointStore::set_linkage(Linkage& l, const Joint& j) const {
  const JointDesc& d = extras_[j.extra].desc;
  for (std::uint32_t e = 0; e < l.ends; ++e) set_end(l.end[e], members_[l.end[e].member]);
  std::optional<JointMember> world;
  const auto set = [&](int part, const JointDesc& of) {
    const std::uint32_t a = l.end[l.part[part].end[0]].member, b = l.end[l.part[part].end[1]].member;
    // One side at most is the world.
    const JointMember &ma = side_at(a, of.anchor_a, world), &mb = side_at(b, of.anchor_b, world);
    set_part(l.part[part], ma, mb, of, s_.lattice);
  };
  l.ratio = l.length = 0;
  if (d.type == JointType::pulley) {
    JointDesc line = d;
    line.anchor_a = d.ground_a;
    line.anchor_b = d.anchor_a;
    set(0, line);
    line.anchor_a = d.ground_b;
    line.anchor_b = d.anchor_b;
    set(1, line);
  } else if (d.type == JointType::gear) {
    for (const int part : {0, 1}) set(part, desc(part_of_gear(j, part)));
  } else if (d.type == JointType::target) {
    JointDesc line = d;
    line.anchor_a = d.target;
    set(0, line);
  } else {
    set(0, d);
  }
  if (d.type == JointType::pulley || d.type == JointType::gear) l.ratio = d.ratio;
  if (l.ratio != 0 || d.type == JointType::distance) l.length = d.length.value_or(0);
  find_at_start(l, h_);
  set_drives(l, d, crowd_of(j));
}

void JointStore::set_linkages() {
  if (linkages_.count() == 0) return;
  for (const Joint& j : joints_) {
    if (!j.alive || j.dormant || j.kind != kernels::JointKind::linkage) continue;
    set_linkage(linkages_[extras_[j.extra].linkage], j);
  }
}

double JointStore::sprung_mass(const JointDesc& d, const JointMember& a, const JointMember& b, const Lattice& lattice) {
  Linkage l;
  const bool line = d.type == JointType::spring, pin = d.type == JointType::weld;
  l.set_type(line ? JointType::distance : pin ? JointType::revolute : d.type);
  if (l.drives == 0) return 0;
  l.ends = 2;
  set_end(l.end[0], a);
  set_end(l.end[1], b);
  set_part(l.part[0], a, b, d, lattice);
  l.part[0].type = l.type;
  find_at_start(l, 0);
  return l.row[l.drive[0].row].mass;
}

}  // namespace psim
