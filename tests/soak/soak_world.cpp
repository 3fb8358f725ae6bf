#include "soak_world.h"

#include <cmath>
#include <stdexcept>
#include <vector>

namespace psim::soak {
namespace {

constexpr double kWidth = 80, kHeight = 50;  // m
constexpr std::uint64_t kCycle = 2400;       // frames: rain, then rest, then a shake

}  // namespace

SoakWorld::SoakWorld(std::size_t bodies, int threads) : most_(bodies) {
  WorldDesc desc;
  desc.bounds = {0, 0, kWidth, kHeight};
  desc.wall.friction = 0.5;
  std::string error;
  world_ = World::create(desc, {best_isa(), threads}, error);
  if (!world_) throw std::runtime_error(error);
  world_->set_event_options({true, true, 2, true});
  world_->enable_snapshots(true);
  build_yard();
}

double SoakWorld::uniform(double low, double high) {  // splitmix64
  std::uint64_t z = (random_ += 0x9E3779B97F4A7C15u);
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return low + (high - low) * static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

bool SoakWorld::require(bool holds, const char* what) {
  if (!holds && fault_.empty()) fault_ = "frame " + std::to_string(frame_) + ": " + what;
  return holds;
}

BodyId SoakWorld::add(const BodyDesc& body) {
  std::string error;
  const BodyId id = world_->add_body(body, error);
  if (id == kNoBody && fault_.empty()) fault_ = "frame " + std::to_string(frame_) + ": " + error;
  return id;
}

// Two slopes, a row of pegs, a mill that turns and a gate that feels who passes.
void SoakWorld::build_yard() {
  BodyDesc fixed;
  fixed.type = BodyType::static_body;
  fixed.material.friction = 0.4;
  fixed.shape = ChainShape{{{0, 22}, {14, 15}, {22, 14}}, false};
  add(fixed);
  fixed.shape = ChainShape{{{kWidth, 26}, {66, 19}, {58, 18}}, false};
  add(fixed);
  for (int k = 0; k < 10; ++k) {
    fixed.shape = DiscShape{0.4};
    fixed.position = {26.0 + 3 * k, 24.0 + k % 2};
    add(fixed);
  }
  BodyDesc mill;
  mill.type = BodyType::kinematic_body;
  mill.shape = BoxShape{12, 0.6};
  mill.position = {40, 8};
  mill.angular_velocity = 0.7;
  add(mill);
  BodyDesc gate;
  gate.type = BodyType::static_body;
  gate.sensor = true;
  gate.shape = BoxShape{20, 2};
  gate.position = {40, 16};
  add(gate);
}

void SoakWorld::spawn() {
  BodyDesc body;
  body.position = {uniform(2, kWidth - 2), uniform(34, kHeight - 2)};
  body.angle = uniform(0, 6);
  body.velocity = {uniform(-4, 4), uniform(-6, 0)};
  body.material = {uniform(0.5, 3), uniform(0, 1) < 0.2 ? uniform(0, 0.6) : 0, uniform(0, 0.8)};
  body.bullet = uniform(0, 1) < 0.02;
  const double size = uniform(0.2, 0.6), kind = uniform(0, 1);
  if (kind < 0.5) {
    body.shape = DiscShape{size};
  } else if (kind < 0.75) {
    body.shape = BoxShape{2 * size, 1.5 * size, uniform(0, 1) < 0.2 ? 0.05 : 0};
  } else if (kind < 0.9) {
    body.shape = CapsuleShape{{-size, 0}, {size, 0}, 0.6 * size};
  } else {
    body.shape = PolygonShape{{{-size, -size}, {size, -size}, {0, size}}, 0};
  }
  bodies_.push_back(add(body));
  ++spawned_;
}

void SoakWorld::remove_oldest() {
  require(world_->remove_body(bodies_.front()), "a living body is not removed");
  bodies_.pop_front();
  ++removed_;
}

// Ties the two newest bodies, who are still in the air; every joint is cut in the end.
void SoakWorld::join() {
  constexpr JointType kTypes[] = {JointType::rope,     JointType::spring, JointType::revolute,
                                  JointType::distance, JointType::weld,   JointType::prismatic};
  JointDesc joint;
  joint.type = kTypes[frame_ / 20 % 6];
  joint.a = bodies_[bodies_.size() - 2];
  joint.b = bodies_.back();
  const BodyState a = *world_->body(joint.a), b = *world_->body(joint.b);
  if (joint.type != JointType::rope && joint.type != JointType::spring && joint.type != JointType::distance) {
    world_->set_transform(joint.b, {a.x + 0.5, a.y}, a.angle);  // these hold them together
  }
  if (joint.type == JointType::rope) joint.length = 2 + std::hypot(a.x - b.x, a.y - b.y);
  if (joint.type == JointType::spring) joint.stiffness = 20, joint.damping = 1;
  if (joint.type == JointType::revolute) joint.motor_speed = 3, joint.motor_limit = 2;
  if (joint.type == JointType::prismatic) joint.lower = -0.5, joint.upper = 0.5;
  std::string error;
  const JointId id = world_->add_joint(joint, error);
  if (!require(id != kNoJoint, "a joint is refused")) return;
  joints_.push_back(id);
  while (joints_.size() > most_ / 10 + 4) {
    world_->remove_joint(joints_.front());  // unless its body took it along
    joints_.pop_front();
  }
}

void SoakWorld::shake() {
  world_->set_gravity({uniform(-4, 4), -9.81});
  for (std::size_t k = 0; k < bodies_.size(); k += 3) {
    world_->apply_impulse(bodies_[k], {uniform(-3, 3), uniform(0, 5)});
  }
}

void SoakWorld::ask() {
  const Vec2 p{uniform(0, kWidth), uniform(0, kHeight)}, q{uniform(0, kWidth), uniform(0, kHeight)};
  answers_ += world_->ray_cast_all(p, q).size();
  answers_ += world_->in_region({p.x - 2, p.y - 2, p.x + 2, p.y + 2}).size();
  answers_ += world_->overlap(CapsuleShape{{-1, 0}, {1, 0}, 0.3}, q, 0.4).size();
  answers_ += world_->closest(p, 5).has_value() ? 1 : 0;
}

void SoakWorld::look() {
  const PublishedState s = world_->published();
  require(s.id.size() == world_->body_count(), "as many rows as bodies");
  for (std::size_t k = 0; k < s.id.size(); ++k) {
    if (!require(std::isfinite(s.x[k] + s.y[k] + s.angle[k] + s.vx[k] + s.vy[k] + s.omega[k]),
                 "a body's state is not finite")) {
      return;
    }
    if (s.type[k] != BodyType::dynamic_body) continue;
    // What a joint pulls with hundreds of times its weight sinks into a wall, but does not pass it.
    const double r = s.radius[k];
    require(s.x[k] >= -r && s.x[k] <= kWidth + r && s.y[k] >= -r && s.y[k] <= kHeight + r, "a body left the walls");
  }
  for (const BodyId id : bodies_) require(world_->is_valid(id), "a living body's id is stale");
}

bool SoakWorld::step() {
  const std::uint64_t at = frame_ % kCycle;
  const bool rains = at < 1500;
  if (rains && frame_ % 4 == 0) {
    spawn();
    if (bodies_.size() > most_) remove_oldest();
    if (frame_ % 20 == 0 && bodies_.size() > 2) join();
  }
  if (at == 2300) shake();
  if (at == 0) world_->set_gravity({0, -9.81});
  if (frame_ % (10 * kCycle) == 5 * kCycle) world_->set_sleeping(false);
  if (frame_ % (10 * kCycle) == 6 * kCycle) world_->set_sleeping(true);
  if (frame_ % (10 * kCycle) == 7 * kCycle) world_->set_governor({true, 0.1, {}});
  if (frame_ % (10 * kCycle) == 8 * kCycle) world_->set_governor({});
  if (frame_ % 6 == 0) ask();

  const StepReport report = world_->step();
  ++frame_;
  asleep_ = report.asleep;
  require(report.quarantined == 0, "a sane body was quarantined");
  require(report.escaped == 0, "a body escaped from walls");
  const Events events = world_->events();
  events_ += events.begin.size() + events.end.size() + events.hits.size() + events.sensor_begin.size() +
             events.sensor_end.size();
  if (frame_ % 60 == 0) look();
  return fault_.empty();
}

}  // namespace psim::soak
