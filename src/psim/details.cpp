#include "details.h"

#include <fmt/format.h>

#include <fstream>
#include <sstream>

#include "text.h"
#include "user_error.h"

namespace psim::cli {
namespace {

constexpr const char* kHeader = "frame,substeps,parts,frames";

}  // namespace

void write_details_header(AtomicFile& file) {
  file.write(kHeader);
  file.write("\n");
}

void write_details_row(AtomicFile& file, std::uint64_t frame, const StepDetail& detail) {
  file.write(fmt::format("{},{},{},{}\n", frame, detail.substeps, detail.parts, detail.frames));
}

std::vector<StepDetail> read_details(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw UserError(fmt::format("--governor-replay {}: cannot be read", one_line(path)));
  const auto refuse = [&](std::size_t line, const char* what) -> UserError {
    return UserError(fmt::format("--governor-replay {}: line {}: {}", one_line(path), line, what));
  };
  std::string line;
  if (!std::getline(file, line) || line != kHeader) {
    throw refuse(1, "is not the first line of a governor's log");
  }
  std::vector<StepDetail> details;
  while (std::getline(file, line)) {
    const std::size_t at = details.size() + 2;
    std::uint64_t frame = 0;
    unsigned substeps = 0, parts = 0, frames = 0;
    char comma[3] = {};
    std::istringstream row(line);
    if (!(row >> frame >> comma[0] >> substeps >> comma[1] >> parts >> comma[2] >> frames) ||
        std::string_view(comma, 3) != ",,," || row.peek() != std::istringstream::traits_type::eof()) {
      throw refuse(at, "must be frame,substeps,parts,frames");
    }
    if (frame != details.size() + 1) throw refuse(at, "is out of order: frames count from 1");
    if (substeps > 64 || parts < 1 || parts > StepDetail::kAll || frames < 1 || frames > 3) {
      throw refuse(at, "has substeps 0 to 64, parts 1 to 7 and frames 1 to 3");
    }
    details.push_back({static_cast<std::uint8_t>(substeps), static_cast<std::uint8_t>(parts),
                       static_cast<std::uint8_t>(frames)});
  }
  return details;
}

}  // namespace psim::cli
