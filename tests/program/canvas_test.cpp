// Pictures: shapes cover the area that they have, wherever their edges fall between pixels.
#include "picture/canvas.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <random>
#include <thread>
#include <utility>
#include <vector>

#include "picture/parallel.h"

namespace psim::cli {
namespace {

constexpr int kSide = 64;

// The light on a black canvas, in pixels of full white.
template <class Paint>
double light(const Paint& paint) {
  Canvas canvas(kSide, kSide, Colour{});
  paint(canvas);
  double sum = 0;
  std::vector<std::uint8_t> bytes;
  canvas.to_srgb(bytes);
  for (std::size_t k = 0; k < bytes.size(); k += 3) {
    const double s = bytes[k] / 255.0;
    sum += s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
  }
  return sum;
}

constexpr Colour kWhite{1, 1, 1};

double convex_light(const std::vector<Point>& points, double radius) {
  return light([&](Canvas& canvas) { canvas.convex(points, radius, kWhite); });
}

// A square of this side about (x, y), turned by `angle`.
std::vector<Point> square(double side, double x, double y, double angle) {
  std::vector<Point> points;
  for (int k = 0; k < 4; ++k) {
    const double at = angle + std::numbers::pi / 4 * (2 * k + 1), r = side / std::numbers::sqrt2;
    points.push_back({x + r * std::cos(at), y + r * std::sin(at)});
  }
  return points;
}

TEST(Canvas, ConvexShapesCoverTheirArea) {
  for (const double angle : {0.0, 0.2, 0.7}) {
    for (const double shift : {0.0, 0.3, 0.5}) {
      const double area = convex_light(square(5, 30 + shift, 31, angle), 0);
      EXPECT_NEAR(area, 25, 0.15) << angle << ' ' << shift;
    }
  }
  const double pi = std::numbers::pi;
  EXPECT_NEAR(convex_light({{20, 30}, {40, 33}}, 2.5), pi * 6.25 + 5 * std::hypot(20, 3), 0.5);
  EXPECT_NEAR(convex_light({{30.3, 30}}, 2.9), light([](Canvas& canvas) { canvas.disc(30.3, 30, 2.9, kWhite); }), 1e-6);
  EXPECT_NEAR(convex_light(square(4, 30, 30, 0.3), 0.75), 16 + 16 * 0.75 + pi * 0.5625, 0.2);
}

TEST(Canvas, DiscsCoverTheirArea) {
  for (const double r : {0.3, 0.5, 0.8, 1.3, 2.9}) {
    for (const double shift : {0.0, 0.3, 0.5}) {
      const double area = std::numbers::pi * r * r;
      EXPECT_NEAR(light([&](Canvas& canvas) { canvas.disc(30 + shift, 31, r, kWhite); }), area, 0.01 * area) << r;
    }
  }
}

// Touching discs share pixels; each pixel's light is the area that they cover together, whatever the
// order. Mixing one over the other would lose a tenth of it.
TEST(Canvas, APileOfTinyDiscsHasTheLightOfItsArea) {
  for (const double r : {0.13, 0.31, 0.5, 0.83}) {
    const int n = static_cast<int>(40 / (2 * r));
    const double area = n * n * std::numbers::pi * r * r;
    const double pile = light([&](Canvas& canvas) {
      for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) canvas.disc(10.3 + 2 * r * i, 10.7 + 2 * r * j, r, kWhite);
      }
    });
    EXPECT_NEAR(pile, area, 0.01 * area) << r;
  }
}

TEST(Canvas, TwoHalvesFillAPixelAndTheLaterOfTwoHides) {
  const std::vector<Point> left = {{10, 10}, {12.5, 10}, {12.5, 40}, {10, 40}},
                           right = {{12.5, 10}, {15, 10}, {15, 40}, {12.5, 40}};
  EXPECT_NEAR(light([&](Canvas& canvas) {
                canvas.convex(left, 0, kWhite);
                canvas.convex(right, 0, kWhite);
              }),
              150, 0.01);
  EXPECT_NEAR(light([&](Canvas& canvas) {
                canvas.disc(30, 30, 2.5, kWhite);
                canvas.disc(30, 30, 4.2, Colour{});
              }),
              0, 1e-6);
  const double behind = light([](Canvas& canvas) {
    canvas.disc(30, 30, 2.5, kWhite);
    canvas.disc(30, 30, 4.2, Colour{}, 0.3f);
  });
  EXPECT_NEAR(behind, 0.7 * std::numbers::pi * 2.5 * 2.5, 0.1);
}

TEST(Canvas, FiguresLieOnTheBackground) {
  const auto paint = [](Canvas& canvas) {
    canvas.clear(Colour{});
    canvas.background_rect(10.5, 20, 50, 40.25, kWhite);
    canvas.disc(30, 30, 2, Colour{});
  };
  EXPECT_NEAR(light(paint), 39.5 * 20.25 - std::numbers::pi * 4, 1);
}

TEST(Canvas, LargeFiguresHaveARim) {
  const double plain = std::numbers::pi * 400;
  const double inside = std::numbers::pi * (20 * 0.86) * (20 * 0.86);
  EXPECT_NEAR(light([](Canvas& canvas) { canvas.disc(32, 32, 20, kWhite); }), inside + 0.55 * (plain - inside), 3);
}

TEST(Canvas, OrderOfTheCornersDoesNotMatter) {
  std::vector<Point> points = square(20, 31, 33, 0.4);
  const double forwards = convex_light(points, 1);
  std::swap(points[1], points[3]);
  EXPECT_NEAR(convex_light(points, 1), forwards, 1e-6);
}

TEST(Canvas, ShapesOutsideAndWithoutAreaPaintNothing) {
  EXPECT_EQ(convex_light(square(10, -50, 30, 0), 0), 0);
  EXPECT_EQ(convex_light(square(10, 1e9, 30, 0), 0), 0);
  EXPECT_EQ(convex_light({{10, 10}, {50, 50}}, 0), 0);
  EXPECT_EQ(convex_light({}, 5), 0);
}

TEST(Canvas, FiguresEndAtTheWindow) {
  constexpr Colour kWhite{1, 1, 1};
  Canvas canvas(20, 20);
  canvas.show_within(5, 5.5, 15, 12);
  canvas.disc(10, 10, 30, kWhite);
  canvas.line({0, 18}, {20, 18}, 2, kWhite);
  std::vector<std::uint8_t> bytes;
  canvas.to_srgb(bytes);
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 20; ++x) {
      const bool inside = x >= 5 && x < 15 && y >= 6 && y < 12, cut = x >= 5 && x < 15 && y == 5;
      const int level = bytes[3 * static_cast<std::size_t>(y * 20 + x)];
      EXPECT_NEAR(level, inside ? 255 : cut ? 188 : 0, 1) << x << " " << y;  // half the light is 188
    }
  }
  canvas.clear({});
  canvas.disc(10, 10, 30, kWhite);
  canvas.to_srgb(bytes);
  EXPECT_EQ(bytes[0], 255);  // a new picture has none
}

// What lies at the border of a picture, or beyond, is as in a larger picture.
TEST(Canvas, TheBorderLeavesNoTrace) {
  constexpr int kLarge = 96, kWidth = 40, kHeight = 70, kLeft = 28, kTop = 13;
  std::mt19937_64 engine(1);
  const auto uniform = [&engine](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  };
  for (int round = 0; round < 600; ++round) {
    Canvas large(kLarge, kLarge), small(kWidth, kHeight);
    for (int k = 0; k < 3; ++k) {
      const double size = std::exp(uniform(std::log(0.05), std::log(1e5))), turn = uniform(0, 6.3);
      const double beside = size > 20 ? size : 0;  // a large one has its edge there
      const Point at{uniform(0, kLarge) + beside * std::cos(turn), uniform(0, kLarge) + beside * std::sin(turn)};
      const Colour colour{static_cast<float>(uniform(0, 1)), static_cast<float>(uniform(0, 1)), 1};
      const double rounding = round % 2 == 0 ? 0 : 0.3 * size;
      for (Canvas* canvas : {&large, &small}) {
        const Point p = canvas == &large ? at : Point{at.x - kLeft, at.y - kTop};
        const Point corners[] = {{p.x - size, p.y}, {p.x, p.y + 0.7 * size}, {p.x + size, p.y + 0.1 * size}};
        if (round % 4 == 0) canvas->disc(p.x, p.y, size, colour);
        if (round % 4 == 1) canvas->line(p, {p.x + size, p.y - 0.3 * size}, 3, colour);
        if (round % 4 == 2) canvas->ring(p.x, p.y, size, 1.2, colour);
        if (k == 2) canvas->convex(corners, rounding, colour);
      }
    }
    std::vector<std::uint8_t> whole, part;
    large.to_srgb(whole);
    small.to_srgb(part);
    int worst = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int b = 0; b < 3 * kWidth; ++b) {
        const auto of_whole = static_cast<std::size_t>(3 * ((y + kTop) * kLarge + kLeft) + b);
        worst = std::max(worst, std::abs(whole[of_whole] - part[static_cast<std::size_t>(3 * y * kWidth + b)]));
      }
    }
    ASSERT_LE(worst, 2) << round;
  }
}

TEST(Canvas, TinyShapesKeepTheirBrightness) {
  for (const double side : {0.25, 0.5, 1.0}) {
    const std::vector<Point> thin = {{10, 20}, {40, 22}, {40, 22 + side}, {10, 20 + side}};
    EXPECT_NEAR(convex_light(thin, 0), 30 * side, 0.3 * side) << side;
    EXPECT_NEAR(convex_light(square(side, 30.2, 30.6, 0.3), 0), side * side, 0.01 * side * side);
  }
}

// A page of everything, of several bands, with figures over many of them.
void paint_page(Canvas& canvas) {
  std::mt19937 random(4);
  const auto number = [&](double from, double to) { return std::uniform_real_distribution<double>(from, to)(random); };
  const auto colour = [&] { return from_srgb(static_cast<std::uint32_t>(random() & 0xFFFFFF)); };
  canvas.clear(from_srgb(0x101820));
  canvas.background_rect(20.4, 30.6, 250.2, 170.3, from_srgb(0x404040));
  for (int k = 0; k < 400; ++k) {
    const double x = number(-40, 340), y = number(-40, 240), size = std::exp(number(-2, 4.5));
    const float opacity = k % 7 == 0 ? 0.3f : 1;
    if (k % 4 == 0) canvas.disc(x, y, size, colour(), opacity);
    if (k % 4 == 1) canvas.convex(square(size, x, y, number(0, 3)), k % 8 < 4 ? 0 : number(0, size), colour(), opacity);
    if (k % 4 == 2) canvas.line({x, y}, {number(0, 300), number(0, 200)}, number(0.3, 6), colour());
    if (k % 4 == 3) canvas.ring(x, y, size, number(0.5, 20), colour());
  }
}

TEST(Canvas, ThreadsDoNotShow) {
  std::vector<std::uint8_t> one, some;
  Canvas canvas(300, 200);
  for (int again = 0; again < 2; ++again) {
    paint_page(canvas);
    canvas.to_srgb(one);
    for (const int threads : {1, 2, 3, 16}) {
      Canvas fresh(300, 200);
      paint_page(fresh);
      fresh.to_srgb(some, threads);
      EXPECT_EQ(some, one) << threads;
      canvas.to_srgb(some, threads);
      EXPECT_EQ(some, one) << threads;
    }
    canvas.clear(Colour{});
    canvas.disc(10, 10, 30, kWhite);
    canvas.to_srgb(some);  // nothing of it stays
  }
}

TEST(ShareOut, EveryJobOnceOnNoMoreThreadsThanAsked) {
  for (const int threads : {1, 2, 5}) {
    std::vector<int> done(100);
    std::vector<std::thread::id> worker_is(static_cast<std::size_t>(threads));
    share_out(done.size(), threads, [&](std::size_t job, std::size_t worker) {
      ++done[job];
      worker_is.at(worker) = std::this_thread::get_id();
    });
    EXPECT_EQ(done, std::vector<int>(100, 1));
    if (threads == 1) {
      EXPECT_EQ(worker_is[0], std::this_thread::get_id());
    }
  }
}

}  // namespace
}  // namespace psim::cli
