# The test program and the checks that are not GoogleTest: installation and generated code.
# Labels: `slow` (suites whose name begins with Slow), `stress` (those that begin with Stress or
# SlowStress), `install`, `docs`, `rooms`, `asm`, `accuracy`, `fluids`, `peers`, `view`.
include(GoogleTest)

# psim_program(NAME OUT [SCRIPT]): where tests find a program of this build. Where an emulator runs it, that is a script;
# Wine itself starts programs of Windows.
function(psim_program name out)
  set(_path "${PROJECT_BINARY_DIR}/${name}${CMAKE_EXECUTABLE_SUFFIX}")
  if(CMAKE_CROSSCOMPILING_EMULATOR AND NOT WIN32)
    set(_script emulated/${name})
    if(ARGN)
      set(_script ${ARGN})
    endif()
    list(JOIN CMAKE_CROSSCOMPILING_EMULATOR " " _emulator)
    file(CONFIGURE OUTPUT ${_script} CONTENT "#!/bin/sh\nexec ${_emulator} '${_path}' \"$@\"\n" @ONLY)
    set(_path "${PROJECT_BINARY_DIR}/${_script}")
    file(CHMOD "${_path}" FILE_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
  endif()
  set(${out} "${_path}" PARENT_SCOPE)
endfunction()

file(GLOB _test_sources CONFIGURE_DEPENDS tests/*/*_test.cpp tests/support/*.cpp)
list(FILTER _test_sources EXCLUDE REGEX "/tests/(peers|pool|profile|sph|view)/")
psim_for_this_system(_test_sources)
if(WIN32)  # what needs fork, signals, shell scripts as programs, libpng
  list(FILTER _test_sources EXCLUDE REGEX
    "/(output_file|cli_pictures|png_write|accuracy_cli|malformed_scene|fuzz)_test\\.cpp$")
endif()
if(_test_sources AND TARGET psim_scene)
  if(NOT TARGET accuracy)
    list(FILTER _test_sources EXCLUDE REGEX "/accuracy_cli_test\\.cpp$")
  endif()
  add_executable(psim_tests ${_test_sources})
  psim_target_defaults(psim_tests)
  target_include_directories(psim_tests PRIVATE tests tests/support src/kernels src/core src/scene)
  target_link_libraries(psim_tests PRIVATE psim_parts psim_reference psim_fuzz_inputs ZLIB::ZLIB
                                           GTest::gtest GTest::gtest_main)
  if(NOT WIN32)
    target_link_libraries(psim_tests PRIVATE PNG::PNG)
  endif()
  psim_compile_quickly(psim_tests)
  if(NOT PSIM_SANITIZE)
    psim_precompile(psim_tests <gtest/gtest.h>)
    if(PSIM_PRECOMPILE AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")  # false alarms in + of strings, only with these
      target_compile_options(psim_tests PRIVATE -Wno-array-bounds -Wno-stringop-overflow)
    endif()
  endif()
  psim_rooms(psim_tests)
  # In the place of ffmpeg, with a folder of its own for PATH.
  add_executable(stand_in_ffmpeg tests/program/stand_in/ffmpeg.cpp)
  psim_target_defaults(stand_in_ffmpeg)
  if(CMAKE_CROSSCOMPILING_EMULATOR AND NOT WIN32)
    psim_program(stand_in_ffmpeg _ffmpeg stand-in/ffmpeg)
  else()
    set_target_properties(stand_in_ffmpeg PROPERTIES OUTPUT_NAME ffmpeg
      RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/stand-in")
  endif()
  add_dependencies(psim_tests stand_in_ffmpeg)
  # Tests read scenes/ and docs/ from the source tree and start the program beside them.
  psim_program(psim _psim)
  target_compile_definitions(psim_tests PRIVATE
    "PSIM_STAND_IN_FOLDER=\"${PROJECT_BINARY_DIR}/stand-in\""
    "PSIM_SOURCE_DIR=\"${PROJECT_SOURCE_DIR}\""
    "PSIM_PROGRAM=\"${_psim}\"")
  if(TARGET psim)
    add_dependencies(psim_tests psim)
  endif()
  if(TARGET accuracy)
    add_dependencies(psim_tests accuracy)
    target_compile_definitions(psim_tests PRIVATE "PSIM_ACCURACY=\"${PROJECT_BINARY_DIR}/accuracy\"")
  endif()

  # The measuring functions of `accuracy --stress`, which the Stress suites hold to their figures,
  # with psim as the only engine.
  file(GLOB _stress_sources CONFIGURE_DEPENDS bench/accuracy/stress*.cpp)
  foreach(_part engines/engines engines/engine_psim engines/model run)
    list(APPEND _stress_sources bench/accuracy/${_part}.cpp)
  endforeach()
  target_sources(psim_tests PRIVATE ${_stress_sources} tests/soak/soak_world.cpp tests/soak/soak_calls.cpp)
  target_include_directories(psim_tests PRIVATE bench/accuracy)

  # `ctest -L` and `-LE` take regular expressions: `slow-stress` is found by `slow` and by `stress`.
  # PRE_TEST: a test program that does not start is a failed test, not a failed build.
  function(psim_suites list filter timeout label)
    set(_properties TIMEOUT ${timeout})
    if(label)
      list(APPEND _properties LABELS ${label})
    endif()
    gtest_discover_tests(psim_tests TEST_LIST ${list} TEST_FILTER "${filter}"
      DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60 PROPERTIES ${_properties})
  endfunction()
  psim_suites(psim_quick_tests "-Slow*:*/Slow*:Stress*" 600 "")
  psim_suites(psim_slow_tests "Slow*:*/Slow*-SlowStress*" 1800 slow)
  psim_suites(psim_stress_tests "Stress*" 600 stress)
  psim_suites(psim_slow_stress_tests "SlowStress*" 1800 slow-stress)
endif()

# The worker pool alone: small, so that the thread sanitizer's build of it takes seconds.
file(GLOB _pool_tests CONFIGURE_DEPENDS tests/pool/*_test.cpp)
if(WIN32)
  list(FILTER _pool_tests EXCLUDE REGEX "/(stopped_workers|few_threads)_test\\.cpp$")
endif()
add_executable(psim_pool_tests ${_pool_tests} src/core/base/worker_pool.cpp src/core/base/machine.cpp)
psim_target_defaults(psim_pool_tests)
target_include_directories(psim_pool_tests PRIVATE include src/core src/kernels)
target_link_libraries(psim_pool_tests PRIVATE GTest::gtest GTest::gtest_main Threads::Threads
                      ${PSIM_CPU_FEATURES})
if(PSIM_PORTABLE)
  target_compile_definitions(psim_pool_tests PRIVATE PSIM_PORTABLE)
endif()
gtest_discover_tests(psim_pool_tests DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 300)

# The zones of a host's profiler, on the pool alone: the rest of psim is built without them.
add_executable(psim_profile_tests tests/profile/zones_test.cpp src/core/base/worker_pool.cpp src/core/base/machine.cpp)
psim_target_defaults(psim_profile_tests)
target_include_directories(psim_profile_tests PRIVATE include src/core src/kernels)
target_link_libraries(psim_profile_tests PRIVATE GTest::gtest GTest::gtest_main Threads::Threads ${PSIM_CPU_FEATURES})
target_compile_definitions(psim_profile_tests PRIVATE
  "PSIM_PROFILE_HEADER=\"${PROJECT_SOURCE_DIR}/tests/profile/counting_zone.h\"")
if(PSIM_PORTABLE)
  target_compile_definitions(psim_profile_tests PRIVATE PSIM_PORTABLE)
endif()
gtest_discover_tests(psim_profile_tests DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 300)

# The table of a step's parts in docs/step.md is the one that the step runs by.
add_executable(step-table tests/step_table/main.cpp)
psim_target_defaults(step-table)
target_include_directories(step-table PRIVATE src/kernels src/core)
target_link_libraries(step-table PRIVATE psim_core)
add_test(NAME StepTableIsCurrent COMMAND step-table check "${PROJECT_SOURCE_DIR}/docs/step.md")
set_tests_properties(StepTableIsCurrent PROPERTIES LABELS docs TIMEOUT 60)

# State hashes of the built-in scenes, frame by frame, on every ISA and thread count.
if(TARGET psim_scene)
  add_executable(golden tests/golden/main.cpp)
  psim_target_defaults(golden)
  target_link_libraries(golden PRIVATE psim_scene)
  foreach(_isa IN LISTS _isa_names)
    foreach(_threads 1 2 3)
      add_test(NAME Golden.${_isa}.${_threads}
        COMMAND golden check "${PROJECT_SOURCE_DIR}/tests/golden/small.csv" --isa ${_isa} --threads ${_threads})
      set_tests_properties(Golden.${_isa}.${_threads} PROPERTIES LABELS golden TIMEOUT 600)
    endforeach()
  endforeach()
endif()

# Random scenes against the laws that hold in every scene (docs/laws.md): from a known seed and from a new one.
if(TARGET laws)
  set(_laws laws --known "${PROJECT_SOURCE_DIR}/tests/laws/known.txt" --out "${CMAKE_BINARY_DIR}/laws-broken" --most 1)
  add_test(NAME Laws.KnownSeed COMMAND ${_laws} --seed 1 --scenes 100 --seconds 300)
  add_test(NAME Laws.NewSeed COMMAND ${_laws} --seconds 30)
  set(_fluid_laws laws --fluids --known "${PROJECT_SOURCE_DIR}/tests/laws/known_fluids.txt"
                  --out "${CMAKE_BINARY_DIR}/laws-broken" --most 1)
  add_test(NAME Laws.FluidsKnownSeed COMMAND ${_fluid_laws} --seed 1 --scenes 10 --seconds 300)
  add_test(NAME Laws.FluidsNewSeed COMMAND ${_fluid_laws} --seconds 8)
  set_tests_properties(Laws.KnownSeed Laws.NewSeed Laws.FluidsKnownSeed Laws.FluidsNewSeed
                       PROPERTIES LABELS laws TIMEOUT 900)
endif()

# An hour of game time in a world that changes; by hand, no test of ctest (docs/hardening.md).
if(TARGET psim_core)
  add_executable(soak EXCLUDE_FROM_ALL tests/soak/main.cpp tests/soak/soak_world.cpp tests/soak/soak_calls.cpp)
  psim_target_defaults(soak)
  target_link_libraries(soak PRIVATE psim_scene)
endif()

# Functions of features that a scene does not have take no instructions. Label `slow`.
find_package(Python3 COMPONENTS Interpreter REQUIRED)
if(TARGET psim_scene)
  add_executable(psim_absent_steps tests/absent/steps.cpp)
  psim_target_defaults(psim_absent_steps)
  target_link_libraries(psim_absent_steps PRIVATE psim_scene)
endif()
if(TARGET psim_scene AND CMAKE_BUILD_TYPE STREQUAL "Release" AND NOT PSIM_SANITIZE)
  add_test(NAME AbsentFeaturesTakeNoInstructions
    COMMAND Python3::Interpreter "${PROJECT_SOURCE_DIR}/tests/absent/count"
            "$<TARGET_FILE:psim_absent_steps>")
  set_tests_properties(AbsentFeaturesTakeNoInstructions PROPERTIES
    LABELS slow TIMEOUT 600 SKIP_RETURN_CODE 77)
endif()

# A call that changes one body costs the same however many there are. Label `slow`.
if(TARGET psim_scene)
  add_executable(psim_calls tests/calls/calls.cpp)
  psim_target_defaults(psim_calls)
  target_link_libraries(psim_calls PRIVATE psim_scene)
endif()
if(TARGET psim_scene AND CMAKE_BUILD_TYPE STREQUAL "Release" AND NOT PSIM_SANITIZE)
  add_test(NAME CallsCostTheSameHoweverManyBodies
    COMMAND Python3::Interpreter "${PROJECT_SOURCE_DIR}/tests/calls/count" "$<TARGET_FILE:psim_calls>")
  set_tests_properties(CallsCostTheSameHoweverManyBodies PROPERTIES
    LABELS slow TIMEOUT 600 SKIP_RETURN_CODE 77)
endif()

# The comparison with other engines, as far as they are built in. Label `peers`.
if(TARGET peers)
  file(GLOB _peers_tests CONFIGURE_DEPENDS tests/peers/*_test.cpp)
  add_executable(psim_peers_tests ${_peers_tests})
  psim_target_defaults(psim_peers_tests)
  target_include_directories(psim_peers_tests PRIVATE tests/support)
  target_link_libraries(psim_peers_tests PRIVATE psim_peers GTest::gtest GTest::gtest_main)
  target_compile_definitions(psim_peers_tests PRIVATE
    "PSIM_SOURCE_DIR=\"${PROJECT_SOURCE_DIR}\""
    "PSIM_PROGRAM=\"$<TARGET_FILE:psim>\""
    "PSIM_PEERS=\"$<TARGET_FILE:peers>\"")
  add_dependencies(psim_peers_tests peers)
  gtest_discover_tests(psim_peers_tests DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60
    PROPERTIES LABELS peers TIMEOUT 300)
endif()

# The reference solver of smoothed particles, and psim's fluids beside it at speed. Label `fluids`.
if(TARGET fluids)
  add_executable(psim_sph_tests tests/sph/sph_test.cpp)
  psim_target_defaults(psim_sph_tests)
  target_link_libraries(psim_sph_tests PRIVATE psim_sph GTest::gtest GTest::gtest_main)
  gtest_discover_tests(psim_sph_tests DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60
    PROPERTIES LABELS fluids TIMEOUT 120)
endif()
if(TARGET fluids AND CMAKE_BUILD_TYPE STREQUAL "Release" AND NOT PSIM_SANITIZE)
  add_test(NAME FluidsQuick COMMAND fluids --quick --output "${PROJECT_BINARY_DIR}/fluids-quick.csv")
  set_tests_properties(FluidsQuick PROPERTIES LABELS fluids TIMEOUT 300)
endif()

# Errors against the limits of the accuracy laboratory, at speed.
if(TARGET accuracy AND CMAKE_BUILD_TYPE STREQUAL "Release" AND NOT PSIM_SANITIZE)
  add_test(NAME AccuracyQuick
    COMMAND accuracy --quick --output "${PROJECT_BINARY_DIR}/accuracy-quick.csv")
  set_tests_properties(AccuracyQuick PROPERTIES LABELS accuracy TIMEOUT 600)
endif()

# The C API, from strict C99, and its layout.
add_executable(psim_c99 tests/capi/c99.c tests/capi/abi_v1.c tests/capi/abi_v1_names.c
               tests/capi/abi_v1_queries.c)
set_target_properties(psim_c99 PROPERTIES C_STANDARD 99 C_EXTENSIONS OFF LINKER_LANGUAGE CXX)
target_link_libraries(psim_c99 PRIVATE psim::psim)
if(NOT MSVC)
  target_compile_options(psim_c99 PRIVATE -pedantic -Wall -Wextra -Wpadded -Werror)
  target_link_libraries(psim_c99 PRIVATE m)
endif()
if(PSIM_SANITIZE)
  target_link_options(psim_c99 PRIVATE -fsanitize=${PSIM_SANITIZE})
endif()
add_test(NAME CApiInC99 COMMAND psim_c99)
set_tests_properties(CApiInC99 PROPERTIES TIMEOUT 60)

# The public headers, as a host with many warnings compiles them: each alone, by every compiler at hand.
add_test(NAME PublicHeadersAreSilent
  COMMAND Python3::Interpreter "${PROJECT_SOURCE_DIR}/tests/install/check_headers.py" "${PROJECT_SOURCE_DIR}/include"
          "${CMAKE_C_COMPILER}" "${CMAKE_CXX_COMPILER}" gcc g++ clang clang++)
set_tests_properties(PublicHeadersAreSilent PROPERTIES LABELS install TIMEOUT 300)

# What the compiler made of the kernels, and what an installation is good for. Neither means
# anything in a sanitizer build.
find_package(Python3 COMPONENTS Interpreter REQUIRED)
if(TARGET psim_shared AND NOT CMAKE_CROSSCOMPILING)
  set(_install_arguments
    -D "BUILD_DIR=${PROJECT_BINARY_DIR}" -D "CXX=${CMAKE_CXX_COMPILER}" -D "CC=${CMAKE_C_COMPILER}"
    -D "GENERATOR=${CMAKE_GENERATOR}" -D "PYTHON=${Python3_EXECUTABLE}")
  if(TARGET psim)
    list(APPEND _install_arguments -D "PSIM=$<TARGET_FILE:psim>")
  endif()
  add_test(NAME InstalledLibraryServesAConsumer
    COMMAND ${CMAKE_COMMAND} ${_install_arguments} -D "NM=${CMAKE_NM}"
      -D "CONSUMER_DIR=${PROJECT_SOURCE_DIR}/tests/install"
      -D "C_SOURCE=${PROJECT_SOURCE_DIR}/tests/capi/c99.c"
      -P "${PROJECT_SOURCE_DIR}/tests/install/check_install.cmake")
  add_test(NAME ExamplesRunOnAnInstalledLibrary
    COMMAND ${CMAKE_COMMAND} ${_install_arguments}
      -D "EXAMPLES_DIR=${PROJECT_SOURCE_DIR}/examples"
      -P "${PROJECT_SOURCE_DIR}/tests/install/check_examples.cmake")
  add_test(NAME SourcesServeAProjectAroundThem
    COMMAND ${CMAKE_COMMAND} ${_install_arguments} -D "SOURCE_DIR=${PROJECT_SOURCE_DIR}"
      -D "CONSUMER_DIR=${PROJECT_SOURCE_DIR}/tests/install"
      -P "${PROJECT_SOURCE_DIR}/tests/install/check_subproject.cmake")
  set_tests_properties(InstalledLibraryServesAConsumer ExamplesRunOnAnInstalledLibrary PROPERTIES
    LABELS install TIMEOUT 300)
  set_tests_properties(SourcesServeAProjectAroundThem PROPERTIES LABELS install TIMEOUT 900)
  if(TARGET psim AND CMAKE_BUILD_TYPE STREQUAL "Release")
    add_test(NAME DebianPackageServesAConsumer
      COMMAND ${CMAKE_COMMAND} ${_install_arguments} -D "WITH_VIEW=$<TARGET_EXISTS:psim-view>"
        -D "CONSUMER_DIR=${PROJECT_SOURCE_DIR}/tests/install"
        -P "${PROJECT_SOURCE_DIR}/tests/install/check_deb.cmake")
    set_tests_properties(DebianPackageServesAConsumer PROPERTIES
      LABELS install TIMEOUT 300 SKIP_REGULAR_EXPRESSION "packages are not tested")
  endif()
endif()

# Every public name has its words.
find_program(PSIM_DOXYGEN doxygen)
if(PSIM_DOXYGEN)
  add_test(NAME PublicApiIsDocumented
    COMMAND ${CMAKE_COMMAND} -E env "PSIM_DOCS_DIR=${PROJECT_BINARY_DIR}/docs"
            "${PROJECT_SOURCE_DIR}/tools/docs" --no-install)
else()
  add_test(NAME PublicApiIsDocumented
    COMMAND ${CMAKE_COMMAND} -E echo "doxygen is not installed: the API docs are not tested")
endif()
set_tests_properties(PublicApiIsDocumented PROPERTIES
  LABELS docs TIMEOUT 120 SKIP_REGULAR_EXPRESSION "docs are not tested")

# The key-by-key page of scene files is the schema's. What the lists of other engines' functions name is in the headers.
find_package(Python3 COMPONENTS Interpreter)
if(Python3_FOUND)
  add_test(NAME SceneReferenceIsCurrent
    COMMAND Python3::Interpreter "${PROJECT_SOURCE_DIR}/tools/scene-reference" --check)
  add_test(NAME FunctionsOfOtherEnginesAreFound
    COMMAND Python3::Interpreter "${PROJECT_SOURCE_DIR}/tests/docs/check_functions.py" "${PROJECT_SOURCE_DIR}")
  add_test(NAME CodeOfThePagesCompiles
    COMMAND Python3::Interpreter "${PROJECT_SOURCE_DIR}/tests/docs/check_snippets.py" "${PROJECT_SOURCE_DIR}"
            "${CMAKE_C_COMPILER}" "${CMAKE_CXX_COMPILER}" gcc g++ clang clang++)
  add_test(NAME PicturesAreShownAndDiagramsCurrent
    COMMAND Python3::Interpreter "${PROJECT_SOURCE_DIR}/tools/pictures" --check)
  set_tests_properties(SceneReferenceIsCurrent FunctionsOfOtherEnginesAreFound CodeOfThePagesCompiles
    PicturesAreShownAndDiagramsCurrent PROPERTIES LABELS docs TIMEOUT 300)
endif()

# Who includes whom, sizes of files and folders, and the layout of the code. Label `rooms`.
if(Python3_FOUND)
  add_test(NAME Rooms COMMAND Python3::Interpreter "${PROJECT_SOURCE_DIR}/tools/rooms" --quiet)
  set_tests_properties(Rooms PROPERTIES LABELS rooms TIMEOUT 60)
endif()
find_program(PSIM_CLANG_FORMAT clang-format)
set(_clang_format "none")
if(PSIM_CLANG_FORMAT)
  execute_process(COMMAND "${PSIM_CLANG_FORMAT}" --version OUTPUT_VARIABLE _clang_format)
endif()
if(_clang_format MATCHES "version 14\\.")
  add_test(NAME Layout COMMAND "${PROJECT_SOURCE_DIR}/tools/format" --check)
else()
  add_test(NAME Layout COMMAND ${CMAKE_COMMAND} -E echo "clang-format 14 is not installed: the layout is not tested")
endif()
set_tests_properties(Layout PROPERTIES LABELS rooms TIMEOUT 120 SKIP_REGULAR_EXPRESSION "layout is not tested")

if(TARGET psim_kernels AND CMAKE_BUILD_TYPE STREQUAL "Release" AND NOT PSIM_SANITIZE)
  add_test(NAME AsmInspect
    COMMAND Python3::Interpreter "${PROJECT_SOURCE_DIR}/tools/asm-inspect"
            --build "${PROJECT_BINARY_DIR}" --check)
  add_test(NAME AsmInspectFindsFaults
    COMMAND Python3::Interpreter "${PROJECT_SOURCE_DIR}/tests/asm/check_faults.py"
            "${CMAKE_CXX_COMPILER}")
  set_tests_properties(AsmInspect AsmInspectFindsFaults PROPERTIES LABELS asm TIMEOUT 300)
endif()

# The viewer, on a screen of its own. Label `view`.
if(TARGET psim-view)
  file(GLOB _view_tests CONFIGURE_DEPENDS tests/view/*_test.cpp)
  add_executable(psim_view_tests ${_view_tests})
  psim_target_defaults(psim_view_tests)
  target_include_directories(psim_view_tests PRIVATE tests tests/support)
  target_link_libraries(psim_view_tests PRIVATE psim_view_model PNG::PNG GTest::gtest GTest::gtest_main)
  target_compile_definitions(psim_view_tests PRIVATE
    "PSIM_PROGRAM=\"$<TARGET_FILE:psim-view>\"")
  add_dependencies(psim_view_tests psim-view)
  gtest_discover_tests(psim_view_tests DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60
    PROPERTIES LABELS view TIMEOUT 300)
elseif(NOT PSIM_SANITIZE)
  set(_message "psim-view is not built (PSIM_VIEW), so it is not tested")
  add_test(NAME View COMMAND ${CMAKE_COMMAND} -E echo "${_message}")
  set_tests_properties(View PROPERTIES LABELS view SKIP_REGULAR_EXPRESSION "is not tested")
endif()
