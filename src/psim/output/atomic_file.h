// An output file that is either complete or not there at all (src/core/output_file.h), for options: what is wrong with
// it is the user's to put right.
#pragma once

#include <charconv>
#include <concepts>
#include <memory>
#include <string>
#include <string_view>

namespace psim {
class OutputFile;
}

namespace psim::cli {

/// Whether a file outlasts a power cut as soon as it has its name.
enum class Durable : bool { no, yes };

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
  void commit(Durable durable = Durable::yes);

  /// For another program that writes the file in our place: the open file, and a path that means it where that
  /// descriptor has the number `there`.
  int descriptor() const;
  std::string path_for_program(int there);

  /// Option and path as the user wrote them.
  const std::string& label() const { return label_; }

 private:
  void flush();
  [[noreturn]] void refuse() const;

  static constexpr std::size_t kFlushBytes = 1 << 18;

  std::string label_;
  std::string buffer_;
  std::unique_ptr<OutputFile> file_;
};

}  // namespace psim::cli
