// An output file that is either complete or not there at all.
//
// The constructor proves that the file can be written, before a long run begins. The data goes to a
// nameless file in the same directory (O_TMPFILE; on file systems without it, to a temporary name)
// and takes its name by rename in commit(). A process that is killed in between leaves the old file
// as it was. Devices, pipes and psim's own stdout cannot be replaced and are written straight.
#pragma once

#include <charconv>
#include <concepts>
#include <string>
#include <string_view>

namespace psim::cli {

class AtomicFile {
 public:
  /// Throws UserError, with `option` in front, if `path` cannot be written.
  AtomicFile(std::string_view option, const std::string& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(std::string_view text) {
    buffer_ += text;
    if (buffer_.size() >= kFlushBytes) flush();
  }
  /// Shortest text that reads back to the same bits.
  template <class Number>
  requires std::floating_point<Number> || std::integral<Number>
  void write_number(Number value) {
    char digits[40];
    const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
    buffer_.append(digits, end);
  }

  /// Gives the file its name. Throws UserError if anything could not be written; then the old file,
  /// if there was one, is untouched.
  void commit();

  /// For another program that writes the file in our place: the open file, and a path that means it where that
  /// descriptor has the number `there`.
  int descriptor() const { return fd_; }
  std::string path_for_program(int there) const;

  /// Option and path as the user wrote them.
  const std::string& label() const { return label_; }

  /// Where the data goes in the end, links resolved.
  const std::string& target() const { return target_; }

 private:
  void open();
  void flush();
  void name_the_file();
  [[noreturn]] void refuse(int error) const;

  static constexpr std::size_t kFlushBytes = 1 << 18;

  std::string label_;
  std::string target_;     // path with links resolved
  std::string temporary_;  // name to unlink; empty while the file is nameless or written straight
  std::string buffer_;
  int fd_ = -1;
  bool straight_ = false;
  int write_error_ = 0;  // errno of the first write that failed
};

}  // namespace psim::cli
