#include "run/details.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>

#include "base/os.h"
#include "output/text.h"
#include "output/user_error.h"

namespace psim::cli {
namespace {

// The columns of a log. Those of older ones lack the last one or the last two: then there were as many as it took.
constexpr std::array<const char*, 3> kHeaders = {"frame,solves,substeps,frames,horizon,pieces,wakes,sweeps,fluid_parts",
                                                 "frame,solves,substeps,frames,horizon,pieces,wakes,sweeps",
                                                 "frame,solves,substeps,frames,horizon,pieces,wakes"};

}  // namespace

void write_details_header(AtomicFile& file) {
  file.write(kHeaders[0]);
  file.write("\n");
}

void write_details_row(AtomicFile& file, std::uint64_t frame, const StepDetail& detail) {
  file.write(fmt::format("{},{},{},{},{},{},{},{},{}\n", frame, detail.solves ? 1 : 0, detail.substeps, detail.frames,
                         detail.horizon, detail.pieces, detail.wakes ? 1 : 0, detail.sweeps, detail.fluid_parts));
}

std::vector<StepDetail> read_details(const std::string& path) {
  std::ifstream file(os::path_of(path), std::ios::binary);
  if (!file) throw UserError(fmt::format("--governor-replay {}: cannot be read", one_line(path)));
  const auto refuse = [&](std::size_t line, const std::string& what) -> UserError {
    return UserError(fmt::format("--governor-replay {}: line {}: {}", one_line(path), line, what));
  };
  std::string line;
  std::getline(file, line);
  const auto header = std::find(kHeaders.begin(), kHeaders.end(), line);
  if (header == kHeaders.end()) throw refuse(1, "is not the first line of a governor's log");
  const std::string columns = line;
  const auto commas = static_cast<std::size_t>(std::count(columns.begin(), columns.end(), ','));
  std::vector<StepDetail> details;
  while (std::getline(file, line)) {
    const std::size_t at = details.size() + 2;
    std::uint64_t frame = 0;
    unsigned solves = 0, substeps = 0, frames = 0, horizon = 0, wakes = 0, sweeps = 0, fluid_parts = 0;
    std::uint32_t pieces = 0;
    char comma[8] = {};
    std::istringstream row(line);
    row >> frame >> comma[0] >> solves >> comma[1] >> substeps >> comma[2] >> frames >> comma[3] >> horizon >>
        comma[4] >> pieces >> comma[5] >> wakes;
    if (commas >= 7) row >> comma[6] >> sweeps;
    if (commas >= 8) row >> comma[7] >> fluid_parts;
    if (!row || std::string_view(comma, commas) != std::string_view(",,,,,,,,", commas) ||
        row.peek() != std::istringstream::traits_type::eof()) {
      throw refuse(at, "must be " + columns);
    }
    if (frame != details.size() + 1) throw refuse(at, "is out of order: frames count from 1");
    using D = StepDetail;
    if (solves > 1 || substeps > D::kMostSubsteps || frames < 1 || frames > D::kMostFrames || horizon < 1 ||
        horizon > D::kMostFrames || wakes > 1 || solves + wakes > 1 || sweeps > D::kMostSweeps ||
        fluid_parts > D::kMostFluidParts) {
      throw refuse(
          at, fmt::format("has solves 0 or 1, substeps 0 to {}, frames 1 to {}, horizon 1 to {}, sweeps 0 to {}, "
                          "fluid_parts 0 to {} and wakes 0 or, without solves, 1",
                          +D::kMostSubsteps, +D::kMostFrames, +D::kMostFrames, +D::kMostSweeps, +D::kMostFluidParts));
    }
    details.push_back({static_cast<std::uint8_t>(substeps), solves == 1, static_cast<std::uint8_t>(frames),
                       static_cast<std::uint8_t>(horizon), pieces, wakes == 1, static_cast<std::uint8_t>(sweeps),
                       static_cast<std::uint8_t>(fluid_parts)});
  }
  return details;
}

}  // namespace psim::cli
