// The readers of psim's own files take paths: an input is a file in memory.
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <string>

#include "inputs.h"
#include "output/user_error.h"
#include "psim/psim.h"
#include "run/details.h"
#include "run/state_comparison.h"
#include "run/state_file.h"

namespace psim::fuzz {
namespace {

class MemoryFile {
 public:
  explicit MemoryFile(Bytes bytes) : fd_(::memfd_create("input", MFD_CLOEXEC)) {
    if (fd_ < 0) throw std::runtime_error("no memory file");
    for (std::size_t done = 0; done < bytes.size();) {
      const ssize_t n = ::write(fd_, bytes.data() + done, bytes.size() - done);
      if (n <= 0) throw std::runtime_error("the memory file takes no bytes");
      done += static_cast<std::size_t>(n);
    }
  }
  ~MemoryFile() { ::close(fd_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  std::string path() const { return "/proc/self/fd/" + std::to_string(fd_); }

 private:
  int fd_;
};

std::string one_line(const std::string& text) {
  return !text.empty() && text.find_first_of("\r\n") == text.npos ? "" : "refused with: " + text;
}

}  // namespace

std::string state_input(Bytes bytes) {
  constexpr std::uint8_t kBetween[] = {'\n', '=', '\n'};
  const auto split = std::search(bytes.begin(), bytes.end(), std::begin(kBetween), std::end(kBetween));
  const bool twice = split == bytes.end();
  const MemoryFile first({bytes.begin(), split}), second({twice ? bytes.begin() : split + 3, bytes.end()});
  try {
    cli::StateFile a(first.path()), b(second.path());
    cli::StateComparison states;
    std::uint64_t bodies = 0;
    while (a.next_frame()) {
      const bool more = b.next_frame();
      if (twice && (!more || a.frame() != b.frame())) return "reads otherwise the second time";
      const cli::StateView u = a.view(), v = b.view();
      for (std::size_t k = 0; k < u.id.size(); ++k) {
        if (k > 0 && u.id[k] <= u.id[k - 1]) return "ids do not ascend";
      }
      if (!more) break;
      bodies += u.id.size() + v.id.size();
      states.add(a.frame(), u, v);
    }
    if (twice && states.first()) return "differs from itself";
    if (states.first().has_value() != (states.differing_bodies() > 0)) return "a difference of no body";
    if (states.differing_bodies() > bodies) return "more bodies differ than there are";
  } catch (const cli::UserError& error) {
    return one_line(error.what());
  }
  return {};
}

std::string details_input(Bytes bytes) {
  const MemoryFile file(bytes);
  std::vector<StepDetail> details;
  try {
    details = cli::read_details(file.path());
  } catch (const cli::UserError& error) {
    return one_line(error.what());
  }
  WorldDesc desc;
  desc.bounds = {-10, -10, 10, 10};
  std::string error;
  const auto world = World::create(desc, {}, error);
  for (int k = 0; k < 20; ++k) {
    BodyDesc disc;
    disc.position = {-9.0 + k % 5, -9.0 + k / 5};
    if (world->add_body(disc, error) == kNoBody) return error;
  }
  constexpr std::size_t kMost = 50;
  if (details.size() > kMost) details.resize(kMost);
  for (const StepDetail& detail : details) world->replay(detail);
  return world->frame() == details.size() ? "" : "not as many frames as details";
}

}  // namespace psim::fuzz
