#include "window/view_options.h"

#include <charconv>
#include <string>
#include <string_view>
#include <vector>

#include "options/settings_options.h"
#include "output/text.h"
#include "output/user_error.h"

namespace psim::view {
namespace {

using cli::UserError;

void read_size(const std::string& text, ViewOptions& options) {
  constexpr int kLeast = 160, kMost = 8192;
  const std::size_t cross = text.find('x');
  const auto side = [](std::string_view digits, int& value) {
    const char* const end = digits.data() + digits.size();
    const auto [stopped, error] = std::from_chars(digits.data(), end, value);
    return error == std::errc() && stopped == end && value >= kLeast && value <= kMost;
  };
  const std::string_view all = text;
  if (cross == std::string::npos || !side(all.substr(0, cross), options.width) ||
      !side(all.substr(cross + 1), options.height)) {
    cli::refuse("--size", text, "must be WIDTHxHEIGHT, each 160 to 8192, as 1280x800");
  }
}

void refuse_unknown(const CLI::App& app) {
  const std::vector<std::string> left = app.remaining();
  if (left.empty()) return;
  const std::string& word = left.front();
  if (!word.starts_with('-')) {
    throw UserError(fmt::format("{}: unexpected word; one scene at a time", cli::one_line(word)));
  }
  std::vector<std::string> known;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  }
  const std::string name = word.substr(0, word.find('='));
  const std::string hint = cli::did_you_mean(name, known);
  throw UserError(fmt::format("{}: unknown option{}", cli::one_line(name),
                              hint.empty() ? "; psim-view --help lists them all" : hint));
}

}  // namespace

std::optional<ViewOptions> parse_view_options(int argc, const char* const* argv) {
  ViewOptions options;
  cli::TypedSettings typed;
  std::string scene, after, size;
  CLI::App app("psim-view: looks at psim's scenes while they run", "psim-view");
  app.set_help_flag("-h,--help", "this text");
  app.allow_extras();
  app.get_formatter()->column_width(28);
  app.footer("Keys: F1 in the window. Input scripts: docs/view.md.");
  cli::declare_settings(app, typed);
  app.get_option("--frames")->group("");  // --after is what ends a view
  app.add_option("SCENE", scene, "the same as --scene")->group("Scene");
  cli::add_value(app, "--shot", options.shot, "FILE.png", "View", "a picture, then the end");
  cli::add_value(app, "--after", after, "N", "View", "frames before that (60)");
  cli::add_value(app, "--play", options.play, "FILE", "View", "keys and pointer from a file");
  cli::add_value(app, "--size", size, "WxH", "View", "of the window, pixels (1280x800)");
  app.add_flag("--stats", options.stats, "what a picture costs, on stderr at the end")->group("View");
  app.add_flag("--version", options.version, "version")->group("View");
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    cli::print_out(app.help());
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    throw UserError(cli::reworded(error));
  }
  refuse_unknown(app);
  if (app.count("--frames") > 0) throw UserError("--frames: psim-view runs until --after N");
  if (!scene.empty()) {
    if (app.count("--scene") > 0) throw UserError("--scene: there is a scene already: " + scene);
  }
  cli::read_settings(app, typed, options.settings);
  if (!scene.empty()) options.settings.scene = scene;

  for (const char* name : {"--shot", "--play"}) {
    if (app.count(name) > 0 && app.get_option(name)->as<std::string>().empty()) {
      cli::refuse(name, "", "needs a file name");
    }
  }
  if (!options.shot.empty()) cli::require_ending("--shot", options.shot, ".png");
  options.after = cli::number<std::uint64_t>("--after", after, app.count("--after") > 0, 1, 1'000'000'000,
                                             "must be a whole number of frames, 1 to 1000000000");
  if (!options.shot.empty() && !options.after) options.after = 60;
  if (app.count("--size") > 0) read_size(size, options);
  return options;
}

}  // namespace psim::view
