// What the fuzzers run, in the normal suite: their corpus, past findings among it, and calls of the
// public interface from seeds.
#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cli_runner.h"
#include "inputs.h"
#include "support.h"

namespace psim::test {
namespace {

using Input = std::string (*)(fuzz::Bytes);

std::vector<std::uint8_t> bytes_of(const std::string& text) { return {text.begin(), text.end()}; }

TEST(FuzzCorpus, EveryInputIsServedOrRefused) {
  const std::vector<std::pair<std::string, Input>> inputs = {
      {"scene", fuzz::scene_input},     {"rube", fuzz::rube_input},   {"state", fuzz::state_input},
      {"details", fuzz::details_input}, {"saved", fuzz::saved_input}, {"recording", fuzz::recording_input},
      {"world", fuzz::world_input}};
  for (const auto& [name, play] : inputs) {
    std::vector<std::filesystem::path> files;
    for (const auto& file : std::filesystem::directory_iterator(PSIM_SOURCE_DIR "/tests/fuzz/corpus/" + name)) {
      files.push_back(file.path());
    }
    EXPECT_GT(files.size(), 3u) << name;
    std::ranges::sort(files);
    for (const auto& file : files) {
      EXPECT_EQ(play(bytes_of(read_file(file))), "") << name << "/" << file.filename().string();
    }
  }
}

using Json = nlohmann::json;

// Words of a scene, each behind the key that it stands under: "disc.radius", "boundary=open".
class SchemaWords {
 public:
  explicit SchemaWords(const Json& schema) : schema_(schema) { walk(schema, ""); }
  const std::set<std::string>& words() const { return words_; }

  /// Takes out what a scene uses. Names that the scene chooses itself do not count as keys.
  void use(const Json& scene, const std::string& under = "") {
    if (scene.is_string()) words_.erase(under + "=" + scene.get<std::string>());
    if (scene.is_array()) {
      for (const Json& item : scene) use(item, under);
    }
    if (!scene.is_object()) return;
    for (const auto& [key, value] : scene.items()) {
      const std::string word = under + "." + key;
      words_.erase(word);
      use(value, all_.contains(word) ? key : under);
    }
  }

 private:
  void walk(const Json& part, const std::string& under) {
    if (part.is_array()) {
      for (const Json& item : part) walk(item, under);
    }
    if (!part.is_object()) return;
    if (part.contains("$ref") && followed_.emplace(part["$ref"], under).second) {
      walk(schema_.at(Json::json_pointer(part["$ref"].get<std::string>().substr(1))), under);
    }
    if (part.contains("properties")) {
      for (const auto& [key, value] : part["properties"].items()) {
        add(under + "." + key);
        walk(value, key);
      }
    }
    if (part.contains("enum")) {
      for (const Json& value : part["enum"]) {
        if (value.is_string()) add(under + "=" + value.get<std::string>());
      }
    }
    for (const char* const inner :
         {"items", "oneOf", "anyOf", "allOf", "prefixItems", "if", "then", "else", "additionalProperties"}) {
      if (part.contains(inner)) walk(part[inner], under);
    }
  }
  void add(const std::string& word) {
    words_.insert(word);
    all_.insert(word);
  }

  const Json& schema_;
  std::set<std::string> words_, all_;
  std::set<std::pair<std::string, std::string>> followed_;
};

// A fuzzer finds a key by itself only after a long time.
TEST(FuzzCorpus, UsesEveryKeyOfTheSceneSchema) {
  const Json schema = Json::parse(read_file(PSIM_SOURCE_DIR "/docs/scene.schema.json"));
  SchemaWords unused(schema);
  EXPECT_GT(unused.words().size(), 120u);
  for (const auto& file : std::filesystem::directory_iterator(PSIM_SOURCE_DIR "/tests/fuzz/corpus/scene")) {
    const std::string text = read_file(file.path());
    std::string error;
    if (parse_scene(text, "f", error)) unused.use(Json::parse(text));
  }
  for (const std::string& word : unused.words()) ADD_FAILURE() << "no seed uses " << word;
}

// Of another format they would all be refused at once, and the fuzzer would begin with nothing.
TEST(FuzzCorpus, SavedWorldsAreOfThisFormat) {
  for (const char* const name : {"world-0", "world-1", "world-2"}) {
    const std::string bytes = read_file(std::string(PSIM_SOURCE_DIR "/tests/fuzz/corpus/saved/") + name);
    std::string error;
    std::vector<std::byte> state;
    ASSERT_TRUE(unpack_state(std::as_bytes(std::span(bytes)), state, error)) << name << ": " << error;
    const auto world = World::from_state(state, {}, error);
    ASSERT_TRUE(world) << name << ": " << error;
    EXPECT_GT(world->body_count(), 3u);
  }
}

std::vector<std::uint8_t> random_calls(std::uint64_t seed) {
  Random random(seed);
  std::vector<std::uint8_t> calls(200 + random.below(1800));
  for (std::uint8_t& byte : calls) byte = static_cast<std::uint8_t>(random.below(256));
  return calls;
}

TEST(WorldFuzz, RandomCallsBreakNoPromise) {
  for (std::uint64_t seed = 1; seed <= (kSanitized ? 30u : 120u); ++seed) {
    ASSERT_EQ(fuzz::world_input(random_calls(seed)), "") << "seed " << seed;
  }
}

TEST(SlowWorldFuzz, ManyRandomCallsBreakNoPromise) {
  for (std::uint64_t seed = 1001; seed <= (all_seeds() ? 11'000u : 3500u); ++seed) {
    ASSERT_EQ(fuzz::world_input(random_calls(seed)), "") << "seed " << seed;
  }
}

}  // namespace
}  // namespace psim::test
