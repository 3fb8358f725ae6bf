#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <utility>
#include <variant>
#include <vector>

#include "body_outlines.h"
#include "comparison.h"

namespace psim::peers {
namespace {

/// Bodies of the three sizes.
struct Bodies {
  std::uint64_t quick, normal, full;
  std::uint64_t of(Size size) const { return size == Size::quick ? quick : size == Size::normal ? normal : full; }
};

/// Level ground of a segment becomes a box under it, which engines of solid bodies have, too.
void put_boxes_for_floors(Scene& scene) {
  constexpr double kThickness = 0.5;
  for (BodyDesc& body : scene.bodies) {
    const auto* line = std::get_if<SegmentShape>(&body.shape);
    if (!line || body.type != BodyType::static_body || line->p1.y != line->p2.y) continue;
    const double width = std::abs(line->p2.x - line->p1.x);
    body.position.x += (line->p1.x + line->p2.x) / 2;
    body.position.y += line->p1.y - kThickness / 2;
    body.shape = BoxShape{width, kThickness, 0};
  }
}

/// A drum, a kinematic body of several convex shapes, becomes a body a shape that turns about the same place: not every
/// engine here is given bodies of several shapes. For scenes without joints, which name bodies by number.
void put_bodies_for_drums(Scene& scene) {
  std::vector<BodyDesc> bodies;
  for (const BodyDesc& body : scene.bodies) {
    if (body.type != BodyType::kinematic_body || !std::holds_alternative<CompoundShape>(body.shape)) {
      bodies.push_back(body);
      continue;
    }
    for (const reference::Outline& outline : test::outlines(body.shape, {0, 0}, 0)) {
      PolygonShape polygon;
      for (const reference::Vec p : outline.points) polygon.vertices.push_back({p.x, p.y});
      polygon.radius = outline.radius;
      bodies.push_back(body);
      bodies.back().shape = std::move(polygon);
    }
  }
  scene.body_names.resize(bodies.size());
  scene.bodies = std::move(bodies);
}

std::function<Scene(Size)> builtin(const std::string& name, Bodies bodies) {
  return [name, bodies](Size size) {
    std::string error;
    auto scene = make_builtin(name, bodies.of(size), 1, error);
    if (!scene) throw std::runtime_error(error);
    put_boxes_for_floors(*scene);
    if (scene->joints.empty()) put_bodies_for_drums(*scene);
    return std::move(*scene);
  };
}

// Packing 0.2, speeds up to 5 m/s an axis, for as many collisions as they come to.
Scene gas(std::uint64_t n) {
  const double side = std::ceil(2 * std::sqrt(static_cast<double>(n)));
  Scene scene = accuracy::walled_scene(side, side, accuracy::material(1));
  GroupDesc discs;
  discs.count = n;
  discs.region = {0, 0, side, side};
  discs.jitter = 0.9;
  discs.velocity_spread = 5;
  discs.body.material = accuracy::material(1);
  scene.groups.push_back(discs);
  return scene;
}

Comparison scene_of(std::string name, std::string shows, std::function<Scene(Size)> scene, int settle, int frames) {
  Comparison c;
  c.name = std::move(name);
  c.shows = std::move(shows);
  c.scene = std::move(scene);
  c.settle = settle;
  c.frames = frames;
  return c;
}

}  // namespace

const std::vector<ErrorColumn>& error_columns() {
  static const std::vector<ErrorColumn> columns = {{"overlap_max_m", "overlap, m", &Errors::deepest},
                                                   {"overlap_p99_m", "overlap p99", &Errors::overlap_p99},
                                                   {"passed_walls", "got out", &Errors::passed_walls},
                                                   {"energy_drift", "energy", &Errors::energy_drift},
                                                   {"rest_speed_m_s", "rest, m/s", &Errors::rest_speed},
                                                   {"sway_m", "sway, m", &Errors::sway},
                                                   {"sink_m", "sink, m", &Errors::sink},
                                                   {"joint_gap_m", "joints, m", &Errors::joint_gap}};
  return columns;
}

std::vector<Comparison> all_comparisons() {
  std::vector<Comparison> all;
  all.push_back(scene_of("falling-pile", "a block of smooth discs falls into its box and lands",
                         builtin("pile", {500, 10'000, 100'000}), 0, 120));
  all.push_back(scene_of("settled-pile", "rough discs, 6 s after they were let fall",
                         builtin("rough-pile", {500, 3'000, 10'000}), 360, 60));
  all.back().rests = true;
  all.push_back(scene_of("mixed-radii", "rough discs of 5, 0.8 and 0.1 m fall on each other",
                         builtin("mixed-sizes", {500, 3'000, 10'000}), 0, 180));
  all.push_back(scene_of(
      "gas", "elastic discs without gravity, 5 s",
      [](Size size) {
        return gas(Bodies{300, 2'000, 10'000}.of(size));
      },
      0, 300));
  all.back().energy = true;
  all.push_back(scene_of("stack", "20 boxes, a centimetre to the left and right in turn, 10 s",
                         builtin("vertical_stack", {10, 20, 20}), 0, 600));
  all.back().rests = all.back().stands = true;
  all.push_back(
      scene_of("pyramid", "boxes, base 20, full size 100; 5 s", builtin("pyramid", {55, 210, 5'050}), 0, 300));
  all.back().rests = all.back().stands = true;
  all.push_back(
      scene_of("many-pyramids", "pyramids of 55 boxes, 2 s", builtin("many_pyramids", {110, 5'500, 22'000}), 0, 120));
  all.back().rests = all.back().stands = true;
  all.push_back(all.back());
  all.back().name = "sleeping-pyramids";
  all.back().shows = "the same with sleeping on, after 4 s";
  all.back().sleeping = true;
  all.back().settle = 240;
  all.back().frames = 60;
  all.push_back(scene_of("bridge",
                         "a row of planks pinned to each other between two fixed points, "
                         "and three discs let fall on it, 10 s",
                         builtin("bridge", {20, 100, 100}), 0, 600));
  all.push_back(scene_of("joint-grid", "a net of discs pinned to each other, let fall, 2 s",
                         builtin("joint_grid", {100, 2'500, 10'000}), 0, 120));
  all.push_back(scene_of("cloth", "discs tied by rods, hung by two corners; a ball is thrown in, 4 s",
                         builtin("cloth", {100, 900, 900}), 0, 240));
  all.push_back(
      scene_of("tumbler", "boxes in a drum that turns, after 2 s", builtin("tumbler", {225, 2'025, 2'025}), 120, 120));
  return all;
}

Comparison comparison_of_file(const std::string& path) {
  std::string error;
  auto scene = load_scene(path, error);
  if (!scene) throw std::invalid_argument(error);
  Comparison c = scene_of(
      std::filesystem::path(path).stem().string(), path, [scene = std::move(*scene)](Size) { return scene; }, 0, 300);
  return c;
}

Comparison comparison_of_builtin(const std::string& words) {
  const std::size_t begin = words.find(':') + 1, end = words.find(':', begin);
  const std::string name = words.substr(begin, end == std::string::npos ? end : end - begin);
  std::uint64_t bodies = 0;  // as many as the scene has by itself
  if (end != std::string::npos) {
    const char* const last = words.data() + words.size();
    const auto [at, wrong] = std::from_chars(words.data() + end + 1, last, bodies);
    if (wrong != std::errc() || at != last || bodies == 0) {
      throw std::invalid_argument("--scenes " + words + ": the number of bodies is no whole number from 1 on");
    }
  }
  std::string error;
  if (!make_builtin(name, bodies, 1, error)) throw std::invalid_argument("--scenes " + words + ": " + error);
  return scene_of(name, "psim's scene of this name", builtin(name.c_str(), {bodies, bodies, bodies}), 0, 300);
}

}  // namespace psim::peers
