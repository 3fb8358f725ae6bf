// Flows with a free surface: a standing wave, a dam that breaks, a drop that is drawn out.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "cases.h"

namespace psim::fluids {
namespace {

constexpr double kPi = std::numbers::pi, kGravity = 9.81;

// ---- standing wave ----------------------------------------------------------------------------

constexpr double kAmplitude = 0.02;  // of water of depth 1 m in a tank of 2 m, wave number pi

Flow wave(int layers) {
  Flow flow;
  flow.spacing = 1.0 / layers;
  flow.bounds = {0, 0, 2, 1.2};
  flow.gravity = {0, -kGravity};
  flow.speed = std::sqrt(kGravity);
  flow.pressure = [](Vec2 p) {
    const double lift = kAmplitude * std::cos(kPi * p.x) * std::cosh(kPi * p.y) / std::cosh(kPi);
    return kDensity * kGravity * std::max(0.0, 1 + lift - p.y);
  };
  fill(flow, {0, 0}, 2 * layers, layers);
  for (Vec2& p : flow.places) {
    const Vec2 at = p;
    const double scale = kAmplitude / std::sinh(kPi);
    p.x -= scale * std::sin(kPi * at.x) * std::cosh(kPi * at.y);
    p.y += scale * std::cos(kPi * at.x) * std::sinh(kPi * at.y);
  }
  return flow;
}

// The share of cos(k x) in the heights of all particles.
double mode_of(const Motion& motion) {
  std::vector<Particle> particles;
  motion.look(particles);
  double sum = 0;
  for (const Particle& p : particles) sum += p.place.y * std::cos(kPi * p.place.x);
  return sum / static_cast<double>(particles.size());
}

// The slope of the line through (k, log of peaks[k]) with the least squares.
double slope_of_logarithms(const std::vector<double>& peaks) {
  const auto n = static_cast<double>(peaks.size());
  double mean = 0, up = 0, down = 0;
  for (const double p : peaks) mean += std::log(p) / n;
  for (std::size_t k = 0; k < peaks.size(); ++k) {
    const double from_middle = static_cast<double>(k) - (n - 1) / 2;
    up += from_middle * (std::log(peaks[k]) - mean);
    down += from_middle * from_middle;
  }
  return up / down;
}

std::vector<Measured> measure_wave(Motion& motion, const Flow& flow, bool quick) {
  const double frame = 1.0 / 60, period = 2 * kPi / std::sqrt(kGravity * kPi * std::tanh(kPi));
  const int frames = quick ? 180 : flow.spacing < 0.015 ? 300 : 500;
  std::vector<double> crossings, peaks;
  double last = mode_of(motion), peak = 0;
  for (int k = 1; k <= frames; ++k) {
    motion.advance(frame);
    const double mode = mode_of(motion);
    if (last * mode <= 0) {
      crossings.push_back((k - 1 + last / (last - mode)) * frame);
      if (crossings.size() > 1) peaks.push_back(peak);
      peak = 0;
    }
    peak = std::max(peak, std::abs(mode));
    last = mode;
  }
  if (crossings.size() < 3) return {{"standing-wave-period", "of the period", "linear theory", INFINITY}};
  const double half = (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
  const std::string theory = "linear theory";
  return {{"standing-wave-period", "of the period", theory, 2 * half / period - 1},
          {"standing-wave-height", "of the height in a period", theory, std::expm1(2 * slope_of_logarithms(peaks))}};
}

// ---- dam break --------------------------------------------------------------------------------

struct Front {
  double time, place;  ///< T = t sqrt(2 g / a), Z = x / a
};
// Martin and Moyce 1952, a column twice as high as wide, a = 2.25 inches.
constexpr Front kDry[] = {{1.997, 2.292}, {2.547, 2.995}, {3.345, 4.134}};

Flow dam(int layers) {
  Flow flow;
  flow.spacing = 1.0 / layers;
  flow.bounds = {0, 0, 5.2, 2.4};
  flow.gravity = {0, -kGravity};
  flow.speed = std::sqrt(2 * kGravity * 2);
  flow.pressure = [](Vec2 p) { return kDensity * kGravity * (2 - p.y); };
  fill(flow, {0, 0}, layers, 2 * layers);
  return flow;
}

// The speed of the front between the first and the last of these points, and its place at the last.
std::vector<Measured> measure_dam(Motion& motion, const Flow&, bool quick) {
  const double frame = 1.0 / 60, scale = std::sqrt(2 * kGravity);
  const double first = kDry[0].time, last = kDry[2].time;
  double before = 1, at_first = 0, at_last = 0;
  std::vector<Particle> particles;
  for (int k = 1; k * frame * scale < last + frame * scale; ++k) {
    motion.advance(frame);
    motion.look(particles);
    double front = 0;
    for (const Particle& p : particles) front = std::max(front, p.place.x);
    const auto reached = [&](double time, double& place) {
      const double share = time / (frame * scale) - (k - 1);
      if (share >= 0 && share < 1) place = before + share * (front - before);
    };
    reached(first, at_first);
    reached(last, at_last);
    if (quick && at_first > 0) break;
    before = front;
  }
  const std::string source = "Martin and Moyce 1952";
  if (quick) return {{"dam-break-place", "of the way", source, (at_first - kDry[0].place) / (kDry[0].place - 1)}};
  const double speed = (at_last - at_first) / (last - first);
  return {{"dam-break-speed", "of the speed", source, speed / ((kDry[2].place - kDry[0].place) / (last - first)) - 1}};
}

// A column of 100,000 particles: what a frame costs. The costly method is measured on a part of a frame.
Flow column_of_100000(int layers) {
  Flow flow;
  flow.spacing = 1.0 / layers;
  const int columns = 224, rows = 447;
  flow.bounds = {0, 0, 12, 9.2};
  flow.gravity = {0, -kGravity};
  flow.speed = std::sqrt(2 * kGravity * rows * flow.spacing);
  flow.pressure = [top = rows * flow.spacing](Vec2 p) { return kDensity * kGravity * (top - p.y); };
  fill(flow, {0, 0}, columns, rows);
  return flow;
}

std::vector<Measured> measure_frame(Motion& motion, const Flow&, bool) {
  const bool whole = motion.dt > 0.001;
  for (int k = 0; k < (whole ? 240 : 24); ++k) motion.advance(whole ? 1.0 / 60 : 1.0 / 3600);
  std::vector<Measured> out = {
      {"large-dam-frame", "seconds a frame", "none: a cost", motion.seconds / motion.simulated / 60}};
  const double sum = motion.time_of_sum();
  if (sum > 0) out.push_back({"large-dam-sum", "seconds a sum over neighbours", "none: a cost", sum});
  return out;
}

// ---- elliptical drop --------------------------------------------------------------------------

// A disc of 1 m with the velocity (-x, y) stays an ellipse (Monaghan 1994). At 0.76 s its half axes are these.
constexpr double kDropTime = 0.76, kShort = 0.514266, kLong = 1.944517;
constexpr int kDropFrames = 46;

Flow drop(int layers) {
  Flow flow;
  flow.spacing = 1.0 / layers;
  flow.bounds = {-3, -3, 3, 3};
  flow.boundary = Boundary::open;
  flow.speed = 1;
  flow.pressure = [](Vec2 p) { return kDensity / 2 * (1 - p.x * p.x - p.y * p.y); };
  for (int j = -layers; j < layers; ++j) {
    for (int i = -layers; i < layers; ++i) {
      const Vec2 p{(i + 0.5) * flow.spacing, (j + 0.5) * flow.spacing};
      if (p.x * p.x + p.y * p.y >= 1) continue;
      flow.places.push_back(p);
      flow.velocities.push_back({-p.x, p.y});
    }
  }
  return flow;
}

// The mean of x^2 over an ellipse is a quarter of its half axis squared.
std::vector<Measured> measure_drop(Motion& motion, const Flow&, bool) {
  const auto half_axes = [&] {
    std::vector<Particle> particles;
    motion.look(particles);
    double x = 0, y = 0;
    for (const Particle& p : particles) x += p.place.x * p.place.x, y += p.place.y * p.place.y;
    const auto count = static_cast<double>(particles.size());
    return Vec2{2 * std::sqrt(x / count), 2 * std::sqrt(y / count)};
  };
  const Vec2 begin = half_axes();
  const double energy = motion.energy();
  for (int k = 0; k < kDropFrames; ++k) motion.advance(kDropTime / kDropFrames);
  const Vec2 end = half_axes();
  const double x = end.x / begin.x / kShort - 1, y = end.y / begin.y / kLong - 1;
  return {{"drop-axes", "of the half axis, the worse one", "Monaghan 1994", std::abs(x) > std::abs(y) ? x : y},
          {"drop-energy", "of the energy", "constant", motion.energy() / energy - 1}};
}

}  // namespace

Case standing_wave() {
  Case c;
  c.name = "standing-wave";
  c.shows = "a wave of 2 cm on water of 1 m in a tank of 2 m: 7 periods, 4 of the finest";
  c.layers = {25, 50, 100};
  c.finest_by_all = false;
  c.quick_layers = 25;
  c.flow = wave;
  c.measure = measure_wave;
  return c;
}

Case dam_break() {
  Case c;
  c.name = "dam-break";
  c.shows = "a column of 1 x 2 m: its front between 2 and 3.3 units of time";
  c.layers = {20, 40, 80};
  c.finest_by_all = false;
  c.quick_layers = 20;
  c.flow = dam;
  c.measure = measure_dam;
  return c;
}

Case elliptical_drop() {
  Case c;
  c.name = "elliptical-drop";
  c.shows = "a disc that is drawn out, without gravity";
  c.frame = kDropTime / kDropFrames;
  c.layers = {25, 50, 100};
  c.quick_layers = 20;
  c.flow = drop;
  c.measure = measure_drop;
  return c;
}

Case large_dam() {
  Case c;
  c.name = "large-dam";
  c.shows = "a frame of 100,128 particles that fall 9 m, in 4 s; sph is measured on the first 1/150 s";
  c.layers = {50};
  c.flow = column_of_100000;
  c.measure = measure_frame;
  return c;
}

std::vector<Case> all_cases() {
  return {taylor_green(), hydrostatic(1), hydrostatic(4), standing_wave(), dam_break(), elliptical_drop(), large_dam()};
}

}  // namespace psim::fluids
