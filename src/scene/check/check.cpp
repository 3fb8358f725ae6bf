// `--check`: what would go wrong when a scene runs. Every rule looks at the sizes, speeds and masses
// of the bodies as they are placed, and says one line: who, what, and the setting that mends it.
// O(n log n) for n bodies; a million in about a second.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "check/rules.h"
#include "check/survey.h"
#include "number_text.h"
#include "psim/scene.h"

namespace psim {
namespace {

constexpr double kMostMassRatio = 100;
constexpr double kMostSizeRatio = 1000;
constexpr double kLongestDt = 1.0 / 30;
constexpr double kLatticeStepsPerRadius = 100;
constexpr double kBouncy = 0.9;
constexpr int kSubstepsToBounce = 4;

std::string placed_name(const Scene& scene, const Survey& survey, const PlacedBody& body) {
  const Owner& owner = survey.owners[body.owner];
  if (body.owner < scene.bodies.size()) return owner.name;
  return owner.name + (owner.is_disc ? " disc " : " body ") + std::to_string(body.place);
}

// ---- rules --------------------------------------------------------------------------------------

void check_dt(const Scene& scene, Lines& lines) {
  if (scene.world.dt <= kLongestDt * (1 + 1e-9)) return;
  lines.push_back("step.dt is " + number_text(scene.world.dt) +
                  " s, longer than 1/30 s: contacts will be soft and fast bodies pass each other; "
                  "make step.dt 1/60");
}

// The worst of those of which a line could be said, and how many there are.
struct Worst {
  const Owner* owner = nullptr;
  double value = 0;
  std::size_t count = 0;

  void note(const Owner& other, double how_bad) {
    ++count;
    if (how_bad <= value) return;
    owner = &other;
    value = how_bad;
  }
  std::string name() const { return owner->name + (count > 1 ? " (the worst of " + std::to_string(count) + ")" : ""); }
};

void check_speed(const Scene& scene, const Survey& survey, Lines& lines) {
  Worst worst;
  for (const Owner& owner : survey.owners) {
    if (owner.type == BodyType::static_body) continue;
    const double frames = owner.speed_over_radius * scene.world.dt;
    if (frames > 1) worst.note(owner, frames);
  }
  if (worst.count == 0) return;
  std::string line = worst.name() + ": at " + number_text(worst.owner->fastest) + " m/s a " +
                     (worst.owner->is_disc ? "disc" : "body") + " of radius " +
                     number_text(worst.owner->fastest_radius) + " m moves " + number_text(worst.value) +
                     " times its radius in a frame";
  line += survey.segments.empty() ? ", and may pass others unseen"
                                  : ", and segments have no thickness: it may pass through";
  lines.push_back(line + "; make step.dt at most " + round_down_text(scene.world.dt / worst.value) +
                  " s or its velocity smaller");
}

void check_gravity(const Scene& scene, const Survey& survey, Lines& lines) {
  const Vec2 g = scene.world.gravity;
  const double dt = scene.world.dt;
  const auto fall_of = [&](const Owner& owner) {
    return std::sqrt(g.x * g.x + g.y * g.y) * std::fabs(owner.gravity_scale) * dt * dt;
  };
  Worst worst;
  for (const Owner& owner : survey.owners) {
    if (owner.type != BodyType::dynamic_body || !owner.has_bodies) continue;
    const double share = fall_of(owner) / owner.radius_min;
    if (share > 0.5) worst.note(owner, share);
  }
  if (worst.count == 0) return;
  const double fall = fall_of(*worst.owner);
  lines.push_back(worst.name() + ": gravity moves a body " + number_text(fall) +
                  " m in one frame from rest, more than half its radius of " + number_text(worst.owner->radius_min) +
                  " m: contacts will not hold it; make step.dt at most " +
                  round_down_text(dt * std::sqrt(0.5 * worst.owner->radius_min / fall)) +
                  " s, or radius larger, or world.gravity smaller");
}

void check_masses(const Survey& survey, Lines& lines) {
  const Owner* light = nullptr;
  const Owner* heavy = nullptr;
  for (const Owner& owner : survey.owners) {
    if (owner.type != BodyType::dynamic_body || !owner.has_bodies) continue;
    if (!light || owner.mass_min < light->mass_min) light = &owner;
    if (!heavy || owner.mass_max > heavy->mass_max) heavy = &owner;
  }
  if (!light || !(heavy->mass_max > kMostMassRatio * light->mass_min)) return;
  lines.push_back(heavy->name + " has a body of " + number_text(heavy->mass_max) + " kg and " + light->name +
                  " one of " + number_text(light->mass_min) + " kg, " + number_text(heavy->mass_max / light->mass_min) +
                  " times lighter: a heavy body that rests on light ones sinks in; bring density or "
                  "mass nearer (a ratio of 100), or step.substeps more");
}

void check_sizes(const Scene& scene, const Survey& survey, Lines& lines) {
  const Owner* small = nullptr;
  const Owner* large = nullptr;
  for (const Owner& owner : survey.owners) {
    // Ground may be as large as it likes.
    if (!owner.has_bodies || (owner.type == BodyType::static_body && !owner.is_disc)) continue;
    if (!small || owner.radius_min < small->radius_min) small = &owner;
    if (!large || owner.radius_max > large->radius_max) large = &owner;
  }
  if (!small) return;
  if (large->radius_max > kMostSizeRatio * small->radius_min) {
    lines.push_back("radii of very different scale: " + number_text(large->radius_max) + " m in " + large->name +
                    " and " + number_text(small->radius_min) + " m in " + small->name +
                    ": slow, and contacts of the small ones are coarse; keep radius "
                    "within a factor of 1000");
  }
  const Bounds& b = scene.world.bounds;
  const double size = std::max(b.xmax - b.xmin, b.ymax - b.ymin);
  const double pitch = size * 0x1p-30;
  if (small->radius_min < kLatticeStepsPerRadius * pitch) {
    lines.push_back(small->name + ": radius " + number_text(small->radius_min) +
                    " m is near the resolution of positions in a world of " + number_text(size) + " m (" +
                    number_text(pitch) + " m); make world.bounds at most " +
                    round_down_text(small->radius_min / kLatticeStepsPerRadius * 0x1p30) +
                    " m across or radius at least " + round_up_text(kLatticeStepsPerRadius * pitch) + " m");
  }
}

void check_bounds(const Scene& scene, const Survey& survey, Lines& lines) {
  for (std::size_t k = 0; k < survey.owners.size(); ++k) {
    const Owner& owner = survey.owners[k];
    if (owner.outside == 0) continue;
    const bool group = k >= scene.bodies.size();
    const char* what = scene.world.boundary == Boundary::walls ? (group ? " bodies reach" : "reaches")
                                                               : (group ? " bodies start" : "starts");
    lines.push_back(owner.name + ": " + (group ? std::to_string(owner.outside) : "") + what +
                    (scene.world.boundary == Boundary::walls ? " out of the walls" : " outside the world") +
                    "; make world.bounds larger or move " + (group ? "region" : "position"));
  }
}

void check_overlaps(const Scene& scene, const Survey& survey, Lines& lines) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Owner& owner : survey.owners) smallest = std::min(smallest, owner.radius_min);
  if (survey.bodies.empty()) return;
  const Overlaps found =
      find_overlaps(survey.bodies, survey.segments, kOverlapTolerance * smallest, jointed_pairs(scene));
  if (found.count == 0) return;
  const std::string other = found.other_is_segment ? survey.owners[survey.segments[found.other].owner].name
                                                   : placed_name(scene, survey, survey.bodies[found.other]);
  lines.push_back(placed_name(scene, survey, survey.bodies[found.body]) + " and " + other + " overlap by " +
                  number_text(found.depth) + " m at the start" +
                  (found.count > 1 ? " (the deepest of " + std::to_string(found.count) + " pairs)" : std::string()) +
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
  const bool wall = scene.world.boundary == Boundary::walls && scene.world.wall.restitution > bounciest->restitution;
  const double restitution = wall ? scene.world.wall.restitution : bounciest->restitution;
  if (restitution < kBouncy) return;
  lines.push_back((wall ? std::string("world.material") : bounciest->name) + ": restitution " +
                  number_text(restitution) + " with step.substeps " + std::to_string(scene.world.substeps) +
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
  check_polygons(scene, lines);
  check_joints(scene, survey, lines);
  check_feasible(scene, survey, lines);
  return lines;
}

}  // namespace psim
