// Our own elementary functions against values that are right to the last digit and against known digits. The C library's
// are not asked: they differ between platforms.
#include "base/elementary.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/elementary_values.h"
#include "base/rotor.h"

namespace psim::test {
namespace {

double relative(double value, double truth, double rest = 0) {
  return truth == 0 ? std::fabs(value) : std::fabs(((value - truth) - rest) / truth);
}

// The largest relative error over a table. Its float must be the right one or a neighbour of it.
template <class Table, class Function>
double worst_of(const Table& table, const Function& function) {
  double worst = 0;
  for (const Value& v : table) {
    const double value = function(v.x);
    worst = std::fmax(worst, relative(value, v.of_x, v.rest));
    const auto right = static_cast<float>(v.of_x), least = std::nextafter(right, -INFINITY);
    EXPECT_GE(static_cast<float>(value), least) << v.x;
    EXPECT_LE(static_cast<float>(value), std::nextafter(right, INFINITY)) << v.x;
  }
  return worst;
}

TEST(Elementary, FunctionsAreAsGoodAsTheyPromise) {
  EXPECT_LT(worst_of(kExponentials, exponential), 2e-16);
  EXPECT_LT(worst_of(kExponentialsLessOne, exponential_less_one), 5e-16);
  EXPECT_LT(worst_of(kLogarithms, logarithm), 2e-16);
  for (const PowerValue& v : kPowers) EXPECT_LT(relative(power(v.x, v.y), v.power), 2e-13) << v.x << " ^ " << v.y;
}

// Near a zero the error is relative to the angle.
TEST(Elementary, SinesAndCosinesAreThoseOfATableThatIsRight) {
  EXPECT_LT(worst_of(kSines, [](double x) { return sine_cosine(x).sine; }), 1e-12);
  EXPECT_LT(worst_of(kCosines, [](double x) { return sine_cosine(x).cosine; }), 1e-12);
  for (const Value& v : kSines) EXPECT_LT(std::fabs((sine_cosine(v.x).sine - v.of_x) - v.rest), 2e-16) << v.x;
  for (const Value& v : kCosines) EXPECT_LT(std::fabs((sine_cosine(v.x).cosine - v.of_x) - v.rest), 2e-16) << v.x;
}

TEST(Elementary, LesserAndGreaterGiveTheSecondOfTwoThatAreEqualOrNotOrdered) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(lesser(1.0, 2.0), 1);
  EXPECT_EQ(greater(1.0f, 2.0f), 2);
  EXPECT_TRUE(std::signbit(lesser(0.0, -0.0)) && !std::signbit(lesser(-0.0, 0.0)));
  EXPECT_TRUE(std::signbit(greater(0.0f, -0.0f)) && !std::signbit(greater(-0.0f, 0.0f)));
  EXPECT_EQ(lesser(kNan, 1.0), 1);
  EXPECT_EQ(greater(kNan, 1.0), 1);
  EXPECT_TRUE(std::isnan(lesser(1.0, kNan)) && std::isnan(greater(1.0, kNan)));
}

// The digits are those of Abramowitz and Stegun, Handbook of Mathematical Functions, tables 1.1 and 4.4.
TEST(Elementary, FunctionsHaveTheDigitsOfTheTables) {
  EXPECT_DOUBLE_EQ(exponential(1), 2.718281828459045);
  EXPECT_DOUBLE_EQ(exponential(-1), 0.36787944117144233);
  EXPECT_DOUBLE_EQ(exponential(10), 22026.465794806718);
  EXPECT_DOUBLE_EQ(exponential_less_one(1e-10), 1.00000000005e-10);
  EXPECT_DOUBLE_EQ(logarithm(2), 0.6931471805599453);
  EXPECT_DOUBLE_EQ(logarithm(10), 2.302585092994046);
  EXPECT_DOUBLE_EQ(logarithm(1e-300), -690.7755278982137);
}

TEST(Elementary, EndsAreThoseOfTheFunctions) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity(), kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(exponential(0), 1);
  EXPECT_EQ(exponential(-kInfinity), 0);
  EXPECT_EQ(exponential(-1e4), 0);
  EXPECT_EQ(exponential(1e4), kInfinity);
  EXPECT_EQ(exponential_less_one(0), 0);
  EXPECT_EQ(exponential_less_one(-kInfinity), -1);
  EXPECT_EQ(logarithm(1), 0);
  EXPECT_EQ(logarithm(0), -kInfinity);
  EXPECT_EQ(logarithm(kInfinity), kInfinity);
  for (const double value : {exponential(kNan), exponential_less_one(kNan), logarithm(kNan)})
    EXPECT_TRUE(std::isnan(value));
}

}  // namespace
}  // namespace psim::test
