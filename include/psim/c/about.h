/// @file
/// C API: the library itself. All of it may be called from any thread at any time.
#pragma once

#include "psim/c/desc.h"

#ifdef __cplusplus
extern "C" {
#endif

/// "0.1.0": of the library that runs. PSIM_VERSION_STRING is that of the headers.
PSIM_API const char* psim_version(void);

/// major * 10000 + minor * 100 + patch.
PSIM_API uint32_t psim_version_number(void);

/// A result in words, such as "out of memory"; "unknown result" for any other number. Never NULL.
PSIM_API const char* psim_result_string(psim_result result);

/// "scalar", "sse", "avx2", "neon" or "simd128"; NULL for any other number.
PSIM_API const char* psim_isa_name(int32_t isa);

/// The reverse of psim_isa_name. PSIM_ERROR_ARGUMENT for any other text.
PSIM_API psim_result psim_parse_isa(const char* name, int32_t* isa);

/// Lanes of 32-bit floats: 1, 4 or 8; 0 for a number that is no psim_isa or a variant that this build does not hold.
PSIM_API int32_t psim_isa_lanes(int32_t isa);

/// 1 if this CPU has the instruction set, else 0.
PSIM_API int32_t psim_isa_available(int32_t isa);

/// The best psim_isa that this CPU has.
PSIM_API int32_t psim_best_isa(void);

/// "verlet", "euler", "rk4" or "symplectic4"; NULL for any other number.
PSIM_API const char* psim_integrator_name(int32_t integrator);

/// The reverse of psim_integrator_name. PSIM_ERROR_ARGUMENT for any other text.
PSIM_API psim_result psim_parse_integrator(const char* name, int32_t* integrator);

/// The name of a stage of a step, by its place in psim_step_report::stage_ms; NULL beyond the last.
PSIM_API const char* psim_stage_name(int32_t stage);

/// The name of what a step can leave out, by its bit in psim_step_report::skipped; NULL beyond the last.
PSIM_API const char* psim_skip_name(int32_t bit);

/// Bytes that `discs` dynamic discs need before the first step, an upper estimate.
PSIM_API size_t psim_estimate_memory_bytes(size_t discs);

/// Measures what work costs with these options (NULL: the defaults) for worlds of about so many
/// bodies, `shapes` of them not discs; about a tenth of a second for 10,000. `costs` must have been through
/// psim_cost_model_init.
PSIM_API psim_result psim_measure_costs(const psim_run_options* options, size_t bodies, size_t shapes,
                                        psim_cost_model* costs);

#ifdef __cplusplus
}
#endif
