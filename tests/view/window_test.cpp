// psim-view the way a user starts it, on a screen of its own (Xvfb) with OpenGL in software: input
// goes in from a script, pictures come out and are looked at.
#include <gtest/gtest.h>
#include <png.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "cli_runner.h"
#include "model/camera.h"

namespace psim::test {
namespace {

constexpr int kWidth = 800, kHeight = 600;

struct Picture {
  std::vector<std::uint8_t> rgb;
  int width = 0, height = 0;

  explicit Picture(const std::string& path) {
    png_image image = {};
    image.version = PNG_IMAGE_VERSION;
    if (png_image_begin_read_from_file(&image, path.c_str()) == 0) return;
    image.format = PNG_FORMAT_RGB;
    width = static_cast<int>(image.width);
    height = static_cast<int>(image.height);
    rgb.resize(PNG_IMAGE_SIZE(image));
    png_image_finish_read(&image, nullptr, rgb.data(), 0, nullptr);
  }

  /// Red, green and blue at a place.
  std::array<int, 3> at(double x, double y) const {
    const auto first = 3 * (static_cast<std::size_t>(std::lround(y)) * static_cast<std::size_t>(width) +
                            static_cast<std::size_t>(std::lround(x)));
    return {rgb[first], rgb[first + 1], rgb[first + 2]};
  }

  /// Pixels unlike the background within `reach` pixels of a place.
  int painted(double x, double y, int reach) const {
    const std::uint8_t background[] = {18, 22, 29};
    int count = 0;
    for (int py = static_cast<int>(y) - reach; py <= static_cast<int>(y) + reach; ++py) {
      for (int px = static_cast<int>(x) - reach; px <= static_cast<int>(x) + reach; ++px) {
        if (px < 0 || py < 0 || px >= width || py >= height) continue;
        const std::uint8_t* const p = &rgb[3 * static_cast<std::size_t>(py * width + px)];
        int difference = 0;
        for (int k = 0; k < 3; ++k) difference += std::abs(p[k] - background[k]);
        count += difference > 30 ? 1 : 0;
      }
    }
    return count;
  }
};

bool has_screen() { return std::system("command -v xvfb-run > /dev/null 2>&1") == 0; }

#define NEEDS_A_SCREEN() \
  if (!has_screen()) GTEST_SKIP() << "xvfb-run is missing: apt install xvfb xauth"

Outcome run_view(const std::string& arguments, const std::string& folder = ".") {
  return Process("/bin/sh", {"-c", "cd '" + folder +
                                       "' && exec xvfb-run -a -s '-screen 0 1280x800x24' " PSIM_PROGRAM
                                       " --threads 1 --size 800x600 " +
                                       arguments})
      .wait();
}

// No gravity; a disc in the middle, a box to the left, and small kinematic discs in two corners so
// that the whole world is shown.
constexpr std::string_view kScene = R"({
  "psim": 1, "name": "bench",
  "world": {"bounds": [-10, -10, 10, 10], "boundary": "walls", "gravity": [0, 0]},
  "bodies": [
    {"type": "dynamic", "shape": {"disc": {"radius": 1}}, "position": [0, 0]},
    {"type": "dynamic", "shape": {"box": {"size": [4, 1]}}, "position": [-6, 0], "angle": 1.5707963},
    {"type": "kinematic", "shape": {"disc": {"radius": 0.5}}, "position": [-9, -9]},
    {"type": "kinematic", "shape": {"disc": {"radius": 0.5}}, "position": [9, 9]}]})";

class ViewWindow : public ::testing::Test {
 protected:
  ViewWindow() { camera_.fit({-10, -10, 10, 10}, kWidth, kHeight); }

  /// Without panels, so that the whole window shows the world.
  std::string script(const std::string& rest) const {
    return scratch_.write("input.txt", "1 key Tab\n2 key Home\n" + rest);
  }
  std::string at(Vec2 place) const {
    const Vec2 p = camera_.to_screen(place);
    return std::to_string(std::lround(p.x)) + " " + std::to_string(std::lround(p.y));
  }
  int painted(const Picture& picture, Vec2 place, int reach) const {
    const Vec2 p = camera_.to_screen(place);
    return picture.painted(p.x, p.y, reach);
  }

  ScratchFolder scratch_;
  view::Camera camera_;
};

TEST_F(ViewWindow, ShowsBodiesWhereTheyAre) {
  NEEDS_A_SCREEN();
  const std::string shot = scratch_.file("a.png");
  const Outcome outcome = run_view("--scene " + scratch_.write("s.json", kScene) + " --play " + script("") +
                                   " --after 5 --stats --shot " + shot);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_NE(outcome.err.find("5 pictures"), std::string::npos) << outcome.err;
  const Picture picture(shot);
  ASSERT_EQ(picture.width, kWidth);
  ASSERT_EQ(picture.height, kHeight);
  EXPECT_EQ(painted(picture, {0, 0}, 10), 21 * 21);
  EXPECT_EQ(painted(picture, {3, 3}, 10), 0);
  EXPECT_EQ(painted(picture, {-6, 1.7}, 3), 7 * 7);  // the box stands upright
  EXPECT_EQ(painted(picture, {-7.5, 0}, 10), 0);
  EXPECT_GT(painted(picture, {10, 0}, 6), 0);  // a wall of the world
  EXPECT_EQ(painted(picture, {9, 9}, 4), 9 * 9);
}

TEST_F(ViewWindow, HandsMoveMakeAndTakeBodies) {
  NEEDS_A_SCREEN();
  const std::string shot = scratch_.file("b.png");
  const std::string input =
      script("3 move " + at({0, 0}) + "\n4 down left\n10 move " + at({5, 5}) + "\n90 up left\n" +  // grab
             "91 key 2\n91 move " + at({-4, 6}) + "\n92 down left\n93 up left\n" +                 // spawn
             "94 key 5\n94 move " + at({0, -5}) + "\n95 down left\n97 move " + at({5, -5}) + "\n98 up left\n" +  // wall
             "100 key 6\n100 move " + at({-6, 0}) + "\n101 down left\n102 up left\n");  // erase
  const Outcome outcome =
      run_view("--scene " + scratch_.write("s.json", kScene) + " --play " + input + " --after 105 --shot " + shot);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const Picture picture(shot);
  EXPECT_EQ(painted(picture, {0, 0}, 10), 0);
  EXPECT_EQ(painted(picture, {5, 5}, 8), 17 * 17);
  EXPECT_GT(painted(picture, {-4, 6}, 25), 100);
  EXPECT_GT(painted(picture, {2.5, -5}, 6), 13);
  EXPECT_EQ(painted(picture, {-6, 0}, 10), 0);
}

TEST_F(ViewWindow, WheelAndRightButtonMoveThePicture) {
  NEEDS_A_SCREEN();
  const std::string shot = scratch_.file("c.png");
  const std::string input =
      script("3 move " + at({0, 0}) + "\n4 wheel 6\n5 down right\n6 move " + at({7, 0}) + "\n7 up right\n");
  const Outcome outcome =
      run_view("--scene " + scratch_.write("s.json", kScene) + " --play " + input + " --after 9 --shot " + shot);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const Picture picture(shot);
  EXPECT_EQ(painted(picture, {0, 0}, 10), 0);
  EXPECT_EQ(painted(picture, {7, 0}, 40), 81 * 81);  // larger than before
}

TEST_F(ViewWindow, SameInputSamePicture) {
  NEEDS_A_SCREEN();
  const std::string input = script("3 key K\n3 key T\n3 key C\n20 shot " + scratch_.file("d.png") +
                                   "\n30 key P\n32 key ,\n33 key ,\n34 shot " + scratch_.file("e.png") + "\n35 quit\n");
  const std::string command = "pile --particles 500 --play " + input;
  ASSERT_EQ(run_view(command).status, 0);
  const std::string d = read_file(scratch_.file("d.png")), e = read_file(scratch_.file("e.png"));
  ASSERT_EQ(run_view(command).status, 0);
  EXPECT_GT(d.size(), 1000u);
  EXPECT_NE(d, e);
  EXPECT_TRUE(d == read_file(scratch_.file("d.png")));
  EXPECT_TRUE(e == read_file(scratch_.file("e.png")));
}

// The disc in the middle is in the first strip, red; nothing touches it, so it has no colour of the solver.
TEST_F(ViewWindow, ColoursByStripAndSolver) {
  NEEDS_A_SCREEN();
  std::string keys;
  for (int k = 0; k < 7; ++k) keys += "3 key C\n";
  const std::string input = script(keys + "8 shot " + scratch_.file("g.png") + "\n9 key C\n12 shot " +
                                   scratch_.file("h.png") + "\n13 quit\n");
  const Outcome outcome = run_view("--scene " + scratch_.write("s.json", kScene) + " --play " + input);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const Vec2 middle = camera_.to_screen({0.2, 0.4});  // beside the spoke
  const auto strip = Picture(scratch_.file("g.png")).at(middle.x, middle.y);
  const auto solver = Picture(scratch_.file("h.png")).at(middle.x, middle.y);
  EXPECT_GT(strip[0], strip[1] + 100);
  EXPECT_GT(strip[0], strip[2] + 100);
  EXPECT_NEAR(solver[0], 77, 3);
  EXPECT_NEAR(solver[1], 77, 3);
}

// Water fills the lower half. F shows particles, V colours them by speed: all rest, dark.
TEST_F(ViewWindow, FluidsAreSeenAsSurfaceOrParticles) {
  NEEDS_A_SCREEN();
  const std::string scene = scratch_.write("w.json", R"({
  "psim": 1, "name": "wet",
  "world": {"bounds": [-10, -10, 10, 10], "boundary": "walls", "gravity": [0, 0]},
  "bodies": [{"type": "kinematic", "shape": {"disc": {"radius": 0.5}}, "position": [9, 9]}],
  "fluids": [{"region": [-10, -10, 10, 0], "spacing": 0.5}]})");
  const auto file = [&](char name) { return scratch_.file(std::string(1, name) + ".png"); };
  const std::string input = script("5 shot " + file('a') + "\n6 key F\n8 shot " + file('b') + "\n9 key V\n11 shot " +
                                   file('c') + "\n12 key F\n14 shot " + file('d') + "\n15 quit\n");
  const Outcome outcome = run_view("--scene " + scene + " --play " + input);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const Picture surface(file('a')), discs(file('b')), dark(file('c')), dark_surface(file('d'));
  EXPECT_EQ(painted(surface, {-5, -5}, 40), 81 * 81);
  EXPECT_EQ(painted(surface, {0, 2}, 20), 0);
  const Vec2 wall = camera_.to_screen({-10, -5});
  EXPECT_EQ(surface.painted(wall.x + 10, wall.y, 9), 19 * 19);  // no gap at the wall
  const int some = painted(discs, {-5, -5}, 40);
  EXPECT_GT(some, 81 * 81 / 2);
  EXPECT_LT(some, 81 * 81 - 300);
  const Vec2 middle = camera_.to_screen({-4.75, -4.75});  // of a particle
  EXPECT_GT(surface.at(middle.x, middle.y)[2], 190);
  EXPECT_GT(discs.at(middle.x, middle.y)[2], 190);
  EXPECT_NEAR(dark.at(middle.x, middle.y)[2], 0x87, 4);
  EXPECT_NEAR(dark_surface.at(middle.x, middle.y)[0], 0x41, 4);
}

// The keys of the help, by what they change.
TEST_F(ViewWindow, KeysDoWhatTheHelpSays) {
  NEEDS_A_SCREEN();
  const auto file = [&](char name) { return scratch_.file(std::string(1, name) + ".png"); };
  const auto shot = [&](int frame, char name) { return std::to_string(frame) + " shot " + file(name) + "\n"; };
  // Coloured by body: what is seen follows from places alone.
  const std::string input =
      script("3 key C\n3 key C\n3 key C\n3 key C\n10 key P\n" + shot(12, 'a') + shot(16, 'b') + "17 key O\n" +
             shot(19, 'c') + "20 key Right\n" + shot(22, 'd') + "23 key ,\n" + shot(25, 'e') + "26 key .\n" +
             shot(28, 'f') + "29 key .\n" + shot(31, 'g') + "32 key R\n" + shot(34, 'h') + "35 key Space\n" +
             shot(39, 'i') + "140 key P\n141 key Home\n" + shot(142, 'j') + "143 key G\n" + shot(144, 'k') +
             "145 key G\n145 key K\n" + shot(148, 'l') + "149 key K\n150 wheel 3\n" + shot(151, 'm') +
             "152 key Home\n" + shot(153, 'n') + "154 key F12\n155 key F1\n" + shot(157, 'o') + "158 quit\n");
  const Outcome outcome = run_view("pile --particles 300 --play " + input, scratch_.file(""));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto same = [&](char one, char other) {
    const std::string first = read_file(file(one));
    EXPECT_GT(first.size(), 500u) << one;
    return first == read_file(file(other));
  };
  EXPECT_TRUE(same('a', 'b'));   // P: it stands still
  EXPECT_FALSE(same('b', 'c'));  // O: a step
  EXPECT_FALSE(same('c', 'd'));  // Right: another
  EXPECT_TRUE(same('e', 'c'));   // , : back
  EXPECT_TRUE(same('f', 'd'));   // . : forward to the newest
  EXPECT_FALSE(same('g', 'f'));  // . : and on
  EXPECT_FALSE(same('h', 'g'));  // R: from the beginning
  EXPECT_FALSE(same('i', 'h'));  // Space: it runs
  EXPECT_FALSE(same('k', 'j'));  // G
  EXPECT_FALSE(same('l', 'j'));  // K
  EXPECT_FALSE(same('m', 'j'));  // wheel
  EXPECT_TRUE(same('n', 'j'));   // Home
  EXPECT_FALSE(same('o', 'n'));  // F1
  EXPECT_TRUE(read_file(scratch_.file("psim-view-001.png")) == read_file(file('n')));
}

TEST_F(ViewWindow, PanelsScenesAndOverlaysCanBeShown) {
  NEEDS_A_SCREEN();
  const std::string input =
      scratch_.write("input.txt", "2 key F1\n3 key G\n3 key H\n4 key K\n5 key ]\n9 key [\n12 key R\n14 key O\n");
  const std::string shot = scratch_.file("f.png");
  const Outcome outcome = run_view("galton --play " + input + " --after 20 --shot " + shot);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_GT(Picture(shot).painted(160, 200, 100), 1000);  // a panel full of words
}

// The tree is closed at first. Opened, it shows the topic of the scene, whose first line is `discs`.
TEST_F(ViewWindow, AClickInTheTreeLoadsAScene) {
  NEEDS_A_SCREEN();
  const auto input = [&](const std::string& clicks, const std::string& name) {
    // Coloured by body: what is seen follows from places alone.
    return scratch_.write(name + ".txt", clicks + "12 key C\n12 key C\n12 key C\n12 key C\n12 key Tab\n13 key Home\n" +
                                             "14 key R\n16 shot " + scratch_.file(name + ".png") + "\n17 quit\n");
  };
  const std::string open = "2 move 160 44\n3 down left\n4 up left\n";
  const std::string choose = "6 move 80 106\n7 down left\n8 up left\n";
  ASSERT_EQ(run_view("galton --play " + input(open + choose, "chosen")).status, 0);
  ASSERT_EQ(run_view("galton --play " + input(choose, "closed")).status, 0);
  ASSERT_EQ(run_view("discs --play " + input("", "discs")).status, 0);
  const std::string discs = read_file(scratch_.file("discs.png"));
  EXPECT_GT(discs.size(), 1000u);
  EXPECT_TRUE(read_file(scratch_.file("chosen.png")) == discs);
  EXPECT_FALSE(read_file(scratch_.file("closed.png")) == discs);
}

TEST_F(ViewWindow, PictureNeedsNoDisplayAndSaysNothing) {
  const std::string shot = scratch_.file("i.png");
  const Outcome outcome =
      Process("/bin/sh", {"-c", "unset DISPLAY WAYLAND_DISPLAY XDG_RUNTIME_DIR SDL_VIDEODRIVER; exec " PSIM_PROGRAM
                                " hourglass --threads 1 --size 400x300 --after 2 --shot " +
                                    shot})
          .wait();
  if (outcome.status != 0) GTEST_SKIP() << "SDL or OpenGL cannot draw without a display here: " << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(outcome.err, "");
  EXPECT_EQ(Picture(shot).width, 400);
}

TEST_F(ViewWindow, MistakesAreOneLineAndStatusTwo) {
  const auto refused = [](std::vector<std::string> arguments, const std::string& word) {
    const Outcome outcome = run_psim(std::move(arguments));
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_TRUE(outcome.err.starts_with("psim-view: ")) << outcome.err;
    EXPECT_EQ(lines_of(outcome.err).size(), 1u) << outcome.err;
    EXPECT_NE(outcome.err.find(word), std::string::npos) << outcome.err;
  };
  refused({"--shoot", "a.png"}, "did you mean --shot?");
  refused({"--after", "0"}, "whole number");
  refused({"--frames", "9"}, "--after");
  refused({"--size", "9x9"}, "1280x800");
  refused({"pile", "galton"}, "galton");
  refused({"pile", "--scene", "galton"}, "a scene already");
  refused({"no-such-scene", "--after", "1"}, "no-such-scene");
  refused({"--shot", "/no/such/folder/a.png"}, "cannot be written");
  refused({"--shot", scratch_.file("a.jpg")}, "must end in .png");
  refused({"--play", scratch_.file("none"), "--after", "1"}, "cannot be read");
  refused({"--play", scratch_.write("bad", "1 jump\n"), "--after", "1"}, "bad:1: ");
}

}  // namespace
}  // namespace psim::test
