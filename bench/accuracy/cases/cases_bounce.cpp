// A disc let go 1 m above level ground. Apexes and times of the bounces come from the places alone:
// three frames fix a flight's parabola, so engines whose velocities lag behind their places are
// judged alike.
#include <algorithm>
#include <cmath>

#include "cases/case.h"
#include "closed_forms.h"

namespace psim::accuracy {
namespace {

constexpr double kRadius = 0.5;

struct Flight {
  double began = 0;  ///< s, the bounce before it
  double apex = 0;   ///< m above the ground
};

// The parabola through the heights of frames k - 1, k and k + 1, the highest in the middle.
Flight flight_through(const std::vector<double>& heights, std::size_t k) {
  const double slope = 0.5 * (heights[k + 1] - heights[k - 1]);
  const double bend = heights[k + 1] - 2 * heights[k] + heights[k - 1];
  const double offset = bend < 0 ? -slope / bend : 0;
  const double apex = heights[k] + 0.5 * slope * offset;
  const double top = (static_cast<double>(k) + offset) / kFrameRate;
  return {top - std::sqrt(2 * std::max(apex, 0.0) / kGravity), apex};
}

struct Track {
  std::vector<Flight> flights;  ///< after each bounce
  double deepest = 0;           ///< m below the ground
};

Track follow(Run& run, double seconds) {
  Track track;
  std::vector<double> heights{run.body(1).y - kRadius};
  const auto frames = static_cast<std::size_t>(seconds * kFrameRate);
  while (heights.size() <= frames) {
    run.frame();
    heights.push_back(run.body(1).y - kRadius);
    track.deepest = std::max(track.deepest, -heights.back());
  }
  for (std::size_t k = 1; k + 1 < heights.size(); ++k) {
    const bool top = heights[k] > heights[k - 1] && heights[k] >= heights[k + 1];
    if (top && heights[k] > 0.02) track.flights.push_back(flight_through(heights, k));
  }
  return track;
}

Scene bouncing(double restitution) {
  Scene scene = open_scene(100);
  scene.bodies = {ground(material(restitution)), disc({0, 1.5}, {0, 0}, material(restitution))};
  return scene;
}

// The first five bounces at e = 0.8.
std::vector<double> measure_decay(Run& run) {
  const reference::Bounces truth{1, 0.8, kGravity};
  const Track track = follow(run, truth.time(5) + 0.1);
  if (track.flights.size() < 5) throw Failed("fewer than five bounces");
  double height = 0, time = 0;
  for (int k = 0; k < 5; ++k) {
    const Flight& flight = track.flights[static_cast<std::size_t>(k)];
    height = std::max(height, std::abs(flight.apex / truth.apex(k) - 1));
    time = std::max(time, std::abs(flight.began - truth.time(k)));
  }
  return {height, time, track.deepest};
}

// Every apex of half a minute at e = 1.
std::vector<double> measure_elastic(Run& run) {
  const Track track = follow(run, 30);
  if (track.flights.size() < 20) throw Failed("it came to rest");
  double height = 0;
  for (const Flight& f : track.flights) height = std::max(height, std::abs(f.apex - 1));
  return {height, track.deepest};
}

}  // namespace

std::vector<Case> bounce_cases(Effort) {
  Case decay;
  decay.name = "bounce-0.8";
  decay.shows = "a disc dropped by 1 m, e = 0.8: the first five bounces";
  decay.quantities = {{"bounce-0.8-apex", "of the apex", "analytic", {{4, 1e-3}}},
                      {"bounce-0.8-time", "s", "analytic", {{4, 1e-3}}},
                      {"bounce-0.8-penetration", "m", "analytic", {{4, 1e-2}}}};
  decay.scene = [] { return bouncing(0.8); };
  decay.measure = measure_decay;

  Case elastic;
  elastic.name = "bounce-1";
  elastic.shows = "a disc dropped by 1 m, e = 1, for 30 s: every apex";
  elastic.quantities = {{"bounce-1-apex", "of the drop", "analytic", {{4, 1e-3}}},
                        {"bounce-1-penetration", "m", "analytic", {{4, 1e-2}}}};
  elastic.scene = [] { return bouncing(1); };
  elastic.measure = measure_elastic;
  return {decay, elastic};
}

}  // namespace psim::accuracy
