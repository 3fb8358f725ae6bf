#include "options/diff_options.h"

#include <algorithm>

#include "output/text.h"
#include "output/user_error.h"

namespace psim::cli {
namespace {

// The options given for both sides, as words again.
std::vector<std::string> shared_words(const CLI::App& diff) {
  std::vector<std::string> words;
  for (const CLI::Option* option : diff.get_options()) {
    const std::string name = option->get_name();
    if (option->count() == 0 || !name.starts_with("--") || name == "--a" || name == "--b") continue;
    words.push_back(name);
    words.push_back(option->as<std::string>());
  }
  return words;
}

// A side's own settings stand last, and so win over the shared ones.
Options read_side(const char* side, std::vector<std::string> words, const std::string& own) {
  const std::vector<std::string> more = CLI::detail::split_up(own);
  words.insert(words.end(), more.begin(), more.end());
  std::reverse(words.begin(), words.end());  // the order in which CLI11 takes them
  TypedSettings typed;
  CLI::App app;
  app.set_help_flag();
  app.allow_extras();
  declare_settings(app, typed);
  Options options;
  try {
    app.parse(words);
    refuse_leftovers(app);
    read_settings(app, typed, options);
  } catch (const CLI::ParseError& error) {
    throw UserError(fmt::format("{}: {}", side, reworded(error)));
  } catch (const UserError& error) {
    throw UserError(fmt::format("{}: {}", side, error.what()));
  }
  return options;
}

std::vector<Options> read_sides(const CLI::App& diff, const TypedDiff& typed) {
  const std::vector<std::string> shared = shared_words(diff);
  std::vector<Options> sides = {read_side("--a", shared, typed.a), read_side("--b", shared, typed.b)};
  if (sides[0].frame_count() != sides[1].frame_count()) {
    throw UserError(fmt::format("--a and --b: {} against {} frames; both must run equally long", sides[0].frame_count(),
                                sides[1].frame_count()));
  }
  return sides;
}

}  // namespace

CLI::App* declare_diff(CLI::App& app, TypedDiff& typed) {
  CLI::App* const diff =
      app.add_subcommand("diff", "the first number in which two files, or two ways to run a scene, differ");
  diff->get_formatter()->column_width(28);
  diff->add_option("A", typed.file_a, "a file of --state, or one of --trajectory")->type_name("FILE.csv");
  diff->add_option("B", typed.file_b, "the file to compare it with")->type_name("FILE.csv");
  add_value(*diff, "--a", typed.a, "\"OPTIONS\"", "Sides", "settings of side A (those below)");
  add_value(*diff, "--b", typed.b, "\"OPTIONS\"", "Sides", "settings of side B");
  declare_settings(*diff, typed.settings);
  diff->footer(
      "Two files:    psim diff a.csv b.csv\n"
      "Two settings: psim diff --scene pile --frames 200 --a \"--isa avx2\" --b \"--isa scalar\"\n"
      "Options outside of --a and --b are those of both sides. Exit status: 0 the same bits,\n"
      "1 a difference, 2 nothing to compare.");
  return diff;
}

Options read_diff(const CLI::App& diff, const TypedDiff& typed) {
  refuse_leftovers(diff);
  Options options;
  options.mode = Mode::diff;
  const bool has_sides = diff.count("--a") + diff.count("--b") > 0;
  if (diff.count("A") == 0) {
    if (!has_sides) {
      throw UserError("diff: needs two files, or settings in --a and --b; see psim diff --help");
    }
    options.sides = read_sides(diff, typed);
    return options;
  }
  if (diff.count("B") == 0) {
    throw UserError(fmt::format("diff {}: needs a second file", one_line(typed.file_a)));
  }
  if (has_sides || !shared_words(diff).empty()) {
    throw UserError("diff: either two files or settings, not both");
  }
  options.files = {typed.file_a, typed.file_b};
  return options;
}

}  // namespace psim::cli
