// What stands by friction and shape alone: leaning cards, a house of cards, an arch, a dry-stone wall; and a block that
// rocks. What stands must not sink, at any number of substeps.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

#include "cases/case.h"
#include "structures.h"

namespace psim::accuracy {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// ---- a rocking block --------------------------------------------------------------------------

const reference::RockingBlock kBlock{0.5, 2};
constexpr int kImpacts = 5;

Scene rocking_block() {
  Scene scene = open_scene(50);
  const double tilt = 0.5 * kBlock.slenderness(), s = std::sin(tilt), c = std::cos(tilt);
  // On its lower right corner, at the origin.
  BodyDesc body =
      box({-0.5 * kBlock.width * c + 0.5 * kBlock.height * s, 0.5 * kBlock.width * s + 0.5 * kBlock.height * c},
          {kBlock.width, kBlock.height}, material(0, 5), 1);
  body.angle = -tilt;
  scene.bodies = {floor_box(material(0, 5)), body};
  return scene;
}

/// The largest angle between the fifth impact and the sixth.
std::vector<double> measure_rocking(Run& run) {
  double most = 0, before = run.body(1).angle;
  int impacts = 0;
  for (int frame = 0; frame < 30 * kFrameRate; ++frame) {
    run.frame();
    const double angle = run.body(1).angle;
    if (angle * before < 0 && ++impacts > kImpacts) {
      const double truth = kBlock.amplitude(0.5 * kBlock.slenderness(), kImpacts);
      return {std::abs(most / truth - 1)};
    }
    if (impacts == kImpacts) most = std::max(most, std::abs(angle));
    before = angle;
  }
  throw Failed("it stopped rocking");
}

Case rocking() {
  Case c;
  c.name = "rocking-block";
  c.shows = "a block of 0.5 x 2 m let go at half of the angle at which it falls: its tilt after five impacts";
  c.quantities = {{"rocking-block", "relative", "Housner 1963", {}}};
  c.scale = Scale::large;
  c.scene = rocking_block;
  c.measure = measure_rocking;
  return c;
}

// ---- leaning cards ----------------------------------------------------------------------------

constexpr int kPairs = 40;
constexpr double kLean = 25 * kDegree, kCard = 1, kThick = 0.05;  // angle from the vertical, m, m
// The foot and the apex are corners of the same side of a card, so its weight acts kThick / 2 nearer to the foot.
const double kLeanFriction = std::tan(kLean) / 2 - kThick / (2 * kCard);

double lean_friction(int k) { return kLeanFriction * (0.9 + 0.2 * (k + 0.5) / kPairs); }

/// Two cards of 1 kg that touch each other above `foot`.
void append_pair(Vec2 foot, Material surface, Scene& scene) {
  const double s = std::sin(kLean), c = std::cos(kLean);
  for (const int side : {-1, 1}) {  // the left card leans to the right
    const double to_apex = 0.5 * kThick * c + 0.5 * kCard * s, up = 0.5 * kThick * s + 0.5 * kCard * c;
    BodyDesc card = box({foot.x + side * to_apex, foot.y + up}, {kThick, kCard}, surface, 1);
    card.angle = side * kLean;
    scene.bodies.push_back(card);
  }
}

// Each pair stands on its own floor. Cards grip one another at the top by 0.7; frictions mix by geometric mean.
Scene leaning_cards() {
  constexpr double kGrip = 0.7;
  Scene scene = open_scene(200);
  for (int k = 0; k < kPairs; ++k) {
    const double x = 4.0 * k - 80, friction = lean_friction(k);
    BodyDesc floor = floor_box(material(0, friction * friction / kGrip), 1.5);
    floor.position.x = x;
    scene.bodies.push_back(floor);
    append_pair({x, 0}, material(0, kGrip), scene);
  }
  return scene;
}

std::vector<double> measure_leaning(Run& run) {
  run.seconds(10);
  int fallen = 0;
  for (int k = 0; k < kPairs; ++k) {
    const auto card = static_cast<std::size_t>(3 * k + 1);
    fallen += run.body(card).y < run.model().bodies[card].position.y - 0.05 ? 1 : 0;
  }
  return {std::abs(0.2 * fallen / kPairs - 0.1)};
}

Case leaning() {
  Case c;
  c.name = "leaning-cards";
  c.shows =
      "40 pairs of cards that lean on one another, friction within a tenth of the threshold: which stand for 10 s";
  c.quantities = {{"leaning-cards-threshold", "of the friction", "analytic", {{4, 0.01}}}};
  c.scale = Scale::large;
  c.timed_seconds = 0.5;
  c.scene = leaning_cards;
  c.measure = measure_leaning;
  return c;
}

// ---- houses, arches, walls --------------------------------------------------------------------

/// Storeys of leaning cards, a board of the same thickness on each but the last, everything in touch at the start.
Scene card_house() {
  constexpr int kStoreys = 5;
  constexpr double kPitch = 1;  // m, of the pairs
  const Material grip = material(0, 0.7);
  Scene scene = open_scene(50);
  scene.bodies = {floor_box(grip, 20)};
  const double s = std::sin(kLean), c = std::cos(kLean), storey = kCard * c + kThick * s + kThick;
  for (int level = 0; level < kStoreys; ++level) {
    const int pairs = kStoreys - level;
    for (int k = 0; k < pairs; ++k) {
      append_pair({(k - 0.5 * (pairs - 1)) * kPitch, level * storey}, grip, scene);
    }
    if (pairs == 1) break;
    const double length = (pairs - 1) * kPitch + 0.2;
    scene.bodies.push_back(box({0, (level + 1) * storey - kThick / 2}, {length, kThick}, grip, length));
  }
  return scene;
}

Scene arch() {
  std::string error;
  auto scene = make_builtin("arch", 21, 1, error);
  if (!scene) throw std::runtime_error(error);
  return std::move(*scene);
}

/// Eight courses of stones, the joints of each off those below, a centimetre wide.
Scene stone_wall() {
  Scene scene = open_scene(50);
  scene.bodies = {floor_box(material(0, 0.6), 10)};
  constexpr double kCourse = 0.3;
  for (int course = 0; course < 8; ++course) {
    double x = -2;
    for (int k = 0; x < 1.99; ++k) {
      double length = 0.5 + 0.1 * ((3 * k + 2 * course) % 4);
      if (k == 0 && course % 2 == 1) length = 0.35;
      length = x + length > 1.7 ? 2 - x : length;
      scene.bodies.push_back(
          box({x + length / 2, (course + 0.5) * kCourse}, {length - 0.01, kCourse}, material(0, 0.6)));
      x += length;
    }
  }
  return scene;
}

/// How far that body is below its start that sank most.
Case standing(const char* name, std::string shows, double seconds, std::vector<Limit> limits,
              std::function<Scene()> scene) {
  Case c;
  c.name = name;
  c.shows = std::move(shows);
  c.quantities = {{std::string(name) + "-sinks", "m", "analytic", std::move(limits)}};
  c.scale = Scale::large;
  c.timed_seconds = 0.5;
  c.scene = std::move(scene);
  c.measure = [seconds](Run& run) -> std::vector<double> {
    run.seconds(seconds);
    double sunk = 0;
    for (std::size_t k = 0; k < run.bodies().size(); ++k) {
      sunk = std::max(sunk, run.model().bodies[k].position.y - run.body(k).y);
    }
    return {sunk};
  };
  return c;
}

}  // namespace

std::vector<Case> stand_cases(Effort effort) {
  const double seconds = effort == Effort::quick ? 10 : 60;
  return {rocking(), leaning(),
          standing("card-house", "five storeys of leaning cards, boards on them: how far any card sinks in a minute",
                   seconds, {{4, 0.005}, {8, 0.0013}}, card_house),
          standing("arch", "seventeen stones and four beams, the scene arch: how far any of them sinks in a minute",
                   seconds, {{8, 0.0066}}, arch),
          standing("stone-wall", "eight courses of dry stones: how far any of them sinks in a minute", seconds,
                   {{4, 0.007}, {8, 0.0018}}, stone_wall)};
}

}  // namespace psim::accuracy
