// Operating systems do some things in different ways. This header has those that the engine needs: paths, files to read,
// memory, the time of a thread. os_posix.cpp and os_windows.cpp hold the two versions, as output_file_posix.cpp and output_file_windows.cpp
// do for files to write. No other file of the engine knows its system.
#pragma once

#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace psim::os {

/// The path of a UTF-8 name. All names in psim are UTF-8, on Windows too, whatever its code page is.
std::filesystem::path path_of(std::string_view utf8);

/// The UTF-8 name of a path.
std::string name_of(const std::filesystem::path& path);

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using FileToRead = std::unique_ptr<std::FILE, CloseFile>;

/// Opens a file for reading, byte for byte. Empty, with errno set, if it cannot be opened. A child process does not
/// inherit the file.
FileToRead open_to_read(const std::string& name);

/// The size of a large page, bytes.
inline constexpr std::size_t kLargePage = std::size_t{1} << 21;
/// Takes memory straight from the system, which sets it to zero and hands out its pages when they are touched. Where the system
/// has large pages, it gives these: there are fewer to hand out and to look up. Throws std::bad_alloc.
void* take_pages(std::size_t bytes);
void give_pages_back(void* begin, std::size_t bytes);

/// The time that the calling thread has worked, in ns: waiting and other programs do not count, except on Windows.
double thread_work_ns();

}  // namespace psim::os
