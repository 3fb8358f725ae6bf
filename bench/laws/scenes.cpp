#include "scenes.h"

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include "shapes.h"

namespace psim::laws {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kHalfWay = 20;  // m: the terrain goes from -kHalfWay to kHalfWay

void add(Scene& scene, BodyDesc body) {
  scene.bodies.push_back(std::move(body));
  scene.body_names.emplace_back();
}

// The height of a terrain, m, and whether it is flat.
struct Profile {
  std::function<double(double)> height;
  bool flat = false;
};

Profile draw_profile(Draw& draw) {
  switch (draw.below(5)) {
    case 0:
      return {[](double) { return 0.0; }, true};
    case 1: {
      const double slope = draw.uniform(-0.4, 0.4);
      return {[slope](double x) { return slope * x; }, false};
    }
    case 2: {
      const double top = draw.uniform(0.3, 2), half = draw.uniform(4, 10);
      return {[=](double x) { return std::fabs(x) < half ? top * (1 + std::cos(kPi * x / half)) / 2 : 0; }, false};
    }
    case 3: {
      const double bend = draw.uniform(0.01, 0.06);
      return {[bend](double x) { return bend * x * x; }, false};
    }
    default: {
      const double a = draw.uniform(0.1, 0.8), b = draw.uniform(0.1, 0.4), p = draw.uniform(0, 6);
      return {[=](double x) { return a * std::sin(0.4 * x + p) + b * std::sin(1.1 * x); }, false};
    }
  }
}

// The ground as one row of boxes of different lengths, flush.
void add_boxes(Draw& draw, Scene& scene, const Material& material) {
  for (double x = -kHalfWay; x < kHalfWay;) {
    const double wide = draw.uniform(0.5, 4);
    add(scene, fixed_of(BoxShape{wide, 1, 0}, {x + wide / 2, -0.5}, material));
    x += wide;
  }
}

JointDesc draw_joint(Draw& draw, JointType type, double r) {
  JointDesc j;
  j.type = type;
  const auto anchor = [&] {
    return draw.chance(0.4) ? Vec2{} : Vec2{draw.uniform(-0.9, 0.9) * r, draw.uniform(-0.9, 0.9) * r};
  };
  j.anchor_a = anchor();
  j.anchor_b = anchor();
  return j;
}

}  // namespace

Scene space(bool gravity) {
  Scene scene;
  scene.name = "law";
  scene.world.bounds = {-512, -512, 512, 512};
  scene.world.boundary = Boundary::open;
  scene.world.gravity = {0, gravity ? -9.81 : 0};
  scene.world.sleeping = false;
  return scene;
}

BodyDesc body_of(Shape shape, Vec2 at, const Material& material) {
  BodyDesc body;
  body.shape = std::move(shape);
  body.position = at;
  body.material = material;
  return body;
}

BodyDesc fixed_of(Shape shape, Vec2 at, const Material& material) {
  BodyDesc body = body_of(std::move(shape), at, material);
  body.type = BodyType::static_body;
  return body;
}

BodyDesc mover_of(Draw& draw, Shape shape, Vec2 at, double speed, double spin, const Material& material) {
  BodyDesc body = body_of(std::move(shape), at, material);
  const double way = draw.uniform(0, 2 * kPi), fast = draw.uniform(0, speed);
  body.velocity = {fast * std::cos(way), fast * std::sin(way)};
  body.angle = draw.chance(0.3) ? 0 : draw.uniform(-kPi, kPi);
  body.angular_velocity = draw.uniform(-spin, spin);
  return body;
}

void add_terrain(Draw& draw, Scene& scene, const Material& material) {
  const Profile profile = draw_profile(draw);
  if (profile.flat && draw.chance(0.4)) {
    if (draw.chance(0.5)) return add_boxes(draw, scene, material);
    const PolygonShape block{{{-kHalfWay, -2}, {kHalfWay, -2}, {kHalfWay, 0}, {-kHalfWay, 0}}, 0};
    return add(scene, fixed_of(block, {}, material));
  }
  const int parts = draw.one_of(std::array{1, 3, 20, 60, 200});
  ChainShape chain;
  for (int k = 0; k <= parts; ++k) {
    const double x = kHalfWay * (2.0 * k / parts - 1);
    chain.vertices.push_back({x, profile.height(x)});
  }
  if (draw.chance(0.5)) chain.vertices = {chain.vertices.rbegin(), chain.vertices.rend()};
  if (draw.chance(0.6)) return add(scene, fixed_of(chain, {}, material));
  for (int k = 0; k < parts; ++k) {
    const auto n = static_cast<std::size_t>(k);
    add(scene, fixed_of(SegmentShape{chain.vertices[n], chain.vertices[n + 1]}, {}, material));
  }
}

Scene one_on_terrain(Draw& draw) {
  Scene scene = space(true);
  const double r = draw.logarithmic(0.1, 1);
  add(scene, mover_of(draw, draw_shape(draw, r), {draw.uniform(-6, 6), 0}, 8, 5, draw_material(draw)));
  add_terrain(draw, scene, draw_material(draw));
  // Above the highest ground near it: over a line it is the line's height, over a row of boxes 0.
  double ground = -1e300;
  const double x = scene.bodies[0].position.x;
  for (std::size_t id = 1; id < scene.bodies.size(); ++id) {
    ChainShape line;
    if (const auto* s = std::get_if<ChainShape>(&scene.bodies[id].shape)) line = *s;
    if (const auto* s = std::get_if<SegmentShape>(&scene.bodies[id].shape)) line.vertices = {s->p1, s->p2};
    if (line.vertices.empty()) ground = std::fmax(ground, 0);
    for (std::size_t k = 0; k + 1 < line.vertices.size(); ++k) {
      const Vec2 p = line.vertices[k], q = line.vertices[k + 1];
      const double low = std::fmin(p.x, q.x), high = std::fmax(p.x, q.x);
      if (high < x - r || low > x + r) continue;
      for (const double at : {std::fmax(low, x - r), std::fmin(high, x + r)}) {
        ground = std::fmax(ground, p.y + (q.y - p.y) * (at - p.x) / (q.x - p.x));
      }
    }
  }
  scene.bodies[0].position.y = ground + 1.01 * r + (draw.chance(0.4) ? 0.01 : draw.uniform(0, 2));
  return scene;
}

Scene one_on_a_joint(Draw& draw) {
  Scene scene = space(true);
  const double r = draw.logarithmic(0.1, 1);
  const JointType type = draw.one_of(
      std::array{JointType::distance, JointType::rope, JointType::spring, JointType::revolute, JointType::prismatic});
  const bool together = type == JointType::revolute;
  const double way = draw.uniform(-kPi, kPi), far = together ? 0 : draw.logarithmic(0.1, 3);
  BodyDesc bob = mover_of(draw, draw_shape(draw, r), {}, 5, 5, draw_material(draw));
  JointDesc joint = draw_joint(draw, type, r);
  joint.anchor_a = {};
  const double c = std::cos(bob.angle), s = std::sin(bob.angle);
  const Vec2 arm{c * joint.anchor_b.x - s * joint.anchor_b.y, s * joint.anchor_b.x + c * joint.anchor_b.y};
  bob.position = {far * std::cos(way) - arm.x, far * std::sin(way) - arm.y};
  bob.filter.mask = 0;
  // Bodies start as the joint lets them move: turning about the anchor, or from rest.
  bob.velocity = together ? Vec2{bob.angular_velocity * arm.y, -bob.angular_velocity * arm.x} : Vec2{};
  if (!together) bob.angular_velocity = 0;
  if (type == JointType::spring) {
    joint.stiffness = draw.logarithmic(5, 500);
    joint.damping = draw.chance(0.5) ? 0 : draw.logarithmic(0.1, 5);
  }
  if (type == JointType::prismatic) joint.axis = {std::cos(way), std::sin(way)};
  add(scene, bob);
  add(scene, fixed_of(DiscShape{0.05}, {}, {}));
  scene.joints.push_back({1, 0, joint});
  return scene;
}

Scene one_mover(Draw& draw) { return draw.chance(0.7) ? one_on_terrain(draw) : one_on_a_joint(draw); }

Scene two_that_meet(Draw& draw) {
  Scene scene = space(false);
  const double a = draw.logarithmic(0.2, 1), b = draw.logarithmic(0.2, 1);
  const double way = draw.uniform(-kPi, kPi), fast = draw.logarithmic(1, 20), aside = draw.uniform(-0.7, 0.7) * (a + b);
  const double far = a + b + draw.uniform(0.1, 0.5) * fast;
  const Vec2 u{std::cos(way), std::sin(way)};
  BodyDesc one = mover_of(draw, draw_shape(draw, a), {}, 0, 5, draw_material(draw));
  BodyDesc other = mover_of(draw, draw_shape(draw, b), {far * u.x - aside * u.y, far * u.y + aside * u.x}, 0, 5,
                            draw_material(draw));
  one.velocity = {fast * u.x / 2, fast * u.y / 2};
  other.velocity = {-fast * u.x / 2, -fast * u.y / 2};
  add(scene, one);
  add(scene, other);
  return scene;
}

void add_pen(Draw& draw, Scene& scene, const Material& material) {
  switch (draw.below(3)) {
    case 0:
      scene.world.bounds = {-6, -6, 6, 6};
      scene.world.boundary = Boundary::walls;
      scene.world.wall = material;
      return;
    case 1: {
      ChainShape loop{{{-6, -6}, {6, -6}, {6, 6}, {-6, 6}}, true};
      if (draw.chance(0.5)) loop.vertices = {loop.vertices.rbegin(), loop.vertices.rend()};
      return add(scene, fixed_of(loop, {}, material));
    }
    default:
      for (const double side : {-6.5, 6.5}) {
        add(scene, fixed_of(BoxShape{14, 1, 0}, {0, side}, material));
        add(scene, fixed_of(BoxShape{1, 14, 0}, {side, 0}, material));
      }
  }
}

void fill_pen(Draw& draw, Scene& scene, int count, double speed, bool discs_only, const Material* material) {
  const int columns = static_cast<int>(std::ceil(std::sqrt(count)));
  const double cell = 11.6 / columns;
  for (int k = 0; k < count; ++k) {
    const double r = cell * draw.uniform(0.15, 0.45);
    const Vec2 at{-5.8 + cell * (k % columns + 0.5), -5.8 + cell * (k / columns + 0.5)};
    const Shape shape = discs_only ? DiscShape{r} : draw_shape(draw, r);
    add(scene, mover_of(draw, shape, at, speed, discs_only ? 0 : 3, material ? *material : draw_material(draw)));
  }
}

Scene jointed(Draw& draw) {
  Scene scene = space(draw.chance(0.8));
  const int count = draw.from(1, 6);
  const bool hung = draw.chance(0.7);
  add(scene, hung ? fixed_of(DiscShape{0.05}, {}, {}) : body_of(DiscShape{0.3}, {}, {}));
  scene.bodies[0].filter.mask = 0;
  for (int k = 1; k <= count; ++k) {
    const double r = draw.logarithmic(0.2, 0.8);
    const JointType type =
        draw.one_of(std::array{JointType::distance, JointType::rope, JointType::spring, JointType::revolute,
                               JointType::weld, JointType::distance, JointType::revolute});
    const bool together = type == JointType::revolute || type == JointType::weld;
    const int parent = draw.chance(0.7) ? k - 1 : draw.below(k);
    const BodyDesc& held = scene.bodies[static_cast<std::size_t>(parent)];
    JointDesc joint = draw_joint(draw, type, r);
    if (parent == 0) joint.anchor_a = {};
    BodyDesc body = body_of(draw_shape(draw, r), {}, draw_dull(draw));
    if (draw.chance(0.3)) body.mass = draw.logarithmic(0.1, 100);
    const double way = draw.uniform(-kPi, kPi), far = together ? 0 : draw.logarithmic(0.05, 2);
    body.position = {held.position.x + joint.anchor_a.x + far * std::cos(way) - joint.anchor_b.x,
                     held.position.y + joint.anchor_a.y + far * std::sin(way) - joint.anchor_b.y};
    body.filter.mask = 0;
    if (type == JointType::spring) joint.stiffness = draw.logarithmic(5, 500);
    if (type == JointType::weld && draw.chance(0.3)) joint.stiffness = draw.logarithmic(5, 500);
    add(scene, body);
    scene.joints.push_back({static_cast<std::uint64_t>(parent), static_cast<std::uint64_t>(k), joint});
  }
  if (!hung) {
    for (BodyDesc& b : scene.bodies) {  // apart from each other: joints have to pull
      b.velocity = {draw.uniform(-3, 3), draw.uniform(-3, 3)};
    }
  }
  return scene;
}

}  // namespace psim::laws
