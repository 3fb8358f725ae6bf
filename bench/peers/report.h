// Rows of the comparison as CSV and as a table.
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "comparison.h"

namespace psim::peers {

/// An engine with a setting in a scene, over all its runs.
struct Row {
  std::string engine, version, setting;
  bool recommended = false;
  int threads = 1;
  std::string scene;
  std::size_t bodies = 0;
  int repeats = 0;
  std::vector<double> frame_ms;  ///< the least of all runs, frame by frame; empty: see `note`
  Errors errors;
  std::string note;  ///< why there is nothing: not supported, failed
};

/// The q-quantile of frame times; their mean.
double quantile_ms(const Row& row, double q);
double mean_ms(const Row& row);

void write_header(std::ostream& out);
void write_row(std::ostream& out, const Row& row);
/// A line for each frame: engine, setting, threads, scene, bodies, frame, ms.
void write_times_header(std::ostream& out);
void write_times(std::ostream& out, const Row& row);
/// The rows of one scene, a line each, with the columns that anybody has.
void print_scene(std::ostream& out, const std::vector<Row>& rows);

}  // namespace psim::peers
