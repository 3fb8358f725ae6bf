// All bodies by id, and the hot columns of moving bodies by slot. Slots follow the order of the grid's cells and change
// whenever the lists are made anew; ids are stable.
//
//   by id    BodyInfo: the slot, and the entry in the table of properties (mass, radius, material)
//   by slot  pos, vel, disp (records), id, radius, reach, rim_speed, angle     the sort moves them together
//            vel_remainder, disp_remainder                                    moved after the sort; only with fields
//            built, linked                                                    written whenever lists are made
//            vel0, rim_speed0, acc, drift_correction, pull, event_time, rim_way   scratch of one step, not moved
//            arm_change, angle_change                                         the same; only with shapes or joints
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <utility>
#include <vector>

#include "base/column.h"
#include "base/lattice.h"
#include "bodies/body_properties.h"
#include "bodies/list_by_id.h"
#include "bodies/shape_table.h"
#include "least.h"
#include "psim/desc.h"
#include "views.h"

namespace psim {

inline constexpr std::uint32_t kNoSlot = 0xFFFFFFFFu;

/// An id is an index and a generation, which tells how many had the index before. What removes the last but one takes the
/// index away: nobody ever has this generation, and no id comes a second time.
inline constexpr std::uint32_t kLastGeneration = 0xFFFFFFFFu;

/// Where a body is: among the moving ones, the static ones, those with broken numbers, those that sleep, or those that the
/// host took out of the simulation for a while.
enum class Place : std::uint8_t { none, moving, fixed, frozen, asleep, disabled };
/// Whether a body at this place is in nobody's way.
inline bool is_out(Place place) { return place == Place::none || place == Place::frozen || place == Place::disabled; }

/// One body, by id.
struct BodyInfo {
  std::uint32_t slot = kNoSlot;  ///< moving: its slot in the columns; else its place in a list
  std::uint32_t generation = 0;
  std::uint32_t properties = 0;
  Place place = Place::none;
};

/// A kinematic body, with the velocity that the host gave it.
struct KinematicBody {
  std::uint32_t id = 0;
  Vec2 velocity;
};
using KinematicBodies = ListById<KinematicBody>;

/// A body that does not pass other moving bodies either (BodyDesc::bullet).
struct Bullet {
  std::uint32_t id = 0;
};
using Bullets = ListById<Bullet>;

/// Damping and locks of a dynamic body that has some of its own.
struct Restraint {
  std::uint32_t id = 0;
  float linear_damping = 0, angular_damping = 0;  ///< 1/s
  Locks locks;
};
using Restraints = ListById<Restraint>;

/// The speeds of a body, m/s.
struct Motion {
  float vx = 0, vy = 0, rim_speed = 0;
  /// No point of the body is faster.
  float fastest() const { return std::sqrt(vx * vx + vy * vy) + std::fabs(rim_speed); }
};

/// What the host pushes a body with until the next step is over. Pushes of frames in which time stood still add up to an
/// impulse.
struct AppliedForce {
  std::uint32_t id = 0;
  Vec2 force;         ///< N
  double torque = 0;  ///< N m
  Vec2 impulse;       ///< N s
  double spin = 0;    ///< N m s
  Motion before;      ///< within LentSpeeds: how it moves (solver/applied_forces.h)
};
using AppliedForces = ListById<AppliedForce>;

/// What the host keeps with a body.
struct UserValue {
  std::uint32_t id = 0;
  std::uint64_t value = 0;
};
using UserValues = ListById<UserValue>;

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
  Column<float> event_time{meter_}, rim_way{meter_};
  Column<std::uint8_t> linked{meter_};
  Column<std::int32_t> built{meter_};  ///< position when the lists were made
  Column<float> reach{meter_};         ///< m: the radius plus the margin of the lists

  // By id.
  mutable Column<BodyInfo> info{meter_};
  BodyPropertyTable property_table;
  ShapeTable hulls;
  PartTable parts;
  BodyKindTable kinds;
  const BodyKind& kind(std::uint32_t body_id) const { return kinds[properties(body_id).kind]; }
  const BodyProperties& properties(std::uint32_t body_id) const { return property_table[info[body_id].properties]; }
  /// How a part of a body bounces and rubs.
  Surface surface_of(std::uint32_t body_id, std::uint32_t part) const { return surface_of(properties(body_id), part); }
  Surface surface_of(const BodyProperties& body, std::uint32_t part) const {
    const std::uint32_t first = parts.any() ? kinds[body.kind].first_part : 0;
    return first == 0 ? Surface{body.restitution, body.friction, 0, 0} : parts[first + part].surface;
  }
  /// 1/kg: 0 of a body that joints cannot move, one that is locked altogether among them.
  float inv_mass_in_joints(std::uint32_t body_id) const {
    const BodyProperties& of = properties(body_id);
    const Locks& locks = kinds[of.kind].locks;
    return locks.x && locks.y && locks.angle ? 0.0f : of.inv_mass;
  }
  /// What a part of a body has.
  PartProperties part_of(const BodyProperties& body, std::uint32_t part) const {
    const BodyKind& kind = kinds[body.kind];
    if (kind.first_part != 0) return parts[kind.first_part + part];
    return {{body.restitution, body.friction, 0, 0}, kind.filter, static_cast<std::uint16_t>(kind.sensor)};
  }
  /// The number of the part that a hull of a body belongs to. Those of static bodies are of sensors and know it: make_sensors.
  std::uint32_t part_of_hull(const BodyProperties& body, std::uint32_t hull) const {
    const BodyKind& kind = kinds[body.kind];
    const std::uint32_t number = kind.part_of_hull(hull);
    if (kind.first_part == 0 || body.type() != BodyType::static_body) return number;
    const std::uint64_t told = parts[kind.first_part + number].user_data();  // in forged states anything
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(told, kind.part_count - 1));
  }
  /// Of length 1, in the body's frame, or of a static body in world axes: what comes against it meets this part. 0: what comes from anywhere.
  Vec2 one_way_of(const BodyKind& body, std::uint32_t part) const {
    if (body.first_part == 0) return {};
    const PartProperties& has = parts[body.first_part + part];
    return {has.one_way_x, has.one_way_y};
  }
  /// Whether the host is shown new contacts of a part.
  bool asks(const BodyKind& body, std::uint32_t part) const {
    return body.first_part != 0 && parts[body.first_part + part].pre_solve != 0;
  }
  const Filter& filter_of(const BodyKind& body, std::uint32_t part) const {
    return body.first_part == 0 ? body.filter : parts[body.first_part + part].filter;
  }
  bool is_sensor(const BodyKind& body, std::uint32_t part) const {
    return body.first_part == 0 ? body.sensor : parts[body.first_part + part].sensor != 0;
  }
  /// Whether two parts collide: neither is a sensor, and their filters agree.
  bool collide(const BodyKind& a, std::uint32_t part_a, const BodyKind& b, std::uint32_t part_b) const {
    return !is_sensor(a, part_a) && !is_sensor(b, part_b) && meet(filter_of(a, part_a), filter_of(b, part_b));
  }
  /// The same for two bodies: false if no parts of them do.
  bool may_collide(const BodyKind& a, const BodyKind& b) const {
    return a.first_part != 0 || b.first_part != 0 || collide(a, 0, b, 0);
  }
  std::uint32_t id_count = 0;
  std::vector<std::uint32_t> free_ids;
  std::uint32_t retired = 0;  ///< indices that are given to nobody any more

  std::uint32_t count = 0;  ///< slots in use; dead slots (id == kNoSlot) count until the next sort
  std::uint32_t dead = 0;
  std::uint32_t listed = 0;  ///< slots since the last sort: lists and contacts may name them, and none behind them
  std::uint32_t awake() const { return count - dead; }
  std::size_t living() const { return id_count - free_ids.size() - retired; }

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
  /// Cleared by release after the slots were written, read by acquire before they are. The thread that sorts sets it; no
  /// other thread may look at the world meanwhile.
  mutable std::atomic<bool> slots_stale = false;

  /// Calls each(slot) for every so many bodies, some 2,000 in all.
  template <class Each>
  void each_sampled(const Each& each) const {
    const std::uint32_t stride = std::max(1u, count / 2048);
    for (std::uint32_t i = 0; i < count; i += stride) {
      if (id[i] != kNoSlot) each(i);
    }
  }

  std::uint32_t blocks() const { return (count + kernels::kBlock - 1) / kernels::kBlock; }

  /// Gives out an id: one that is free again, else a new one.
  std::uint32_t take_id() {
    if (!free_ids.empty()) {
      const std::uint32_t index = free_ids.back();
      free_ids.pop_back();
      return index;
    }
    info.reserve(std::size_t{id_count} + 1);
    return id_count++;
  }

  /// Gives a body a slot behind the others, where it is at rest.
  std::uint32_t enter(std::uint32_t body, const LatticePoint& at, double turn) {
    reserve_slots(1);
    const std::uint32_t slot = count++;
    info[body].slot = slot;
    info[body].place = Place::moving;
    id[slot] = body;
    radius[slot] = properties(body).radius;
    linked[slot] = 0;
    put_point(slot, at);
    put_velocity(slot, {});
    clear_remainders(slot);
    if (rim_speed.empty()) return slot;
    rim_speed[slot] = 0;
    angle[slot] = turn;
    return slot;
  }

  /// Takes the body of a slot out. A listed slot stays as a dead one; another one is given to the last body, so that
  /// bodies that come and go between two steps take no more room than there are at once.
  void leave(std::uint32_t slot) {
    id[slot] = kNoSlot;
    if (slot < listed) {
      ++dead;
    } else if (const std::uint32_t last = --count; slot != last) {
      move_slot(last, slot);
    }
    if (dead == count) count = dead = listed = 0;  // nobody is awake
  }

  /// Makes room for n more slots.
  void reserve_slots(std::size_t n) {
    const std::size_t total = kernels::round_up_block(count + n);
    keep_if(true, 2 * total, pos, vel, disp);
    keep_if(true, total, id, radius, linked);
    if (!rim_speed.empty()) keep_rotation(true);
    if (!vel_remainder.empty()) keep_remainders(true, !disp_remainder.empty());
  }

  /// Makes the columns of rotation, filled with zero, or gives them back. Then no body may have an angle or an angular
  /// velocity. The speeds come last: where they are, so is all of it.
  void keep_rotation(bool wanted) { keep_if(wanted, id.capacity(), angle, rim_speed0, rim_speed); }

  /// Makes the columns of the remainders, filled with zero, or gives them back.
  void keep_remainders(bool of_velocities, bool of_offsets) {
    keep_if(of_velocities, 2 * id.capacity(), vel_remainder);
    keep_if(of_offsets, 2 * id.capacity(), disp_remainder);
  }

  /// Makes the columns of turning within a frame, filled with zero, or gives them back.
  void keep_turns(bool wanted) {
    keep_if(wanted, 2 * id.capacity(), arm_change);
    keep_if(wanted, id.capacity(), angle_change);
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
    disp[2 * slot] = kernels::snapped(p.dx, kernels::kLeastOffset);
    disp[2 * slot + 1] = kernels::snapped(p.dy, kernels::kLeastOffset);
  }
  double angle_of(std::size_t slot) const { return angle.empty() ? 0 : angle[slot]; }
  float rim_speed_of(std::size_t slot) const { return rim_speed.empty() ? 0.0f : rim_speed[slot]; }
  /// The angular velocity, rad/s.
  double omega_of(std::size_t slot) const { return double{rim_speed_of(slot)} / radius[slot]; }
  Vec2 velocity(std::size_t slot) const { return {vel[2 * slot], vel[2 * slot + 1]}; }

  /// Sets the velocity of a slot, m/s. Where remainders are kept, the part that does not fit into a float goes there.
  void put_velocity(std::size_t slot, Vec2 v) {
    vel[2 * slot] = kernels::snapped(v.x);
    vel[2 * slot + 1] = kernels::snapped(v.y);
    if (vel_remainder.empty()) return;
    const Vec2 rest = v - velocity(slot);
    vel_remainder[2 * slot] = static_cast<float>(rest.x);
    vel_remainder[2 * slot + 1] = static_cast<float>(rest.y);
  }

  /// Sets the rim speed of a slot, m/s, where there is rotation.
  void put_rim_speed(std::size_t slot, double u) {
    if (!rim_speed.empty()) rim_speed[slot] = kernels::snapped(u);
  }

  /// Fills up the last block with neutral records: at the place of the last body, at rest, unlinked.
  void pad_tail() {
    const std::size_t last = count - 1;
    for (std::size_t i = count; i < kernels::round_up_block(count); ++i) {
      put_point(i, {pos[2 * last], pos[2 * last + 1]});
      vel[2 * i] = vel[2 * i + 1] = 0;
      radius[i] = 0;
      linked[i] = 0;
      id[i] = kNoSlot;
      if (!rim_speed.empty()) rim_speed[i] = 0;
    }
  }

  std::size_t rotation_bytes() const { return rim_speed.bytes() + angle.bytes() + rim_speed0.bytes(); }

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
            .rim_way = rim_way.data(),
            .linked = linked.data()};
  }

 private:
  void move_slot(std::uint32_t from, std::uint32_t to) {
    for (Column<float>* record : {&vel, &disp, &vel_remainder, &disp_remainder}) {
      if (!record->empty())
        std::copy_n(record->data() + 2 * std::size_t{from}, 2, record->data() + 2 * std::size_t{to});
    }
    std::copy_n(pos.data() + 2 * std::size_t{from}, 2, pos.data() + 2 * std::size_t{to});
    for (Column<float>* value : {&radius, &rim_speed}) {
      if (!value->empty()) (*value)[to] = (*value)[from];
    }
    if (!angle.empty()) angle[to] = angle[from];
    linked[to] = linked[from];
    id[to] = id[from];
    if (id[to] != kNoSlot) info[id[to]].slot = to;
  }

  mutable std::mutex finding_;
};

}  // namespace psim
