// Structs that begin with struct_size: defaults, reading those of other versions, writing into them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>

#include "handle.h"

namespace psim::capi {

/// The defaults of each, from those of the C++ descriptions. struct_size is set.
void set_defaults(psim_world_desc& d);
void set_defaults(psim_run_options& d);
void set_defaults(psim_body_desc& d);
void set_defaults(psim_body_traits& d);
void set_defaults(psim_part_traits& d);
void set_defaults(psim_disc_batch& d);
void set_defaults(psim_joint_desc& d);
void set_defaults(psim_query_filter& d);
void set_defaults(psim_mover_desc& d);
void set_defaults(psim_debug_draw& d);
void set_defaults(psim_fluid_desc& d);
void set_defaults(psim_emitter_desc& d);
void set_defaults(psim_event_options& d);
void set_defaults(psim_cost_model& d);
void set_defaults(psim_governor_desc& d);
void set_defaults(psim_job_system& d);

/// What is wrong with a struct_size, or empty: whole pairs of words, so that no field is cut.
std::string wrong_size(const char* what, std::uint32_t size, std::size_t known);

/// Reads the caller's struct into one of our size; the fields that it lacks keep their defaults.
template <class T>
psim_result read(const Call& call, const char* what, const T* in, T& out) {
  static_assert(std::is_trivially_copyable_v<T> && sizeof(T) % 8 == 0);
  if (in == nullptr) return call.fail(PSIM_ERROR_ARGUMENT, std::string(what) + " must not be NULL");
  const std::string wrong = wrong_size(what, in->struct_size, sizeof(T));
  if (!wrong.empty()) return call.fail(PSIM_ERROR_STRUCT_SIZE, wrong);
  set_defaults(out);
  std::memcpy(&out, in, in->struct_size);
  return PSIM_OK;
}

/// Whether structs that lie `stride` bytes apart can be read.
inline psim_result check_stride(const Call& call, std::size_t count, std::size_t stride) {
  if (count <= 1 || (stride >= 8 && stride % 8 == 0)) return PSIM_OK;
  return call.fail(PSIM_ERROR_ARGUMENT, "stride must be the size of a description, a multiple of 8");
}

/// The caller's run options, or the defaults for NULL; PSIM_ERROR_UNSUPPORTED where the CPU lacks the
/// instruction set.
psim_result read_options(const Call& call, const psim_run_options* options, RunOptions& out);

/// The caller's filter, or the defaults for NULL.
psim_result read_filter(const Call& call, const psim_query_filter* filter, QueryFilter& out);

/// Keeps the world's fields as C sees them.
void keep_fields(psim_world& handle);

/// Whether a struct to be filled has a size that we know.
template <class T>
psim_result check_output(const Call& call, const char* what, const T* out) {
  if (out == nullptr) return call.fail(PSIM_ERROR_ARGUMENT, std::string(what) + " must not be NULL");
  const std::string wrong = wrong_size(what, out->struct_size, sizeof(T));
  return wrong.empty() ? PSIM_OK : call.fail(PSIM_ERROR_STRUCT_SIZE, wrong);
}

/// Fills the caller's struct, as much as it has room for.
template <class T>
void write(const T& value, T* out) {
  static_assert(std::is_trivially_copyable_v<T> && sizeof(T) % 8 == 0);
  const std::uint32_t size = out->struct_size;
  std::memcpy(out, &value, size);
  out->struct_size = size;
}

}  // namespace psim::capi
