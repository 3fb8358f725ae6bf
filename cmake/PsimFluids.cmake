# Error against run time of fluids: psim, and a reference solver by smoothed particles (bench/fluids).

file(GLOB _sph_sources CONFIGURE_DEPENDS bench/fluids/sph*.cpp)
add_library(psim_sph STATIC ${_sph_sources})
psim_target_defaults(psim_sph)
target_include_directories(psim_sph PUBLIC bench/fluids include)
# The sums get all that a compiler can do for them: lanes as wide as psim's own AVX2 kernels, and sums in any order.
if(NOT MSVC)
  set(_sph_flags -O3 -ffast-math -ffp-contract=fast -fopenmp-simd)
  if(PSIM_PROCESSOR STREQUAL "x86-64")
    list(APPEND _sph_flags -mavx2 -mfma)
  endif()
  set_source_files_properties(bench/fluids/sph_sums.cpp PROPERTIES COMPILE_OPTIONS "${_sph_flags}")
endif()

file(GLOB _fluids_sources CONFIGURE_DEPENDS bench/fluids/*.cpp)
list(FILTER _fluids_sources EXCLUDE REGEX "/sph[^/]*\\.cpp$")
add_executable(fluids ${_fluids_sources})
psim_target_defaults(fluids)
target_link_libraries(fluids PRIVATE psim_sph psim_core CLI11::CLI11)
