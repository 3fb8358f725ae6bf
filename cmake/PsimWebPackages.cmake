# What WebAssembly builds need: header-only libraries as Debian installs them, and zlib from its source.
option(PSIM_WEB_THREADS "Threads in shared memory: the page needs COOP and COEP headers" OFF)
set(PSIM_ZLIB_SOURCE "${PROJECT_SOURCE_DIR}/build/packages/zlib" CACHE PATH
    "zlib's source, for pictures; tools/cross web fetches it")

# A page loads all of it: small code, but for the kernels (CMakeLists.txt); see PsimWeb.cmake, too. -Os and -Oz of clang
# 14 inline so little that templates become larger by them.
set(CMAKE_CXX_FLAGS_RELEASE "-O2 -fno-unroll-loops -DNDEBUG")
set(CMAKE_C_FLAGS_RELEASE "-O2 -DNDEBUG")

# libc++ lacks what the sources take for granted; see the file.
add_compile_options($<$<COMPILE_LANGUAGE:CXX>:-include> $<$<COMPILE_LANGUAGE:CXX>:${PROJECT_SOURCE_DIR}/cmake/standard_gaps.h>)
# WebAssembly's own exceptions: without a cost where nothing is thrown, and smaller than emulated ones.
add_compile_options(-fwasm-exceptions)
add_link_options(-fwasm-exceptions)
set(PSIM_CPU_FEATURES "")
add_library(Threads::Threads INTERFACE IMPORTED)
if(PSIM_WEB_THREADS)
  add_compile_options(-pthread)
  add_link_options(-pthread)
  # clang 14 looks for the place where a handler is chosen among globals, emscripten's library puts it into thread-local
  # memory: no `catch` of a type would catch anything. The library's file is compiled once more with a global one. Two
  # threads must not catch by type at the same moment, then; jobs of workers catch all there is.
  set(_unwind "${PSIM_EMSCRIPTEN_ROOT}/system/lib/libunwind")
  if(CMAKE_CXX_COMPILER_VERSION VERSION_LESS 15 AND EXISTS "${_unwind}/src/Unwind-wasm.c")
    set(_object "${PROJECT_BINARY_DIR}/unwind.o")
    execute_process(
      COMMAND "${CMAKE_C_COMPILER}" -O2 -pthread -fwasm-exceptions -D__USING_WASM_EXCEPTIONS__ -DNDEBUG -D_Thread_local=
              -D_LIBUNWIND_DISABLE_VISIBILITY_ANNOTATIONS "-I${_unwind}/include" -c "${_unwind}/src/Unwind-wasm.c" -o
              "${_object}" COMMAND_ERROR_IS_FATAL ANY)
    add_link_options("${_object}")
  endif()
endif()

# /usr/include itself would bring the headers of another C library.
set(_headers "${PROJECT_BINARY_DIR}/headers")
file(MAKE_DIRECTORY "${_headers}")
function(psim_web_headers target folder package)
  if(NOT EXISTS "/usr/include/${folder}")
    message(FATAL_ERROR "psim: ${package} is missing: apt install ${package}")
  endif()
  file(CREATE_LINK "/usr/include/${folder}" "${_headers}/${folder}" SYMBOLIC)
  add_library(${target} INTERFACE IMPORTED)
  target_include_directories(${target} SYSTEM INTERFACE "${_headers}")
endfunction()
psim_web_headers(CLI11::CLI11 CLI libcli11-dev)
psim_web_headers(nlohmann_json::nlohmann_json nlohmann nlohmann-json3-dev)
psim_web_headers(fmt::fmt fmt libfmt-dev)
target_compile_definitions(fmt::fmt INTERFACE FMT_HEADER_ONLY)
set(PSIM_FMT fmt::fmt)

if(NOT EXISTS "${PSIM_ZLIB_SOURCE}/deflate.c")
  message(FATAL_ERROR "psim: no zlib source in PSIM_ZLIB_SOURCE=${PSIM_ZLIB_SOURCE}; tools/cross web fetches it")
endif()
file(GLOB _zlib "${PSIM_ZLIB_SOURCE}/*.c")
list(FILTER _zlib EXCLUDE REGEX "/gz[a-z]*\\.c$")
add_library(psim_zlib STATIC EXCLUDE_FROM_ALL ${_zlib})
target_include_directories(psim_zlib SYSTEM PUBLIC "${PSIM_ZLIB_SOURCE}")
target_compile_options(psim_zlib PRIVATE -w)
add_library(ZLIB::ZLIB ALIAS psim_zlib)
