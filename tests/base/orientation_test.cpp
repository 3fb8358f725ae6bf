// The side of a line is found without rounding.
#include "base/orientation.h"

#include <gtest/gtest.h>

#include <cmath>

namespace psim {
namespace {

int sign(double v) { return v > 0 ? 1 : v < 0 ? -1 : 0; }

// Points a few units in the last place beside the line y = x, where rounded arithmetic is wrong for most (L. Kettner and
// others, "Classroom examples of robustness problems in geometric computations", 2008).
TEST(Orientation, IsExactBesideALine) {
  for (const double scale : {1.0, 0x1p-60, 0x1p25}) {
    for (int i = -64; i <= 64; ++i) {
      for (int j = -64; j <= 64; ++j) {
        const Vec2 a{scale * (0.5 + i * 0x1p-53), scale * (0.5 + j * 0x1p-53)};
        const Vec2 b{scale * 12, scale * 12}, c{scale * 24, scale * 24};
        const int wanted = sign(a.y - a.x);
        ASSERT_EQ(side_of(b, c, a), wanted) << i << ' ' << j;
        ASSERT_EQ(side_of(c, a, b), wanted);
        ASSERT_EQ(side_of(a, b, c), wanted);
        ASSERT_EQ(side_of(c, b, a), -wanted);
      }
    }
  }
}

TEST(Orientation, IsExactForLargeAndSmallNumbersTogether) {
  EXPECT_EQ(side_of({-1e9, 0}, {1e9, 0}, {0, 1e-100}), 1);
  EXPECT_EQ(side_of({-1e9, 0}, {1e9, 0}, {1, -1e-100}), -1);
  EXPECT_EQ(side_of({-1e9, -1e-100}, {1e9, 1e-100}, {0, 0}), 0);
  EXPECT_EQ(side_of({1e6, 1e6}, {std::nextafter(1e6, 2e6), 1e6}, {1e6, 1e6}), 0);
  EXPECT_EQ(side_of({1e9, 1e9}, {1e9, 1e9}, {3, 4}), 0);
}

}  // namespace
}  // namespace psim
