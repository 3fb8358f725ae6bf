// A file that is either complete or does not exist.
//
// The constructor proves that the file can be written, before a long run begins. The data goes to a nameless file in
// the same folder (O_TMPFILE; on file systems without it, a new file with an unused name). commit() renames that file.
// A process that is killed before leaves the old file as it was. Devices, pipes and the process's own stdout and
// stderr cannot be replaced, so they are written directly. On Windows the new file has an unused name and is marked to
// go with its last handle, until commit() takes the mark off.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

namespace psim {

class OutputFile {
 public:
  explicit OutputFile(const std::string& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// errno of the first call that failed, or 0.
  int error() const { return error_; }

  /// Appends data. Does nothing after an error.
  void write(const void* data, std::size_t size);

  /// Gives the file its name; with `to_disk` the data reaches the disk first. False on an error: then an old file is
  /// untouched and no temporary file is left.
  bool commit(bool to_disk);

  /// For a program that writes the file in our place: the open descriptor, and a path that names the file in a process
  /// where the descriptor has the number `there`.
  int descriptor() const { return fd_; }
  std::string path_for_program(int there);

 private:
  struct Old;  // what the system says of a file that is there
  bool open_straight(const std::string& path, const Old& old);
  bool find_target(const std::string& path, bool exists);
  void open_beside(bool exists);
  int take_name(const std::function<bool(const std::string&)>& take);
  bool give_name(bool to_disk);
  bool fail(int error);

  std::string target_;     // with links resolved; empty if it is written directly
  std::string temporary_;  // to unlink; empty while the file is nameless or written directly
  int fd_ = -1;
  int error_ = 0;
};

}  // namespace psim
