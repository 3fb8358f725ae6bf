// The command line as a checked value.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "options/picture_options.h"
#include "psim/integrator.h"
#include "psim/isa.h"

namespace psim::cli {

/// What psim does instead of, or as, a run.
enum class Mode : std::uint8_t { run, list_scenes, explain, check, verify, benchmark, replay, diff, version };

enum class ReportFormat : std::uint8_t { text, json };

struct Options {
  Mode mode = Mode::run;

  std::string scene = "discs";  ///< a built-in name or a file
  std::optional<std::uint64_t> particles;
  std::optional<std::uint64_t> seed;

  std::optional<std::uint64_t> frames;
  std::optional<double> dt_s;
  std::optional<int> substeps;
  std::optional<Integrator> integrator;
  std::optional<bool> sleep;
  std::optional<double> skin;
  std::uint64_t memory_bytes = 0;                 ///< that a run may take
  std::optional<double> target_error, target_ms;  ///< one of them at most
  int threads = 1;
  Isa isa = Isa::scalar;

  ReportFormat report = ReportFormat::text;
  double budget_ms = 16.67;
  bool governor = false;
  bool profile = false;                                 ///< stages and threads in the report
  std::string governor_replay;                          ///< the log of a governed run, to run again; empty: none
  std::string state, fluid_state, metrics, trajectory;  ///< files; empty = not wanted
  std::string image, trace, governor_log;               ///< likewise
  std::string save, record;                             ///< files: the final state to go on from; the run to replay
  std::string restore, replay;                          ///< the state to start in; Mode::replay: the recording
  std::uint64_t every = 1;                              ///< frames between trajectory rows
  PictureOptions pictures;                              ///< of --image and of films

  std::vector<std::string> files;  ///< Mode::diff: the two to compare, or none
  std::vector<Options> sides;      ///< Mode::diff: the two settings to compare, or none

  static constexpr std::uint64_t kDefaultFrames = 600;
  std::uint64_t frame_count() const { return frames.value_or(kDefaultFrames); }
};

/// Reads the command line. Nothing if --help was asked for and printed. Throws UserError that names
/// the option, the value and what would be right.
std::optional<Options> parse_options(int argc, const char* const* argv);

}  // namespace psim::cli
