// Every body by id, and the hot columns of those that move, by slot. Slots follow the grid's cell
// order and change whenever the lists are rebuilt; ids are stable.
//
//   by id:   BodyInfo (where its slot is, its Surface: mass, radius, material)
//   by slot: pos, vel, disp (records), id, radius, spin, angle   moved together by the sort
//            vel_rest, disp_rest                                 moved after it (fields only)
//            vel0, acc, bend, pull, event_time, linked           scratch of one build, not moved
//            turn, swing                                         of one frame (shapes, joints only)
#pragma once

#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <mutex>
#include <optional>
#include <vector>

#include "column.h"
#include "lattice.h"
#include "psim/desc.h"
#include "make_table.h"
#include "shape_table.h"
#include "views.h"

namespace psim {

inline constexpr std::uint32_t kNoSlot = 0xFFFFFFFFu;

enum class Place : std::uint8_t { none, moving, fixed, frozen, asleep };

/// Of restitution or friction. What a step would take for 0 (FloatSettings) is 0, so that whoever counts bodies by it
/// gets the same inside and outside of one.
inline float coefficient(double value) {
  const auto as_float = static_cast<float>(value);
  return as_float < std::numeric_limits<float>::min() ? 0.0f : as_float;
}

/// What bodies of one make share: a million equal discs have one Surface.
struct Surface {
  float inv_mass = 0;       ///< 1/kg; 0 = kinematic or static
  float mass = 0;           ///< kg
  float spin_gain = 0;      ///< r^2 / inertia, 1/kg; 0 = does not turn
  float radius = 0;         ///< m: of the circle about the centre that holds it
  float gravity_scale = 1;
  float restitution = 0;
  float friction = 0;
  std::uint32_t make : 24 = 0;        ///< in BodyStore::makes; 0: a plain disc that meets all
  BodyType type : 8 = BodyType::dynamic_body;
  friend bool operator==(const Surface&, const Surface&) = default;
};
static_assert(sizeof(Surface) == 32);

/// One body, by id.
struct BodyInfo {
  std::uint32_t slot = kNoSlot;  ///< moving: column slot; fixed, frozen, asleep: place in its list
  std::uint32_t generation = 0;
  std::uint32_t surface = 0;
  Place place = Place::none;
};

/// Bodies whose ids follow each other and that differ in nothing but their slots, which follow each other too
/// unless they move.
struct AlikeBodies {
  std::uint32_t count = 0, generation = 0, surface = 0, slot = kNoSlot;
  Place place = Place::none;
  friend bool operator==(const AlikeBodies&, const AlikeBodies&) = default;
};

/// Surfaces in use, each once for a run of equal bodies.
class SurfaceTable {
  friend struct Image;

 public:
  const Surface& operator[](std::uint32_t i) const { return list_[i].surface; }
  std::size_t bytes() const { return (list_.capacity() + before_.capacity()) * sizeof(Entry); }

  /// The heaviest dynamic body over the lightest; 1 if there is none. O(surfaces).
  double mass_ratio() const {
    float least = std::numeric_limits<float>::infinity(), most = 0;
    for (const Entry& e : list_) {
      if (e.users == 0 || !(e.surface.mass > 0)) continue;
      least = std::fmin(least, e.surface.mass);
      most = std::fmax(most, e.surface.mass);
    }
    return most > 0 ? static_cast<double>(most) / static_cast<double>(least) : 1;
  }

  std::uint32_t acquire(const Surface& s) {
    if (last_ < list_.size() && list_[last_].users != 0 && list_[last_].surface == s) {
      ++list_[last_].users;
      return last_;
    }
    if (free_.empty()) {
      last_ = static_cast<std::uint32_t>(list_.size());
      list_.push_back({s, 1});
    } else {
      last_ = free_.back();
      free_.pop_back();
      list_[last_] = {s, 1};
    }
    return last_;
  }
  void release(std::uint32_t i) {
    if (--list_[i].users == 0) free_.push_back(i);
  }

 private:
  struct Entry {
    Surface surface;
    std::uint32_t users = 0;
  };
  std::vector<Entry> list_;
  std::vector<Entry> before_;  // a state is restored: those until then
  std::vector<std::uint32_t> free_;
  std::uint32_t last_ = 0;
};

class BodyStore {
 public:
  explicit BodyStore(MemoryMeter& meter)
      : pos(meter), vel(meter), disp(meter), id(meter), radius(meter), spin(meter), angle(meter),
        vel0(meter), spin0(meter), acc(meter), bend(meter), pull(meter), vel_rest(meter),
        disp_rest(meter), spare(meter), turn(meter), swing(meter), event_time(meter), linked(meter), built(meter),
        reach(meter), info(meter) {}

  // By slot.
  Column<std::int32_t> pos;
  Column<float> vel, disp;
  Column<std::uint32_t> id;
  Column<float> radius;
  Column<float> spin;    ///< only if the plan has rotation
  Column<double> angle;  ///< only if the plan has rotation
  Column<float> vel0, spin0, acc;
  Column<float> bend;       ///< m records: see BodyView (only if the plan has an integrator)
  Column<float> pull;       ///< gravity scale, 0: kinematic (only if the plan has scales)
  Column<float> vel_rest;   ///< m/s records: what velocities lost to rounding (fields only)
  Column<float> disp_rest;  ///< m records: what offsets lost (only if the plan has an integrator)
  Column<float> spare;      ///< scratch of move_rests
  Column<float> turn, swing;  ///< since the frame's start: see BodyView (shapes, joints only)
  Column<float> event_time;
  Column<std::uint8_t> linked;
  Column<std::int32_t> built;     ///< position when the lists were made
  Column<float> reach;           ///< radius + margin of the lists, m

  // By id.
  mutable Column<BodyInfo> info;
  SurfaceTable surfaces;
  ShapeTable hulls;
  MakeTable makes;
  const Make& make(std::uint32_t body_id) const { return makes[surface(body_id).make]; }
  const Surface& surface(std::uint32_t body_id) const { return surfaces[info[body_id].surface]; }
  std::uint32_t id_count = 0;
  std::vector<std::uint32_t> free_ids;
  std::vector<AlikeBodies> roster;  ///< as of the last saved state
  bool roster_changed = true;       ///< since then: a body's place, generation or surface
  std::optional<std::uint64_t> roster_sum;  ///< of the ids that it has moving (image_check_bodies.cpp)
  bool alike = false;               ///< a state is restored: bodies' places and surfaces are as they were

  std::uint32_t count = 0;  ///< slots in use, dead ones (id == kNoSlot) included until a rebuild
  std::uint32_t dead = 0;
  std::size_t living = 0, moving = 0, fixed = 0, kinematic = 0;
  std::size_t asleep = 0;  ///< of the moving ones: not in the columns

  /// Sorting moves slots without telling the ids: whoever asks for info[id].slot of moving bodies
  /// calls this first. O(bodies) after a sort, else nothing. Several threads may ask at once.
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

  /// A fresh id, recycled if one is free.
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

  /// Room for n more slots.
  void reserve_slots(std::size_t n) {
    const std::size_t total = kernels::round_up_block(count + n);
    pos.reserve(2 * total);
    vel.reserve(2 * total);
    disp.reserve(2 * total);
    id.reserve(total);
    radius.reserve(total);
    linked.reserve(total);
    if (!spin.empty()) add_rotation();
    if (!vel_rest.empty()) add_rests(!disp_rest.empty());
  }

  /// Makes the rotation columns (zero) if they are not there.
  void add_rotation() {
    const std::size_t total = kernels::round_up_block(id.capacity());
    spin.reserve(total);
    angle.reserve(total);
    spin0.reserve(total);
  }

  /// Makes the columns of what rounding took (zero) if they are not there.
  void add_rests(bool of_offsets) {
    const std::size_t total = kernels::round_up_block(id.capacity());
    vel_rest.reserve(2 * total);
    if (of_offsets) disp_rest.reserve(2 * total);
  }

  /// Forgets what velocity and offset of a slot lost: they are new.
  void clear_rests(std::size_t slot) {
    for (Column<float>* rest : {&vel_rest, &disp_rest}) {
      if (!rest->empty()) (*rest)[2 * slot] = (*rest)[2 * slot + 1] = 0;
    }
  }

  /// Puts a velocity in, m/s, and keeps what does not fit into a float where remainders are kept.
  void put_velocity(std::size_t slot, Vec2 v) {
    vel[2 * slot] = static_cast<float>(v.x);
    vel[2 * slot + 1] = static_cast<float>(v.y);
    if (vel_rest.empty()) return;
    vel_rest[2 * slot] = static_cast<float>(v.x - static_cast<double>(vel[2 * slot]));
    vel_rest[2 * slot + 1] = static_cast<float>(v.y - static_cast<double>(vel[2 * slot + 1]));
  }

  /// Radii by slot, of bodies' surfaces; all alike unless `mixed`.
  void fill_radii(float alike, bool mixed) {
    radius.reserve(kernels::round_up_block(count));
    std::fill_n(radius.data(), count, alike);
    if (!mixed) return;
    for (std::uint32_t i = 0; i < count; ++i) {
      if (id[i] != kNoSlot) radius[i] = surface(id[i]).radius;
    }
  }
  /// Radii of dead slots, in order: until the next sort they count for the width of cells.
  std::vector<float> dead_radii() const {
    std::vector<float> out;
    for (std::uint32_t i = 0; i < count && out.size() < dead; ++i) {
      if (id[i] == kNoSlot) out.push_back(radius[i]);
    }
    return out;
  }
  void put_dead_radii(const std::vector<float>& radii) {
    std::size_t next = 0;
    for (std::uint32_t i = 0; i < count && next < radii.size(); ++i) {
      if (id[i] == kNoSlot) radius[i] = radii[next++];
    }
  }

  /// Neutral padding up to a whole block: at the last body's place, at rest, unlinked.
  void pad_tail() {
    const std::uint32_t end = static_cast<std::uint32_t>(kernels::round_up_block(count));
    for (std::uint32_t i = count; i < end; ++i) {
      pos[2 * i] = pos[2 * (count - 1)];
      pos[2 * i + 1] = pos[2 * (count - 1) + 1];
      vel[2 * i] = vel[2 * i + 1] = disp[2 * i] = disp[2 * i + 1] = 0;
      radius[i] = 0;
      linked[i] = 0;
      id[i] = kNoSlot;
      if (!spin.empty()) spin[i] = 0;
    }
  }

  /// Gives them back; nobody turns or stands turned.
  void drop_rotation() {
    spin.release();
    angle.release();
    spin0.release();
  }
  std::size_t rotation_bytes() const { return spin.bytes() + angle.bytes() + spin0.bytes(); }

  /// Makes the columns of turning within a frame (zero), or gives them back.
  void keep_turns(bool wanted) {
    if (!wanted) {
      turn.release();
      swing.release();
      return;
    }
    const std::size_t total = kernels::round_up_block(id.capacity());
    turn.reserve(2 * total);
    swing.reserve(total);
  }

  kernels::BodyView view() {
    kernels::BodyView v;
    v.pos = pos.data();
    v.vel = vel.data();
    v.vel0 = vel0.data();
    v.disp = disp.data();
    v.acc = acc.empty() ? nullptr : acc.data();
    v.vel_rest = vel_rest.empty() ? nullptr : vel_rest.data();
    v.disp_rest = disp_rest.empty() ? nullptr : disp_rest.data();
    v.bend = bend.empty() ? nullptr : bend.data();
    v.pull = pull.empty() ? nullptr : pull.data();
    v.spin = spin.empty() ? nullptr : spin.data();
    v.spin0 = spin0.empty() ? nullptr : spin0.data();
    v.turn = turn.empty() ? nullptr : turn.data();
    v.swing = swing.empty() ? nullptr : swing.data();
    v.event_time = event_time.empty() ? nullptr : event_time.data();
    v.linked = linked.data();
    return v;
  }

 private:
  mutable std::mutex finding_;
};

}  // namespace psim
