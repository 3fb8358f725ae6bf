// Bodies and joints come, go and are moved.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "world_descs.h"
#include "world_session.h"

namespace psim::fuzz {

void Session::add_body() {
  if (bodies_.size() < most_bodies_) add(body(in_));
}

BodyId Session::add(const BodyDesc& d) {
  const BodyId id = change<BodyId>("add_body", [&](auto& w) {
    std::string error;
    const BodyId got = w.add_body(d, error);
    require((got == kNoBody) != error.empty(), "add_body: an id or an error");
    if (got == kNoBody) refused(error);
    return got;
  });
  say("body %u type %d shape %zu at %g %g angle %g velocity %g %g %g mass %g density %g "
      "restitution %g friction %g "
      "scale %g%s%s%s filter %x %x %d damping %g %g locks %d%d%d",
      id.index, static_cast<int>(d.type), d.shape.index(), d.position.x, d.position.y, d.angle, d.velocity.x,
      d.velocity.y, d.angular_velocity, d.mass, d.material.density, d.material.restitution, d.material.friction,
      d.gravity_scale, d.fixed_rotation ? " upright" : "", d.bullet ? " bullet" : "", d.sensor ? " sensor" : "",
      d.filter.category, d.filter.mask, d.filter.group, d.linear_damping, d.angular_damping, d.locks.x, d.locks.y,
      d.locks.angle);
  if (id != kNoBody) live(id);
  return id;
}

void Session::add_discs() {
  const std::size_t n = in_.below(30);
  if (bodies_.size() + n > most_bodies_) return;
  std::vector<double> x, y, radius{in_.number(0.1, 0.6)}, vx, more;
  const Vec2 at = in_.place(-kHalf, kHalf / 2);
  for (std::size_t k = 0; k < n; ++k) {
    x.push_back(at.x + 0.7 * static_cast<double>(k % 5));
    y.push_back(at.y + 0.7 * static_cast<double>(k / 5));
  }
  if (in_.chance(60)) {
    while (radius.size() < n) radius.push_back(in_.number(0.1, 0.5));
  }
  if (in_.chance(60)) vx.assign(n, in_.number(-5, 5));
  if (in_.chance(16)) more.assign(in_.below(30), in_.number(-5, 5));
  DiscBatch batch;
  batch.x = x;
  batch.y = y;
  batch.radius = radius;
  batch.vx = vx;
  batch.angular_velocity = more;
  batch.type =
      in_.chance(200) ? BodyType::dynamic_body : one_of(in_, {BodyType::static_body, BodyType::kinematic_body});
  if (in_.chance(60)) batch.material = material(in_);
  if (in_.chance(30)) batch.mass = in_.number(0, 20);
  if (in_.chance(20)) batch.gravity_scale = in_.number(-1, 2);
  batch.bullet = in_.chance(10);
  batch.filter = filter(in_);
  say("discs %zu at %g %g radius %g vx %g type %d mass %g bullet %d", n, at.x, at.y, radius[0], vx.empty() ? 0 : vx[0],
      static_cast<int>(batch.type), batch.mass, batch.bullet);
  add(batch);
}

std::size_t Session::add(const DiscBatch& batch) {
  const std::size_t n = batch.x.size();
  const auto before = worlds_.front()->body_count();
  const std::size_t added = change<std::size_t>("add_discs", [&](auto& w) {
    std::string error;
    std::uint32_t first = 0;
    const std::size_t got = w.add_discs(batch, first, error);
    require(got == (error.empty() ? n : 0), "add_discs: all or none, and then an error: " + error);
    if (!error.empty()) refused(error);
    return got;
  });
  require(worlds_.front()->body_count() == before + added, "add_discs: the count");
  const PublishedState s = worlds_.front()->published();
  for (const std::uint32_t index : s.id) live(worlds_.front()->id_of(index));
  return added;
}

void Session::live(BodyId id) {
  if (is_live(id)) return;
  bodies_.push_back(id);
  if (known_.by_index.size() <= id.index) known_.by_index.resize(id.index + std::size_t{1});
  known_.by_index[id.index] = id;
}

// One that lives, one that is gone, or nonsense.
BodyId Session::some_body() {
  if (bodies_.empty() || in_.chance(8)) {
    if (!dead_.empty() && in_.chance(160)) return dead_[in_.below(std::min<std::size_t>(dead_.size(), 256))];
    return {static_cast<std::uint32_t>(in_.byte()) << (in_.below(4) * 8), in_.byte()};
  }
  if (in_.rich) return bodies_[in_.below_wide(bodies_.size())];
  return bodies_[in_.below(std::min<std::size_t>(bodies_.size(), 256))];
}

void Session::remove_body() {
  const BodyId id = some_body();
  const bool lives = is_live(id);
  say("remove %u", id.index);
  require(change<bool>("remove_body", [&](auto& w) { return w.remove_body(id); }) == lives,
          "remove_body: true for the living");
  if (lives) bury({id});
}

void Session::bury(const std::vector<BodyId>& gone) {
  for (const BodyId id : gone) {
    require(!worlds_.front()->is_valid(id), "a removed body is valid");
    known_.by_index[id.index] = kNoBody;
    dead_.push_back(id);
    broken_.erase(id.index);
  }
  std::erase_if(bodies_, [&](BodyId id) { return !is_live(id); });
}

bool Session::is_live(BodyId id) const { return id.index < known_.by_index.size() && known_.by_index[id.index] == id; }

void Session::move_body() {
  const BodyId id = some_body();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const bool breaks = in_.chance(6);
  const Vec2 v = breaks ? Vec2{nan, 0} : in_.vec2(-kHalf, kHalf);
  const double turn = in_.chance(100) ? in_.number(-10, 10) : 0;
  const Vec2 at = in_.place(-kHalf, kHalf);
  const std::size_t which = in_.below(5);
  say("move %u by %zu: %g %g turn %g at %g %g", id.index, which, v.x, v.y, turn, at.x, at.y);
  const Vec2 to{in_.home.x + v.x, in_.home.y + v.y};
  const bool moved = change<bool>("moving a body", [&](auto& w) {
    switch (which) {
      case 0:
        return w.set_transform(id, to, turn);
      case 1:
        return w.set_velocity(id, v, turn);
      case 2:
        return w.apply_impulse(id, v);
      case 3:
        return w.apply_impulse_at(id, v, at);
      default:
        return w.apply_angular_impulse(id, breaks ? nan : turn);
    }
  });
  require(!moved || is_live(id), "a body that is not there was moved");
  if (moved && breaks) broken_.insert(id.index);
  if (moved && breaks && which == 4) maybe_broken_ = true;  // one that cannot turn takes no harm
  change_body(id, {v.x + at.y, at.x - turn});
  push_body(id, {v.x + at.y, at.x - turn});
}

// Switches a body off or on, or changes its traits.
void Session::change_body(BodyId id, Vec2 place) {
  const Digits digits(place);
  ByteSource own(digits);
  const bool lives = is_live(id) && !broken_.contains(id.index);
  if (broken_.contains(id.index)) return;  // the next step freezes it
  if (own.chance(48)) {
    const bool on = own.chance(128);
    say("enable %u: %d", id.index, on);
    const bool done = change<bool>("set_enabled", [&](auto& w) { return w.set_enabled(id, on); });
    require(!done || is_live(id), "set_enabled: a body that is not there");
    if (done) {
      require(same<bool>("is_enabled", [&](World& w) { return w.is_enabled(id); }) == on, "set_enabled does so");
    }
  }
  if (own.chance(48)) {
    const auto has = worlds_.front()->traits(id);
    require(has.has_value() == is_live(id), "traits of the living");
    BodyTraits to = has.value_or(BodyTraits{});
    if (own.chance(64)) to.friction = own.uniform(0, 2);
    if (own.chance(64)) to.restitution = own.uniform(0, 1);
    if (own.chance(64)) to.tangent_speed = own.chance(64) ? 0 : own.uniform(-5, 5);
    if (own.chance(64)) to.rolling_resistance = own.uniform(0, 0.5);
    if (own.chance(32)) to.one_way = own.chance(64) ? Vec2{} : Vec2{own.uniform(-1, 1), own.uniform(-1, 1)};
    if (own.chance(32)) to.filter.mask = own.byte();
    if (own.chance(32)) to.sensor = own.chance(128);
    if (own.chance(32)) to.bullet = own.chance(128);
    if (own.chance(64)) to.mass = own.uniform(0.01, 50);
    if (own.chance(32)) to.inertia = own.chance(64) ? 0 : own.uniform(0.01, 5);
    if (own.chance(32)) to.gravity_scale = own.uniform(-1, 2);
    if (own.chance(32)) to.linear_damping = own.uniform(0, 5);
    if (own.chance(32)) to.angular_damping = own.uniform(0, 5);
    if (own.chance(32)) to.locks = {own.chance(128), own.chance(128), own.chance(128)};
    if (own.chance(32)) to.pre_solve = own.chance(128);
    if (own.chance(32)) to.can_sleep = own.chance(128);
    say("traits %u", id.index);
    const bool done = change<bool>("set_traits", [&](auto& w) { return w.set_traits(id, to); });
    require(!done || is_live(id), "set_traits: a body that is not there");
    if (done && lives) {
      const BodyTraits now = worlds_.front()->traits(id).value();
      const bool dynamic = worlds_.front()->body(id)->type == BodyType::dynamic_body;
      require(now.filter == to.filter, "set_traits: the filter");
      require(!dynamic || now.can_sleep == to.can_sleep, "set_traits: whether it can sleep");
      require(!dynamic || now.locks == to.locks, "set_traits: the locks");
      require(!dynamic || std::fabs(now.mass - to.mass) <= 1e-6 * to.mass, "set_traits: the mass");
    }
  }
  if (own.chance(24)) {
    const auto parts = same<std::uint32_t>("part_count", [&](World& w) { return w.part_count(id); });
    require((parts != 0) == is_live(id), "part_count: of the living");
    const std::uint32_t part = own.byte() % (parts + 1);
    const auto has = worlds_.front()->part_traits(id, part);
    require(has.has_value() == (part < parts), "part_traits of a part");
    PartTraits to = has.value_or(PartTraits{});
    if (own.chance(128)) to.friction = own.uniform(0, 2);
    if (own.chance(64)) to.restitution = own.uniform(0, 1);
    if (own.chance(32)) to.filter.mask = own.byte();
    if (own.chance(32)) to.sensor = own.chance(128);
    if (own.chance(32)) to.one_way = {own.uniform(-1, 1), own.uniform(-1, 1)};
    if (own.chance(32)) to.pre_solve = own.chance(128);
    if (own.chance(64)) to.user_data = own.byte();
    const bool wrong = own.chance(8);
    if (wrong) to.rolling_resistance = -1;
    say("part %u of %u", part, id.index);
    const bool done = change<bool>("set_part_traits", [&](auto& w) { return w.set_part_traits(id, part, to); });
    require(!done || (part < parts && !wrong), "set_part_traits: no part, or no number");
    if (done) {
      const auto now = worlds_.front()->part_traits(id, part);
      require(now && now->user_data == to.user_data && now->filter == to.filter, "set_part_traits does so");
      require(std::fabs(now->friction - to.friction) <= 1e-6 && now->sensor == to.sensor, "set_part_traits does so");
    }
  }
  if (own.chance(24)) {
    const std::uint64_t value = own.byte();
    const bool done = change<bool>("set_user_data", [&](auto& w) { return w.set_user_data(id, value); });
    require(done == is_live(id), "set_user_data: true for the living");
    if (done) {
      const auto now = same<std::uint64_t>("user_data", [&](World& w) { return w.user_data(id); });
      require(now == value, "set_user_data does so");
    }
  }
}

void Session::add_joint() {
  if (joints_.size() >= most_joints_) return;
  JointDesc d = joint_of(static_cast<JointType>(in_.below(12)));
  d.a = in_.chance(40) ? kWorldBody : some_body();
  d.b = in_.chance(10) ? kWorldBody : some_body();
  if (d.type == JointType::gear) d.joint_a = some_joint(), d.joint_b = some_joint();
  add(d);
}

// A description without bodies.
JointDesc Session::joint_of(JointType type) {
  JointDesc d;
  d.type = type;
  d.anchor_a = in_.chance(128) ? Vec2{} : in_.vec2(-1, 1);
  d.anchor_b = in_.chance(128) ? Vec2{} : in_.vec2(-1, 1);
  if (in_.chance(80)) d.length = in_.number(0, 4);
  if (in_.chance(80)) d.stiffness = in_.number(0, 500);
  if (in_.chance(80)) d.damping = in_.number(0, 20);
  if (in_.chance(80)) d.axis = in_.vec2(-1, 1);
  if (in_.chance(30)) d.reference = in_.number(-3, 3);
  if (in_.chance(60)) d.lower = in_.number(-2, 0);
  if (in_.chance(60)) d.upper = in_.number(0, 2);
  if (in_.chance(60)) d.motor_speed = in_.number(-10, 10), d.motor_limit = in_.number(0, 200);
  d.collide = in_.chance(60);
  if (in_.chance(60)) d.frequency = in_.number(0, 20), d.damping_ratio = in_.number(0, 2);
  if (in_.chance(60)) d.rest = in_.number(-2, 2);
  if (in_.chance(30)) d.break_force = in_.number(0, 500);
  if (in_.chance(20)) d.break_torque = in_.number(0, 500);
  if (in_.chance(20)) d.user_data = in_.byte();
  if (in_.chance(20)) d.pressure = in_.number(-500, 500), d.area = in_.number(-2, 2);
  if (in_.chance(20)) d.wind_drag = in_.number(0, 5), d.wind_lift = in_.number(0, 5);
  if (type == JointType::motor) {
    d.linear_velocity = in_.vec2(-5, 5);
    d.angular_velocity = in_.number(-10, 10);
    d.torque_limit = in_.number(0, 100);
  }
  if (in_.chance(128)) d.force_limit = in_.number(0, 500);
  if (type == JointType::target) d.target = in_.vec2(-10, 10);
  if (type == JointType::pulley) d.ground_a = in_.vec2(-10, 10), d.ground_b = in_.vec2(-10, 10);
  if (type == JointType::pulley || type == JointType::gear) d.ratio = in_.number(-3, 3);
  return d;
}

JointId Session::add(const JointDesc& d) {
  const JointId id = change<JointId>("add_joint", [&](auto& w) {
    std::string error;
    const JointId got = w.add_joint(d, error);
    require((got == kNoJoint) != error.empty(), "add_joint: an id or an error");
    if (got == kNoJoint) refused(error);
    return got;
  });
  say("joint %u type %d of %u and %u%s", id.index, static_cast<int>(d.type), d.a.index, d.b.index,
      d.collide ? " colliding" : "");
  if (id == kNoJoint) return id;
  const auto is_there = [&](BodyId body) { return body == kWorldBody || is_live(body); };
  const bool own_a = d.type != JointType::target && d.type != JointType::gear, own_b = d.type != JointType::gear;
  require((!own_a || is_there(d.a)) && (!own_b || is_there(d.b)), "a joint on a body that is not there");
  joints_.push_back(id);
  jointed_ = true;
  return id;
}

JointId Session::some_joint() {
  if (joints_.empty() || in_.chance(16)) return {in_.byte(), in_.byte()};
  return joints_[in_.rich ? in_.below_wide(joints_.size()) : in_.below(joints_.size())];
}

void Session::touch_joint() {
  const JointId id = some_joint();
  const std::size_t which = in_.below(5);
  const double speed = in_.number(-10, 10), limit = in_.number(0, 100);
  const bool valid = worlds_.front()->is_valid_joint(id);
  if (which >= 3) return change_joint(id, which == 3);
  say("change joint %u by %zu", id.index, which);
  const auto ask = [&](World& w) {
    const auto state = w.joint(id);
    const auto is_there = [&](BodyId body) { return body == kWorldBody || w.is_valid(body); };
    if (state) require(is_there(state->a) && is_there(state->b), "a joint of no bodies");
    return state.has_value();
  };
  const auto touch = [&](auto& w) { return which == 0 ? w.remove_joint(id) : w.set_motor(id, speed, limit); };
  const bool did = which == 2 ? same<bool>("asking for a joint", ask) : change<bool>("changing a joint", touch);
  require(!did || valid, "a joint that is not there was changed");
  require(which == 1 || did == valid, "a joint that is there was refused");
  if (which == 0 && did) std::erase(joints_, id);
}

// Another description, or another target.
void Session::change_joint(JointId id, bool whole) {
  const auto before = worlds_.front()->joint_desc(id);
  if (!whole || !before) {
    const Vec2 to = in_.vec2(-10, 10);
    say("target of joint %u", id.index);
    const bool did = change<bool>("set_target", [&](auto& w) { return w.set_target(id, to); });
    require(!did || (before && before->type == JointType::target), "set_target of another joint");
    if (did) require(worlds_.front()->joint_desc(id)->target.x == to.x, "set_target does so");
    return;
  }
  JointDesc d = joint_of(before->type);
  d.a = before->a, d.b = before->b, d.joint_a = before->joint_a, d.joint_b = before->joint_b;
  say("joint %u is described anew", id.index);
  const bool did = change<bool>("set_joint", [&](auto& w) {
    std::string error;
    const bool done = w.set_joint(id, d, error);
    require(done == error.empty(), "set_joint: true or an error");
    if (!done) refused(error);
    return done;
  });
  const JointDesc now = *worlds_.front()->joint_desc(id);
  require(now.break_force == (did ? d.break_force : before->break_force), "set_joint does so, or nothing");
  require(now.pressure == (did ? d.pressure : before->pressure), "set_joint does so, or nothing");
}

}  // namespace psim::fuzz
