// PNG files hold the pixels that went in, whatever these are: libpng reads them back.
#include "picture/png_write.h"

#include <png.h>

#include <random>

#include "cli_runner.h"

namespace psim::cli {
namespace {

using Bytes = std::vector<std::uint8_t>;

struct Size {
  int width, height;
  std::size_t pixels() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
};

// Of all kinds of parts: less than one, one, several, the last of one row, a row each.
constexpr Size kSizes[] = {{1, 1}, {1, 500}, {2, 3}, {16, 16}, {640, 137}, {1920, 91}, {8192, 33}, {100'000, 3}};

// each(pixel's number): three bytes.
template <class Each>
Bytes picture(Size size, const Each& each) {
  Bytes rgb;
  for (std::size_t k = 0; k < size.pixels(); ++k) {
    const std::uint32_t pixel = each(k);
    for (const int shift : {0, 8, 16}) rgb.push_back(static_cast<std::uint8_t>(pixel >> shift));
  }
  return rgb;
}

class PngWrite : public ::testing::Test {
 protected:
  std::string written(Size size, const Bytes& rgb, int threads) {
    const std::string path = folder_.file("picture.png");
    AtomicFile file("--image", path);
    write_png(file, size.width, size.height, rgb, threads);
    file.commit(Durable::no);
    return test::read_file(path);
  }
  // The size of the file.
  std::size_t expect_back(Size size, const Bytes& rgb) {
    SCOPED_TRACE(std::to_string(size.width) + "x" + std::to_string(size.height));
    const std::string png = written(size, rgb, 1);
    EXPECT_EQ(written(size, rgb, 2), png);
    EXPECT_EQ(written(size, rgb, 5), png);
    png_image image = {};
    image.version = PNG_IMAGE_VERSION;
    EXPECT_NE(png_image_begin_read_from_memory(&image, png.data(), png.size()), 0) << image.message;
    EXPECT_EQ(image.width, static_cast<unsigned>(size.width));
    EXPECT_EQ(image.height, static_cast<unsigned>(size.height));
    image.format = PNG_FORMAT_RGB;
    Bytes back(PNG_IMAGE_SIZE(image));
    EXPECT_NE(png_image_finish_read(&image, nullptr, back.data(), 0, nullptr), 0) << image.message;
    EXPECT_EQ(image.warning_or_error, 0u) << image.message;
    EXPECT_TRUE(back == rgb);
    return png.size();
  }
  test::ScratchFolder folder_;
};

TEST_F(PngWrite, PlainPicturesComeBackAndAreSmall) {
  for (const Size size : kSizes) {
    expect_back(size, picture(size, [](std::size_t) { return 0u; }));
    EXPECT_LT(expect_back(size, picture(size, [](std::size_t) { return 0x3B2A19u; })), 300 + size.pixels() / 20);
  }
}

TEST_F(PngWrite, NoiseComesBackAndGrowsLittle) {
  std::mt19937 random(1);
  for (const Size size : kSizes) {
    const Bytes rgb = picture(size, [&](std::size_t) { return static_cast<std::uint32_t>(random()); });
    EXPECT_LT(expect_back(size, rgb), rgb.size() + rgb.size() / 100 + 700);
  }
}

TEST_F(PngWrite, RepeatsOfEveryDistanceComeBack) {
  std::mt19937 random(2);
  for (const Size size : kSizes) {
    for (const std::uint32_t period : {2u, 3u, 80u, 640u, 10'922u, 10'923u, 20'000u}) {
      expect_back(size, picture(size, [&](std::size_t k) {
                    return static_cast<std::uint32_t>(k % period) * 2'654'435'761u >> (random() % 40 == 0 ? 9 : 8);
                  }));
    }
  }
}

}  // namespace
}  // namespace psim::cli
