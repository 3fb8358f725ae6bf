// Worlds for JavaScript: functions of the C API whose structs are passed by value or filled in, with plain numbers
// instead. All others JavaScript calls as they are.
#include <cstdint>
#include <optional>

#include "flat.h"

namespace {

void run_jobs(void*, std::size_t count, psim_job_function function, void* job) {
  psim::web::workers->run(count, [&](std::size_t k) { function(job, k); });
}

psim_body_id body_of(std::uint32_t index, std::uint32_t generation) { return {index, generation}; }

}  // namespace

void psim::web::share_workers(psim_world* world) {
  if (workers == nullptr || world == nullptr) return;
  psim_job_system jobs;
  psim_job_system_init(&jobs);
  jobs.workers = workers->threads();
  jobs.parallel_for = run_jobs;
  psim_world_set_job_system(world, &jobs);
}

/// Once, before the first world.
PSIM_FLAT void psim_flat_start_workers(int threads) {
  if (psim::web::workers == nullptr && threads > 1) psim::web::workers = new psim::WorkerPool(threads);
}

// ---- steps -----------------------------------------------------------------------------------------------------
/// out: milliseconds, contacts, awake, asleep, pairs, escaped, quarantined.
PSIM_FLAT int psim_flat_step(psim_world* world, double dt, double* out) {
  std::optional<psim::WorkerPool::Awake> awake;
  if (psim::web::workers != nullptr) awake.emplace(*psim::web::workers, psim::WorkerPool::Work::step);
  psim_step_report report;
  psim_step_report_init(&report);
  const psim_result result = dt > 0 ? psim_world_step_by(world, dt, &report) : psim_world_step(world, &report);
  out[0] = report.total_ms, out[1] = static_cast<double>(report.contacts);
  out[2] = static_cast<double>(report.awake), out[3] = static_cast<double>(report.asleep);
  out[4] = static_cast<double>(report.pairs), out[5] = report.escaped, out[6] = report.quarantined;
  return result;
}
/// out: bounds (4), boundary, gravity (2), dt, substeps.
PSIM_FLAT int psim_flat_desc(const psim_world* world, double* out) {
  psim_world_desc d;
  psim_world_desc_init(&d);
  const psim_result result = psim_world_get_desc(world, &d);
  const double all[] = {d.bounds.xmin,
                        d.bounds.ymin,
                        d.bounds.xmax,
                        d.bounds.ymax,
                        static_cast<double>(d.boundary),
                        d.gravity.x,
                        d.gravity.y,
                        d.dt,
                        static_cast<double>(d.substeps)};
  for (int k = 0; k < 9; ++k) out[k] = all[k];
  return result;
}
PSIM_FLAT int psim_flat_set_gravity(psim_world* world, double x, double y) {
  return psim_world_set_gravity(world, {x, y});
}
/// out: kinetic and potential energy, momentum x and y, angular momentum, deepest overlap.
PSIM_FLAT int psim_flat_diagnostics(psim_world* world, double* out) {
  psim_diagnostics d;
  psim_diagnostics_init(&d);
  const psim_result result = psim_world_diagnostics(world, &d);
  out[0] = d.kinetic, out[1] = d.potential, out[2] = d.momentum_x, out[3] = d.momentum_y;
  out[4] = d.angular_momentum, out[5] = d.max_penetration;
  return result;
}
/// Low and high half.
PSIM_FLAT void psim_flat_hash(const psim_world* world, std::uint32_t* out) {
  const std::uint64_t hash = psim_world_state_hash(world);
  out[0] = static_cast<std::uint32_t>(hash), out[1] = static_cast<std::uint32_t>(hash >> 32);
}
PSIM_FLAT double psim_flat_frame(const psim_world* world) { return static_cast<double>(psim_world_frame(world)); }

// ---- columns: 32-bit words, so that JavaScript makes typed arrays on them ------------------------------------------
static_assert(sizeof(void*) == 4, "JavaScript reads pointers as 32-bit words");
/// out: count, then the addresses of id, x, y, angle, vx, vy, omega, radius, type.
PSIM_FLAT int psim_flat_state(psim_world* world, std::uintptr_t* out) {
  psim_state s;
  psim_state_init(&s);
  const psim_result result = psim_world_state(world, &s);
  const void* const columns[] = {s.id, s.x, s.y, s.angle, s.vx, s.vy, s.omega, s.radius, s.type};
  *out++ = s.count;
  for (const void* const column : columns) *out++ = reinterpret_cast<std::uintptr_t>(column);
  return result;
}
/// out: count, then the addresses of id, x, y, x_prev, y_prev, angle, angle_prev, radius, speed, asleep. origin: x, y.
PSIM_FLAT int psim_flat_snapshot(psim_world* world, std::uintptr_t* out, double* origin) {
  psim_snapshot s;
  psim_snapshot_init(&s);
  const psim_result result = psim_world_latest_snapshot(world, &s);
  const void* const columns[] = {s.id,    s.x,          s.y,      s.x_prev, s.y_prev,
                                 s.angle, s.angle_prev, s.radius, s.speed,  s.asleep};
  *out++ = s.count;
  for (const void* const column : columns) *out++ = reinterpret_cast<std::uintptr_t>(column);
  origin[0] = s.origin.x, origin[1] = s.origin.y;
  return result;
}

// ---- bodies ----------------------------------------------------------------------------------------------------
/// out: x, y, angle, vx, vy, omega, radius, type.
PSIM_FLAT int psim_flat_body(const psim_world* world, std::uint32_t index, std::uint32_t generation, double* out) {
  psim_body_state s{};
  const psim_result result = psim_world_body(world, body_of(index, generation), &s);
  const double all[] = {s.x, s.y, s.angle, s.vx, s.vy, s.omega, s.radius, static_cast<double>(s.type)};
  for (int k = 0; k < 8; ++k) out[k] = all[k];
  return result;
}
PSIM_FLAT int psim_flat_id_of(const psim_world* world, std::uint32_t index, psim_body_id* id) {
  return psim_world_id_of(world, index, id);
}
PSIM_FLAT int psim_flat_remove(psim_world* world, std::uint32_t index, std::uint32_t generation) {
  return psim_world_remove_body(world, body_of(index, generation));
}
PSIM_FLAT int psim_flat_set_transform(psim_world* world, std::uint32_t index, std::uint32_t generation, double x,
                                      double y, double angle) {
  return psim_world_set_transform(world, body_of(index, generation), {x, y}, angle);
}
PSIM_FLAT int psim_flat_set_velocity(psim_world* world, std::uint32_t index, std::uint32_t generation, double vx,
                                     double vy, double omega) {
  return psim_world_set_velocity(world, body_of(index, generation), {vx, vy}, omega);
}
PSIM_FLAT int psim_flat_impulse(psim_world* world, std::uint32_t index, std::uint32_t generation, double px, double py,
                                double x, double y) {
  return psim_world_apply_impulse_at(world, body_of(index, generation), {px, py}, {x, y});
}
PSIM_FLAT int psim_flat_wake(psim_world* world, std::uint32_t index, std::uint32_t generation) {
  return psim_world_wake(world, body_of(index, generation));
}

// ---- joints ----------------------------------------------------------------------------------------------------
/// v: anchors a and b (4), length, stiffness, damping, axis (2), reference, lower, upper, motor speed and limit, then
/// flags: has length, reference, lower, upper; collide; then target (2), rest, linear velocity (2), angular velocity, force
/// and torque limit, grounds a and b (4), ratio, frequency, damping ratio, break force and torque. ids: index and
/// generation of a, of b, and of the joints a and b of a gear.
PSIM_FLAT int psim_flat_add_joint(psim_world* world, int type, const std::uint32_t* ids, const double* v,
                                  psim_joint_id* id) {
  psim_joint_desc d;
  psim_joint_desc_init(&d);
  d.type = type;
  d.a = body_of(ids[0], ids[1]), d.b = body_of(ids[2], ids[3]);
  d.anchor_a = {v[0], v[1]}, d.anchor_b = {v[2], v[3]};
  d.length = v[4], d.stiffness = v[5], d.damping = v[6];
  d.axis = {v[7], v[8]}, d.reference = v[9], d.lower = v[10], d.upper = v[11];
  d.motor_speed = v[12], d.motor_limit = v[13];
  d.has_length = v[14] != 0, d.has_reference = v[15] != 0, d.has_lower = v[16] != 0, d.has_upper = v[17] != 0;
  d.collide = v[18] != 0;
  d.target = {v[19], v[20]}, d.rest = v[21];
  d.linear_velocity = {v[22], v[23]}, d.angular_velocity = v[24], d.force_limit = v[25], d.torque_limit = v[26];
  d.ground_a = {v[27], v[28]}, d.ground_b = {v[29], v[30]}, d.ratio = v[31];
  d.frequency = v[32], d.damping_ratio = v[33], d.break_force = v[34], d.break_torque = v[35];
  d.joint_a = {ids[4], ids[5]}, d.joint_b = {ids[6], ids[7]};
  return psim_world_add_joint(world, &d, id);
}
PSIM_FLAT int psim_flat_remove_joint(psim_world* world, std::uint32_t index, std::uint32_t generation) {
  return psim_world_remove_joint(world, {index, generation});
}
PSIM_FLAT int psim_flat_set_target(psim_world* world, std::uint32_t index, std::uint32_t generation, double x,
                                   double y) {
  return psim_world_set_target(world, {index, generation}, {x, y});
}
PSIM_FLAT int psim_flat_set_motor(psim_world* world, std::uint32_t index, std::uint32_t generation, double speed,
                                  double limit) {
  return psim_world_set_motor(world, {index, generation}, speed, limit);
}

// ---- queries ---------------------------------------------------------------------------------------------------
/// out: point (2), normal (2), fraction.
PSIM_FLAT int psim_flat_ray(const psim_world* world, double x0, double y0, double x1, double y1, psim_body_id* id,
                            double* out) {
  psim_ray_hit hit{};
  const psim_result result = psim_world_ray_cast(world, {x0, y0}, {x1, y1}, nullptr, &hit);
  *id = hit.body;
  out[0] = hit.point.x, out[1] = hit.point.y, out[2] = hit.normal.x, out[3] = hit.normal.y, out[4] = hit.fraction;
  return result;
}
/// Only dynamic bodies with `dynamic`. out: point (2), distance.
PSIM_FLAT int psim_flat_closest(const psim_world* world, double x, double y, double reach, int dynamic,
                                psim_body_id* id, double* out) {
  psim_query_filter filter;
  psim_query_filter_init(&filter);
  if (dynamic != 0) filter.kinematic = filter.fixed = 0;
  psim_closest_hit hit{};
  const psim_result result = psim_world_closest(world, {x, y}, reach, &filter, &hit);
  *id = hit.body;
  out[0] = hit.point.x, out[1] = hit.point.y, out[2] = hit.distance;
  return result;
}
/// How many there are; `ids` takes as many as its capacity.
PSIM_FLAT int psim_flat_in_region(const psim_world* world, double xmin, double ymin, double xmax, double ymax,
                                  psim_body_id* ids, std::uint32_t capacity) {
  std::size_t count = 0;
  const psim_result result = psim_world_in_region(world, {xmin, ymin, xmax, ymax}, nullptr, ids, capacity, &count);
  return result == PSIM_OK ? static_cast<int>(count) : result;
}
/// Six numbers a contact: indices of a and b (-1: a wall), point (2), normal impulse, separation.
PSIM_FLAT int psim_flat_contacts(psim_world* world, double* out, std::uint32_t capacity) {
  const psim_contact* contacts = nullptr;
  std::size_t count = 0;
  const psim_result result = psim_world_contacts(world, &contacts, &count);
  if (result != PSIM_OK) return result;
  for (std::size_t k = 0; k < count && k < capacity; ++k, out += 6) {
    const psim_contact& c = contacts[k];
    out[0] = c.a.index, out[1] = c.b.index == 0xFFFFFFFFu ? -1.0 : c.b.index;
    out[2] = c.point.x, out[3] = c.point.y, out[4] = c.impulse, out[5] = c.separation;
  }
  return static_cast<int>(count);
}

// ---- saved states ----------------------------------------------------------------------------------------------
/// The length of a packed state, which goes to `packed` if that is not null.
PSIM_FLAT int psim_flat_save(psim_world* world, void* packed, std::uint32_t capacity) {
  const void* state = nullptr;
  std::size_t size = 0;
  psim_result result = psim_world_save(world, &state, &size);
  if (result == PSIM_OK) result = psim_pack_state(state, size, packed, capacity, &size);
  return result == PSIM_OK ? static_cast<int>(size) : result;
}
/// A world that goes on from a packed state, or null. `state` has room for `size` bytes.
PSIM_FLAT psim_world* psim_flat_restore(const void* packed, std::uint32_t size, void* state, int isa) {
  psim_run_options options;
  psim_run_options_init(&options);
  options.isa = isa;
  std::size_t length = 0;
  psim_world* world = nullptr;
  char* const error = psim::web::error;
  if (psim_unpack_state(packed, size, state, size, &length, error, sizeof psim::web::error) != PSIM_OK) return nullptr;
  psim_world_from_state(state, length, &options, &world, error, sizeof psim::web::error);
  psim::web::share_workers(world);
  return world;
}
