// What a step calls its stages, and what its zones cost a build without a profiler.
#include <gtest/gtest.h>

#include <string>
#include <type_traits>
#include <vector>

#include "base/profile_zone.h"
#include "base/trace.h"
#include "cli_runner.h"
#include "psim/report.h"

namespace psim {
namespace {

static_assert(std::is_empty_v<ProfileZone> && std::is_trivially_destructible_v<ProfileZone>);
static_assert(std::is_empty_v<LateZone> && std::is_trivially_destructible_v<LateZone>);

// The table of docs/performance.md has the stages in order, then the wait.
TEST(Zones, ThePageHasTheNamesOfTheStages) {
  const std::string page = test::read_file(std::string(PSIM_SOURCE_DIR) + "/docs/performance.md");
  const std::size_t begin = page.find("\n## Names of zones\n"), end = page.find("\n## ", begin + 1);
  ASSERT_NE(begin, std::string::npos);
  std::vector<std::string> named;
  for (const std::string& line : test::lines_of(page.substr(begin, end - begin))) {
    if (!line.starts_with("| `")) continue;
    named.push_back(line.substr(3, line.find('`', 3) - 3));
    EXPECT_GT(line.size(), named.back().size() + 20) << line;  // it says something of it
  }
  std::vector<std::string> wanted(kStageNames.begin(), kStageNames.end());
  wanted.emplace_back(kWaitName);
  EXPECT_EQ(named, wanted);
}

}  // namespace
}  // namespace psim
