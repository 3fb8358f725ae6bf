# Cross-compilation to WebAssembly with emscripten, Debian's package or another one whose em++ is in PATH.
find_program(PSIM_EMCC em++ REQUIRED)
file(REAL_PATH "${PSIM_EMCC}" _emcc)
cmake_path(GET _emcc PARENT_PATH _root)
set(PSIM_EMSCRIPTEN_ROOT "${_root}")
set(EMSCRIPTEN_SYSTEM_PROCESSOR wasm)
include("${_root}/cmake/Modules/Platform/Emscripten.cmake")
