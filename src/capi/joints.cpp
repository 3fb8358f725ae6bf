// Joints.
#include <algorithm>

#include "convert.h"
#include "structs.h"

using namespace psim::capi;

namespace {

psim_result stale_joint(const Call& call, std::uint32_t index) {
  return call.fail(PSIM_ERROR_STALE_ID, "there is no joint " + std::to_string(index) + " of this generation");
}

// Hands the joints that ask() finds to the host, as many as it has room for.
template <class Ask>
psim_result hand_over(const Call& call, const Ask& ask, psim_joint_id* ids, size_t capacity, size_t* count) {
  if (count == nullptr || (ids == nullptr && capacity != 0)) {
    return call.fail(PSIM_ERROR_ARGUMENT, "count, and ids where there is room for some, must not be NULL");
  }
  const std::vector<psim::JointId> found = ask();
  for (std::size_t k = 0; k < std::min(capacity, found.size()); ++k) ids[k] = to_c(found[k]);
  *count = found.size();
  return PSIM_OK;
}

}  // namespace

psim_result psim_world_add_joint(psim_world* world, const psim_joint_desc* desc, psim_joint_id* id) {
  return guarded(world, __func__, [&](psim::World&, const Call& call) -> psim_result {
    psim_joint_desc given;
    if (const psim_result r = read(call, "desc", desc, given); r != PSIM_OK) return r;
    psim::JointDesc joint;
    std::string wrong = convert(given, joint);
    psim::JointId made = psim::kNoJoint;
    if (wrong.empty()) made = world->changed([&](auto& w) { return w.add_joint(joint, wrong); });
    if (made == psim::kNoJoint) return call.fail(PSIM_ERROR_ARGUMENT, wrong);
    if (id != nullptr) *id = to_c(made);
    return PSIM_OK;
  });
}

psim_result psim_world_remove_joint(psim_world* world, psim_joint_id id) {
  return guarded(world, __func__, [&](psim::World&, const Call& call) -> psim_result {
    return world->changed([&](auto& w) { return w.remove_joint(to_cpp(id)); }) ? PSIM_OK : stale_joint(call, id.index);
  });
}

int32_t psim_world_is_valid_joint(const psim_world* world, psim_joint_id id) {
  return asked(world, __func__, int32_t{0},
               [id](const psim::World& w) -> int32_t { return w.is_valid_joint(to_cpp(id)); });
}

psim_result psim_world_joint(const psim_world* world, psim_joint_id id, psim_joint_state* state) {
  return guarded(world, __func__, [&](const psim::World& w, const Call& call) -> psim_result {
    if (state == nullptr) return call.fail(PSIM_ERROR_ARGUMENT, "state must not be NULL");
    const auto s = w.joint(to_cpp(id));
    if (!s) return stale_joint(call, id.index);
    *state = {to_c(s->a), to_c(s->b),        static_cast<int32_t>(s->type),
              0,          to_c(s->anchor_a), to_c(s->anchor_b),
              s->value,   to_c(s->force),    s->torque};
    return PSIM_OK;
  });
}

psim_result psim_world_joint_speed(const psim_world* world, psim_joint_id id, double* speed) {
  return guarded(world, __func__, [&](const psim::World& w, const Call& call) -> psim_result {
    if (speed == nullptr) return call.fail(PSIM_ERROR_ARGUMENT, "speed must not be NULL");
    const auto state = w.joint(to_cpp(id));
    if (!state) return stale_joint(call, id.index);
    *speed = state->speed;
    return PSIM_OK;
  });
}

psim_result psim_world_joint_desc(const psim_world* world, psim_joint_id id, psim_joint_desc* desc) {
  return guarded(world, __func__, [&](const psim::World& w, const Call& call) -> psim_result {
    if (const psim_result r = check_output(call, "desc", desc); r != PSIM_OK) return r;
    const auto known = w.joint_desc(to_cpp(id));
    if (!known) return stale_joint(call, id.index);
    write(to_c(*known), desc);
    return PSIM_OK;
  });
}

psim_result psim_world_set_joint(psim_world* world, psim_joint_id id, const psim_joint_desc* desc) {
  return guarded(world, __func__, [&](psim::World& w, const Call& call) -> psim_result {
    psim_joint_desc given;
    if (const psim_result r = read(call, "desc", desc, given); r != PSIM_OK) return r;
    if (!w.is_valid_joint(to_cpp(id))) return stale_joint(call, id.index);
    psim::JointDesc joint;
    std::string wrong = convert(given, joint);
    if (wrong.empty() && world->changed([&](auto& one) { return one.set_joint(to_cpp(id), joint, wrong); })) {
      return PSIM_OK;
    }
    return call.fail(PSIM_ERROR_ARGUMENT, wrong);
  });
}

psim_result psim_world_set_target(psim_world* world, psim_joint_id id, psim_vec2 point) {
  return guarded(world, __func__, [&](psim::World& w, const Call& call) -> psim_result {
    if (!w.is_valid_joint(to_cpp(id))) return stale_joint(call, id.index);
    if (world->changed([&](auto& one) { return one.set_target(to_cpp(id), to_cpp(point)); })) return PSIM_OK;
    return call.fail(PSIM_ERROR_ARGUMENT, "only target joints have a target, a point from -1e9 to 1e9 m");
  });
}

psim_result psim_world_set_motor(psim_world* world, psim_joint_id id, double speed, double limit) {
  return guarded(world, __func__, [&](psim::World& w, const Call& call) -> psim_result {
    if (!w.is_valid_joint(to_cpp(id))) return stale_joint(call, id.index);
    if (world->changed([&](auto& one) { return one.set_motor(to_cpp(id), speed, limit); })) return PSIM_OK;
    return call.fail(PSIM_ERROR_ARGUMENT,
                     "only distance, revolute, prismatic and wheel joints have a motor; speed must be finite and "
                     "limit 0 or more");
  });
}

psim_result psim_world_joints_of(const psim_world* world, psim_body_id id, psim_joint_id* ids, size_t capacity,
                                 size_t* count) {
  return guarded(world, __func__, [&](const psim::World& w, const Call& call) -> psim_result {
    return hand_over(
        call, [&] { return w.joints_of(to_cpp(id)); }, ids, capacity, count);
  });
}

psim_result psim_world_joints_across(const psim_world* world, psim_vec2 from, psim_vec2 to, psim_joint_id* ids,
                                     size_t capacity, size_t* count) {
  return guarded(world, __func__, [&](const psim::World& w, const Call& call) -> psim_result {
    return hand_over(
        call, [&] { return w.joints_across(to_cpp(from), to_cpp(to)); }, ids, capacity, count);
  });
}

size_t psim_world_joint_count(const psim_world* world) {
  return asked(world, __func__, size_t{0}, [](const psim::World& w) { return w.joint_count(); });
}
