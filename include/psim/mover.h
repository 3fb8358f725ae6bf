// A character that walks through a world: an upright capsule that no force moves. It slides along what it meets, climbs
// steps, stands on slopes up to a limit, rides on platforms and passes through what is solid from one side. It is no
// body: other bodies do not feel it, unless it pushes them. Built on the queries of World (psim/query.h).
//
//   velocity = mover.velocity();               // what the last move left of it
//   velocity.x = 5 * stick;
//   velocity.y = jump && mover.on_ground() ? 6 : velocity.y - 9.81 * dt;
//   mover.move(*world, velocity, dt);          // after world->step()
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "psim/api.h"
#include "psim/query.h"
#include "psim/world.h"

namespace psim {

class Recorder;

/// What a mover is.
struct MoverDesc {
  double radius = 0.3;         ///< metres, 1e-6 to 1e3: of the capsule
  double half_height = 0.6;    ///< metres, 0 to 1e3: from its middle to the centres of its round ends
  Vec2 up = {0, 1};            ///< direction of any length: the capsule stands along it
  double slope_limit = 0.873;  ///< radians, 0 to 1.5: ground is no steeper; 50 degrees
  double step_height = 0.3;    ///< metres, 0 to 1e3: it climbs steps no higher, and walks down them without a fall
  double skin = 0.01;          ///< metres, above 0, at most the radius: the distance that it keeps
  double push_force = 0;       ///< N, 0 to 1e12: it pushes dynamic bodies in its way with no more
  QueryFilter filter = {};     ///< what it meets; `one_way` and `enter_only` are set by the mover
};

/// What a mover stands on.
struct MoverGround {
  BodyId body = {};    ///< that it stands on
  Vec2 point = {};     ///< metres: where it touches
  Vec2 normal = {};    ///< of the surface
  Vec2 velocity = {};  ///< m/s: of the surface at the point; a game may add it to that of a jump
};

/// What a mover met in a move.
struct MoverTouch {
  BodyId body = {};  ///< that it met
  Vec2 point = {};   ///< metres
  Vec2 normal = {};  ///< of the body's surface
};

/// A character. It may be copied: a copy goes on with the same bits.
class PSIM_API Mover {
 public:
  /// A move tells of no more bodies than this.
  static constexpr std::size_t kMostTouches = 16;

  /// At a place, metres: of the middle of the capsule. With a description that is not sound no move does anything.
  explicit Mover(const MoverDesc& desc = {}, Vec2 position = {});
  /// Whether all numbers are within their ranges.
  static bool sound(const MoverDesc& desc);

  /// One move of `dt` seconds (above 0, at most 10) at `velocity`, m/s, as seen from what it stands on: after each step of
  /// the world. First it goes with the ground, then out of what it overlaps, then its own way. While it stands and the
  /// velocity does not point up it walks: what is across `up` counts, along the ground. False, and nothing changes, if a
  /// number is out of range (1e6 m/s, 1e9 m) or a query found no memory (out_of_memory). Pushes go through the recorder, if
  /// there is one. Not beside another call.
  bool move(World& world, Vec2 velocity, double dt, Recorder* recorder = nullptr);

  /// Puts it elsewhere, metres: at rest, on no ground. False and nothing changes if a number is out of range.
  bool set_position(Vec2 position);
  /// Changes what it is, say to duck; it stays where its middle is. False and nothing changes if it is not sound.
  bool set_desc(const MoverDesc& desc);
  /// As described.
  const MoverDesc& desc() const { return desc_; }
  /// Metres: the middle of the capsule.
  Vec2 position() const { return position_; }
  /// m/s: what is left of the last move's velocity.
  Vec2 velocity() const { return velocity_; }
  /// Whether it stands.
  bool on_ground() const { return stands_; }
  /// On what; nothing in the air.
  std::optional<MoverGround> ground() const { return stands_ ? std::optional<MoverGround>(ground_) : std::nullopt; }
  /// What it met in the last move, each body once, in the order of the move.
  std::span<const MoverTouch> touches() const { return {touches_.data(), touch_count_}; }
  /// Metres: how deep it is still in something after the last move, from both sides at once; 0: it is free.
  double squeezed() const { return squeezed_; }

 private:
  friend struct MoverWork;
  MoverDesc desc_;
  Vec2 position_, velocity_;
  bool stands_ = false;
  MoverGround ground_;
  Vec2 anchor_;  // the point of the ground in the frame of its body
  double squeezed_ = 0;
  std::array<MoverTouch, kMostTouches> touches_;
  std::size_t touch_count_ = 0;
};

}  // namespace psim
