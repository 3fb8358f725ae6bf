#include "soak_calls.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>

namespace psim::soak {
namespace {

constexpr double kWidth = 60, kHeight = 40;  // m
constexpr std::size_t kMany = 30;            // bodies that come or go at once

bool finite(const PublishedState& s) {
  const auto sound = [](std::span<const double> of) {
    return std::ranges::all_of(of, [](double v) { return std::isfinite(v); });
  };
  return sound(s.x) && sound(s.y) && sound(s.angle) && sound(s.vx) && sound(s.vy) && sound(s.omega);
}

}  // namespace

SoakCalls::SoakCalls(std::size_t bodies, int threads) : most_(bodies) {
  WorldDesc desc;
  desc.bounds = {0, -5, kWidth, kHeight};
  desc.boundary = Boundary::open;
  desc.fields = {WellField{{kWidth / 2, kHeight}, 2, 1, 1, 20}, DragField{0.01, 0.001}};
  std::string error;
  world_ = World::create(desc, {best_isa(), threads}, error);
  if (!world_) throw std::runtime_error(error);
  BodyDesc floor;
  floor.type = BodyType::static_body;
  floor.shape = ChainShape{{{kWidth, 1}, {kWidth - 10, 0}, {10, 0}, {0, 1}}, false};
  floor.material.friction = 0.5;
  floor_ = world_->add_body(floor, error);
  bodies_.reserve(2 * most_ + 2 * kMany);
  joints_.reserve(most_);
}

double SoakCalls::uniform(double low, double high) {  // splitmix64
  std::uint64_t z = (random_ += 0x9E3779B97F4A7C15u);
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return low + (high - low) * static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

bool SoakCalls::require(bool holds, const std::string& what) {
  if (!holds && fault_.empty()) fault_ = "step " + std::to_string(steps_) + ": " + what;
  return holds;
}

// A body that is there, or kNoBody.
BodyId SoakCalls::any() {
  while (!bodies_.empty()) {
    const std::size_t k = below(bodies_.size());
    if (world_->is_valid(bodies_[k])) return bodies_[k];
    bodies_[k] = bodies_.back();
    bodies_.pop_back();
  }
  return kNoBody;
}

BodyId SoakCalls::keep(const BodyDesc& body) {
  std::string error;
  const BodyId id = world_->add_body(body, error);
  ++calls_;
  if (require(id != kNoBody, "a body is refused")) bodies_.push_back(id);
  return id;
}

BodyDesc SoakCalls::any_body() {
  BodyDesc body;
  body.position = {uniform(2, kWidth - 2), uniform(1, kHeight / 2)};
  body.angle = uniform(0, 6);
  body.velocity = {uniform(-3, 3), uniform(-3, 3)};
  body.material = {uniform(0.5, 3), uniform(0, 1) < 0.2 ? 0.4 : 0, uniform(0.2, 0.8)};
  body.bullet = uniform(0, 1) < 0.05;
  if (uniform(0, 1) < 0.2) body.filter = {1u << below(4), 0xFu, static_cast<std::int32_t>(below(3)) - 1};
  const double size = uniform(0.2, 0.5), kind = uniform(0, 1);
  if (kind < 0.5) {
    body.shape = DiscShape{size};
  } else if (kind < 0.75) {
    body.shape = BoxShape{2 * size, 1.5 * size, uniform(0, 1) < 0.2 ? 0.05 : 0};
  } else if (kind < 0.85) {
    body.shape = CapsuleShape{{-size, 0}, {size, 0}, 0.6 * size};
  } else if (kind < 0.95) {
    body.shape = PolygonShape{{{-size, -size}, {size, -size}, {0, size}}, 0};
  } else {
    body.shape = SegmentShape{{-size, 0}, {size, 0}};
  }
  const double type = uniform(0, 1);
  if (type < 0.08) {
    body.type = BodyType::kinematic_body;
    body.angular_velocity = uniform(-1, 1);
    body.sensor = uniform(0, 1) < 0.3;
  }
  return body;
}

void SoakCalls::add() { keep(any_body()); }

void SoakCalls::add_many() {
  std::array<double, kMany> x, y;
  const double left = uniform(2, kWidth - 20), low = uniform(2, kHeight / 2);
  for (std::size_t k = 0; k < kMany; ++k) {
    x[k] = left + 1.1 * static_cast<double>(k % 10);
    y[k] = low + 1.1 * static_cast<double>(k / 10);
  }
  const std::array<double, 1> radius{uniform(0.3, 0.5)};
  DiscBatch batch;
  batch.x = x, batch.y = y, batch.radius = radius;
  batch.type = uniform(0, 1) < 0.1 ? BodyType::static_body : BodyType::dynamic_body;
  std::uint32_t first = 0;
  std::string error;
  require(world_->add_discs(batch, first, error) == kMany, "a batch is refused");
  // Their ids follow each other only where no id was free.
  bodies_.clear();
  for (const std::uint32_t index : world_->published().id) {
    if (index != floor_.index) bodies_.push_back(world_->id_of(index));
  }
}

void SoakCalls::add_static() {
  BodyDesc body = any_body();
  body.type = BodyType::static_body;
  body.bullet = false;
  body.velocity = {};
  body.angular_velocity = 0;
  body.sensor = uniform(0, 1) < 0.3;
  if (uniform(0, 1) < 0.4) {
    body.angle = 0;
    body.shape = ChainShape{{{4, 0.5}, {2, 0}, {0, uniform(0, 0.3)}, {-3, 0}}, false};
  }
  keep(body);
}

void SoakCalls::remove_many() {
  for (std::size_t k = 0; k < kMany && !bodies_.empty(); ++k) {
    if (const BodyId id = any(); id != kNoBody) {
      require(world_->remove_body(id) && !world_->is_valid(id), "a living body is not removed");
    }
    ++calls_;
  }
}

// A body of another type takes the place of one.
void SoakCalls::change_type() {
  const BodyId id = any();
  if (id == kNoBody) return;
  const BodyState s = *world_->body(id);
  world_->remove_body(id);
  BodyDesc body = any_body();
  body.position = {std::clamp(s.x, 1.0, kWidth - 1), std::clamp(s.y, 0.0, kHeight - 1)};
  body.type = s.type == BodyType::dynamic_body ? BodyType::kinematic_body : BodyType::dynamic_body;
  body.sensor = false;
  keep(body);
}

// Ties a new body to a static one or to another new one: joints of one body may contradict each other.
void SoakCalls::join() {
  BodyDesc body = any_body();
  body.type = BodyType::dynamic_body;
  body.sensor = false;
  BodyId other = any();
  if (other == kNoBody || world_->body(other)->type != BodyType::static_body) other = keep(body);
  const BodyState s = *world_->body(other);
  body.position = {std::clamp(s.x + 0.8, 1.0, kWidth - 1), std::clamp(s.y, 0.0, kHeight - 1)};
  JointDesc joint;
  joint.type = static_cast<JointType>(below(6));
  joint.a = other;
  joint.b = keep(body);
  joint.anchor_b = {-0.8, 0};
  joint.collide = uniform(0, 1) < 0.3;
  if (joint.type == JointType::rope) joint.length = 2;
  if (joint.type == JointType::distance) joint.anchor_b = {};
  if (joint.type == JointType::spring) joint.stiffness = 20, joint.damping = 1;
  if (joint.type == JointType::revolute && uniform(0, 1) < 0.5) joint.motor_speed = 2, joint.motor_limit = 1;
  if (joint.type == JointType::prismatic) joint.lower = -0.5, joint.upper = 0.5;
  std::string error;
  const JointId id = world_->add_joint(joint, error);
  ++calls_;
  if (id != kNoJoint) joints_.push_back(id);
  if (joints_.size() > most_ / 8) unjoin();
}

void SoakCalls::unjoin() {
  if (joints_.empty()) return;
  const std::size_t k = below(joints_.size());
  world_->joint(joints_[k]);
  world_->set_motor(joints_[k], uniform(-2, 2), 1);
  world_->remove_joint(joints_[k]);  // unless its body took it along
  require(!world_->is_valid_joint(joints_[k]), "a joint is not removed");
  joints_[k] = joints_.back();
  joints_.pop_back();
  calls_ += 3;
}

void SoakCalls::push() {
  const BodyId id = any();
  if (id == kNoBody) return;
  const Vec2 v{uniform(-2, 2), uniform(-2, 4)};
  const BodyState place = *world_->body(id);
  switch (below(8)) {
    case 0:
      return void(world_->set_velocity(id, v, uniform(-1, 1)));
    case 1:
      return void(world_->apply_impulse(id, v));
    case 2:
      return void(world_->apply_impulse_at(id, v, {place.x + 0.1, place.y}));
    case 3:
      return void(world_->apply_angular_impulse(id, uniform(-0.1, 0.1)));
    case 4:
      // Not far: a joint would pull it back within a step.
      return void(world_->set_transform(id, {place.x + uniform(-0.3, 0.3), place.y + uniform(0, 0.3)}, place.angle));
    case 5:
      return void(world_->set_velocity(id, {uniform(-40, 40), 0}, 0));  // it may leave the world
    default:
      require(world_->wake(id), "a living body is not woken");
  }
}

// Settings of the whole world.
void SoakCalls::set() {
  switch (below(8)) {
    case 0:
      return void(world_->set_gravity({uniform(-1, 1), -9.81}));
    case 1:
      return void(world_->set_skin(uniform(0.5, 2)));
    case 2:
      return world_->set_sleeping(uniform(0, 1) < 0.8);
    case 3:
      return void(world_->set_governor({uniform(0, 1) < 0.2, 0.5, {}}));
    case 4:
      return world_->enable_snapshots(uniform(0, 1) < 0.5);
    case 5:
      world_->start_trace();
      world_->step();
      ++steps_;
      world_->stop_trace();
      return void(world_->take_trace());
    default:
      world_->set_event_options({uniform(0, 1) < 0.8, uniform(0, 1) < 0.5, 2, uniform(0, 1) < 0.8});
  }
}

void SoakCalls::ask() {
  const Vec2 p{uniform(0, kWidth), uniform(0, kHeight)}, q{uniform(0, kWidth), uniform(0, kHeight)};
  switch (below(5)) {
    case 0:
      return void(world_->ray_cast(p, q));
    case 1:
      return void(world_->ray_cast_all(p, q));
    case 2:
      return void(world_->overlap(CapsuleShape{{-1, 0}, {1, 0}, 0.3}, q, 0.4));
    case 3:
      return void(world_->in_region({p.x - 2, p.y - 2, p.x + 2, p.y + 2}));
    default:
      world_->closest(p, 5);
  }
}

void SoakCalls::look() {
  const PublishedState s = world_->published();
  require(s.id.size() == world_->body_count(), "as many rows as bodies");
  require(finite(s), "a body's state is not finite");
  switch (below(6)) {
    case 0:
      return void(world_->contacts());
    case 1:
      return void(world_->strips());
    case 2:
      return void(world_->diagnostics());
    case 3:
      return void(world_->plan());
    case 4:
      return void(world_->latest_snapshot());
    default:
      if (const BodyId id = any(); id != kNoBody) require(!world_->why_awake(id).empty(), "no reason");
  }
}

// Another world goes on from the state with the same bits; this one goes back to it.
void SoakCalls::save_and_restore() {
  world_->save(state_);
  const std::uint64_t hash = world_->state_hash();
  std::string error;
  const auto other = World::from_state(state_, {Isa::scalar, 1}, error);
  world_->set_governor({});
  for (int k = 0; k < 2; ++k) world_->step();
  if (require(other != nullptr, "a state is refused")) {
    for (int k = 0; k < 2; ++k) other->step();
    require(other->state_hash() == world_->state_hash(), "a world goes on otherwise than its state");
  }
  require(world_->restore(state_, error) && world_->state_hash() == hash, "a world does not go back");
}

void SoakCalls::record() {
  world_->set_governor({});
  Recorder recorder(*world_, 3);
  std::string error;
  const BodyId id = recorder.add_body(any_body(), error);
  recorder.apply_impulse(any(), {1, 1});
  for (int k = 0; k < 6; ++k) recorder.step();
  recorder.remove_body(id);
  const std::vector<std::byte> recording = recorder.recording();
  const auto replay = Replay::open(recording, {best_isa(), 1}, error);
  if (replay == nullptr) {
    std::string ignored;
    write_bytes("soak-refused.psimrec", recording, ignored);
  }
  if (!require(replay != nullptr, "a recording is refused, it lies in soak-refused.psimrec: " + error)) return;
  while (replay->next()) {
  }
  require(replay->complete() && replay->differs_at() == 0, "a recording has other bits");
}

void SoakCalls::change() {
  const double of = uniform(0, 100);
  const bool full = bodies_.size() >= most_;
  if (of < 30) {
    full ? void(world_->remove_body(any())) : add();
  } else if (of < 31) {
    full ? remove_many() : add_many();
  } else if (of < 36) {
    change_type();
  } else if (of < 41) {
    join();
  } else if (of < 44) {
    unjoin();
  } else if (of < 48) {
    add_static();
  } else if (of < 74) {
    push();
  } else if (of < 75) {
    set();
  } else if (of < 92) {
    ask();
  } else if (of < 99.9) {
    look();
  } else if (of < 99.95) {
    save_and_restore();
  } else {
    record();
  }
  ++calls_;
}

void SoakCalls::step() {
  const StepReport report = world_->step();
  ++steps_;
  most_asleep_ = std::max<std::uint64_t>(most_asleep_, report.asleep);
  require(report.no_room_for == nullptr, "a step found no memory");
  const Events events = world_->events();
  events_ += events.begin.size() + events.end.size() + events.hits.size() + events.sensor_begin.size() +
             events.sensor_end.size();
}

bool SoakCalls::season() {
  while (any() != kNoBody) remove_many();
  require(world_->body_count() == 1 && world_->joint_count() == 0, "a body is left");
  bodies_.clear();
  joints_.clear();
  world_->save(state_);
  std::string error;
  const auto bare = World::from_state(state_, {best_isa(), 1}, error);
  if (!require(bare != nullptr, "a state is refused")) return false;
  bare_bytes_ = state_.size() + bare->memory_bytes();
  random_ = season_++ % kSeasons;
  world_->set_sleeping(true);
  world_->set_governor({});
  const std::uint64_t end = calls_ + kCallsAStep * kSteps;
  while (calls_ < end && fault_.empty()) {
    const std::uint64_t before = calls_;
    // Nothing changes in a fifth of the time, so that bodies come to rest.
    if (steps_ % 250 < 50) {
      calls_ += 2;
      ask();
      look();
    } else {
      while (calls_ < before + kCallsAStep && fault_.empty()) change();
    }
    step();
  }
  return fault_.empty();
}

}  // namespace psim::soak
