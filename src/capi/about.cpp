// The library itself: versions, words for numbers, instruction sets. Nothing here has a world.
#include "convert.h"
#include "psim/integrator.h"
#include "psim/isa.h"
#include "structs.h"

using namespace psim::capi;

const char* psim_version(void) { return PSIM_VERSION_STRING; }

uint32_t psim_version_number(void) {
  return PSIM_VERSION_MAJOR * 10000 + PSIM_VERSION_MINOR * 100 + PSIM_VERSION_PATCH;
}

const char* psim_result_string(psim_result result) {
  switch (result) {
    case PSIM_NOTHING:
      return "nothing found";
    case PSIM_OK:
      return "done";
    case PSIM_ERROR_ARGUMENT:
      return "NULL, or a value out of its range";
    case PSIM_ERROR_STRUCT_SIZE:
      return "struct_size is not set, or of a newer version";
    case PSIM_ERROR_STALE_ID:
      return "no such body or joint";
    case PSIM_ERROR_NOT_MOVABLE:
      return "the body is static or frozen";
    case PSIM_ERROR_UNSUPPORTED:
      return "this CPU lacks the instruction set";
    case PSIM_ERROR_OUT_OF_MEMORY:
      return "out of memory";
    case PSIM_ERROR_INTERNAL:
      return "internal error";
    case PSIM_ERROR_BROKEN_WORLD:
      return "the world broke before";
    default:
      return "unknown result";
  }
}

// The names are string literals in the engine: their data ends with a zero.
const char* psim_isa_name(int32_t isa) {
  const auto which = to_enum(isa, kLastIsa);
  return which ? psim::isa_name(*which).data() : nullptr;
}

psim_result psim_parse_isa(const char* name, int32_t* isa) {
  if (name == nullptr || isa == nullptr) return PSIM_ERROR_ARGUMENT;
  const auto which = psim::parse_isa(name);
  if (!which) return PSIM_ERROR_ARGUMENT;
  *isa = static_cast<int32_t>(*which);
  return PSIM_OK;
}

int32_t psim_isa_lanes(int32_t isa) {
  const auto which = to_enum(isa, kLastIsa);
  return which ? psim::isa_lanes(*which) : 0;
}

int32_t psim_isa_available(int32_t isa) {
  const auto which = to_enum(isa, kLastIsa);
  return which && psim::isa_available(*which);
}

int32_t psim_best_isa(void) { return static_cast<int32_t>(psim::best_isa()); }

const char* psim_integrator_name(int32_t integrator) {
  const auto which = to_enum(integrator, psim::Integrator::symplectic4);
  return which ? psim::integrator_name(*which).data() : nullptr;
}

psim_result psim_parse_integrator(const char* name, int32_t* integrator) {
  if (name == nullptr || integrator == nullptr) return PSIM_ERROR_ARGUMENT;
  const auto which = psim::parse_integrator(name);
  if (!which) return PSIM_ERROR_ARGUMENT;
  *integrator = static_cast<int32_t>(*which);
  return PSIM_OK;
}

const char* psim_stage_name(int32_t stage) {
  if (stage < 0 || static_cast<std::size_t>(stage) >= psim::kStageCount) return nullptr;
  return psim::kStageNames[static_cast<std::size_t>(stage)].data();
}

const char* psim_skip_name(int32_t bit) {
  if (bit < 0 || static_cast<std::size_t>(bit) >= psim::kSkipNames.size()) return nullptr;
  return psim::kSkipNames[static_cast<std::size_t>(bit)].data();
}

size_t psim_estimate_memory_bytes(size_t discs) { return psim::estimate_memory_bytes(discs); }

psim_result psim_measure_costs(const psim_run_options* options, size_t bodies, size_t shapes, psim_cost_model* costs) {
  psim_world scratch;  // for the guard: there is no world yet
  const Call call{&scratch, __func__};
  return caught(call, [&]() -> psim_result {
    psim::RunOptions run;
    if (const psim_result r = read_options(call, options, run); r != PSIM_OK) return r;
    if (run.threads < 1 || run.threads > 256) return PSIM_ERROR_ARGUMENT;
    if (const psim_result r = check_output(call, "costs", costs); r != PSIM_OK) return r;
    write(to_c(psim::World::measure_costs(run, bodies, shapes)), costs);
    return PSIM_OK;
  });
}
