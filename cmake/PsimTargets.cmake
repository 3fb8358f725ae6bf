# What every target of the tree has in common.

include(PsimCompilers)

# Language, warnings and floating point (PsimCompilers.cmake).
function(psim_target_defaults target)
  target_compile_features(${target} PRIVATE cxx_std_20)
  set_target_properties(${target} PROPERTIES
    CXX_EXTENSIONS OFF
    CXX_VISIBILITY_PRESET hidden
    VISIBILITY_INLINES_HIDDEN ON)
  if(NOT EMSCRIPTEN)  # whose modules are linked once, and are slower with it
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  endif()
  target_compile_options(${target} PRIVATE ${PSIM_WARNINGS} ${PSIM_EXACT_FLOATS})
  target_compile_definitions(${target} PRIVATE ${PSIM_SYSTEM_DEFINITIONS})
  if(EMSCRIPTEN)  # std::size_t has 32 bits; what files say is compared as 64 before it becomes one
    target_compile_options(${target} PRIVATE -Wno-sign-conversion -Wno-shorten-64-to-32)
  endif()
  if(PSIM_WERROR)
    target_compile_options(${target} PRIVATE ${PSIM_WARNINGS_ARE_ERRORS})
  endif()
  if(PSIM_ASSERTS)
    target_compile_definitions(${target} PRIVATE PSIM_ENABLE_ASSERTS _GLIBCXX_ASSERTIONS)
  endif()
  if(PSIM_SANITIZE)
    target_compile_options(${target} PRIVATE
      -fsanitize=${PSIM_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
    target_link_options(${target} PRIVATE -fsanitize=${PSIM_SANITIZE})
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")  # false alarms in <regex>, only under sanitizers
      target_compile_options(${target} PRIVATE -Wno-error=maybe-uninitialized)
    endif()
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND PSIM_SANITIZE MATCHES "thread")
      target_compile_options(${target} PRIVATE -Wno-error=tsan)  # says that fences are not seen
    endif()
  endif()
endfunction()

# The fuzzers' libFuzzer is told of every comparison, to learn which numbers an input is compared with. A step compares
# what it computed, so there is nothing to learn, and this takes half of its time. States are read from inputs: the files
# of src/core/state keep it.
function(psim_trace_no_comparisons target)
  if(PSIM_FUZZ)
    target_compile_options(${target} PRIVATE -fno-sanitize-coverage=trace-cmp)
    get_target_property(sources ${target} SOURCES)
    list(FILTER sources INCLUDE REGEX "/core/state/")
    set_source_files_properties(${sources} PROPERTIES COMPILE_OPTIONS -fsanitize-coverage=trace-cmp)
  endif()
endfunction()

# Files whose names end in _posix or _windows are for these systems alone, _absent for those that can do no such thing.
# All that differs between systems is in them.
function(psim_for_this_system list)
  if(WIN32)
    list(FILTER ${list} EXCLUDE REGEX "_posix\\.cpp$")
  else()
    list(FILTER ${list} EXCLUDE REGEX "_windows\\.cpp$")
  endif()
  if(EMSCRIPTEN)  # no other program can be started
    list(FILTER ${list} EXCLUDE REGEX "/program_posix\\.cpp$")
  else()
    list(FILTER ${list} EXCLUDE REGEX "_absent\\.cpp$")
  endif()
  set(${list} "${${list}}" PARENT_SCOPE)
endfunction()

# For code around the engine, whose own speed hardly matters: takes a quarter to a half less time to compile. The engine
# keeps what the preset says.
function(psim_compile_quickly target)
  if(PSIM_SANITIZE)
    target_compile_options(${target} PRIVATE -O0)
  elseif(CMAKE_BUILD_TYPE STREQUAL "Release" AND NOT EMSCRIPTEN)
    target_compile_options(${target} PRIVATE $<IF:$<BOOL:${MSVC}>,/O1,-O1>)
  endif()
endfunction()

# A third of the time of most files is these headers. Off by default, for files that lack an include would go unseen
# (.ci/run builds each target without them in one preset), and with ccache, which does not keep what uses them.
function(psim_precompile target)
  if(PSIM_PRECOMPILE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
    target_precompile_headers(${target} PRIVATE
      <algorithm> <array> <atomic> <cmath> <functional> <limits> <memory> <optional> <string> <vector>
      <psim/psim.h> ${ARGN})
  endif()
endfunction()

# Each room, a folder of sources, becomes one translation unit: half the time of a build from nothing, for the public
# headers are read once a room. In one room no two files may give one name in an anonymous namespace two meanings.
function(psim_rooms target)
  if(NOT PSIM_ROOMS)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  foreach(source IN LISTS sources)
    cmake_path(GET source PARENT_PATH room)
    cmake_path(GET room FILENAME room)
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${room})
    if(source MATCHES "_windows\\.cpp$")  # windows.h makes macros of common words
      set_source_files_properties(${source} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    endif()
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP UNITY_BUILD_UNIQUE_ID "")
endfunction()

# What a user of the library needs: the public headers and the libraries behind them.
function(psim_library_interface target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(${target} PRIVATE ${PSIM_CPU_FEATURES} Threads::Threads ${PSIM_PROFILE_TARGET})
  set_target_properties(${target} PROPERTIES LINKER_LANGUAGE CXX)
  if(PSIM_SANITIZE)
    target_link_options(${target} PRIVATE -fsanitize=${PSIM_SANITIZE})
  endif()
endfunction()

# While the major version is 0 a new minor version may change the ABI.
if(PROJECT_VERSION_MAJOR EQUAL 0)
  set(PSIM_SOVERSION 0.${PROJECT_VERSION_MINOR})
  set(PSIM_COMPATIBILITY SameMinorVersion)
else()
  set(PSIM_SOVERSION ${PROJECT_VERSION_MAJOR})
  set(PSIM_COMPATIBILITY SameMajorVersion)
endif()

function(psim_library_properties target name)
  psim_library_interface(${target})
  set_target_properties(${target} PROPERTIES
    OUTPUT_NAME psim
    EXPORT_NAME ${name}
    VERSION ${PROJECT_VERSION}
    SOVERSION ${PSIM_SOVERSION})
  if(WIN32 AND name STREQUAL "psim_shared")  # psim.lib is the static library, libpsim.dll.a what psim.exe exports
    set_target_properties(${target} PROPERTIES ARCHIVE_OUTPUT_NAME psim_dll)
  endif()
endfunction()

# A shared library exports what the public headers mark with PSIM_API. The version script takes out
# what the compiler marks by itself: the standard library's templates, made for our types.
function(psim_export_public_names target)
  if(WIN32 OR APPLE)  # their linkers have no such script
    return()
  endif()
  target_link_options(${target} PRIVATE
    "LINKER:--version-script=${PROJECT_SOURCE_DIR}/cmake/psim.map" "LINKER:--no-undefined")
  set_property(TARGET ${target} APPEND PROPERTY
    LINK_DEPENDS "${PROJECT_SOURCE_DIR}/cmake/psim.map")
endfunction()
