// Pictures and films as the program writes them.
#include <zlib.h>

#include <cstdio>

#include "cli_runner.h"

namespace psim::test {
namespace {

using Words = std::vector<std::string>;

// Width and height of a PNG, as "64x48"; what is wrong with it else.
std::string png_size(const std::string& path) {
  const std::string png = read_file(path);
  if (png.size() < 60 || png.substr(0, 8) != "\x89PNG\r\n\x1a\n") return "no PNG";
  if (png.substr(png.size() - 8, 4) != "IEND") return "cut off";
  const auto side = [&png](std::size_t at) {
    unsigned value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(png[at + i]);
    return std::to_string(value);
  };
  return side(16) + "x" + side(20);
}

bool has_program(const std::string& name) {
  return Process("/bin/sh", {"-c", "command -v " + name}).wait().status == 0;
}

class CliPictures : public ::testing::Test {
 protected:
  Words arguments(Words more) {
    Words all = {"--scene", scene_, "--frames", "7"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  Outcome run(Words more) { return run_psim(arguments(std::move(more))); }
  // With another PATH.
  Outcome run_in_path(const std::string& path, Words more) {
    Words words = arguments(std::move(more));
    words.insert(words.begin(), {"PATH=" + path, PSIM_PROGRAM});
    return Process("/usr/bin/env", words).wait();
  }
  // A folder with a program of this name.
  std::string fake(const std::string& script) {
    std::filesystem::create_directory(folder_.file("bin"));
    const std::string program = folder_.write("bin/ffmpeg", "#!/bin/sh\n" + script + "\n");
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
    return folder_.file("bin") + ":/usr/bin:/bin";
  }
  ScratchFolder folder_, frames_;
  std::string scene_ = folder_.write("small.json", kSmallScene);
};

TEST_F(CliPictures, AFrameFileForEveryPicture) {
  ASSERT_EQ(run({"--frames-dir", frames_.file(""), "--image-size", "64x48"}).status, 0);
  ASSERT_EQ(frames_.names().size(), 8u);
  for (int k = 0; k < 8; ++k) {
    EXPECT_EQ(png_size(frames_.file("frame_00000" + std::to_string(k) + ".png")), "64x48") << k;
  }
  EXPECT_NE(read_file(frames_.file("frame_000000.png")), read_file(frames_.file("frame_000007.png")));
}

TEST_F(CliPictures, FilmsAreFullHdUnlessToldOtherwise) {
  ASSERT_EQ(run({"--frames", "0", "--frames-dir", frames_.file("")}).status, 0);
  EXPECT_EQ(png_size(frames_.file("frame_000000.png")), "1920x1080");
}

TEST_F(CliPictures, EveryAndFpsChooseThePictures) {
  const std::string dir = frames_.file(""), table = folder_.file("t.csv");
  ASSERT_EQ(run({"--frames-dir", dir, "--image-size", "64x48", "--every", "3", "--trajectory", table}).status, 0);
  EXPECT_EQ(frames_.names(), (Words{"frame_000000.png", "frame_000001.png", "frame_000002.png"}));
  EXPECT_EQ(lines_of(read_file(table)).size(), 1 + 3 * 4u);  // the same frames: 0, 3, 6
  const Outcome half = run({"--frames-dir", dir, "--image-size", "32x32", "--fps", "30"});
  EXPECT_EQ(half.err, "");
  EXPECT_EQ(frames_.names().size(), 4u);
  EXPECT_EQ(png_size(frames_.file("frame_000003.png")), "32x32");
}

TEST_F(CliPictures, ARestoredRunIsFilmedAtItsOwnPace) {
  const std::string saved = folder_.file("saved"), dir = frames_.file("");
  ASSERT_EQ(run({"--dt", "0.1", "--save", saved}).status, 0);
  ASSERT_EQ(run({"--restore", saved, "--frames-dir", dir, "--fps", "20", "--image-size", "32x32"}).err, "");
  EXPECT_EQ(frames_.names().size(), 15u);  // 0.7 s, two pictures a frame
}

TEST_F(CliPictures, FramesOfALongerFilmBeforeArePointedOut) {
  const std::string dir = frames_.file("");
  ASSERT_EQ(run({"--frames-dir", dir, "--image-size", "32x32"}).status, 0);
  const Outcome shorter = run({"--frames-dir", dir, "--image-size", "32x32", "--frames", "2"});
  EXPECT_EQ(shorter.status, 0);
  EXPECT_NE(shorter.err.find("frame_000003.png and what follows"), std::string::npos) << shorter.err;
}

// Every chunk's checksum, and zlib's of the pixels (which its format keeps at the end).
TEST_F(CliPictures, ChecksumsAreRightAndThreadsDoNotShow) {
  const auto image = [&](const char* threads) {
    EXPECT_EQ(run({"--image", folder_.file("i.png"), "--image-size", "700x900", "--threads", threads}).status, 0);
    return read_file(folder_.file("i.png"));
  };
  const std::string png = image("1");
  EXPECT_EQ(image("2"), png);
  const auto number = [&png](std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(png.at(at + i));
    return value;
  };
  std::string kinds;
  for (std::size_t at = 8; at < png.size();) {
    const std::size_t size = number(at);
    kinds += png.substr(at + 4, 4) + ' ';
    EXPECT_EQ(number(at + 8 + size), crc32_z(0, reinterpret_cast<const Bytef*>(png.data()) + at + 4, size + 4))
        << kinds;
    if (kinds.ends_with("IDAT ")) {
      std::vector<Bytef> pixels(900 * (3 * 700 + 1));
      uLongf count = pixels.size();
      EXPECT_EQ(uncompress(pixels.data(), &count, reinterpret_cast<const Bytef*>(png.data()) + at + 8, size), Z_OK);
      EXPECT_EQ(count, pixels.size());
    }
    at += size + 12;
  }
  EXPECT_EQ(kinds, "IHDR sRGB IDAT IEND ");
}

TEST_F(CliPictures, SizeViewAndColourOfAnImage) {
  const auto image = [&](const char* name, Words more) {
    more.insert(more.begin(), {"--image", folder_.file(name)});
    EXPECT_EQ(run(more).status, 0);
    return read_file(folder_.file(name));
  };
  const std::string plain = image("a.png", {"--image-size", "200x100"});
  EXPECT_EQ(png_size(folder_.file("a.png")), "200x100");
  EXPECT_NE(plain, image("b.png", {"--image-size", "200x100", "--view", "-3,-1,3,2"}));
  EXPECT_NE(plain, image("c.png", {"--image-size", "200x100", "--colour", "body"}));
  const std::string strips = image("e.png", {"--image-size", "200x100", "--colour", "strip"});
  const std::string solver = image("f.png", {"--image-size", "200x100", "--colour", "solver"});
  EXPECT_NE(plain, strips);
  EXPECT_NE(plain, solver);
  EXPECT_NE(strips, solver);
  image("d.png", {"--view", "-1,-1,3,1"});
  EXPECT_EQ(png_size(folder_.file("d.png")), "1600x800");
}

TEST_F(CliPictures, MistakesAreOneLine) {
  const std::string dir = frames_.file(""), file = folder_.file("f.png");
  const std::vector<std::pair<Words, Words>> mistakes = {
      {{"--frames-dir", frames_.file("none")}, {"--frames-dir", "none", "No such file"}},
      {{"--frames-dir", scene_}, {"--frames-dir", "Not a directory"}},
      {{"--frames-dir", ""}, {"--frames-dir", "needs a directory"}},
      {{"--video", ""}, {"--video", "needs a file name"}},
      {{"--video", folder_.file("f.avi")}, {"--video", "f.avi", "must end in .mp4"}},
      {{"--image", folder_.file("x.jpg")}, {"--image", "x.jpg", "must end in .png"}},
      {{"--image", folder_.file("png")}, {"--image", "must end in .png"}},
      {{"--image", folder_.file(".png")}, {"--image", "must end in .png"}},
      {{"--video", folder_.file("none/f.mp4")}, {"--video", "No such file"}},
      {{"--fps", "30"}, {"--fps", "--frames-dir"}},
      {{"--fps", "0", "--frames-dir", dir}, {"--fps 0", "0.1 to 1000"}},
      {{"--fps", "fast", "--frames-dir", dir}, {"--fps fast", "0.1 to 1000"}},
      {{"--every", "0", "--frames-dir", dir}, {"--every 0"}},
      {{"--image-size", "64x48"}, {"--image-size", "--image"}},
      {{"--colour", "speed"}, {"--colour", "--image"}},
      {{"--image", file, "--image-size", "64"}, {"--image-size 64", "1920x1080"}},
      {{"--image", file, "--image-size", "15x48"}, {"--image-size", "16 to 8192"}},
      {{"--image", file, "--image-size", "64x8193"}, {"--image-size", "16 to 8192"}},
      {{"--image", file, "--image-size", "64x48x3"}, {"--image-size", "1920x1080"}},
      {{"--image", file, "--image-size", "64X48"}, {"--image-size", "1920x1080"}},
      {{"--video", folder_.file("f.mp4"), "--image-size", "65x48"}, {"--image-size 65x48", "even"}},
      {{"--image", file, "--view", "1,2,3"}, {"--view 1,2,3", "xmin,ymin,xmax,ymax"}},
      {{"--image", file, "--view", "1,2,3,x"}, {"--view", "xmin,ymin,xmax,ymax"}},
      {{"--image", file, "--view", "nan,2,3,4"}, {"--view", "xmin,ymin,xmax,ymax"}},
      {{"--image", file, "--view", "0,0,1e300,4"}, {"--view", "xmin,ymin,xmax,ymax"}},
      {{"--image", file, "--view", "3,0,-3,4"}, {"--view 3,0,-3,4", "xmin must be less"}},
      {{"--image", file, "--view", "-3,4,3,4"}, {"--view -3,4,3,4", "ymin must be less"}},
      {{"--image", file, "--colour", "blue"}, {"--colour blue", "spin"}},
      {{"--image", file, "--fluid-look", "foam"}, {"--fluid-look foam", "surface or particles"}},
      {{"--image", file, "--fluid-colour", "wet"}, {"--fluid-colour wet", "fluid, speed or pressure"}},
      {{"--fluid-look", "surface"}, {"--fluid-look", "--image"}},
      {{"--fluid-colour", "speed"}, {"--fluid-colour", "--image"}},
      {{"--verify", "--frames-dir", dir}, {"--frames-dir", "belongs to a run"}},
  };
  for (const auto& [arguments, words] : mistakes) {
    SCOPED_TRACE(::testing::PrintToString(arguments));
    expect_refused(run(arguments), words);
  }
  EXPECT_EQ(folder_.names(), Words{"small.json"});
  EXPECT_EQ(frames_.names(), Words{});
}

TEST_F(CliPictures, WithoutFfmpegNothingIsRun) {
  for (const char* path : {"", "/nonexistent"}) {
    expect_refused(run_in_path(path, {"--video", folder_.file("f.mp4")}), {"--video", "f.mp4", "apt install ffmpeg"});
  }
  EXPECT_EQ(folder_.names(), Words{"small.json"});
}

TEST_F(CliPictures, AnFfmpegThatFailsIsOneLineAndNoFilm) {
  const std::vector<std::pair<std::string, std::string>> faults = {
      {"echo out of paper >&2; exit 3", "ffmpeg failed: out of paper"},
      {"cat > /dev/null; exit 3", "ffmpeg failed: exit status 3"},
      {"exit 0", "ffmpeg failed: ended without a film"},
      {"kill -9 $$", "ffmpeg failed: ended by signal 9"},
  };
  const std::string old = folder_.write("f.mp4", "old");
  for (const auto& [script, said] : faults) {
    SCOPED_TRACE(script);
    for (const char* size : {"64x48", "1920x1080"}) {  // all pictures in the pipe; or not
      const Outcome outcome = run_in_path(fake(script), {"--video", old, "--image-size", size});
      EXPECT_EQ(outcome.status, 2);
      EXPECT_EQ(lines_of(outcome.err).size(), 1u) << outcome.err;
      EXPECT_NE(outcome.err.find("psim: --video " + old + ": " + said), std::string::npos) << outcome.err;
      EXPECT_NE(outcome.out.find("State 0x"), std::string::npos);  // the run itself is done
      EXPECT_EQ(read_file(old), "old");
      EXPECT_EQ(folder_.names(), (Words{"bin", "f.mp4", "small.json"}));
    }
  }
}

class CliVideo : public CliPictures {
 protected:
  void SetUp() override {
    if (!has_program("ffmpeg") || !has_program("ffprobe")) GTEST_SKIP() << "ffmpeg is not installed";
  }
  // "codec,width,height,rate,pictures"
  std::string probe(const std::string& film) {
    const Outcome said =
        Process("/usr/bin/env", {"ffprobe", "-v", "error", "-count_frames", "-of", "csv=p=0", "-show_entries",
                                 "stream=codec_name,width,height,avg_frame_rate,nb_read_frames", film})
            .wait();
    return said.out.substr(0, said.out.find('\n')) + said.err;
  }
};

TEST_F(CliVideo, AFilmHasItsPicturesAtItsRate) {
  const std::string film = folder_.file("f.mp4");
  ASSERT_EQ(run({"--video", film, "--image-size", "128x96"}).err, "");
  EXPECT_EQ(probe(film), "h264,128,96,60/1,8");
  ASSERT_EQ(run({"--video", film, "--image-size", "64x48", "--fps", "25", "--every", "2"}).err, "");
  EXPECT_EQ(probe(film), "h264,64,48,25/1,4");
  EXPECT_EQ(folder_.names(), (Words{"f.mp4", "small.json"}));
}

TEST_F(CliVideo, CtrlCEndsTheFilmWithWhatThereIs) {
  const std::string film = folder_.file("f.mp4");
  Process psim(PSIM_PROGRAM, arguments({"--frames", "1000000000", "--video", film, "--image-size", "64x48"}));
  ASSERT_TRUE(psim.waits_for(SIGINT));
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  psim.signal(SIGINT);
  const Outcome outcome = psim.wait();
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("interrupted after frame"), std::string::npos);
  EXPECT_TRUE(probe(film).starts_with("h264,64,48,60/1,")) << probe(film);
}

TEST_F(CliVideo, AKilledRunLeavesTheOldFilm) {
  const std::string film = folder_.write("f.mp4", "old");
  Process psim(PSIM_PROGRAM, arguments({"--frames", "1000000000", "--video", film, "--image-size", "64x48"}));
  ASSERT_TRUE(psim.waits_for(SIGINT));
  psim.signal(SIGKILL);
  EXPECT_EQ(psim.wait().status, -SIGKILL);
  EXPECT_EQ(read_file(film), "old");
}

}  // namespace
}  // namespace psim::test
