// World and bodies of a R.U.B.E. scene. Each fixture of a body is a part of it here.
#include "file/rube.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "bodies/hull.h"
#include "file/parse_limits.h"
#include "place/shape_size.h"

namespace psim::scene {
namespace {

constexpr std::array<std::string_view, 4> kRubeShapes = {"circle", "polygon", "chain", "edge"};
// Of the body's mass: what a fixture without density weighs.
constexpr double kMassless = 1e-3;

// A fixture, in the frame of its body.
struct Part {
  ShapePart part;
  double density = 0;    // kg/m^2; 0: it weighs nothing
  Vec2 centre;           // of mass
  double area = 0;       // mass / density
  double gyration2 = 0;  // inertia about the centre / mass, m^2
};

struct Counts {
  std::size_t unused = 0, massless = 0;
  std::string first_unused, first_massless;

  static void note(std::size_t& count, std::string& first, const Node& body) {
    if (count++ == 0) first = path_text(body.path());
  }
};

std::vector<Vec2> read_vertices(const Node& node, std::size_t least, std::size_t most) {
  node.expect_object();
  const Node x = node.require("x"), y = node.require("y");
  x.expect_array(least, most);
  y.expect_array(least, most);
  if (x.size() != y.size()) {
    y.fail(count_text(y.size()) + ", \"x\" has " + std::to_string(x.size()) + ": as many");
  }
  std::vector<Vec2> vertices;
  for (std::size_t k = 0; k < x.size(); ++k) {
    vertices.push_back(
        {rube_number(x.element(k), limits::kCoordinate), rube_number(y.element(k), limits::kCoordinate)});
  }
  return vertices;
}

PartShape read_rube_chain(const Node& chain) {
  const Node node = chain.require("vertices");
  ChainShape shape{read_vertices(node, 2, kMostChainVertices), false};
  const auto same = [](Vec2 a, Vec2 b) { return a.x == b.x && a.y == b.y; };
  std::vector<Vec2>& v = shape.vertices;
  v.erase(std::unique(v.begin(), v.end(), same), v.end());
  if (v.size() > 3 && same(v.front(), v.back())) {
    v.pop_back();
    shape.loop = true;
  }
  if (v.size() < 2) node.fail("are all one point: two apart from each other");
  return shape;
}

// Of a fixture; a circle is a disc at `centre`.
PartShape read_shape(const Node& fixture, Vec2& centre) {
  centre = {};
  std::optional<Node> node;
  std::string_view kind;
  for (const std::string_view candidate : kRubeShapes) {
    if (const std::optional<Node> found = fixture.find(candidate)) {
      if (node) fixture.fail("has two shapes: one of " + word_list(kRubeShapes));
      node.emplace(*found);
      kind = candidate;
    }
  }
  if (!node) fixture.fail("has no shape: one of " + word_list(kRubeShapes));
  const Node shape = fixture.require(kind);
  shape.expect_object();
  if (kind == "circle") {
    centre = rube_vec2_or(shape, "center", {}, limits::kCoordinate);
    return DiscShape{rube_number(shape.require("radius"), limits::kRadius)};
  }
  if (kind == "edge") {
    return SegmentShape{rube_vec2_or(shape, "vertex1", {}, limits::kCoordinate),
                        rube_vec2_or(shape, "vertex2", {}, limits::kCoordinate)};
  }
  if (kind == "chain") return read_rube_chain(shape);
  const Node vertices = shape.require("vertices");
  return PolygonShape{read_vertices(vertices, 3, kMostPolygonVertices), 0};
}

Part read_fixture(const Node& node, const BodyDesc& body) {
  node.expect_object();
  Part out;
  ShapePart& part = out.part;
  part.shape = read_shape(node, part.position);
  const bool line = std::holds_alternative<ChainShape>(part.shape) || std::holds_alternative<SegmentShape>(part.shape);
  if (line && body.type == BodyType::dynamic_body) {
    node.fail("is a chain or an edge of a dynamic body (type 2): types 0 and 1 only");
  }
  HullSet hulls;
  std::string error;
  if (!make_hulls(shape_of(part), true, hulls, error)) node.fail(std::move(error));
  out.area = hulls.mass.area;
  out.gyration2 = hulls.mass.inertia;
  out.centre = part.position + hulls.mass.centre;
  out.density = rube_number_or(node, "density", 0, {0, limits::kDensity.max});
  part.friction = rube_number_or(node, "friction", 0, limits::kFriction);
  part.restitution = rube_number_or(node, "restitution", 0, limits::kRestitution);
  Filter filter;
  constexpr std::int64_t k16Bits = 0xFFFF, kInt16 = 0x8000;
  if (const auto bits = node.find("filter-categoryBits")) {
    filter.category = static_cast<std::uint32_t>(bits->signed_integer(0, k16Bits));
  }
  if (const auto bits = node.find("filter-maskBits")) {
    const std::int64_t mask = bits->signed_integer(-kInt16, k16Bits) & k16Bits;
    if (mask != k16Bits) filter.mask = static_cast<std::uint32_t>(mask);
  }
  if (const auto group = node.find("filter-groupIndex")) {
    filter.group = static_cast<std::int32_t>(group->signed_integer(-kInt16, kInt16 - 1));
  }
  part.filter = filter;
  part.sensor = node.boolean_or("sensor", false);
  return out;
}

// In the place of the fixtures of a body that has none, but joints hold on to it.
Part nothing_to_touch() {
  Part out;
  out.part.shape = DiscShape{0.1};
  out.part.filter = Filter{0, 0, 0};
  out.part.sensor = true;
  out.area = 3.14159265358979323846 * 0.01;
  out.gyration2 = 0.005;
  return out;
}

// The parts' densities, and the mass and inertia of the body as a whole.
void weigh(std::vector<Part>& parts, const Node& node, RubeBody& body, Counts& counts) {
  double mass = 0;
  for (const Part& part : parts) mass += part.area * part.density;
  const bool massless = !(mass > 0);
  if (massless) mass = rube_number_or(node, "massData-mass", 1, {0, limits::kMass.max});
  if (!(mass > 0)) mass = 1;
  Vec2 centre;
  double total = 0;
  for (Part& part : parts) {
    double own = part.area * part.density;
    if (!(own > 0)) {
      if (parts.size() > 1) Counts::note(counts.massless, counts.first_massless, node);
      own = massless ? mass / static_cast<double>(parts.size()) : kMassless * mass;
    }
    part.density = std::clamp(own / part.area, limits::kDensity.min, limits::kDensity.max);
    centre = centre + own * part.centre;
    total += own;
  }
  centre = {centre.x / total, centre.y / total};
  body.mass = total;
  body.inertia = 0;
  for (const Part& part : parts) {
    const Vec2 arm = part.centre - centre;
    body.inertia += part.area * part.density * (part.gyration2 + dot(arm, arm));
  }
}

// Gives a body its parts: a shape, where one stands in the body's frame, else a compound.
void put_parts(std::vector<Part>& parts, BodyDesc& body) {
  const ShapePart& first = parts[0].part;
  if (parts.size() == 1 && first.position.x == 0 && first.position.y == 0) {
    body.shape = shape_of(first);
    body.material = {std::max(parts[0].density, limits::kDensity.min), first.restitution.value_or(0),
                     first.friction.value_or(0)};
    body.filter = first.filter.value_or(Filter{});
    body.sensor = first.sensor.value_or(false);
    return;
  }
  CompoundShape all;
  for (Part& part : parts) {
    all.parts.push_back(std::move(part.part));
    all.parts.back().density = std::max(part.density, limits::kDensity.min);
  }
  body.shape = std::move(all);
}

BodyDesc read_body_keys(const Node& node) {
  constexpr std::array<BodyType, 3> kOf = {BodyType::static_body, BodyType::kinematic_body, BodyType::dynamic_body};
  BodyDesc body;
  body.type = BodyType::static_body;
  if (const auto type = node.find("type")) body.type = kOf[type->integer(0, 2)];
  body.position = rube_vec2_or(node, "position", {}, limits::kCoordinate);
  body.angle = rube_number_or(node, "angle", 0, limits::kAngle);
  const Vec2 velocity = rube_vec2_or(node, "linearVelocity", {}, limits::kVelocity);
  const double angular_velocity = rube_number_or(node, "angularVelocity", 0, limits::kAngularVelocity);
  if (body.type != BodyType::static_body) {
    body.velocity = velocity;
    body.angular_velocity = angular_velocity;
  }
  body.gravity_scale = rube_number_or(node, "gravityScale", 1, limits::kGravityScale);
  body.bullet = node.boolean_or("bullet", false);
  body.fixed_rotation = node.boolean_or("fixedRotation", false);
  body.linear_damping = rube_number_or(node, "linearDamping", 0, limits::kDamping);
  body.angular_damping = rube_number_or(node, "angularDamping", 0, limits::kDamping);
  return body;
}

// Which bodies joints name.
std::set<std::uint64_t> jointed_bodies(const Node& root) {
  std::set<std::uint64_t> named;
  const auto joints = root.find("joint");
  if (!joints || !joints->is_array()) return named;
  for (std::size_t k = 0; k < joints->size(); ++k) {
    const Node joint = joints->element(k);
    joint.expect_object();
    for (const std::string_view key : {"bodyA", "bodyB"}) {
      const auto body = joint.find(key);
      if (body && body->json().is_number_unsigned()) {
        named.insert(body->json().get<std::uint64_t>());
      }
    }
  }
  return named;
}

RubeBody read_body(const Node& node, bool jointed, Scene& scene, std::set<std::string>& names, Counts& counts) {
  node.expect_object();
  RubeBody out;
  BodyDesc body = read_body_keys(node);
  out.type = body.type;
  std::vector<Part> parts;
  if (const auto fixtures = node.find("fixture")) {
    fixtures->expect_array(0, 100'000);
    for (std::size_t k = 0; k < fixtures->size(); ++k) parts.push_back(read_fixture(fixtures->element(k), body));
  }
  if (parts.empty()) {
    if (!jointed) {
      Counts::note(counts.unused, counts.first_unused, node);
      return out;
    }
    parts.push_back(nothing_to_touch());
  }
  if (body.type == BodyType::dynamic_body) weigh(parts, node, out, counts);
  put_parts(parts, body);
  out.in_scene = true;
  out.id = scene.bodies.size();
  std::string name;
  if (const auto key = node.find("name")) name = key->name();
  if (!name.empty() && !names.insert(name).second) name.clear();  // they may repeat there
  scene.bodies.push_back(std::move(body));
  scene.body_names.push_back(std::move(name));
  return out;
}

// An open world, three times as wide and high as all there is and 100 m more on every side, or as large as worlds are.
Bounds roomy_bounds(const Scene& scene, const Node& bodies) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Bounds all{kFar, kFar, -kFar, -kFar};
  for (const BodyDesc& body : scene.bodies) {
    const Bounds own = extent(body.shape, body.position, body.angle);
    all = {std::min(all.xmin, own.xmin), std::min(all.ymin, own.ymin), std::max(all.xmax, own.xmax),
           std::max(all.ymax, own.ymax)};
  }
  if (!(all.xmin <= all.xmax)) all = {0, 0, 0, 0};
  const double size = std::max(all.xmax - all.xmin, all.ymax - all.ymin);
  const double most = limits::kExtent.max - 2;  // whole metres
  if (size > most) bodies.fail("reach over " + exact_text(size) + " m: at most " + exact_text(most));
  const auto side = [&](double low, double high, double& from, double& to) {
    const double room = std::min(size + 100, (most - (high - low)) / 2);
    from = std::max(std::floor(low - room), limits::kCoordinate.min);
    to = std::min(std::ceil(high + room), limits::kCoordinate.max);
  };
  Bounds bounds;
  side(all.xmin, all.xmax, bounds.xmin, bounds.xmax);
  side(all.ymin, all.ymax, bounds.ymin, bounds.ymax);
  return bounds;
}

void add_note(Scene& scene, std::size_t count, const std::string& first, const char* one, const char* what) {
  if (count == 0) return;
  std::string line = first;
  if (count > 1) line += " and " + std::to_string(count - 1) + " more";
  scene.notes.push_back(line + ": " + one + what);
}

}  // namespace

double rube_number(const Node& node, Range range) {
  if (!node.is_string()) return node.number(range);
  const std::string& text = node.string();
  std::uint32_t bits = 0;
  const auto end = std::from_chars(text.data(), text.data() + text.size(), bits, 16);
  if (text.size() != 8 || end.ptr != text.data() + text.size()) {
    node.fail("must be a number, or the eight hex digits of a float");
  }
  const double value = std::bit_cast<float>(bits);
  if (!range.contains(value)) node.fail(exact_text(value) + " is out of range: a number " + range_text(range));
  return value;
}

double rube_number_or(const Node& parent, std::string_view key, double absent, Range range) {
  const auto node = parent.find(key);
  return node ? rube_number(*node, range) : absent;
}

Vec2 rube_vec2_or(const Node& parent, std::string_view key, Vec2 absent, Range range) {
  const auto node = parent.find(key);
  if (!node) return absent;
  if (node->is_number()) {
    if (node->number(range) != 0) node->fail("must be 0 or an object with \"x\" and \"y\"");
    return {0, 0};
  }
  node->expect_object();
  return {rube_number(node->require("x"), range), rube_number(node->require("y"), range)};
}

bool is_rube(const Node& root) {
  const auto bodies = root.find("body");
  return bodies && bodies->is_array() && !root.find("psim");
}

Scene read_rube(const Node& root) {
  Scene scene;
  scene.description = "from R.U.B.E.";
  scene.world.boundary = Boundary::open;
  scene.world.gravity = rube_vec2_or(root, "gravity", {0, -10}, limits::kGravity);
  if (const auto rate = root.find("stepsPerSecond")) {
    scene.world.dt = 1 / rube_number(*rate, {1, 1e6});
  }
  scene.world.sleeping = root.boolean_or("allowSleep", true);

  const Node nodes = root.require("body");
  nodes.expect_array(0, kMostBodiesInGroup);
  const std::set<std::uint64_t> jointed = jointed_bodies(root);
  std::set<std::string> names;
  std::vector<RubeBody> bodies;
  Counts counts;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    bodies.push_back(read_body(nodes.element(k), jointed.contains(k), scene, names, counts));
  }
  scene.world.bounds = roomy_bounds(scene, nodes);
  add_note(scene, counts.massless, counts.first_massless, "a fixture without density",
           " among others weighs a thousandth of its body");
  add_note(scene, counts.unused, counts.first_unused, "no fixture and no joint", ": left out");
  read_rube_joints(root, bodies, scene);
  return scene;
}

}  // namespace psim::scene
