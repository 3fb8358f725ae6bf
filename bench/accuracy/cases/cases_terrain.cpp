// Terrain of many short pieces: level ground, hills, bowls and loops without friction, their pieces listed either way.
// Vertices cost energy; truths count that (reference::Track).
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <utility>

#include "cases/case.h"
#include "structures.h"

namespace psim::accuracy {
namespace {

constexpr double kPi = std::numbers::pi;
const Material kSmooth = material(0);

enum class Pieces { segments, chain, boxes };

/// A static box under the level line from p to q.
BodyDesc block(Vec2 p, Vec2 q) {
  BodyDesc body = box({(p.x + q.x) / 2, p.y - 0.25}, {std::abs(q.x - p.x), 0.5}, kSmooth);
  body.type = BodyType::static_body;
  return body;
}

/// A static line through the points, its pieces listed from its end if `backwards`.
void append_line(std::vector<Vec2> line, Pieces pieces, bool backwards, Scene& scene) {
  if (backwards) std::ranges::reverse(line);
  if (pieces == Pieces::chain) {
    BodyDesc body = segment({}, {}, kSmooth);
    body.shape = ChainShape{std::move(line), false};
    scene.bodies.push_back(body);
    return;
  }
  for (std::size_t k = 0; k + 1 < line.size(); ++k) {
    scene.bodies.push_back(pieces == Pieces::boxes ? block(line[k], line[k + 1])
                                                   : segment(line[k], line[k + 1], kSmooth));
  }
}

std::vector<std::size_t> movers(const Model& model) {
  std::vector<std::size_t> ids;
  for (std::size_t k = 0; k < model.bodies.size(); ++k) {
    if (model.bodies[k].type == BodyType::dynamic_body) ids.push_back(k);
  }
  return ids;
}

const char* in_words(Pieces pieces) {
  return pieces == Pieces::chain ? "a chain" : pieces == Pieces::boxes ? "boxes" : "segments";
}

std::string named(const char* name, Pieces pieces) {
  return std::string(name) + (pieces == Pieces::chain ? "-chain" : pieces == Pieces::boxes ? "-boxes" : "");
}

// ---- level ground -----------------------------------------------------------------------------

constexpr double kLevelSpeed = 10;

// Discs and boxes on four lanes one above the other.
Scene level_ground(Pieces pieces) {
  Scene scene = open_scene(200);
  for (int lane = 0; lane < 4; ++lane) {
    const double y = 10.0 * lane;
    std::vector<Vec2> line;
    for (int k = 0; k <= 1000; ++k) line.push_back({0.1 * k - 50, y});
    append_line(std::move(line), pieces, lane % 2 == 1, scene);
    BodyDesc body = disc({-45, y + 0.5}, {kLevelSpeed, 0}, kSmooth);
    if (lane > 1) body.shape = BoxShape{1, 1};
    body.mass = 1;
    scene.bodies.push_back(body);
  }
  return scene;
}

Case level(Pieces pieces) {
  const std::string name = named("level", pieces);
  Case c;
  c.name = name;
  c.shows = std::string("a disc and a box slide at 10 m/s over 1000 pieces in a line, as ") + in_words(pieces) +
            ", listed either way: speed lost, bump";
  c.quantities = {{name + "-speed", "of the speed", "analytic", {{4, 1e-5}}},
                  {name + "-bump", "m", "analytic", {{4, 6e-5}, {8, 1.4e-5}}}};
  c.scale = Scale::large;
  c.timed_seconds = 0.5;
  c.scene = [pieces] { return level_ground(pieces); };
  c.measure = [](Run& run) -> std::vector<double> {
    const auto ids = movers(run.model());
    double bump = 0, lost = 0;
    for (int frame = 0; frame < 8 * kFrameRate; ++frame) {
      run.frame();
      for (const std::size_t k : ids) bump = std::max(bump, std::abs(run.body(k).y - run.model().bodies[k].position.y));
    }
    for (const std::size_t k : ids) lost = std::max(lost, std::abs(run.body(k).vx / kLevelSpeed - 1));
    return {lost, bump};
  };
  return c;
}

// ---- over a hill ------------------------------------------------------------------------------

constexpr double kHillSpeed = 7;
constexpr int kHillPieces = 160;

std::vector<Vec2> hill_line(double height, bool mirrored) {
  std::vector<Vec2> line = {{-20, 0}};
  for (int k = 0; k <= kHillPieces; ++k) {
    const double x = 12.0 * k / kHillPieces - 6;
    line.push_back({x, height * (1 + std::cos(kPi * x / 6)) / 2});
  }
  line.push_back({20, 0});
  if (mirrored) {
    for (Vec2& v : line) v.x = -v.x;
    std::ranges::reverse(line);
  }
  return line;
}

reference::Track track_of(const std::vector<Vec2>& line, double radius) {
  std::vector<reference::Vec> points;
  for (const Vec2 v : line) points.push_back({v.x, v.y});
  return {std::move(points), radius, kGravity};
}

/// Speed four seconds after the start 12 m before the middle.
double speed_after(double height, double radius) {
  static std::map<std::pair<double, double>, double> known;
  const auto [found, is_new] = known.try_emplace({height, radius}, 0);
  if (!is_new) return found->second;
  const reference::Track track = track_of(hill_line(height, false), radius);
  found->second = track.after(4, {{-12, radius}, {kHillSpeed, 0}}).v.x;
  return found->second;
}

// Two sizes x listed either way x from either side, one above the other.
Scene ways(double height, Pieces pieces) {
  Scene scene = open_scene(200);
  for (int lane = 0; lane < 8; ++lane) {
    const double radius = lane < 4 ? 0.2 : 0.6, y = 12.0 * lane - 40;
    const bool mirrored = lane % 2 == 1;
    std::vector<Vec2> line = hill_line(height, mirrored);
    for (Vec2& v : line) v.y += y;
    append_line(std::move(line), pieces, lane / 2 % 2 == 1, scene);
    const double side = mirrored ? 1 : -1;
    BodyDesc body = disc({12 * side, y + radius}, {-kHillSpeed * side, 0}, kSmooth, radius);
    body.mass = 1;
    scene.bodies.push_back(body);
  }
  return scene;
}

Case way(const char* what, double height, Pieces pieces) {
  const std::string name = named(what, pieces);
  Case c;
  c.name = name;
  c.shows = "discs of 0.2 and 0.6 m slide at 7 m/s through a " + std::string(what) + " of 160 pieces, as " +
            in_words(pieces) + ", listed either way, from either side: speed after it";
  c.quantities = {{name + "-speed", "of the speed", "stepped at 20 us", {{4, 5e-4}, {8, 7e-4}}}};
  c.scale = Scale::large;
  c.timed_seconds = 0.5;
  c.scene = [=] { return ways(height, pieces); };
  c.measure = [height](Run& run) -> std::vector<double> {
    run.seconds(4);
    const double small = speed_after(height, 0.2), large = speed_after(height, 0.6);
    double off = 0;
    for (const std::size_t k : movers(run.model())) {
      const BodyDesc& start = run.model().bodies[k];
      const double side = start.position.x > 0 ? 1 : -1;
      off = std::max(off, std::abs(-side * run.body(k).vx / (radius_of(start) < 0.4 ? small : large) - 1));
    }
    return {off};
  };
  return c;
}

// ---- a loop -----------------------------------------------------------------------------------

constexpr int kLoops = 20, kLoopPieces = 200;
constexpr double kLoopRadius = 2, kLoopDisc = 0.2;

constexpr double kRho = kLoopRadius - kLoopDisc;
constexpr double kLoopPitch = 0.01;

/// Of 5 g rho / 2, with which it just gets round a circle. Vertices cost it a tenth.
double loop_share(int k) { return 1 + kLoopPitch * (k + 0.5); }

/// The loop about the origin; the lowest point is in the middle of a piece.
std::vector<Vec2> loop_line() {
  std::vector<Vec2> line;
  for (int i = 0; i <= kLoopPieces; ++i) {
    const double a = 2 * kPi * (i + 0.5) / kLoopPieces - kPi / 2, r = kLoopRadius / std::cos(kPi / kLoopPieces);
    line.push_back({r * std::cos(a), r * std::sin(a)});
  }
  return line;
}

double loop_speed(int k) { return std::sqrt(5 * kGravity * kRho * loop_share(k)); }

/// Round: over the top from one side to the other, never 2 cm off the line.
struct Ride {
  bool fell = false, round = false;

  /// x: to the side that it started for, from the loop's centre.
  void look(double x, double y) {
    fell = fell || (!round && std::hypot(x, y) < kRho - 0.02);
    round = round || (!fell && y > 0.5 && x < 0);
  }
};

/// How many of the loops truly get a disc round.
int truly_round() {
  const reference::Track track = track_of(loop_line(), kLoopDisc);
  int count = 0;
  for (int k = 0; k < kLoops; ++k) {
    reference::Track::State s{{0, -kRho}, {loop_speed(k), 0}};
    Ride ride;
    for (int frame = 0; frame < 2 * kFrameRate && !ride.fell && !ride.round; ++frame) {
      s = track.after(1.0 / kFrameRate, s);
      ride.look(s.x.x, s.x.y);
    }
    count += ride.round ? 1 : 0;
  }
  return count;
}

Scene loops(Pieces pieces) {
  Scene scene = open_scene(200);
  for (int k = 0; k < kLoops; ++k) {
    const Vec2 centre{5.0 * (k % 10) - 25, 5.0 * (k / 10)};
    std::vector<Vec2> line = loop_line();
    for (Vec2& v : line) v = {v.x + centre.x, v.y + centre.y};
    append_line(std::move(line), pieces, k % 2 == 1, scene);
    const double side = k % 4 < 2 ? 1 : -1;
    scene.bodies.push_back(disc({centre.x, centre.y - kRho}, {side * loop_speed(k), 0}, kSmooth, kLoopDisc));
  }
  return scene;
}

std::vector<double> measure_loops(Run& run) {
  const auto ids = movers(run.model());
  std::vector<Ride> rides(ids.size());
  for (int frame = 0; frame < 2 * kFrameRate; ++frame) {
    run.frame();
    for (std::size_t k = 0; k < ids.size(); ++k) {
      const BodyDesc& start = run.model().bodies[ids[k]];
      const BodyState& s = run.body(ids[k]);
      const double side = start.velocity.x > 0 ? 1 : -1;
      rides[k].look(side * (s.x - start.position.x), s.y - start.position.y - kRho);
    }
  }
  static const int truth = truly_round();
  const auto round = std::ranges::count_if(rides, &Ride::round);
  return {kLoopPitch * std::abs(static_cast<double>(round) - truth)};
}

Case loop(Pieces pieces) {
  const std::string name = named("loop", pieces);
  Case c;
  c.name = name;
  c.shows = std::string("20 discs at the bottom of loops of 200 pieces, as ") + in_words(pieces) +
            ", energy a per cent apart: how many get round";
  c.quantities = {{name + "-threshold", "of the energy", "stepped at 20 us", {{4, kLoopPitch}}}};
  c.scale = Scale::large;
  c.timed_seconds = 0.5;
  c.scene = [pieces] { return loops(pieces); };
  c.measure = measure_loops;
  return c;
}

}  // namespace

std::vector<Case> terrain_cases(Effort) {
  return {level(Pieces::boxes),
          level(Pieces::segments),
          level(Pieces::chain),
          way("hill", 1.5, Pieces::segments),
          way("hill", 1.5, Pieces::chain),
          way("valley", -1.2, Pieces::segments),
          way("valley", -1.2, Pieces::chain),
          loop(Pieces::segments),
          loop(Pieces::chain)};
}

}  // namespace psim::accuracy
