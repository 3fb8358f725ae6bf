// The command line of psim diff: two files, or a scene with the settings of side A and of side B.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "options/options.h"
#include "options/settings_options.h"

namespace psim::cli {

struct TypedDiff {
  TypedSettings settings;  // of both sides
  std::string a, b;        // more settings, as one string each
  std::string file_a, file_b;
};

/// Adds the subcommand to psim's command line.
CLI::App* declare_diff(CLI::App& app, TypedDiff& typed);

/// What `diff`, once parsed, asks for. Throws UserError.
Options read_diff(const CLI::App& diff, const TypedDiff& typed);

}  // namespace psim::cli
