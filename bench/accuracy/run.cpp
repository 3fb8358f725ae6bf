#include "run.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <variant>

namespace psim::accuracy {
namespace {

bool is_finite(const BodyState& b) { return std::isfinite(b.x + b.y + b.angle + b.vx + b.vy + b.omega); }

bool moves(const BodyDesc& body) { return body.type == BodyType::dynamic_body; }

/// Sum over dynamic bodies of f(description, state).
template <class F>
double sum_over(Run& run, const F& f) {
  const auto& states = run.bodies();
  const auto& descs = run.model().bodies;
  double sum = 0;
  for (std::size_t k = 0; k < states.size(); ++k) {
    if (moves(descs[k])) sum += f(descs[k], states[k]);
  }
  return sum;
}

double distance_to(const SegmentShape& s, Vec2 origin, const BodyState& disc) {
  const double ax = origin.x + s.p1.x, ay = origin.y + s.p1.y;
  const double ex = s.p2.x - s.p1.x, ey = s.p2.y - s.p1.y;
  const double along = ((disc.x - ax) * ex + (disc.y - ay) * ey) / (ex * ex + ey * ey);
  const double t = std::clamp(along, 0.0, 1.0);
  return std::hypot(disc.x - ax - t * ex, disc.y - ay - t * ey);
}

void append_if_deep(double depth, std::vector<double>& depths) {
  if (depth > 0) depths.push_back(depth);
}

/// Copies of discs at the seams, shifted to one side only, so that a pair across meets once.
void append_images(const Bounds& b, std::vector<BodyState>& discs) {
  const double width = b.xmax - b.xmin, height = b.ymax - b.ymin;
  double reach = 0;
  for (const BodyState& s : discs) reach = std::max(reach, 2 * s.radius);
  const std::size_t originals = discs.size();
  for (const auto& [i, j] : {std::pair{1, -1}, {1, 0}, {1, 1}, {0, 1}}) {
    for (std::size_t k = 0; k < originals; ++k) {
      BodyState image = discs[k];
      image.x += i * width;
      image.y += j * height;
      const bool near = image.x < b.xmax + reach && image.y > b.ymin - reach && image.y < b.ymax + reach;
      if (near) discs.push_back(image);
    }
  }
}

// Sorted by the left edge, a disc meets only those that begin before it ends.
void append_disc_overlaps(Run& run, std::vector<double>& depths) {
  const WorldDesc& world = run.model().scene.world;
  std::vector<BodyState> discs;
  for (const BodyState& s : run.bodies()) {
    if (s.radius > 0) discs.push_back(s);
  }
  if (world.boundary == Boundary::periodic) append_images(world.bounds, discs);
  std::ranges::sort(discs, {}, [](const BodyState& s) { return s.x - s.radius; });
  for (std::size_t a = 0; a < discs.size(); ++a) {
    for (std::size_t c = a + 1; c < discs.size(); ++c) {
      const BodyState &p = discs[a], &q = discs[c];
      if (q.x - q.radius > p.x + p.radius) break;
      if (p.type != BodyType::dynamic_body && q.type != BodyType::dynamic_body) continue;
      append_if_deep(p.radius + q.radius - std::hypot(q.x - p.x, q.y - p.y), depths);
    }
  }
}

void append_fixed_overlaps(Run& run, std::vector<double>& depths) {
  const auto& states = run.bodies();
  const WorldDesc& world = run.model().scene.world;
  for (const BodyDesc& fixed : run.model().bodies) {
    const auto* shape = std::get_if<SegmentShape>(&fixed.shape);
    if (!shape) continue;
    for (const BodyState& s : states) {
      if (s.radius > 0) append_if_deep(s.radius - distance_to(*shape, fixed.position, s), depths);
    }
  }
  if (world.boundary != Boundary::walls) return;
  const Bounds& b = world.bounds;
  for (const BodyState& s : states) {
    if (s.type != BodyType::dynamic_body) continue;
    for (const double gap : {s.x - b.xmin, b.xmax - s.x, s.y - b.ymin, b.ymax - s.y}) {
      append_if_deep(s.radius - gap, depths);
    }
  }
}

}  // namespace

void Run::advance() {
  simulation_->advance();
  ++frames_;
}

void Run::frame() {
  advance();
  visits_ += simulation_->row_visits();
}

void Run::frames(int count) {
  for (int k = 0; k < count; ++k) frame();
}

void Run::seconds(double duration) { frames(static_cast<int>(std::lround(duration * kFrameRate))); }

const std::vector<BodyState>& Run::bodies() {
  if (read_at_ == frames_) return bodies_;
  simulation_->read(bodies_);
  read_at_ = frames_;
  if (bodies_.size() != model_->bodies.size()) throw Failed("a body was lost");
  if (!std::ranges::all_of(bodies_, is_finite)) throw Failed("a body is no longer finite");
  return bodies_;
}

double kinetic_energy(Run& run) {
  return sum_over(run, [](const BodyDesc& d, const BodyState& s) {
    return 0.5 * mass_of(d) * (s.vx * s.vx + s.vy * s.vy) + 0.5 * inertia_of(d) * s.omega * s.omega;
  });
}

double energy(Run& run) {
  const Vec2 g = run.model().scene.world.gravity;
  return kinetic_energy(run) -
         sum_over(run, [g](const BodyDesc& d, const BodyState& s) { return mass_of(d) * (g.x * s.x + g.y * s.y); });
}

Vec2 momentum(Run& run) {
  const auto x = [](const BodyDesc& d, const BodyState& s) { return mass_of(d) * s.vx; };
  const auto y = [](const BodyDesc& d, const BodyState& s) { return mass_of(d) * s.vy; };
  return {sum_over(run, x), sum_over(run, y)};
}

double angular_momentum(Run& run) {
  return sum_over(run, [](const BodyDesc& d, const BodyState& s) {
    return mass_of(d) * (s.x * s.vy - s.y * s.vx) + inertia_of(d) * s.omega;
  });
}

double rms_speed(Run& run) {
  const double squares = sum_over(run, [](const BodyDesc&, const BodyState& s) { return s.vx * s.vx + s.vy * s.vy; });
  return std::sqrt(squares / sum_over(run, [](const auto&, const auto&) { return 1.0; }));
}

std::vector<double> penetrations(Run& run) {
  std::vector<double> depths;
  append_disc_overlaps(run, depths);
  append_fixed_overlaps(run, depths);
  std::ranges::sort(depths);
  return depths;
}

double deepest(Run& run) {
  const auto depths = penetrations(run);
  return depths.empty() ? 0 : depths.back();
}

double quantile(const std::vector<double>& sorted, double q) {
  if (sorted.empty()) return 0;
  return sorted[static_cast<std::size_t>(q * static_cast<double>(sorted.size() - 1))];
}

}  // namespace psim::accuracy
