# 64-bit ARM Linux from Debian's cross compiler; libraries are Debian's own for arm64 (multiarch). Programs run here
# under qemu. tools/cross arm64 installs all of these.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)

# Static programs: the emulator's folder and Debian's packages for arm64 may hold different versions of the C library.
set(CMAKE_EXE_LINKER_FLAGS_INIT -static)
set(ZLIB_LIBRARY /usr/lib/aarch64-linux-gnu/libz.a)
set(PNG_LIBRARY /usr/lib/aarch64-linux-gnu/libpng.a)
find_program(PSIM_QEMU qemu-aarch64-static)  # by its path: tests start programs with a PATH of their own
set(CMAKE_CROSSCOMPILING_EMULATOR "${PSIM_QEMU}" -L /usr/aarch64-linux-gnu)
