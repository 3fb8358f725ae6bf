// Reads the CSV files that psim writes with --state and --trajectory, a frame at a time: memory for
// one frame, whatever the length of the file. About 0.1 us a row.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/os.h"
#include "run/state_comparison.h"

namespace psim::cli {

/// Lines of a file that may be a pipe.
class LineReader {
 public:
  /// Throws UserError if the file cannot be read.
  explicit LineReader(const std::string& path);

  /// The next line without its end, valid until the next call; false after the last one.
  bool next(std::string_view& line);

  /// Throws UserError "FILE:LINE: what", about the line that next() gave.
  [[noreturn]] void refuse(std::string_view what) const;

 private:
  bool refill();

  std::string name_;
  os::FileToRead file_;
  std::uint64_t line_ = 0;
  std::vector<char> buffer_;
  std::size_t begin_ = 0, end_ = 0;  // what of the buffer is still to be read
};

class StateFile {
 public:
  /// Opens the file and reads its first line. Throws UserError, here and in next_frame, with
  /// FILE:LINE if this is neither a state nor a trajectory.
  explicit StateFile(const std::string& path);

  bool is_trajectory() const { return is_trajectory_; }

  /// Reads the next frame; false if there is none. A state file has one, with the number 0.
  bool next_frame();
  std::uint64_t frame() const { return frame_; }
  StateView view() const;

 private:
  struct Row {
    std::uint64_t frame = 0;
    std::uint32_t id = 0;
    std::array<double, kStateFields.size()> values{};
  };
  bool read_row();
  void take_row();

  LineReader lines_;
  bool is_trajectory_ = false;
  bool started_ = false;
  bool has_row_ = false;  // row_ is read, and not yet part of a frame
  Row row_;
  std::uint64_t frame_ = 0;
  std::vector<std::uint32_t> id_;
  std::array<std::vector<double>, kStateFields.size()> fields_;
};

}  // namespace psim::cli
