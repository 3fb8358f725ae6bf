// The table of a step's parts (src/core/step/step_table.h) as Markdown, which docs/step.md holds between two marks.
//
//   step-table                 prints the table
//   step-table check FILE.md   exits with 1 if the file holds another one
//   step-table write FILE.md   puts the table into the file
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>

#include "step/step_table.h"

namespace {

constexpr std::string_view kBegin = "<!-- parts: begin -->\n", kEnd = "<!-- parts: end -->";

std::string table() {
  std::string out = "| part | time counts as | what it does | a piece |\n|---|---|---|---|\n";
  for (const psim::StepPart& part : psim::step_parts()) {
    const auto stage = psim::kStageNames[static_cast<std::size_t>(part.stage)];
    for (const std::string_view cell : {part.name, stage, part.does, part.cut}) {
      out.append("| ").append(cell).append(" ");
    }
    out += "|\n";
  }
  return out;
}

std::string read(const char* path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fputs(table().c_str(), stdout);
    return 0;
  }
  const std::string_view what = argv[1];
  const std::string text = read(argv[2]);
  const std::size_t begin = text.find(kBegin), end = text.find(kEnd);
  if (begin == std::string::npos || end == std::string::npos || end < begin) {
    std::fprintf(stderr, "step-table: %s: there are no marks for the table\n", argv[2]);
    return 1;
  }
  const std::string fresh = text.substr(0, begin + kBegin.size()) + table() + text.substr(end);
  if (what == "write") return (std::ofstream(argv[2]) << fresh).flush().good() ? 0 : 1;
  if (fresh == text) return 0;
  std::fprintf(stderr, "step-table: %s is not current: step-table write %s\n", argv[2], argv[2]);
  return 1;
}
