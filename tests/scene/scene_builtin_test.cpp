// The built-in scenes: every one makes the discs that were asked for, in places where they can
// start, and says the same as its file in scenes/.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "place/links.h"
#include "place/placement.h"
#include "place/shape_size.h"
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

// The scenes of discs come first, `million` is the last of them.
std::vector<BuiltinScene> disc_scenes() {
  std::vector<BuiltinScene> scenes;
  for (const BuiltinScene& info : builtin_scenes()) {
    scenes.push_back(info);
    if (info.name == "million") break;
  }
  return scenes;
}

bool same(Vec2 a, Vec2 b) { return a.x == b.x && a.y == b.y; }
bool same(const Bounds& a, const Bounds& b) {
  return a.xmin == b.xmin && a.ymin == b.ymin && a.xmax == b.xmax && a.ymax == b.ymax;
}
bool same(const Material& a, const Material& b) {
  return a.density == b.density && a.restitution == b.restitution && a.friction == b.friction;
}
bool same(const std::vector<Vec2>& a, const std::vector<Vec2>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](Vec2 p, Vec2 q) { return same(p, q); });
}

bool same(const Shape& a, const Shape& b) {
  if (a.index() != b.index()) return false;
  return std::ranges::equal(outlines(a), outlines(b), [](const Outline& p, const Outline& q) {
    return p.radius == q.radius && p.line == q.line && p.closed == q.closed && same(p.points, q.points);
  });
}

bool same(const JointDesc& a, const JointDesc& b) {
  return a.type == b.type && same(a.anchor_a, b.anchor_a) && same(a.anchor_b, b.anchor_b) && a.length == b.length &&
         a.stiffness == b.stiffness && a.damping == b.damping && same(a.axis, b.axis) && a.reference == b.reference &&
         a.lower == b.lower && a.upper == b.upper && a.motor_speed == b.motor_speed && a.motor_limit == b.motor_limit &&
         a.collide == b.collide;
}

// All but shape and place.
bool same_body_keys(const BodyDesc& a, const BodyDesc& b) {
  return a.type == b.type && a.angle == b.angle && a.angular_velocity == b.angular_velocity &&
         same(a.material, b.material) && a.mass == b.mass && a.gravity_scale == b.gravity_scale &&
         a.fixed_rotation == b.fixed_rotation && a.bullet == b.bullet && a.sensor == b.sensor && a.filter == b.filter;
}

bool same(const Field& a, const Field& b) {
  if (a.index() != b.index()) return false;
  if (const auto* well = std::get_if<WellField>(&a)) {
    const auto& other = std::get<WellField>(b);
    return same(well->position, other.position) && well->strength == other.strength &&
           well->softening == other.softening && well->exponent == other.exponent && well->range == other.range;
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
  EXPECT_EQ(a.world.skin, b.world.skin);
  EXPECT_EQ(a.world.sleeping, b.world.sleeping);
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
    EXPECT_TRUE(same(a.groups[k].body.shape, b.groups[k].body.shape)) << "groups[" << k << "]";
    const PlacedGroup p = placed(a, k), q = placed(b, k);
    EXPECT_TRUE(p.x == q.x && p.y == q.y && p.radius == q.radius && p.vx == q.vx && p.vy == q.vy)
        << "groups[" << k << "]";
  }
  const auto joints_a = all_joints(a), joints_b = all_joints(b);
  ASSERT_EQ(joints_a.size(), joints_b.size());
  for (std::size_t k = 0; k < joints_a.size(); ++k) {
    EXPECT_TRUE(joints_a[k].a == joints_b[k].a && joints_a[k].b == joints_b[k].b &&
                same(joints_a[k].joint, joints_b[k].joint))
        << "joint " << k;
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
  for (const BuiltinScene& info : disc_scenes()) {
    if (info.default_particles < 1'000'000) {
      EXPECT_EQ(dynamic_discs(builtin_of(info.name)), info.default_particles) << info.name;
    }
    for (const std::uint64_t n : {1u, 2u, 3u, 4u, 5u, 6u, 7u, 10u, 16u, 17u, 99u, 101u, 1000u, 3001u}) {
      const Scene scene = builtin_of(info.name, n);
      EXPECT_EQ(dynamic_discs(scene), n) << info.name;
      EXPECT_GE(scene.body_count(), n) << info.name;
    }
  }
}

TEST(SceneBuiltin, StartsWithoutOverlapsAndInsideItsWalls) {
  for (const BuiltinScene& info : disc_scenes()) {
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
  for (const BuiltinScene& info : disc_scenes()) {
    const Scene a = builtin_of(info.name, 100, 1), b = builtin_of(info.name, 100, 2);
    const std::size_t last = a.groups.size() - 1;
    const PlacedGroup p = placed(a, last), q = placed(b, last), again = placed(a, last);
    EXPECT_TRUE(p.x != q.x || p.vx != q.vx) << info.name;
    EXPECT_TRUE(p.x == again.x && p.vx == again.vx) << info.name;
  }
}

// Bodies that move, all bodies, and joints, as published where a scene is.
TEST(SceneBuiltin, RigidScenesHaveTheirPublishedSizes) {
  struct Size {
    std::string_view name;
    std::uint64_t moving, bodies, joints;
  };
  const Size sizes[] = {{"large_pyramid", 5050, 5051, 0},
                        {"many_pyramids", 22'000, 22'020, 0},
                        {"joint_grid", 9993, 10'000, 19'794},
                        {"tumbler", 2025, 2026, 0},
                        {"washer", 8100, 8101, 0},
                        {"compounds", 3000, 3001, 0},
                        {"junkyard", 8001, 8002, 2},
                        {"rain", 11'000, 13'505, 10'000},
                        {"smash", 9601, 9601, 0},
                        {"spinner", 6077, 6078, 1},
                        {"card_house", 40, 41, 0},
                        {"arch", 21, 22, 0},
                        {"vertical_stack", 15, 16, 0},
                        {"stack_100", 100, 101, 0},
                        {"pyramid", 210, 211, 0},
                        {"high_mass_ratio_1", 165, 166, 0},
                        {"high_mass_ratio_2", 3, 4, 0},
                        {"high_mass_ratio_3", 3, 4, 0},
                        {"overlap_recovery", 10, 11, 0},
                        {"ball_and_chain", 31, 32, 31},
                        {"far_pyramid", 55, 56, 0},
                        {"rush", 400, 401, 0},
                        {"bridge", 163, 165, 161},
                        {"chain", 30, 31, 30},
                        {"newtons_cradle", 5, 6, 5},
                        {"domino_run", 201, 202, 0},
                        {"rope", 99, 100, 99},
                        {"cloth", 2499, 2501, 4900},
                        {"boxes_into_discs", 50'050, 50'050, 0}};
  EXPECT_EQ(std::size(sizes) + disc_scenes().size(), builtin_scenes().size());
  for (const Size& size : sizes) {
    const Scene scene = builtin_of(size.name);
    const SceneBodies bodies(scene);
    std::uint64_t moving = 0;
    for (std::uint64_t id = 0; id < scene.body_count(); ++id) {
      moving += bodies.type_of(id) == BodyType::dynamic_body;
    }
    EXPECT_EQ(moving, size.moving) << size.name;
    EXPECT_EQ(scene.body_count(), size.bodies) << size.name;
    EXPECT_EQ(all_joints(scene).size(), size.joints) << size.name;
  }
}

TEST(SceneBuiltin, RigidScenesOfAnySizeArePlacedInTheirWorld) {
  for (const BuiltinScene& info : builtin_scenes()) {
    for (const std::uint64_t n : {1u, 2u, 7u, 12u, 100u, 1001u}) {
      if (!info.sized) continue;
      const Scene scene = builtin_of(info.name, n), next = builtin_of(info.name, n + 1);
      EXPECT_GE(next.body_count(), scene.body_count() + 1) << info.name << n;
      std::string error;
      EXPECT_TRUE(parse_scene(scene_to_json(scene), "text", error)) << info.name << n << error;
    }
  }
}

TEST(SceneBuiltin, RigidScenesStartAsTheyShould) {
  // What their point is.
  const auto expected = [](std::string_view name, const std::string& line) {
    const auto says = [&](std::string_view words) { return line.find(words) != line.npos; };
    if (name == "card_house") return says("more than half its radius") || says("overlap by");
    if (name == "overlap_recovery") return says("overlap by");
    if (name == "spinner") return says("overlap by") || says("times lighter");
    if (name == "bridge" || name == "cloth") return says("has no slack");
    return says("times lighter") &&
           (name.starts_with("high_mass_ratio") || name == "ball_and_chain" || name == "smash" || name == "junkyard");
  };
  for (const BuiltinScene& info : builtin_scenes()) {
    for (const std::string& line : check_scene(builtin_of(info.name))) {
      if (info.name == "mixed-sizes" || expected(info.name, line)) continue;
      ADD_FAILURE() << info.name << ": " << line;
    }
  }
}

TEST(SceneBuiltin, OneOfFixedSizeSaysSo) {
  std::string error;
  EXPECT_TRUE(make_builtin("card_house", 40, 1, error)) << error;
  EXPECT_FALSE(make_builtin("card_house", 41, 1, error));
  EXPECT_EQ(error, "scene card_house with 41 particles: it always has 40");
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

// The scenes of discs have a file each, some of the others.
TEST(SceneBuiltin, FileSaysTheSame) {
  std::size_t files = 0;
  for (const BuiltinScene& info : builtin_scenes()) {
    SCOPED_TRACE(info.name);
    std::string error;
    const std::string path = PSIM_SOURCE_DIR "/scenes/" + std::string(info.name) + ".json";
    if (files >= disc_scenes().size() && !std::filesystem::exists(path)) continue;
    ++files;
    const auto file = load_scene(path, error);
    ASSERT_TRUE(file) << error;
    const Scene scene = builtin_of(info.name);
    EXPECT_EQ(file->name, scene.name);
    EXPECT_EQ(file->description, scene.description);
    expect_same_world(*file, scene);
    expect_same_bodies(*file, scene);
  }
  EXPECT_GT(files, disc_scenes().size());
}

TEST(SceneBuiltin, TextReadsBackToTheSameScene) {
  for (const BuiltinScene& info : builtin_scenes()) {
    SCOPED_TRACE(info.name);
    const Scene scene = builtin_of(info.name, info.sized ? 500 : 0);
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
  for (const BuiltinScene& info : disc_scenes()) {
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
