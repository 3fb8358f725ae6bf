// All bodies by id, and the hot columns of moving bodies by slot. Slots follow the order of the grid's cells and change
// whenever the lists are made anew; ids are stable.
//
//   by id    BodyInfo: the slot, and the entry in the table of properties (mass, radius, material)
//   by slot  pos, vel, disp (records), id, radius, rim_speed, angle    the sort moves them together
//            vel_remainder, disp_remainder                             moved after the sort; only with fields
//            vel0, acc, drift_correction, pull, event_time, linked     scratch of one step, not moved
//            arm_change, angle_change                                  scratch of one frame; only with shapes or joints
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <utility>
#include <vector>

#include "base/column.h"
#include "base/lattice.h"
#include "bodies/body_properties.h"
#include "bodies/shape_table.h"
#include "psim/desc.h"
#include "views.h"

namespace psim {

inline constexpr std::uint32_t kNoSlot = 0xFFFFFFFFu;

enum class Place : std::uint8_t { none, moving, fixed, frozen, asleep };

/// One body, by id.
struct BodyInfo {
  std::uint32_t slot = kNoSlot;  ///< moving: its slot in the columns; else its place in a list
  std::uint32_t generation = 0;
  std::uint32_t properties = 0;
  Place place = Place::none;
};

/// Ids of the kinematic bodies, with the velocities that the host gave them.
using KinematicBodies = std::vector<std::pair<std::uint32_t, Vec2>>;

/// Frames of a body's present motion that are looked ahead: what margins of lists allow for, who may touch, who wakes.
/// A quarter more than one frame, since speeds change within a step.
inline constexpr double kMarginFrames = 1.25;

class BodyStore {
  MemoryMeter& meter_;  // stands first, since the columns take it

 public:
  explicit BodyStore(MemoryMeter& meter) : meter_(meter) {}

  // By slot.
  Column<std::int32_t> pos{meter_};
  Column<float> vel{meter_}, disp{meter_};
  Column<std::uint32_t> id{meter_};
  Column<float> radius{meter_};
  Column<float> rim_speed{meter_};  ///< only if the plan has rotation
  Column<double> angle{meter_};     ///< only if the plan has rotation
  Column<float> vel0{meter_}, rim_speed0{meter_}, acc{meter_};
  Column<float> drift_correction{meter_};  ///< m, records: see BodyView; only if the plan has an integrator
  Column<float> pull{meter_};              ///< gravity scale, 0 for kinematic bodies; only if the plan has scales
  Column<float> vel_remainder{meter_};     ///< m/s, records: what velocities lost to rounding; only with fields
  Column<float> disp_remainder{meter_};    ///< m, records: the same for offsets; only if the plan has an integrator
  Column<float> spare{meter_};             ///< scratch of move_remainders
  Column<float> arm_change{meter_}, angle_change{meter_};  ///< since the frame's start; only with shapes or joints
  Column<float> event_time{meter_};
  Column<std::uint8_t> linked{meter_};
  Column<std::int32_t> built{meter_};  ///< position when the lists were made
  Column<float> reach{meter_};         ///< m: the radius plus the margin of the lists

  // By id.
  mutable Column<BodyInfo> info{meter_};
  BodyPropertyTable property_table;
  ShapeTable hulls;
  BodyKindTable kinds;
  const BodyKind& kind(std::uint32_t body_id) const { return kinds[properties(body_id).kind]; }
  const BodyProperties& properties(std::uint32_t body_id) const { return property_table[info[body_id].properties]; }
  std::uint32_t id_count = 0;
  std::vector<std::uint32_t> free_ids;

  std::uint32_t count = 0;  ///< slots in use; dead slots (id == kNoSlot) count until the next sort
  std::uint32_t dead = 0;
  std::uint32_t awake() const { return count - dead; }
  std::size_t living = 0, moving = 0, fixed = 0, kinematic = 0;
  std::size_t asleep = 0;  ///< of the moving bodies: they sleep and have no slot

  /// Brings info[id].slot of moving bodies up to date, since a sort moves bodies to other slots and leaves `info` as it
  /// is. Comes before every read of such a slot. O(bodies) after a sort, else nothing. Threads may call it at once.
  void find_slots() const {
    if (!slots_stale.load(std::memory_order_acquire)) return;
    const std::lock_guard<std::mutex> lock(finding_);
    if (!slots_stale.load(std::memory_order_relaxed)) return;
    for (std::uint32_t i = 0; i < count; ++i) {
      if (id[i] != kNoSlot) info[id[i]].slot = i;
    }
    slots_stale.store(false, std::memory_order_release);
  }
  mutable std::atomic<bool> slots_stale = false;

  std::uint32_t blocks() const { return (count + kernels::kBlock - 1) / kernels::kBlock; }

  /// Gives out an id: one that is free again, else a new one.
  std::uint32_t take_id() {
    ++living;
    if (!free_ids.empty()) {
      const std::uint32_t index = free_ids.back();
      free_ids.pop_back();
      return index;
    }
    info.reserve(std::size_t{id_count} + 1);
    return id_count++;
  }

  /// Makes room for n more slots.
  void reserve_slots(std::size_t n) {
    const std::size_t total = kernels::round_up_block(count + n);
    pos.reserve(2 * total);
    vel.reserve(2 * total);
    disp.reserve(2 * total);
    id.reserve(total);
    radius.reserve(total);
    linked.reserve(total);
    if (!rim_speed.empty()) add_rotation();
    if (!vel_remainder.empty()) add_remainders(!disp_remainder.empty());
  }

  /// Makes the columns of rotation, filled with zero, if they are not there.
  void add_rotation() {
    const std::size_t total = kernels::round_up_block(id.capacity());
    rim_speed.reserve(total);
    angle.reserve(total);
    rim_speed0.reserve(total);
  }

  /// Makes the columns of the remainders, filled with zero, if they are not there.
  void add_remainders(bool of_offsets) {
    const std::size_t total = kernels::round_up_block(id.capacity());
    vel_remainder.reserve(2 * total);
    if (of_offsets) disp_remainder.reserve(2 * total);
  }

  /// Sets the remainders of a slot to zero, since its velocity and offset are new.
  void clear_remainders(std::size_t slot) {
    for (Column<float>* rest : {&vel_remainder, &disp_remainder}) {
      if (!rest->empty()) (*rest)[2 * slot] = (*rest)[2 * slot + 1] = 0;
    }
  }

  LatticePoint point(std::size_t slot) const {
    return {pos[2 * slot], pos[2 * slot + 1], disp[2 * slot], disp[2 * slot + 1]};
  }
  void put_point(std::size_t slot, const LatticePoint& p) {
    pos[2 * slot] = p.x;
    pos[2 * slot + 1] = p.y;
    disp[2 * slot] = p.dx;
    disp[2 * slot + 1] = p.dy;
  }
  double angle_of(std::size_t slot) const { return angle.empty() ? 0 : angle[slot]; }
  /// The angular velocity, rad/s.
  double omega_of(std::size_t slot) const {
    return rim_speed.empty() ? 0 : static_cast<double>(rim_speed[slot]) / static_cast<double>(radius[slot]);
  }
  Vec2 velocity(std::size_t slot) const {
    return {static_cast<double>(vel[2 * slot]), static_cast<double>(vel[2 * slot + 1])};
  }

  /// Sets the velocity of a slot, m/s. Where remainders are kept, the part that does not fit into a float goes there.
  void put_velocity(std::size_t slot, Vec2 v) {
    vel[2 * slot] = static_cast<float>(v.x);
    vel[2 * slot + 1] = static_cast<float>(v.y);
    if (vel_remainder.empty()) return;
    vel_remainder[2 * slot] = static_cast<float>(v.x - static_cast<double>(vel[2 * slot]));
    vel_remainder[2 * slot + 1] = static_cast<float>(v.y - static_cast<double>(vel[2 * slot + 1]));
  }

  /// Fills up the last block with neutral records: at the place of the last body, at rest, unlinked.
  void pad_tail() {
    const std::uint32_t end = static_cast<std::uint32_t>(kernels::round_up_block(count));
    for (std::uint32_t i = count; i < end; ++i) {
      pos[2 * i] = pos[2 * (count - 1)];
      pos[2 * i + 1] = pos[2 * (count - 1) + 1];
      vel[2 * i] = vel[2 * i + 1] = disp[2 * i] = disp[2 * i + 1] = 0;
      radius[i] = 0;
      linked[i] = 0;
      id[i] = kNoSlot;
      if (!rim_speed.empty()) rim_speed[i] = 0;
    }
  }

  /// Gives the columns of rotation back. No body may have an angle or an angular velocity.
  void drop_rotation() {
    rim_speed.release();
    angle.release();
    rim_speed0.release();
  }
  std::size_t rotation_bytes() const { return rim_speed.bytes() + angle.bytes() + rim_speed0.bytes(); }

  /// Makes the columns of turning within a frame, filled with zero, or gives them back.
  void keep_turns(bool wanted) {
    if (!wanted) {
      arm_change.release();
      angle_change.release();
      return;
    }
    const std::size_t total = kernels::round_up_block(id.capacity());
    arm_change.reserve(2 * total);
    angle_change.reserve(total);
  }

  /// Returns the columns as kernels see them. A column that the plan does not have is null.
  kernels::BodyView view() {
    return {.pos = pos.data(),
            .vel = vel.data(),
            .vel0 = vel0.data(),
            .disp = disp.data(),
            .acc = acc.data(),
            .vel_remainder = vel_remainder.data(),
            .disp_remainder = disp_remainder.data(),
            .drift_correction = drift_correction.data(),
            .pull = pull.data(),
            .rim_speed = rim_speed.data(),
            .rim_speed0 = rim_speed0.data(),
            .arm_change = arm_change.data(),
            .angle_change = angle_change.data(),
            .event_time = event_time.data(),
            .linked = linked.data()};
  }

 private:
  mutable std::mutex finding_;
};

}  // namespace psim
