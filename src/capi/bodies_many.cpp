// Many bodies in one call.
#include <span>
#include <type_traits>
#include <utility>

#include "convert.h"
#include "structs.h"

using namespace psim::capi;

namespace {

psim_result missing(const Call& call, const char* what) {
  return call.fail(PSIM_ERROR_ARGUMENT, std::string(what) + " must not be NULL");
}

// Copies an array of C into a vector of the types of C++.
template <class C>
auto copies(const C* from, std::size_t count) {
  using Of = std::conditional_t<std::is_same_v<C, double>, double, decltype(to_cpp(std::declval<C>()))>;
  std::vector<Of> all;
  all.reserve(count);
  for (std::size_t k = 0; k < count; ++k) {
    if constexpr (std::is_same_v<C, double>) {
      all.push_back(from[k]);
    } else {
      all.push_back(to_cpp(from[k]));
    }
  }
  return all;
}

// Lets apply(world, ids) change bodies, and tells how many it changed.
template <class Apply>
psim_result change_all(const Call& call, const psim_body_id* ids, std::size_t count, std::size_t* changed,
                       const Apply& apply) {
  const auto given = copies(ids, count);
  const std::size_t done = call.world->changed([&](auto& w) { return apply(w, std::span(given)); });
  if (changed != nullptr) *changed = done;
  if (!psim::out_of_memory()) return PSIM_OK;
  return call.fail(PSIM_ERROR_OUT_OF_MEMORY,
                   "out of memory; " + std::to_string(done) + " of " + std::to_string(count) + " bodies were changed");
}

// The same for a call of C. `values`: whether what is given beside the ids is there.
template <class Apply>
psim_result change(psim_world* world, const char* name, const psim_body_id* ids, std::size_t count, bool values,
                   std::size_t* changed, const Apply& apply) {
  if (changed != nullptr) *changed = 0;
  return guarded(world, name, [&](psim::World&, const Call& call) -> psim_result {
    if (count != 0 && ids == nullptr) return missing(call, "ids");
    if (count != 0 && !values) return missing(call, "an array of values");
    return change_all(call, ids, count, changed, apply);
  });
}

}  // namespace

psim_result psim_world_remove_bodies(psim_world* world, const psim_body_id* ids, size_t count, size_t* removed) {
  return change(world, __func__, ids, count, true, removed, [](auto& w, auto given) { return w.remove_bodies(given); });
}

psim_result psim_world_states_of(const psim_world* world, const psim_body_id* ids, size_t count,
                                 psim_body_state* states, size_t* known) {
  if (known != nullptr) *known = 0;
  return guarded(world, __func__, [&](const psim::World& w, const Call& call) -> psim_result {
    if (count != 0 && ids == nullptr) return missing(call, "ids");
    if (count != 0 && states == nullptr) return missing(call, "states");
    const auto given = copies(ids, count);
    std::vector<psim::BodyState> found(count);
    const std::size_t there = w.states_of(given, found);
    for (std::size_t k = 0; k < count; ++k) states[k] = to_c(found[k]);
    if (known != nullptr) *known = there;
    return PSIM_OK;
  });
}

psim_result psim_world_set_transforms(psim_world* world, const psim_body_id* ids, size_t count,
                                      const psim_vec2* positions, const double* angles, size_t* changed) {
  const bool values = positions != nullptr && angles != nullptr;
  return change(world, __func__, ids, count, values, changed, [&](auto& w, auto given) {
    return w.set_transforms(given, copies(positions, count), std::span(angles, count));
  });
}

psim_result psim_world_set_velocities(psim_world* world, const psim_body_id* ids, size_t count,
                                      const psim_vec2* velocities, const double* angular_velocities, size_t* changed) {
  const bool values = velocities != nullptr && angular_velocities != nullptr;
  return change(world, __func__, ids, count, values, changed, [&](auto& w, auto given) {
    return w.set_velocities(given, copies(velocities, count), std::span(angular_velocities, count));
  });
}

psim_result psim_world_apply_impulses(psim_world* world, const psim_body_id* ids, size_t count,
                                      const psim_vec2* impulses, size_t* changed) {
  return change(world, __func__, ids, count, impulses != nullptr, changed,
                [&](auto& w, auto given) { return w.apply_impulses(given, copies(impulses, count)); });
}

psim_result psim_world_apply_forces(psim_world* world, const psim_body_id* ids, size_t count, const psim_vec2* forces,
                                    size_t* changed) {
  return change(world, __func__, ids, count, forces != nullptr, changed,
                [&](auto& w, auto given) { return w.apply_forces(given, copies(forces, count)); });
}

psim_result psim_world_set_enabled_of(psim_world* world, const psim_body_id* ids, size_t count, int32_t on,
                                      size_t* changed) {
  return change(world, __func__, ids, count, true, changed,
                [&](auto& w, auto given) { return w.set_enabled_of(given, on != 0); });
}

psim_result psim_world_set_traits_of(psim_world* world, const psim_body_id* ids, size_t count,
                                     const psim_body_traits* traits, size_t stride, size_t* changed) {
  if (changed != nullptr) *changed = 0;
  return guarded(world, __func__, [&](psim::World&, const Call& call) -> psim_result {
    if (count != 0 && ids == nullptr) return missing(call, "ids");
    if (count != 0 && traits == nullptr) return missing(call, "traits");
    if (const psim_result r = check_stride(call, count, stride); r != PSIM_OK) return r;
    std::vector<psim::BodyTraits> all(count);
    const auto* at = reinterpret_cast<const unsigned char*>(traits);
    for (std::size_t k = 0; k < count; ++k) {
      const std::string which = "traits[" + std::to_string(k) + "]";
      psim_body_traits one;
      const auto* here = reinterpret_cast<const psim_body_traits*>(at + k * stride);
      if (const psim_result r = read(call, which.c_str(), here, one); r != PSIM_OK) return r;
      const std::string wrong = convert(one, all[k]);
      if (!wrong.empty()) return call.fail(PSIM_ERROR_ARGUMENT, which + ": " + wrong);
    }
    return change_all(call, ids, count, changed, [&](auto& w, auto given) { return w.set_traits_of(given, all); });
  });
}
