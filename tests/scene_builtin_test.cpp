// The built-in scenes: every one makes the discs that were asked for, in places where they can
// start, and says the same as its file in scenes/.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <set>
#include <string>
#include <variant>

#include "placement.h"
#include "psim/scene.h"

namespace psim::test {
namespace {

Scene builtin_of(std::string_view name, std::uint64_t particles = 0, std::uint64_t seed = 1) {
  std::string error;
  auto scene = make_builtin(name, particles, seed, error);
  EXPECT_TRUE(scene) << error;
  return scene.value_or(Scene{});
}

PlacedGroup placed(const Scene& scene, std::size_t k) {
  std::string error;
  auto group = place_group(seeded_group(scene, k), error);
  EXPECT_TRUE(group) << scene.name << " groups[" << k << "]: " << error;
  return group.value_or(PlacedGroup{});
}

std::uint64_t dynamic_discs(const Scene& scene) {
  std::uint64_t count = 0;
  for (const BodyDesc& body : scene.bodies) count += body.type == BodyType::dynamic_body;
  for (std::size_t k = 0; k < scene.groups.size(); ++k) {
    if (scene.groups[k].body.type == BodyType::dynamic_body) count += placed(scene, k).x.size();
  }
  return count;
}

bool same(Vec2 a, Vec2 b) { return a.x == b.x && a.y == b.y; }
bool same(const Bounds& a, const Bounds& b) {
  return a.xmin == b.xmin && a.ymin == b.ymin && a.xmax == b.xmax && a.ymax == b.ymax;
}
bool same(const Material& a, const Material& b) {
  return a.density == b.density && a.restitution == b.restitution && a.friction == b.friction;
}
bool same(const std::vector<Vec2>& a, const std::vector<Vec2>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](Vec2 p, Vec2 q) { return same(p, q); });
}

bool same(const Shape& a, const Shape& b) {
  if (a.index() != b.index()) return false;
  if (const auto* disc = std::get_if<DiscShape>(&a)) {
    return disc->radius == std::get<DiscShape>(b).radius;
  }
  if (const auto* segment = std::get_if<SegmentShape>(&a)) {
    const auto& other = std::get<SegmentShape>(b);
    return same(segment->p1, other.p1) && same(segment->p2, other.p2);
  }
  const auto &chain = std::get<ChainShape>(a), &other = std::get<ChainShape>(b);
  return chain.loop == other.loop && same(chain.vertices, other.vertices);
}

// All but shape and place.
bool same_body_keys(const BodyDesc& a, const BodyDesc& b) {
  return a.type == b.type && a.angle == b.angle && a.angular_velocity == b.angular_velocity &&
         same(a.material, b.material) && a.mass == b.mass && a.gravity_scale == b.gravity_scale &&
         a.fixed_rotation == b.fixed_rotation && a.bullet == b.bullet;
}

bool same(const Field& a, const Field& b) {
  if (a.index() != b.index()) return false;
  if (const auto* well = std::get_if<WellField>(&a)) {
    const auto& other = std::get<WellField>(b);
    return same(well->position, other.position) && well->strength == other.strength &&
           well->softening == other.softening && well->exponent == other.exponent &&
           well->range == other.range;
  }
  const auto &drag = std::get<DragField>(a), &other = std::get<DragField>(b);
  return drag.linear == other.linear && drag.quadratic == other.quadratic;
}

void expect_same_world(const Scene& a, const Scene& b) {
  EXPECT_TRUE(same(a.world.bounds, b.world.bounds));
  EXPECT_EQ(a.world.boundary, b.world.boundary);
  EXPECT_TRUE(same(a.world.gravity, b.world.gravity));
  EXPECT_EQ(a.world.linear_damping, b.world.linear_damping);
  EXPECT_TRUE(same(a.world.wall, b.world.wall));
  EXPECT_EQ(a.world.dt, b.world.dt);
  EXPECT_EQ(a.world.substeps, b.world.substeps);
  EXPECT_EQ(a.world.restitution_threshold, b.world.restitution_threshold);
  EXPECT_EQ(a.sleeping, b.sleeping);
  ASSERT_EQ(a.world.fields.size(), b.world.fields.size());
  for (std::size_t k = 0; k < a.world.fields.size(); ++k) {
    EXPECT_TRUE(same(a.world.fields[k], b.world.fields[k])) << k;
  }
}

void expect_same_bodies(const Scene& a, const Scene& b) {
  EXPECT_EQ(a.body_names, b.body_names);
  ASSERT_EQ(a.bodies.size(), b.bodies.size());
  for (std::size_t k = 0; k < a.bodies.size(); ++k) {
    const BodyDesc &p = a.bodies[k], &q = b.bodies[k];
    EXPECT_TRUE(same_body_keys(p, q) && same(p.shape, q.shape) && same(p.position, q.position) &&
                same(p.velocity, q.velocity))
        << "bodies[" << k << "]";
  }
  ASSERT_EQ(a.groups.size(), b.groups.size());
  for (std::size_t k = 0; k < a.groups.size(); ++k) {
    EXPECT_TRUE(same_body_keys(a.groups[k].body, b.groups[k].body)) << "groups[" << k << "]";
    const PlacedGroup p = placed(a, k), q = placed(b, k);
    EXPECT_TRUE(p.x == q.x && p.y == q.y && p.radius == q.radius && p.vx == q.vx && p.vy == q.vy)
        << "groups[" << k << "]";
  }
}

TEST(SceneBuiltin, NamesAreUniqueAndDescribedInOneLine) {
  std::set<std::string_view> names;
  for (const BuiltinScene& scene : builtin_scenes()) {
    EXPECT_TRUE(names.insert(scene.name).second) << scene.name;
    EXPECT_FALSE(scene.description.empty()) << scene.name;
    EXPECT_EQ(scene.description.find('\n'), std::string_view::npos) << scene.name;
  }
  EXPECT_EQ(builtin_scenes().front().name, "discs");
}

TEST(SceneBuiltin, MakesExactlyTheDiscsAskedFor) {
  for (const BuiltinScene& info : builtin_scenes()) {
    if (info.default_particles < 1'000'000) {
      EXPECT_EQ(dynamic_discs(builtin_of(info.name)), info.default_particles) << info.name;
    }
    for (const std::uint64_t n :
         {1u, 2u, 3u, 4u, 5u, 6u, 7u, 10u, 16u, 17u, 99u, 101u, 1000u, 3001u}) {
      const Scene scene = builtin_of(info.name, n);
      EXPECT_EQ(dynamic_discs(scene), n) << info.name;
      EXPECT_GE(scene.body_count(), n) << info.name;
    }
  }
}

TEST(SceneBuiltin, StartsWithoutOverlapsAndInsideItsWalls) {
  for (const BuiltinScene& info : builtin_scenes()) {
    for (const std::uint64_t n : {1u, 7u, 100u, 5000u}) {
      for (const std::string& line : check_scene(builtin_of(info.name, n))) {
        // A scene of mixed sizes is about what this warns of.
        if (info.name == "mixed-sizes" && line.find("times lighter") != std::string::npos) continue;
        ADD_FAILURE() << info.name << " with " << n << ": " << line;
      }
    }
  }
}

TEST(SceneBuiltin, SeedMovesTheDiscs) {
  for (const BuiltinScene& info : builtin_scenes()) {
    const Scene a = builtin_of(info.name, 100, 1), b = builtin_of(info.name, 100, 2);
    const std::size_t last = a.groups.size() - 1;
    const PlacedGroup p = placed(a, last), q = placed(b, last), again = placed(a, last);
    EXPECT_TRUE(p.x != q.x || p.vx != q.vx) << info.name;
    EXPECT_TRUE(p.x == again.x && p.vx == again.vx) << info.name;
  }
}

TEST(SceneBuiltin, UnknownNameListsTheOnesThereAre) {
  std::string error;
  EXPECT_FALSE(make_builtin("disks", 0, 1, error));
  for (const BuiltinScene& info : builtin_scenes()) {
    EXPECT_NE(error.find(info.name), std::string::npos) << error;
  }
  EXPECT_FALSE(make_builtin("discs", 10'000'001, 1, error));
  EXPECT_NE(error.find("1 to 10000000"), std::string::npos) << error;
}

TEST(SceneBuiltin, FileSaysTheSame) {
  for (const BuiltinScene& info : builtin_scenes()) {
    SCOPED_TRACE(info.name);
    std::string error;
    const std::string path = PSIM_SOURCE_DIR "/scenes/" + std::string(info.name) + ".json";
    const auto file = load_scene(path, error);
    ASSERT_TRUE(file) << error;
    const Scene scene = builtin_of(info.name);
    EXPECT_EQ(file->name, scene.name);
    EXPECT_EQ(file->description, scene.description);
    expect_same_world(*file, scene);
    expect_same_bodies(*file, scene);
  }
}

TEST(SceneBuiltin, TextReadsBackToTheSameScene) {
  for (const BuiltinScene& info : builtin_scenes()) {
    SCOPED_TRACE(info.name);
    const Scene scene = builtin_of(info.name, 500);
    std::string error;
    const auto read = parse_scene(scene_to_json(scene), "text", error);
    ASSERT_TRUE(read) << error;
    EXPECT_EQ(read->name, scene.name);
    expect_same_world(*read, scene);
    expect_same_bodies(*read, scene);
  }
}

TEST(SceneBuiltin, SeedFromOutsideMeansTheSameForFileAndName) {
  std::string error;
  auto file = load_scene(PSIM_SOURCE_DIR "/scenes/dam.json", error);
  ASSERT_TRUE(file) << error;
  file->seed = 5;
  expect_same_bodies(*file, builtin_of("dam", 0, 5));
}

TEST(SceneBuiltin, BuildsWorldsOfAsManyBodies) {
  for (const BuiltinScene& info : builtin_scenes()) {
    const Scene scene = builtin_of(info.name, 200);
    std::string error;
    const auto world = build_world(scene, RunOptions{}, error);
    ASSERT_TRUE(world) << info.name << ": " << error;
    EXPECT_EQ(world->body_count(), scene.body_count()) << info.name;
    EXPECT_EQ(world->dynamic_count(), 200u) << info.name;
  }
}

TEST(SceneBuiltin, BodyThatIsRefusedIsNamed) {
  Scene scene = builtin_of("hourglass", 10);
  std::get<ChainShape>(scene.bodies[1].shape).vertices.clear();
  std::string error;
  EXPECT_FALSE(build_world(scene, RunOptions{}, error));
  EXPECT_EQ(error.rfind("bodies[1] \"right\": ", 0), 0u) << error;
  scene = builtin_of("dam", 10);
  scene.groups[0].radius_min = scene.groups[0].radius_max = 5;
  EXPECT_FALSE(build_world(scene, RunOptions{}, error));
  EXPECT_EQ(error.rfind("groups[0]: a cell of the lattice", 0), 0u) << error;
}

}  // namespace
}  // namespace psim::test
