# What fuzzers and the tests of their corpus share, and with PSIM_FUZZ the fuzzers themselves:
# fuzz_scene, fuzz_rube, fuzz_state, fuzz_details, fuzz_saved, fuzz_recording, fuzz_world.
# docs/hardening.md says how to run them.
file(GLOB _fuzz_sources CONFIGURE_DEPENDS tests/fuzz/*.cpp)
list(FILTER _fuzz_sources EXCLUDE REGEX "/libfuzzer_main\\.cpp$")
psim_for_this_system(_fuzz_sources)
add_library(psim_fuzz_inputs STATIC EXCLUDE_FROM_ALL ${_fuzz_sources})
psim_target_defaults(psim_fuzz_inputs)
target_include_directories(psim_fuzz_inputs PUBLIC tests/fuzz)
target_link_libraries(psim_fuzz_inputs PUBLIC psim_scene PRIVATE psim_parts)

if(PSIM_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang" OR NOT PSIM_SANITIZE MATCHES "fuzzer-no-link")
    message(FATAL_ERROR "psim: PSIM_FUZZ needs clang++ and PSIM_SANITIZE with fuzzer-no-link; "
                        "`cmake --preset fuzz` has both")
  endif()
  add_custom_target(fuzzers)
  foreach(_input scene rube state details saved recording world)
    add_executable(fuzz_${_input} tests/fuzz/libfuzzer_main.cpp)
    psim_target_defaults(fuzz_${_input})
    target_compile_definitions(fuzz_${_input} PRIVATE PSIM_FUZZ_INPUT=${_input}_input)
    target_link_libraries(fuzz_${_input} PRIVATE psim_fuzz_inputs)
    target_link_options(fuzz_${_input} PRIVATE -fsanitize=fuzzer)
    add_dependencies(fuzzers fuzz_${_input})
  endforeach()
endif()
