# Finds what the build needs and, where something is missing, says which Debian package brings it.
# All missing ones are named at once.

set(_psim_missing "")

macro(psim_need package debian)
  find_package(${package} ${ARGN} QUIET)
  if(NOT ${package}_FOUND)
    list(APPEND _psim_missing ${debian})
  endif()
endmacro()

set(PSIM_CPU_FEATURES "")
if(PSIM_PROCESSOR STREQUAL "x86-64" AND NOT PSIM_PORTABLE)  # every aarch64 CPU has NEON: nothing is asked there
  if(CMAKE_SYSTEM_NAME STREQUAL "Linux")
    psim_need(CpuFeatures libcpu-features-dev CONFIG)
  else()  # machine.cpp then asks the processor itself
    find_package(CpuFeatures CONFIG QUIET)
  endif()
  if(CpuFeatures_FOUND)
    set(PSIM_CPU_FEATURES CpuFeatures::cpu_features)
  endif()
endif()
psim_need(Threads libc6-dev)
if(PSIM_BUILD_PROGRAMS OR PSIM_BUILD_TESTS OR PSIM_BUILD_BENCH)
  psim_need(nlohmann_json nlohmann-json3-dev CONFIG)
  psim_need(ZLIB zlib1g-dev)  # packs the pictures
endif()
if(PSIM_BUILD_PROGRAMS OR PSIM_BUILD_TESTS OR PSIM_BUILD_BENCH OR PSIM_FUZZ)
  psim_need(CLI11 libcli11-dev CONFIG)
endif()
if(PSIM_BUILD_PROGRAMS OR PSIM_BUILD_TESTS OR PSIM_BUILD_BENCH OR PSIM_FUZZ)
  psim_need(fmt libfmt-dev CONFIG)
  set(PSIM_FMT fmt::fmt)
  if(CMAKE_EXE_LINKER_FLAGS MATCHES "-static" AND TARGET fmt::fmt-header-only)  # Debian has no static libfmt
    set(PSIM_FMT fmt::fmt-header-only)
  endif()
endif()
if(PSIM_BUILD_BENCH)
  psim_need(benchmark libbenchmark-dev CONFIG)
endif()
if(PSIM_BUILD_TESTS)
  psim_need(GTest libgtest-dev)
  if(NOT WIN32)
    psim_need(PNG libpng-dev)  # reads the pictures
  endif()
endif()

if(_psim_missing)
  set(_message "")
  foreach(_package IN LISTS _psim_missing)
    string(APPEND _message "psim: ${_package} is missing: apt install ${_package}\n")
  endforeach()
  message(FATAL_ERROR "${_message}")
endif()
