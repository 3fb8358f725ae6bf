# What psim asks of the compiler at hand, in its own words. These go to psim's own targets alone, never to users.
#
#   PSIM_WARNINGS               as many as the code is free of
#   PSIM_EXACT_FLOATS           no multiply and add becomes one: part of the promise that all builds give the same bits
#   PSIM_NO_AUTO_VECTORIZATION  lanes are written by hand, and "scalar" means one lane
#   PSIM_SYSTEM_DEFINITIONS     what the system's own headers want to know
#   psim_isa_flags(flag out)    a flag of src/kernels/isa_list.h
#
# g++ and clang++ on Linux and g++ on Windows (mingw-w64) are tested. MSVC and clang-cl are not (docs/platforms.md).
set(PSIM_SYSTEM_DEFINITIONS "")
set(PSIM_NO_AUTO_VECTORIZATION "")
if(CMAKE_CXX_COMPILER_FRONTEND_VARIANT STREQUAL "MSVC")  # clang-cl
  set(PSIM_WARNINGS /W4 /utf-8)
  set(PSIM_WARNINGS_ARE_ERRORS /WX)
  set(PSIM_EXACT_FLOATS /fp:precise /clang:-ffp-contract=off)
  set(PSIM_NO_AUTO_VECTORIZATION /clang:-fno-vectorize /clang:-fno-slp-vectorize)
elseif(MSVC)
  # 19.30 is the first whose /fp:precise does not contract. Its vectoriser has no flag; it keeps the order of sums.
  if(CMAKE_CXX_COMPILER_VERSION VERSION_LESS 19.30)
    message(FATAL_ERROR "psim: MSVC ${CMAKE_CXX_COMPILER_VERSION} fuses multiply and add: Visual Studio 2022 does not")
  endif()
  set(PSIM_WARNINGS /W4 /wd4068 /utf-8 /permissive- /Zc:__cplusplus)  # 4068: pragmas of g++
  set(PSIM_WARNINGS_ARE_ERRORS /WX)
  set(PSIM_EXACT_FLOATS /fp:precise)
else()
  set(PSIM_WARNINGS -Wall -Wextra -Wconversion)
  set(PSIM_WARNINGS_ARE_ERRORS -Werror)
  set(PSIM_EXACT_FLOATS -ffp-contract=off -fno-math-errno)
  if(CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    set(PSIM_NO_AUTO_VECTORIZATION -fno-vectorize -fno-slp-vectorize)
  else()
    set(PSIM_NO_AUTO_VECTORIZATION -fno-tree-vectorize -fno-tree-slp-vectorize)
  endif()
endif()
if(WIN32)
  set(PSIM_SYSTEM_DEFINITIONS NOMINMAX WIN32_LEAN_AND_MEAN _WIN32_WINNT=0x0A00 _USE_MATH_DEFINES)
endif()
if(MSVC)
  list(APPEND PSIM_SYSTEM_DEFINITIONS _CRT_SECURE_NO_WARNINGS)
endif()

function(psim_isa_flags flag out)
  set(flags ${flag})
  if(MSVC AND NOT CMAKE_CXX_COMPILER_FRONTEND_VARIANT STREQUAL "MSVC")
    string(REPLACE "-mavx2" "/arch:AVX2" flags "${flags}")
    string(REPLACE "-msse4.1" "" flags "${flags}")  # SSE4.1 needs no flag there
  elseif(MINGW AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND flag MATCHES "avx")
    # g++ keeps 32-byte values on a stack that Windows aligns to 16 (gcc bug 54412): no aligned moves.
    list(APPEND flags -Wa,-muse-unaligned-vector-move)
  endif()
  set(${out} "${flags}" PARENT_SCOPE)
endfunction()
