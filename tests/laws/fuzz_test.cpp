// What the fuzzers run, in the normal suite: their corpus, past findings among it, and calls of the
// public interface from seeds.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cli_runner.h"
#include "inputs.h"
#include "psim/recording.h"
#include "psim/saved_state.h"
#include "psim/scene.h"
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
  /// Keys and values alone: "radius", "open".
  std::set<std::string> plain_words() const {
    std::set<std::string> plain;
    for (const std::string& word : words_) plain.insert(word.substr(word.find_first_of(".=") + 1));
    return plain;
  }

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

std::string all_seeds_of(const std::string& input) {
  std::string text;
  for (const auto& file : std::filesystem::directory_iterator(PSIM_SOURCE_DIR "/tests/fuzz/corpus/" + input)) {
    text += read_file(file.path()) + "\n";
  }
  return text;
}

// A fuzzer puts words of its dictionary into inputs.
void expect_in_dictionary(const std::string& word, const std::string& file) {
  const std::string dictionary = read_file(std::string(PSIM_SOURCE_DIR "/tests/fuzz/") + file);
  EXPECT_NE(dictionary.find("\"\\\"" + word + "\\\"\"\n"), dictionary.npos) << file << " lacks " << word;
}

TEST(FuzzCorpus, DictionaryHasEveryWordOfTheSceneSchema) {
  const Json schema = Json::parse(read_file(PSIM_SOURCE_DIR "/docs/scene.schema.json"));
  for (const std::string& word : SchemaWords(schema).plain_words()) expect_in_dictionary(word, "scene.dict");
}

// The words of R.U.B.E. are the one-word strings of the files that read it.
TEST(FuzzCorpus, UsesEveryWordOfRube) {
  const std::string code = read_file(PSIM_SOURCE_DIR "/src/scene/file/rube.cpp") +
                           read_file(PSIM_SOURCE_DIR "/src/scene/file/rube_joints.cpp");
  const std::string seeds = all_seeds_of("rube");
  const std::regex one_word("\"([A-Za-z][A-Za-z0-9-]*)\"");
  std::set<std::string> words;
  for (std::sregex_iterator match(code.begin(), code.end(), one_word), end; match != end; ++match) {
    words.insert((*match)[1].str());
  }
  EXPECT_GT(words.size(), 50u);
  for (const std::string& word : words) {
    EXPECT_NE(seeds.find('"' + word + '"'), seeds.npos) << "no seed uses " << word;
    expect_in_dictionary(word, "rube.dict");
  }
}

// The names of the functions of a class in a public header.
std::set<std::string> functions_of(const std::string& class_name, const std::string& header) {
  const std::string code = read_file(std::string(PSIM_SOURCE_DIR "/include/psim/") + header);
  const std::size_t begin = code.find("class PSIM_API " + class_name + " {");
  const std::string body = code.substr(begin, code.find("private:", begin) - begin);
  const std::regex declaration("\n  (?!///|~)[^\n(]*[ *&](\\w+)\\(");
  std::set<std::string> names;
  for (std::sregex_iterator match(body.begin(), body.end(), declaration), end; match != end; ++match) {
    names.insert((*match)[1].str());
  }
  names.erase("operator");
  names.erase(class_name);
  return names;
}

TEST(FuzzCorpus, EveryPublicFunctionOfAWorldIsCalled) {
  std::string calls;
  for (const auto& file : std::filesystem::directory_iterator(PSIM_SOURCE_DIR "/tests/fuzz")) {
    if (file.path().filename().string().starts_with("world_")) calls += read_file(file.path());
  }
  const auto expect_calls = [&](const std::string& class_name, const std::string& header, std::size_t at_least) {
    const std::set<std::string> names = functions_of(class_name, header);
    EXPECT_GE(names.size(), at_least) << class_name;
    for (const std::string& name : names) {
      EXPECT_TRUE(std::regex_search(calls, std::regex("(\\.|->|::)" + name + "\\(")))
          << "no input calls " << class_name << "::" << name;
    }
  };
  expect_calls("World", "world.h", 60);
  expect_calls("Recorder", "recording.h", 17);
  expect_calls("Replay", "recording.h", 8);
}

std::string corpus(const std::string& name) { return PSIM_SOURCE_DIR "/tests/fuzz/corpus/" + name; }

// A world of a seed of the scenes, some steps on.
std::unique_ptr<World> seed_world(const std::string& scene_name, int steps) {
  std::string error;
  const auto scene = load_scene(corpus("scene/" + scene_name), error);
  auto world = scene ? build_world(*scene, {}, error) : nullptr;
  for (int k = 0; world && k < steps; ++k) world->step();
  return world;
}

// A recording in which the host does something of every kind.
std::vector<std::byte> seed_recording(World& world, bool governed) {
  Recorder recorder(world, 2);
  std::string error;
  const BodyId body = recorder.add_body(disc({1, 2}), error), other = recorder.add_body(disc({2, 3}), error);
  JointDesc joint;
  joint.a = body;
  joint.b = other;
  const JointId tied = recorder.add_joint(joint, error);
  recorder.step();
  recorder.apply_impulse(body, {1, 0});
  recorder.apply_impulse_at(other, {1, 0}, {2, 3.1});
  recorder.set_velocity(body, {0, 1}, 1);
  recorder.set_transform(other, {3, 4}, 0.5);
  recorder.set_gravity({1, -5});
  recorder.set_skin(2);
  recorder.set_pre_solve([](std::span<NewContact> contacts) {
    for (NewContact& c : contacts) c.enabled = c.b.index % 2 == 0, c.friction = 0.3;
  });
  BodyDesc asks = disc({1, 6});
  asks.pre_solve = true;
  const BodyId asking = recorder.add_body(asks, error);
  recorder.set_fields({BuoyancyField{{-50, -50, 50, 1}, 2, 1}, WindField{{3, 0}, 0.1}}, error);
  recorder.apply_force(other, {1, 2});
  recorder.apply_torque(other, 0.5);
  recorder.explode({{1, 1}, 1, 2, 3});
  const FluidId fluid = recorder.add_fluid({0.5, 2, 0.1}, error);
  recorder.add_particles(fluid, std::vector<Vec2>{{4, 4}, {4.5, 4}, {4, 4.5}}, std::vector<Vec2>(3, {0, 1}), error);
  EmitterDesc tap;
  tap.from = {-4, 4};
  tap.to = {-4, 3};
  tap.speed = 20;
  const EmitterId emitter = recorder.add_emitter(tap, error);
  recorder.set_emitter_speed(emitter, 40);
  recorder.add_drain({-2, -9, 9, 9}, error);
  const DrainId drain = recorder.add_drain({-9, -9, -5, 9}, error);
  recorder.remove_drain(drain);
  asks.shape = BoxShape{1, 0.5};
  recorder.set_body(asking, asks, error);
  BodyTraits traits = *world.traits(other);
  traits.pre_solve = true;
  recorder.set_traits(other, traits);
  recorder.set_user_data(other, 7);
  std::vector<BodyId> more(3);
  recorder.add_bodies(std::vector<BodyDesc>(3, disc({-2, 6})), more, error);
  recorder.remove_bodies(std::span(more).first(2));
  if (governed) recorder.replay({2, true, 1, 1});
  recorder.step(0.01);
  recorder.remove_joint(tied);
  recorder.remove_emitter(emitter);
  recorder.remove_body(body);
  recorder.set_sleeping(true);
  for (int k = 0; k < 4; ++k) recorder.step();
  return recorder.recording();
}

// Seeds that a change of the format has made useless: PSIM_RENEW_CORPUS=1 writes them anew.
void renew_corpus() {
  const auto write = [](const std::string& file, std::span<const std::byte> bytes) {
    std::string error;
    EXPECT_TRUE(write_bytes(file, bytes, error)) << error;
  };
  const char* const scenes[] = {"shapes", "group-traits", "groups", "fluids"};
  const char* const recordings[] = {"calls", "governed", "discs", "fluids"};
  for (int k = 0; k < 4; ++k) {
    std::vector<std::byte> state;
    seed_world(scenes[k], 12)->save(state);
    const std::vector<std::byte> packed = pack_state(state);
    write(corpus("saved/world-" + std::to_string(k)), packed);
    const std::vector<std::byte> recording = seed_recording(*seed_world(scenes[k], 3), k == 1);
    write(corpus(std::string("recording/") + recordings[k]), recording);
    if (k != 0) continue;
    write(corpus("saved/cut"), std::span(packed).first(200));
    write(corpus("recording/cut"), std::span(recording).first(1800));
  }
}

// Of another format they would all be refused at once, and the fuzzer would begin with nothing.
TEST(FuzzCorpus, SavedWorldsAndRecordingsAreOfThisFormat) {
  if (std::getenv("PSIM_RENEW_CORPUS") != nullptr) renew_corpus();
  std::string error;
  for (const char* const name : {"world-0", "world-1", "world-2", "world-3"}) {
    const std::string bytes = read_file(corpus(std::string("saved/") + name));
    std::vector<std::byte> state;
    ASSERT_TRUE(unpack_state(std::as_bytes(std::span(bytes)), state, error)) << name << ": " << error;
    const auto world = World::from_state(state, {}, error);
    ASSERT_TRUE(world) << name << ": " << error;
    EXPECT_GT(world->body_count(), 3u);
  }
  for (const char* const name : {"calls", "governed", "discs", "fluids"}) {
    const std::string bytes = read_file(corpus(std::string("recording/") + name));
    EXPECT_TRUE(Replay::open(std::as_bytes(std::span(bytes)), {}, error)) << name << ": " << error;
  }
}

std::vector<std::uint8_t> random_calls(std::uint64_t seed) {
  Random random(seed);
  std::vector<std::uint8_t> calls(200 + random.below(1800));
  for (std::uint8_t& byte : calls) byte = static_cast<std::uint8_t>(random.below(256));
  if (seed % 8 != 0) calls[0] &= 15;  // the others make worlds of many bodies, which take as long as all the rest
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
