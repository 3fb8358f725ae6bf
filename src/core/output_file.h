// A file that is either complete or not there at all.
//
// The constructor proves that the file can be written, before a long run begins. The data goes to a nameless file in
// the same folder (O_TMPFILE; on file systems without it, to a new file of a name that nobody has) and takes its name
// by rename in commit(). A process that is killed in between leaves the old file as it was. Devices, pipes and the
// process's own stdout and stderr cannot be replaced and are written straight.
#pragma once

#include <sys/stat.h>

#include <cstddef>
#include <string>

namespace psim {

class OutputFile {
 public:
  explicit OutputFile(const std::string& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// errno of the first thing that failed; 0: none.
  int error() const { return error_; }

  /// Does nothing after an error.
  void write(const void* data, std::size_t size);

  /// Brings the data to the disk, if asked, and gives the file its name. False on an error; then the old file, if
  /// there was one, is untouched and nothing else is left.
  bool commit(bool to_disk);

  /// For another program that writes the file in our place: the open file, and a path that means it where that
  /// descriptor has the number `there`.
  int descriptor() const { return fd_; }
  std::string path_for_program(int there) const;

 private:
  void open(const std::string& path);
  bool open_straight(const std::string& path, const struct stat& old);
  bool find_target(std::string path, bool exists);
  void open_beside(bool exists);
  void keep_owner_and_mode(const struct stat& old);
  std::string name_beside() const;
  bool give_name(bool to_disk);
  bool fail(int error);

  std::string folder_, target_;  // links resolved
  std::string temporary_;        // to unlink; empty while the file is nameless or written straight
  int fd_ = -1;
  int error_ = 0;
  bool straight_ = false;
};

}  // namespace psim
