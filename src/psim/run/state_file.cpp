#include "run/state_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>

#include "output/text.h"
#include "output/user_error.h"
#include "report/csv.h"

namespace psim::cli {
namespace {

// Longer than any row can be; what has no line end within it is no CSV of psim's.
constexpr std::size_t kBufferBytes = 1 << 20;

// Takes the text up to the next comma off the line.
std::string_view take_word(std::string_view& line) {
  const std::size_t comma = line.find(',');
  const std::string_view word = line.substr(0, comma);
  line.remove_prefix(comma == std::string_view::npos ? line.size() : comma + 1);
  return word;
}

template <class Number>
Number take_number(std::string_view& line, std::string_view column, const LineReader& lines) {
  const char* const end = line.data() + line.size();
  Number value{};
  const auto [stopped, error] = std::from_chars(line.data(), end, value);
  if (error != std::errc() || (stopped != end && *stopped != ',')) {
    const std::string_view word = take_word(line).substr(0, 40);
    lines.refuse(word.empty() ? fmt::format("{} is missing", column)
                              : fmt::format("{}: '{}' is not a number", column, one_line(word)));
  }
  line.remove_prefix(static_cast<std::size_t>(stopped - line.data()) + (stopped != end ? 1 : 0));
  return value;
}

}  // namespace

LineReader::LineReader(const std::string& path)
    : name_(one_line(path)), file_(os::open_to_read(path)), buffer_(kBufferBytes) {
  if (!file_) throw UserError(fmt::format("{}: {}", name_, std::strerror(errno)));
  std::setvbuf(file_.get(), nullptr, _IONBF, 0);  // buffer_ does it
}

void LineReader::refuse(std::string_view what) const { throw UserError(fmt::format("{}:{}: {}", name_, line_, what)); }

// Moves what is left to the front and reads behind it; false at the end of the file.
bool LineReader::refill() {
  std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
  end_ -= begin_;
  begin_ = 0;
  const std::size_t n = std::fread(buffer_.data() + end_, 1, buffer_.size() - end_, file_.get());
  if (std::ferror(file_.get()) != 0) throw UserError(fmt::format("{}: {}", name_, std::strerror(errno)));
  end_ += n;
  return n > 0;
}

bool LineReader::next(std::string_view& line) {
  std::size_t searched = 0;
  for (;;) {
    const char* const first = buffer_.data() + begin_;
    const std::size_t have = end_ - begin_;
    const void* const found = std::memchr(first + searched, '\n', have - searched);
    if (found != nullptr) {
      line = {first, static_cast<std::size_t>(static_cast<const char*>(found) - first)};
      begin_ += line.size() + 1;
      ++line_;
      return true;
    }
    searched = have;
    if (have == buffer_.size()) {
      ++line_;
      refuse("a line of over 1 MiB: not a state or trajectory file");
    }
    if (!refill()) break;
  }
  line = {buffer_.data() + begin_, end_ - begin_};
  begin_ = end_;
  if (line.empty()) return false;
  ++line_;
  return true;
}

StateFile::StateFile(const std::string& path) : lines_(path) {
  std::string_view header;
  const bool any = lines_.next(header);
  is_trajectory_ = any && header == kTrajectoryHeader;
  if (is_trajectory_ || (any && header == kStateHeader)) return;
  throw UserError(fmt::format("{}:1: not a state or trajectory file; the first line must be {} or {}", one_line(path),
                              kStateHeader, kTrajectoryHeader));
}

bool StateFile::read_row() {
  std::string_view line;
  if (!lines_.next(line)) return false;
  if (is_trajectory_) row_.frame = take_number<std::uint64_t>(line, "frame", lines_);
  row_.id = take_number<std::uint32_t>(line, "id", lines_);
  for (std::size_t i = 0; i < row_.values.size(); ++i) {
    row_.values[i] = take_number<double>(line, kStateFields[i], lines_);
  }
  if (!line.empty()) lines_.refuse("has more values than the first line names");
  return true;
}

void StateFile::take_row() {
  if (!id_.empty() && row_.id <= id_.back()) {
    lines_.refuse(fmt::format("id {} after {}: ids must ascend", row_.id, id_.back()));
  }
  id_.push_back(row_.id);
  for (std::size_t i = 0; i < fields_.size(); ++i) fields_[i].push_back(row_.values[i]);
}

bool StateFile::next_frame() {
  const bool first = !started_;
  started_ = true;
  if (first) has_row_ = read_row();
  id_.clear();
  for (std::vector<double>& column : fields_) column.clear();
  if (!has_row_) return first && !is_trajectory_;
  if (!first && row_.frame < frame_) {
    lines_.refuse(fmt::format("frame {} after {}: frames must ascend", row_.frame, frame_));
  }
  frame_ = row_.frame;
  while (has_row_ && row_.frame == frame_) {
    take_row();
    has_row_ = read_row();
  }
  return true;
}

StateView StateFile::view() const {
  StateView view;
  view.id = id_;
  std::copy(fields_.begin(), fields_.end(), view.fields.begin());
  return view;
}

}  // namespace psim::cli
