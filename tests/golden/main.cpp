// Prints or checks the state hashes of built-in scenes, frame by frame: proof that a change of the
// code changed no bit of the results.
//
//   golden print small|default [--isa NAME] [--threads N] [--scene NAME]   prints the table
//   golden check FILE.csv      [--isa NAME] [--threads N] [--scene NAME]   compares with a table
//   golden frames NAME COUNT FRAMES [--isa NAME] [--threads N]             one line a frame
//
// A row holds the scene, its number of bodies, the number of frames, and digests over the state hashes
// of frames 0 to 1, 10, 100 and the last. The first digest that differs bounds the first frame that does.
#include <array>
#include <charconv>
#include <cinttypes>
#include <cstdio>
#include <fstream>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "psim/scene.h"
#include "psim/world.h"

namespace {

constexpr std::array<std::uint64_t, 3> kMarks = {1, 10, 100};
constexpr std::uint64_t kFrames = 600;

struct Choice {
  psim::Isa isa = psim::best_isa();
  int threads = 1;
  std::string scene;  // empty: all
};

struct Row {
  std::string scene;
  std::uint64_t count = 0, frames = 0;
  std::array<std::uint64_t, kMarks.size() + 1> digest{};
  friend bool operator==(const Row&, const Row&) = default;
};

// FNV-1a over the eight bytes of a hash.
std::uint64_t mix(std::uint64_t digest, std::uint64_t hash) {
  for (int k = 0; k < 8; ++k) digest = (digest ^ ((hash >> (8 * k)) & 0xFF)) * 0x100000001b3u;
  return digest;
}

std::unique_ptr<psim::World> make_world(const std::string& scene, std::uint64_t count, const Choice& choice) {
  std::string error;
  const auto made = psim::make_builtin(scene, count, 1, error);
  std::unique_ptr<psim::World> world;
  if (made) world = psim::build_world(*made, {.isa = choice.isa, .threads = choice.threads}, error);
  if (!world) std::fprintf(stderr, "golden: %s: %s\n", scene.c_str(), error.c_str());
  return world;
}

// Calls each(frame, hash) for the start, frame 0, and after every step.
template <class Each>
bool run(const std::string& scene, std::uint64_t count, std::uint64_t frames, const Choice& choice, const Each& each) {
  const auto world = make_world(scene, count, choice);
  if (!world) return false;
  each(std::uint64_t{0}, world->state_hash());
  for (std::uint64_t frame = 1; frame <= frames; ++frame) {
    world->step();
    each(frame, world->state_hash());
  }
  return true;
}

bool measure(Row& row, const Choice& choice) {
  std::uint64_t digest = 0xcbf29ce484222325u;
  return run(row.scene, row.count, row.frames, choice, [&](std::uint64_t frame, std::uint64_t hash) {
    digest = mix(digest, hash);
    for (std::size_t k = 0; k < kMarks.size(); ++k) {
      if (frame == kMarks[k]) row.digest[k] = digest;
    }
    row.digest.back() = digest;
  });
}

void print(const Row& row) {
  std::printf("%s,%" PRIu64 ",%" PRIu64, row.scene.c_str(), row.count, row.frames);
  for (const std::uint64_t digest : row.digest) std::printf(",%016" PRIx64, digest);
  std::printf("\n");
  std::fflush(stdout);
}

constexpr const char* kHeader = "scene,count,frames,digest_1,digest_10,digest_100,digest_last";

// Few enough bodies that every ISA and thread count takes seconds, many enough that work is split.
std::uint64_t small_count(const psim::BuiltinScene& scene) {
  if (!scene.sized) return scene.default_particles;
  return scene.default_particles <= 400 ? scene.default_particles : 400 + scene.default_particles / 100;
}

int print_table(std::string_view size, const Choice& choice) {
  std::printf("%s\n", kHeader);
  for (const psim::BuiltinScene& scene : psim::builtin_scenes()) {
    if (!choice.scene.empty() && choice.scene != scene.name) continue;
    if (size == "small" && scene.name == "million") continue;  // the scene discs
    Row row{std::string(scene.name), size == "small" ? small_count(scene) : scene.default_particles, kFrames, {}};
    if (!measure(row, choice)) return 2;
    print(row);
  }
  return 0;
}

// A number of a row; leaves `line` behind the comma after it.
bool take(std::string_view& line, std::uint64_t& value, int base) {
  const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), value, base);
  if (error != std::errc()) return false;
  line.remove_prefix(static_cast<std::size_t>(end - line.data()));
  if (line.starts_with(',')) line.remove_prefix(1);
  return true;
}

bool parse(std::string_view line, Row& row) {
  const std::size_t comma = line.find(',');
  if (comma == std::string_view::npos) return false;
  row.scene = line.substr(0, comma);
  line.remove_prefix(comma + 1);
  bool good = take(line, row.count, 10) && take(line, row.frames, 10);
  for (std::uint64_t& digest : row.digest) good = good && take(line, digest, 16);
  return good;
}

int check_table(const std::string& file, const Choice& choice) {
  std::ifstream lines(file);
  std::string line;
  if (!std::getline(lines, line) || line != kHeader) {
    std::fprintf(stderr, "golden: %s: no table of hashes\n", file.c_str());
    return 2;
  }
  int rows = 0, different = 0;
  while (std::getline(lines, line)) {
    Row expected;
    if (!parse(line, expected)) {
      std::fprintf(stderr, "golden: %s: not a row: %s\n", file.c_str(), line.c_str());
      return 2;
    }
    if (!choice.scene.empty() && choice.scene != expected.scene) continue;
    Row seen = expected;
    if (!measure(seen, choice)) return 2;
    ++rows;
    if (seen == expected) continue;
    ++different;
    std::uint64_t since = 0, until = expected.frames;
    for (std::size_t k = 0; k < kMarks.size() && until == expected.frames; ++k) {
      (seen.digest[k] == expected.digest[k] ? since : until) = kMarks[k];
    }
    std::printf("DIFFERS %s, %" PRIu64 " bodies: in a frame from %" PRIu64 " to %" PRIu64 "\n", seen.scene.c_str(),
                seen.count, since, until);
    std::fflush(stdout);
  }
  std::printf("%d scenes, %d differ\n", rows, different);
  return different != 0 || rows == 0 ? 1 : 0;
}

int print_frames(const std::string& scene, std::uint64_t count, std::uint64_t frames, const Choice& choice) {
  const bool done = run(scene, count, frames, choice, [](std::uint64_t frame, std::uint64_t hash) {
    std::printf("%" PRIu64 " %016" PRIx64 "\n", frame, hash);
  });
  return done ? 0 : 2;
}

int usage() {
  std::fprintf(stderr,
               "golden: print small|default | check FILE.csv | frames NAME COUNT FRAMES, each with "
               "[--isa NAME] [--threads N] [--scene NAME]\n");
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> words;
  Choice choice;
  for (int k = 1; k < argc; ++k) {
    const std::string_view word = argv[k];
    if (!word.starts_with("--")) {
      words.emplace_back(word);
      continue;
    }
    if (++k == argc) return usage();
    if (word == "--threads") {
      choice.threads = std::stoi(argv[k]);
    } else if (word == "--scene") {
      choice.scene = argv[k];
    } else if (word == "--isa") {
      bool known = false;
      for (const psim::Isa isa : psim::kAllIsas) {
        if (psim::isa_name(isa) != argv[k]) continue;
        choice.isa = isa;
        known = psim::isa_available(isa);
      }
      if (!known) return usage();
    } else {
      return usage();
    }
  }
  if (words.size() == 2 && words[0] == "print" && (words[1] == "small" || words[1] == "default")) {
    return print_table(words[1], choice);
  }
  if (words.size() == 2 && words[0] == "check") return check_table(words[1], choice);
  if (words.size() == 4 && words[0] == "frames") {
    return print_frames(words[1], std::stoull(words[2]), std::stoull(words[3]), choice);
  }
  return usage();
}
