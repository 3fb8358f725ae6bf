#include "psim/mover.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

#include "base/elementary.h"
#include "base/machine.h"
#include "base/room.h"
#include "mover/mover_path.h"
#include "psim/limits.h"
#include "psim/recording.h"

namespace psim {
namespace {

constexpr Range kRadius{1e-6, 1e3}, kHeight{0, 1e3}, kSlope{0, 1.5}, kForce{0, 1e12};
constexpr int kMostPushesOut = 4;      // looks at what overlaps
constexpr std::size_t kMostNear = 16;  // pieces that one look sees
constexpr double kStill = 1e-9;        // m: ground that goes no farther stands still, but for rounding
constexpr int kMostRides = 64;         // parts of a way on a platform; one that is longer is a jump

// From one point of a periodic world to the nearest copy of the other.
Vec2 nearest_way(const World& world, Vec2 way) {
  if (world.desc().boundary != Boundary::periodic) return way;
  const Bounds& b = world.desc().bounds;
  const Vec2 size{b.xmax - b.xmin, b.ymax - b.ymin};
  return {way.x - size.x * std::rint(way.x / size.x), way.y - size.y * std::rint(way.y / size.y)};
}

}  // namespace

/// One move.
struct MoverWork {
  World& world;
  const MoverDesc& desc;
  Mover& mover;
  const double dt;
  MoverPath path{world, desc, mover.position_};

  // Takes the capsule along with the ground, which has moved and turned since the last move.
  void ride() {
    if (!mover.stands_) return;
    const auto body = world.body(mover.ground_.body);
    if (!body || !world.is_enabled(mover.ground_.body)) return;
    const Vec2 now = Vec2{body->x, body->y} + turned(sine_cosine(body->angle), mover.anchor_);
    const Vec2 n = mover.ground_.normal;
    Vec2 way = nearest_way(world, now - mover.ground_.point);
    if (const auto has = world.traits(mover.ground_.body)) way = way + dt * has->tangent_speed * Vec2{n.y, -n.x};
    const double length = length_of(way), part = desc.radius / 2;
    if (!(length > kStill) || !sound_place(path.at + way)) return;
    const int parts = length < kMostRides * part ? static_cast<int>(length / part) + 1 : 1;
    for (int k = 0; k < parts; ++k) {
      if (k > 0) push_out();
      path.at = path.at + 1.0 / parts * way;
    }
  }

  // Out of what overlaps: the least way that keeps the near surfaces outside, by Gauss and Seidel.
  void push_out() {
    mover.squeezed_ = 0;
    const double reach = desc.radius / 2;
    for (int look = 0; look < kMostPushesOut; ++look) {
      std::array<NearHit, kMostNear> near;
      std::array<double, kMostNear> need{}, push{};
      const std::size_t count = std::min(world.nearby(path.capsule, path.at, 0, reach, near, path.filter), near.size());
      double deepest = 0;
      for (std::size_t k = 0; k < count; ++k) {
        need[k] = -near[k].distance;  // a surface that is apart stays so
        if (near[k].distance >= 0) continue;
        if (near[k].one_way && !catches(near[k])) {
          need[k] = -1e300;
          continue;
        }
        need[k] += desc.skin / 2;
        deepest = lesser(near[k].distance, deepest);
        path.touch({near[k].body, near[k].point, near[k].normal, 0});
      }
      mover.squeezed_ = 0 - deepest;
      if (deepest == 0) return;
      Vec2 out;
      for (int sweep = 0; sweep < 20; ++sweep) {
        for (std::size_t k = 0; k < count; ++k) {
          const double more = greater(push[k] + need[k] - dot(near[k].normal, out), 0.0) - push[k];
          push[k] += more;
          out = out + more * near[k].normal;
        }
      }
      const double length = length_of(out);
      path.at = path.at + (length > reach ? reach / length : 1) * out;
    }
  }

  // m/s: of a point of a body that is there.
  Vec2 velocity_at(BodyId body, Vec2 point) const { return world.velocity_at(body, point).value_or(Vec2{}); }

  // Whether a shape that is solid from one side, and in which the foot is, came against the mover in the last step.
  bool catches(const NearHit& near) const {
    const double closing = dot(velocity_at(near.body, near.point) - mover.velocity_, near.normal);
    return closing >= 0 && -near.distance <= desc.skin + closing * dt;
  }

  // Its own way.
  void go(Vec2 velocity) {
    const bool walks = mover.stands_ && dot(velocity, path.up) <= 1e-9;
    mover.velocity_ = velocity;
    if (walks) {
      const double speed = dot(velocity, path.side);
      mover.velocity_ = path.walk(dt * speed, mover.ground_.normal) ? speed * path.side : Vec2{};
    } else {
      path.fly(dt * velocity, mover.velocity_);
    }
    auto ground = dot(mover.velocity_, path.up) <= 1e-9 ? path.settle(walks) : std::nullopt;
    if (walks && !ground) {  // it walked off an edge, or hangs between two sides
      const Vec2 fall = dot(velocity, path.up) * path.up;
      mover.velocity_ = mover.velocity_ + fall;
      path.fly(dt * fall, mover.velocity_);
      ground = path.settle(false);
    }
    mover.stands_ = ground.has_value();
    if (!ground) return;
    mover.ground_ = *ground;
    mover.velocity_ = dot(mover.velocity_, path.side) * path.side;
    const auto body = world.body(ground->body);
    if (!body) return;
    const SineCosine turn = sine_cosine(body->angle);
    mover.anchor_ = turned({-turn.sine, turn.cosine}, nearest_way(world, ground->point - Vec2{body->x, body->y}));
    mover.ground_.velocity = velocity_at(ground->body, Vec2{body->x, body->y} + turned(turn, mover.anchor_));
    if (const auto has = world.traits(ground->body)) {
      mover.ground_.velocity = mover.ground_.velocity + has->tangent_speed * Vec2{ground->normal.y, -ground->normal.x};
    }
  }

  // Gives dynamic bodies in the way the mover's speed, as far as its force does. False if there was no memory for the
  // first push; where there is none for a later one, that body and the rest are not pushed.
  bool push_bodies(Vec2 velocity, Recorder* recorder) {
    bool pushed = false;
    if (!(desc.push_force > 0)) return true;
    for (std::size_t k = 0; k < path.touch_count; ++k) {
      const MoverTouch& t = path.touches[k];
      if (path.is_ground(t.normal)) continue;
      const auto body = world.body(t.body);
      const auto has = world.traits(t.body);
      if (!body || !has || body->type != BodyType::dynamic_body || !(has->mass > 0)) continue;
      const Vec2 arm = nearest_way(world, t.point - Vec2{body->x, body->y}), at = Vec2{body->x, body->y} + arm;
      const double closing = -dot(velocity - velocity_at(t.body, at), t.normal);
      const double turn = cross(arm, t.normal);
      const double yield = 1 / has->mass + (has->inertia > 0 ? turn * turn / has->inertia : 0);
      const double impulse = lesser(desc.push_force * dt, closing / yield);
      if (!(impulse > 0)) continue;
      const Vec2 push = -impulse * t.normal;
      const bool done =
          recorder != nullptr ? recorder->apply_impulse_at(t.body, push, at) : world.apply_impulse_at(t.body, push, at);
      if (!done && ran_out_of_memory()) return pushed;
      pushed |= done;
    }
    return true;
  }

  static bool sound_place(Vec2 p) { return limits::kCoordinate.contains(p); }
};

Mover::Mover(const MoverDesc& desc, Vec2 position) : desc_(desc), position_(position) {}

bool Mover::sound(const MoverDesc& d) {
  const double length = length_of(d.up);
  return kRadius.contains(d.radius) && kHeight.contains(d.half_height) && length > 1e-9 && length < 1e9 &&
         kSlope.contains(d.slope_limit) && kHeight.contains(d.step_height) && d.skin > 0 && d.skin <= d.radius &&
         kForce.contains(d.push_force);
}

bool Mover::move(World& world, Vec2 velocity, double dt, Recorder* recorder) {
  const FloatSettings settings;
  if (!sound(desc_) || !MoverWork::sound_place(position_) || !limits::kVelocity.contains(velocity) ||
      !limits::kTimeStep.contains(dt)) {
    return false;
  }
  const bool before = std::exchange(ran_out_of_memory(), false);
  Mover next = *this;
  MoverWork work{world, desc_, next, dt};
  work.ride();
  work.push_out();
  work.go(velocity);
  if (ran_out_of_memory() || !MoverWork::sound_place(work.path.at) || !work.push_bodies(velocity, recorder)) {
    ran_out_of_memory() |= before;
    return false;
  }
  next.position_ = work.path.at;
  next.touches_ = work.path.touches;
  next.touch_count_ = work.path.touch_count;
  *this = next;
  ran_out_of_memory() |= before;
  return true;
}

bool Mover::set_position(Vec2 position) {
  if (!MoverWork::sound_place(position)) return false;
  *this = Mover(desc_, position);
  return true;
}

bool Mover::set_desc(const MoverDesc& desc) {
  if (!sound(desc)) return false;
  desc_ = desc;
  return true;
}

}  // namespace psim
