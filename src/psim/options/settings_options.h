// The options that say what is run and how, shared by psim and psim diff, and the words for what
// is wrong with an option.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <optional>
#include <string>
#include <string_view>

#include "options/options.h"

namespace psim::cli {

/// The words as they were typed; CLI11 fills them, read_settings turns them into values.
struct TypedSettings {
  std::string scene, particles, seed, frames, dt, substeps, integrator, threads, isa, sleep, skin, memory;
};

/// An option with a value; the last one given wins.
CLI::Option* add_value(CLI::App& app, const char* name, std::string& target, const char* type, const char* group,
                       const char* what);

/// Declares --scene to --memory.
void declare_settings(CLI::App& app, TypedSettings& typed);

/// Fills the settings of `options`. Throws UserError.
void read_settings(const CLI::App& app, const TypedSettings& typed, Options& options);

/// Throws UserError "OPTION VALUE: what would be right".
[[noreturn]] void refuse(std::string_view option, std::string_view text, std::string_view right);

/// Throws UserError unless a file's name ends in `ending`, as ".png", in small or capital letters. Directories
/// and devices are left to who opens them.
void require_ending(std::string_view option, const std::string& file, std::string_view ending);

/// Throws UserError about the first word that is no option of `app`.
void refuse_leftovers(const CLI::App& app);

/// CLI11's own complaints (a value that is missing, or one that a flag does not take) in our words.
std::string reworded(const CLI::ParseError& error);

/// The value of an option, if it was given; refused outside of least..most.
template <class Number>
std::optional<Number> number(std::string_view option, const std::string& text, bool given, Number least, Number most,
                             std::string_view right) {
  if (!given) return std::nullopt;
  Number value{};
  const char* const end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stopped != end || !(value >= least && value <= most)) {
    refuse(option, text, right);
  }
  return value;
}

std::optional<bool> on_off(std::string_view option, const std::string& text, bool given);

}  // namespace psim::cli
