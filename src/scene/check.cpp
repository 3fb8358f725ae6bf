// `--check`: what would go wrong when a scene runs. Every rule looks at the sizes, speeds and masses
// of the bodies as they are placed, and says one line: who, what, and the setting that mends it.
// O(n log n) for n bodies; a million in about a second.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "number_text.h"
#include "overlaps.h"
#include "placement.h"
#include "psim/scene.h"

namespace psim {
namespace {

constexpr double kMostMassRatio = 100;
constexpr double kMostSizeRatio = 1000;
constexpr double kLongestDt = 1.0 / 30;
constexpr double kLatticeStepsPerRadius = 100;
constexpr double kBouncy = 0.9;
constexpr int kSubstepsToBounce = 4;
constexpr double kPi = 3.14159265358979323846;
// Of the radius: what rounding and a lattice that just fits may overlap.
constexpr double kOverlapTolerance = 1e-4;

// What the rules need to know of a body or a group.
struct Owner {
  std::string name;
  BodyType type = BodyType::dynamic_body;
  bool has_discs = false;
  double radius_min = std::numeric_limits<double>::infinity(), radius_max = 0;
  double mass_min = std::numeric_limits<double>::infinity(), mass_max = 0;
  double speed_over_radius = 0;  // of the body for which this is largest, 1/s
  double fastest = 0, fastest_radius = 0;
  double gravity_scale = 1;
  double restitution = 0;
  std::size_t outside = 0;  // bodies beyond the sides of the world
};

struct Survey {
  std::vector<Owner> owners;  // bodies, then groups
  std::vector<PlacedDisc> discs;
  std::vector<PlacedSegment> segments;
  std::vector<std::string> misplaced;
};

bool leaves(const WorldDesc& world, double x, double y, double radius) {
  const double r = world.boundary == Boundary::walls ? radius * (1 - kOverlapTolerance) : 0;
  const Bounds& b = world.bounds;
  return !(x - r >= b.xmin && x + r <= b.xmax && y - r >= b.ymin && y + r <= b.ymax);
}

Owner owner_of(const BodyDesc& body, std::string name) {
  Owner owner;
  owner.name = std::move(name);
  owner.type = body.type;
  owner.gravity_scale = body.gravity_scale;
  owner.restitution = body.material.restitution;
  return owner;
}

void see_disc(Survey& survey, Owner& owner, const WorldDesc& world, const BodyDesc& body,
              PlacedDisc disc, Vec2 velocity) {
  const double r = disc.radius;
  const double mass = body.mass > 0 ? body.mass : body.material.density * kPi * r * r;
  const double speed = std::sqrt(velocity.x * velocity.x + velocity.y * velocity.y);
  owner.has_discs = true;
  owner.radius_min = std::min(owner.radius_min, r);
  owner.radius_max = std::max(owner.radius_max, r);
  owner.mass_min = std::min(owner.mass_min, mass);
  owner.mass_max = std::max(owner.mass_max, mass);
  if (speed > owner.speed_over_radius * r) {
    owner.speed_over_radius = speed / r;
    owner.fastest = speed;
    owner.fastest_radius = r;
  }
  disc.moves = body.type == BodyType::dynamic_body;
  if (disc.moves && leaves(world, disc.x, disc.y, r)) ++owner.outside;
  survey.discs.push_back(disc);
}

void see_segments(Survey& survey, const BodyDesc& body, std::uint32_t owner,
                  const std::vector<Vec2>& vertices, bool loop) {
  const double c = std::cos(body.angle), s = std::sin(body.angle);
  const auto in_world = [&](Vec2 v) {
    return Vec2{body.position.x + c * v.x - s * v.y, body.position.y + s * v.x + c * v.y};
  };
  for (std::size_t k = 0; k + 1 < vertices.size(); ++k) {
    survey.segments.push_back({in_world(vertices[k]), in_world(vertices[k + 1]), owner});
  }
  if (loop && vertices.size() > 2) {
    survey.segments.push_back({in_world(vertices.back()), in_world(vertices.front()), owner});
  }
}

Survey look_at(const Scene& scene) {
  Survey survey;
  for (std::size_t k = 0; k < scene.bodies.size(); ++k) {
    const BodyDesc& body = scene.bodies[k];
    std::string name = "bodies[" + std::to_string(k) + "]";
    if (k < scene.body_names.size() && !scene.body_names[k].empty()) {
      name += " \"" + scene.body_names[k] + "\"";
    }
    Owner owner = owner_of(body, std::move(name));
    const auto id = static_cast<std::uint32_t>(survey.owners.size());
    if (const auto* disc = std::get_if<DiscShape>(&body.shape)) {
      see_disc(survey, owner, scene.world, body,
               {body.position.x, body.position.y, disc->radius, id, 0, false}, body.velocity);
    } else if (const auto* segment = std::get_if<SegmentShape>(&body.shape)) {
      see_segments(survey, body, id, {segment->p1, segment->p2}, false);
    } else if (const auto* chain = std::get_if<ChainShape>(&body.shape)) {
      see_segments(survey, body, id, chain->vertices, chain->loop);
    }
    survey.owners.push_back(std::move(owner));
  }
  for (std::size_t k = 0; k < scene.groups.size(); ++k) {
    const GroupDesc group = seeded_group(scene, k);
    Owner owner = owner_of(group.body, "groups[" + std::to_string(k) + "]");
    const auto id = static_cast<std::uint32_t>(survey.owners.size());
    std::string error;
    if (const std::optional<PlacedGroup> placed = place_group(group, error)) {
      for (std::size_t i = 0; i < placed->x.size(); ++i) {
        see_disc(survey, owner, scene.world, group.body,
                 {placed->x[i], placed->y[i], placed->radius[i], id, static_cast<std::uint32_t>(i),
                  false},
                 {placed->vx[i], placed->vy[i]});
      }
    } else {
      survey.misplaced.push_back(owner.name + ": " + error);
    }
    survey.owners.push_back(std::move(owner));
  }
  return survey;
}

std::string disc_name(const Scene& scene, const Survey& survey, const PlacedDisc& disc) {
  const std::string& owner = survey.owners[disc.owner].name;
  if (disc.owner < scene.bodies.size()) return owner;
  return owner + " disc " + std::to_string(disc.place);
}

// ---- rules --------------------------------------------------------------------------------------

using Lines = std::vector<std::string>;

void check_dt(const Scene& scene, Lines& lines) {
  if (scene.world.dt <= kLongestDt * (1 + 1e-9)) return;
  lines.push_back("step.dt is " + number_text(scene.world.dt) +
                  " s, longer than 1/30 s: contacts will be soft and fast bodies pass each other; "
                  "make step.dt 1/60");
}

void check_speed(const Scene& scene, const Survey& survey, Lines& lines) {
  for (const Owner& owner : survey.owners) {
    if (owner.type == BodyType::static_body) continue;
    const double frames = owner.speed_over_radius * scene.world.dt;
    if (!(frames > 1)) continue;
    std::string line = owner.name + ": at " + number_text(owner.fastest) +
                       " m/s a disc of radius " + number_text(owner.fastest_radius) + " m moves " +
                       number_text(frames) + " times its radius in a frame";
    line += survey.segments.empty() ? ", and may pass others unseen"
                                    : ", and segments have no thickness: it may pass through";
    lines.push_back(line + "; make step.dt at most " + round_down_text(scene.world.dt / frames) +
                    " s or its velocity smaller");
  }
}

void check_gravity(const Scene& scene, const Survey& survey, Lines& lines) {
  const Vec2 g = scene.world.gravity;
  const double dt = scene.world.dt;
  for (const Owner& owner : survey.owners) {
    if (owner.type != BodyType::dynamic_body || !owner.has_discs) continue;
    const double fall = std::sqrt(g.x * g.x + g.y * g.y) * std::fabs(owner.gravity_scale) * dt * dt;
    if (!(fall > 0.5 * owner.radius_min)) continue;
    lines.push_back(owner.name + ": gravity moves a body " + number_text(fall) +
                    " m in one frame from rest, more than half its radius of " +
                    number_text(owner.radius_min) +
                    " m: contacts will not hold it; make step.dt at most " +
                    round_down_text(dt * std::sqrt(0.5 * owner.radius_min / fall)) +
                    " s, or radius larger, or world.gravity smaller");
  }
}

void check_masses(const Survey& survey, Lines& lines) {
  const Owner* light = nullptr;
  const Owner* heavy = nullptr;
  for (const Owner& owner : survey.owners) {
    if (owner.type != BodyType::dynamic_body || !owner.has_discs) continue;
    if (!light || owner.mass_min < light->mass_min) light = &owner;
    if (!heavy || owner.mass_max > heavy->mass_max) heavy = &owner;
  }
  if (!light || !(heavy->mass_max > kMostMassRatio * light->mass_min)) return;
  lines.push_back(
      heavy->name + " has a body of " + number_text(heavy->mass_max) + " kg and " + light->name +
      " one of " + number_text(light->mass_min) + " kg, " +
      number_text(heavy->mass_max / light->mass_min) +
      " times lighter: a heavy body that rests on light ones sinks in; bring density or "
      "mass nearer (a ratio of 100), or step.substeps more");
}

void check_sizes(const Scene& scene, const Survey& survey, Lines& lines) {
  const Owner* small = nullptr;
  const Owner* large = nullptr;
  for (const Owner& owner : survey.owners) {
    if (!owner.has_discs) continue;
    if (!small || owner.radius_min < small->radius_min) small = &owner;
    if (!large || owner.radius_max > large->radius_max) large = &owner;
  }
  if (!small) return;
  if (large->radius_max > kMostSizeRatio * small->radius_min) {
    lines.push_back("radii of very different scale: " + number_text(large->radius_max) + " m in " +
                    large->name + " and " + number_text(small->radius_min) + " m in " +
                    small->name +
                    ": slow, and contacts of the small ones are coarse; keep radius "
                    "within a factor of 1000");
  }
  const Bounds& b = scene.world.bounds;
  const double size = std::max(b.xmax - b.xmin, b.ymax - b.ymin);
  const double pitch = size * 0x1p-30;
  if (small->radius_min < kLatticeStepsPerRadius * pitch) {
    lines.push_back(small->name + ": radius " + number_text(small->radius_min) +
                    " m is near the resolution of positions in a world of " + number_text(size) +
                    " m (" + number_text(pitch) + " m); make world.bounds at most " +
                    round_down_text(small->radius_min / kLatticeStepsPerRadius * 0x1p30) +
                    " m across or radius at least " +
                    round_up_text(kLatticeStepsPerRadius * pitch) + " m");
  }
}

void check_bounds(const Scene& scene, const Survey& survey, Lines& lines) {
  for (std::size_t k = 0; k < survey.owners.size(); ++k) {
    const Owner& owner = survey.owners[k];
    if (owner.outside == 0) continue;
    const bool group = k >= scene.bodies.size();
    const char* what = scene.world.boundary == Boundary::walls
                           ? (group ? " bodies reach" : "reaches")
                           : (group ? " bodies start" : "starts");
    lines.push_back(
        owner.name + ": " + (group ? std::to_string(owner.outside) : "") + what +
        (scene.world.boundary == Boundary::walls ? " out of the walls" : " outside the world") +
        "; make world.bounds larger or move " + (group ? "region" : "position"));
  }
}

void check_overlaps(const Scene& scene, const Survey& survey, Lines& lines) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Owner& owner : survey.owners) smallest = std::min(smallest, owner.radius_min);
  if (survey.discs.empty()) return;
  const Overlaps found = find_overlaps(survey.discs, survey.segments, kOverlapTolerance * smallest);
  if (found.count == 0) return;
  const std::string other = found.other_is_segment
                                ? survey.owners[survey.segments[found.other].owner].name
                                : disc_name(scene, survey, survey.discs[found.other]);
  lines.push_back(disc_name(scene, survey, survey.discs[found.disc]) + " and " + other +
                  " overlap by " + number_text(found.depth) + " m at the start" +
                  (found.count > 1 ? " (the deepest of " + std::to_string(found.count) + " pairs)"
                                   : std::string()) +
                  ": they will be pushed apart; move position, region or x and y");
}

void check_restitution(const Scene& scene, const Survey& survey, Lines& lines) {
  if (scene.world.substeps >= kSubstepsToBounce) return;
  const Vec2 g = scene.world.gravity;
  if (g.x == 0 && g.y == 0) return;
  const Owner* bounciest = nullptr;
  for (const Owner& owner : survey.owners) {
    if (!bounciest || owner.restitution > bounciest->restitution) bounciest = &owner;
  }
  if (!bounciest) return;
  const bool wall = scene.world.boundary == Boundary::walls &&
                    scene.world.wall.restitution > bounciest->restitution;
  const double restitution = wall ? scene.world.wall.restitution : bounciest->restitution;
  if (restitution < kBouncy) return;
  lines.push_back((wall ? std::string("world.material") : bounciest->name) + ": restitution " +
                  number_text(restitution) + " with step.substeps " +
                  std::to_string(scene.world.substeps) +
                  ": the height of a bounce will be off; make step.substeps at least 4");
}

}  // namespace

std::vector<std::string> check_scene(const Scene& scene) {
  const Survey survey = look_at(scene);
  Lines lines = survey.misplaced;
  check_dt(scene, lines);
  check_speed(scene, survey, lines);
  check_gravity(scene, survey, lines);
  check_masses(survey, lines);
  check_sizes(scene, survey, lines);
  check_bounds(scene, survey, lines);
  check_overlaps(scene, survey, lines);
  check_restitution(scene, survey, lines);
  return lines;
}

}  // namespace psim
