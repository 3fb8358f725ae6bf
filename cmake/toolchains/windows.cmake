# x86-64 Windows by Debian's mingw-w64: cmake --toolchain cmake/toolchains/windows.cmake (tools/cross windows).
# The posix variant has std::thread. Everything is linked in, so that psim.exe runs alone.
set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
set(CMAKE_C_COMPILER x86_64-w64-mingw32-gcc-posix)
set(CMAKE_CXX_COMPILER x86_64-w64-mingw32-g++-posix)
set(CMAKE_EXE_LINKER_FLAGS_INIT -static)
set(CMAKE_SHARED_LINKER_FLAGS_INIT -static)
set(CMAKE_FIND_ROOT_PATH /usr/x86_64-w64-mingw32)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)

# Wine runs the tests.
find_program(PSIM_WINE NAMES wine64 wine)
if(PSIM_WINE)
  set(CMAKE_CROSSCOMPILING_EMULATOR "${PSIM_WINE}")
endif()

include("${CMAKE_CURRENT_LIST_DIR}/headers/use.cmake")
