// The governor's log: what was done of every frame, and a run again by it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "output/atomic_file.h"
#include "psim/governor.h"

namespace psim::cli {

void write_details_header(AtomicFile& file);
void write_details_row(AtomicFile& file, std::uint64_t frame, const StepDetail& detail);

/// The details of a log, by frame. Throws UserError that names the line.
std::vector<StepDetail> read_details(const std::string& path);

}  // namespace psim::cli
