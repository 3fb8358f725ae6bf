#include "check/scene_kind.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <variant>
#include <vector>

#include "base/elementary.h"
#include "base/rotor.h"
#include "bodies/hull.h"
#include "number_text.h"
#include "place/links.h"
#include "place/placement.h"
#include "place/shape_size.h"

namespace psim {
namespace {

constexpr double kDense = 0.5;        // of the bodies' box
constexpr double kBouncyScene = 0.3;  // mean restitution
constexpr double kMixedMassRatio = 10;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double squared(double x) { return x * x; }

/// Sums over the dynamic bodies.
struct DiscSums {
  double count = 0, area = 0, mass = 0, speed2 = 0, diameter = 0, bounce = 0, rough = 0;
  double x = 0, y = 0;
  double cornered = 0;  // how many are no discs
  double lightest = kInfinity, heaviest = 0;
  double field_rate = 0;
  std::vector<double> masses;  // kg, by index of the body in the scene; 0: it is not dynamic
  Bounds box{kInfinity, kInfinity, -kInfinity, -kInfinity};

  double mean(double sum) const { return count > 0 ? sum / count : 0; }
  double width() const { return box.xmax - box.xmin; }
  double height() const { return box.ymax - box.ymin; }
};

double field_rate(const WorldDesc& world, Vec2 at, double speed) {
  double steepness = 0, drag = 0;
  for (const Field& field : world.fields) {
    if (const auto* well = std::get_if<WellField>(&field)) {
      const double d2 = squared(at.x - well->position.x) + squared(at.y - well->position.y);
      if (well->range > 0 && d2 > squared(well->range)) continue;
      const double s = d2 + squared(well->softening);
      if (s > 0) steepness += std::abs(well->strength) / power(s, 0.5 * (well->exponent + 1));
    } else if (const auto* resistance = std::get_if<DragField>(&field)) {
      drag += resistance->quadratic * speed;
    }
  }
  return std::sqrt(steepness) + drag;
}

void see(const WorldDesc& world, const BodyDesc& body, Vec2 at, Vec2 velocity, double radius, DiscSums& survey) {
  const double area = std::numbers::pi * radius * radius;
  const double mass = body.mass > 0 ? body.mass : body.material.density * area;
  const double speed = length_of(velocity);
  survey.count += 1;
  survey.area += area;
  survey.mass += mass;
  survey.masses.back() = mass;
  survey.speed2 += speed * speed;
  survey.diameter += 2 * radius;
  survey.bounce += body.material.restitution;
  survey.rough += body.material.friction > 0 ? 1 : 0;
  survey.cornered += is_disc(body.shape) ? 0 : 1;
  survey.x += at.x;
  survey.y += at.y;
  survey.lightest = std::min(survey.lightest, mass);
  survey.heaviest = std::max(survey.heaviest, mass);
  survey.field_rate = std::max(survey.field_rate, field_rate(world, at, speed));
  survey.box = {std::min(survey.box.xmin, at.x - radius), std::min(survey.box.ymin, at.y - radius),
                std::max(survey.box.xmax, at.x + radius), std::max(survey.box.ymax, at.y + radius)};
}

// A shape that is no disc counts as the disc of its area.
double radius_of(const Shape& shape) {
  if (const auto* disc = std::get_if<DiscShape>(&shape)) return disc->radius;
  HullSet hulls;
  std::string error;
  if (!make_hulls(shape, true, hulls, error)) return bounding_radius(shape);
  return std::sqrt(hulls.mass.area / std::numbers::pi);
}

DiscSums sums_of(const Scene& scene) {
  DiscSums survey;
  for (const BodyDesc& body : scene.bodies) {
    survey.masses.push_back(0);
    if (body.type != BodyType::dynamic_body) continue;
    see(scene.world, body, body.position, body.velocity, radius_of(body.shape), survey);
  }
  for (std::size_t k = 0; k < scene.groups.size(); ++k) {
    const GroupDesc group = seeded_group(scene, k);
    const std::size_t first = survey.masses.size();
    if (group.body.type != BodyType::dynamic_body) {
      survey.masses.resize(first + group.count);
      continue;
    }
    std::string error;
    const std::optional<PlacedGroup> placed = place_group(group, error);
    if (!placed) continue;  // whoever builds the world says so
    const bool discs = is_disc(group.body.shape);
    const double radius = discs ? 0 : radius_of(group.body.shape);
    for (std::size_t i = 0; i < placed->x.size(); ++i) {
      survey.masses.push_back(0);
      if (is_pinned(group, i)) continue;
      see(scene.world, group.body, {placed->x[i], placed->y[i]}, {placed->vx[i], placed->vy[i]},
          discs ? placed->radius[i] : radius, survey);
    }
  }
  return survey;
}

bool has_fields(const WorldDesc& world) {
  return std::ranges::any_of(world.fields, [](const Field& field) {
    const auto* drag = std::get_if<DragField>(&field);
    return std::holds_alternative<WellField>(field) || (drag != nullptr && drag->quadratic > 0);
  });
}

/// How far the mean disc is above the lowest place of `box`, m.
double drop(const DiscSums& s, const Bounds& box, Vec2 gravity, double g) {
  const auto along = [&](double x, double y) { return (x * gravity.x + y * gravity.y) / g; };
  double lowest = -kInfinity;
  for (const double x : {box.xmin, box.xmax}) {
    for (const double y : {box.ymin, box.ymax}) lowest = std::max(lowest, along(x, y));
  }
  return lowest - along(s.mean(s.x), s.mean(s.y));
}

double collision_rate(const DiscSums& s, const WorldDesc& world, double g) {
  const Bounds& room = world.boundary == Boundary::open ? s.box : world.bounds;
  const double covered = std::min(s.area / ((room.xmax - room.xmin) * (room.ymax - room.ymin)), 0.7);
  const double fall = g > 0 ? 2 * g * drop(s, room, world.gravity, g) : 0;
  const double speed = std::sqrt(s.mean(s.speed2) + fall);
  const double crowding = (1 - 7 * covered / 16) / squared(1 - covered);
  return 8 * covered * crowding * speed / (s.mean(s.diameter) * std::sqrt(2 * std::numbers::pi));
}

double load_rate(const DiscSums& s, const WorldDesc& world, double g, bool dense) {
  const bool upright = std::abs(world.gravity.y) >= std::abs(world.gravity.x);
  const Bounds& room = dense || world.boundary == Boundary::open ? s.box : world.bounds;
  const double width = upright ? room.xmax - room.xmin : room.ymax - room.ymin;
  return std::sqrt(s.mass * g / (width * s.lightest));
}

bool has_joints(const Scene& scene) {
  return !scene.joints.empty() ||
         std::ranges::any_of(scene.groups, [](const GroupDesc& group) { return group.links.has_value(); });
}

/// The largest mass of dynamic bodies that hang together by joints and links, kg.
double heaviest_joined(const Scene& scene, const DiscSums& s) {
  std::vector<std::size_t> parent(s.masses.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root = [&](std::size_t k) {
    while (parent[k] != k) k = parent[k] = parent[parent[k]];
    return k;
  };
  const auto join = [&](std::size_t a, std::size_t b) {
    if (std::max(a, b) < parent.size() && s.masses[a] > 0 && s.masses[b] > 0) parent[root(a)] = root(b);
  };
  for (const SceneJoint& joint : scene.joints) join(joint.a, joint.b);
  std::size_t first = scene.bodies.size();
  for (const GroupDesc& group : scene.groups) {
    const std::size_t end = std::min<std::size_t>(first + group.count, parent.size());
    std::size_t last = first;
    for (std::size_t k = first; group.links && k < end; ++k) {
      if (!(s.masses[k] > 0)) continue;  // pinned
      join(last, k);
      last = k;
    }
    first += group.count;
  }
  std::vector<double> sums(parent.size());
  for (std::size_t k = 0; k < parent.size(); ++k) sums[root(k)] += s.masses[k];
  return sums.empty() ? 0 : std::ranges::max(sums);
}

double joint_rate(const Scene& scene, const DiscSums& s, double g) {
  if (s.count == 0) return 0;
  const double size = s.mean(s.diameter), acceleration = std::max(g, s.mean(s.speed2) / size);
  return std::sqrt(acceleration / size * (heaviest_joined(scene, s) / s.lightest));
}

}  // namespace

std::optional<SceneKind> parse_scene_kind(std::string_view name) {
  for (std::size_t k = 0; k < kSceneKindNames.size(); ++k) {
    if (kSceneKindNames[k] == name) return static_cast<SceneKind>(k);
  }
  return std::nullopt;
}

SceneTraits traits_of(const Scene& scene) {
  const WorldDesc& world = scene.world;
  const DiscSums s = sums_of(scene);
  const double g = length_of(world.gravity);
  const bool dense = s.count > 0 && s.area > kDense * s.width() * s.height();
  SceneTraits traits;
  traits.moving = static_cast<std::uint64_t>(s.count);
  traits.size = s.mean(s.diameter);
  if (has_fields(world)) {
    traits.kind = SceneKind::fields;
    traits.because = "wells or quadratic drag";
    traits.rate = s.field_rate;
  } else if (has_joints(scene)) {
    traits.kind = SceneKind::joints;
    traits.because = "joints";
    traits.rate = joint_rate(scene, s, g);
  } else if (s.count == 0 || g == 0 || (s.mean(s.bounce) >= kBouncyScene && !dense)) {
    traits.kind = s.cornered > 0 ? SceneKind::elastic_shapes : SceneKind::gas;
    traits.because = g == 0 ? "no gravity" : "restitution of 0.3 or more, less than half of the box covered";
    traits.rate = s.count == 0 ? 0 : collision_rate(s, world, g);
  } else {
    const double ratio = s.heaviest / s.lightest;
    traits.rate = load_rate(s, world, g, dense);
    if (s.cornered > 0) {
      traits.kind = SceneKind::shapes;
      traits.because = "gravity, bodies that are no discs";
    } else if (ratio >= kMixedMassRatio) {
      traits.kind = SceneKind::mixed_masses;
      traits.because = "gravity, masses up to 1 : " + number_text(std::round(ratio));
    } else {
      traits.kind = s.rough > 0 ? SceneKind::rough_pile : SceneKind::pile;
      traits.because = s.rough > 0 ? "gravity and friction" : "gravity, no friction";
    }
  }
  return traits;
}

}  // namespace psim
