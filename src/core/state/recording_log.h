// A recording holds the state that it began with, and a log of entries. This file describes the entries.
#pragma once

#include <array>
#include <span>
#include <tuple>
#include <vector>

#include "psim/pre_solve.h"
#include "psim/world.h"
#include "state/describe_calls.h"

namespace psim::recorded {

// Calls of the host that take what they are given, each by its place in this list.
inline constexpr std::tuple kCalls{&World::remove_body,    &World::set_transform,     &World::set_velocity,
                                   &World::apply_impulse,  &World::apply_impulse_at,  &World::apply_angular_impulse,
                                   &World::set_gravity,    &World::set_sleeping,      &World::wake,
                                   &World::remove_joint,   &World::set_motor,         &World::set_skin,
                                   &World::set_enabled,    &World::set_traits,        &World::set_user_data,
                                   &World::set_target,     &World::apply_force,       &World::apply_force_at,
                                   &World::apply_torque,   &World::explode,           &World::set_part_traits,
                                   &World::remove_emitter, &World::set_emitter_speed, &World::remove_drain};

// An entry of the log begins with one of these numbers, or with kCallsBegin and the place of a call in kCalls.
enum Op : std::uint8_t {
  kStep,
  kHash,
  kAddBody,
  kAddDiscs,
  kAddJoint,
  kSetJoint,
  kSetFields,
  kSetBody,
  kDecide,
  kRemoveBodies,
  kAddFluid,
  kAddParticles,
  kAddEmitter,
  kAddDrain,
  kCallsBegin
};
inline constexpr std::uint8_t kOps = kCallsBegin + std::tuple_size_v<decltype(kCalls)>;

struct RecordHeader : FileHeader {
  static constexpr std::uint64_t kMagic = 0x31304352'6D697370u;  // "psimRC01"
  static constexpr std::uint64_t kFormat = 17;
  std::uint64_t state = 0;  ///< bytes of the state that it began with
  std::uint64_t steps = 0;

  void seal(std::span<const std::byte> rest) {
    const std::uint64_t hash = hash_of(rest) + 0x9E3779B97F4A7C15u * steps;
    static_cast<FileHeader&>(*this) = {kMagic, kFormat, sizeof *this + rest.size(), hash};
  }
};

// What the host said of one new contact, and of all that it was shown at once.
struct Answer {
  bool enabled = true;
  std::array<double, 4> surface{};  // friction, restitution, tangent speed, rolling resistance
};
using Answers = std::vector<Answer>;
inline auto fields(Answer& a) { return std::tie(a.enabled, a.surface); }
inline constexpr std::size_t kAnswerBytes = 33, kAnswersBytes = 32;  // no less than they take in a log

// What a DiscBatch looks at.
using Discs = std::array<std::vector<double>, 7>;

inline void describe(Archive& a, DiscBatch& b, Discs& discs) {
  std::span<const double>* seen[] = {&b.x, &b.y, &b.radius, &b.angle, &b.vx, &b.vy, &b.angular_velocity};
  for (std::size_t k = 0; k < discs.size(); ++k) {
    discs[k].assign(seen[k]->begin(), seen[k]->end());
    values(a, discs[k]);
    *seen[k] = discs[k];
  }
  values(a, b.type, b.material, b.mass, b.gravity_scale, b.fixed_rotation, b.bullet, b.filter);
}

}  // namespace psim::recorded
