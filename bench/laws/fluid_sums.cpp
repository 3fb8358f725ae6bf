#include "fluid_sums.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "course.h"

namespace psim::laws {
namespace {

// Adds a mass that moves. The height is that of the lowest middle so far, as a potential, until all are there.
void take(FluidSums& sums, double mass, const BodyState& s, Vec2 gravity) {
  sums.mass += mass;
  sums.centre = {sums.centre.x + mass * s.x, sums.centre.y + mass * s.y};
  sums.momentum = {sums.momentum.x + mass * s.vx, sums.momentum.y + mass * s.vy};
  sums.angular += mass * (s.x * s.vy - s.y * s.vx);
  sums.kinetic += mass * (s.vx * s.vx + s.vy * s.vy) / 2;
  sums.potential -= mass * (gravity.x * s.x + gravity.y * s.y);
  sums.height = std::min(sums.height, -(gravity.x * s.x + gravity.y * s.y));
  sums.moving += mass * std::hypot(s.vx, s.vy);
}

void take_fluids(FluidSums& sums, const World& world, const Scene& run, const Scene& scene, const Change& change,
                 double time) {
  std::vector<FluidParticleState> particles;
  world.fluid_particles(particles);
  double mass = 0;
  Vec2 first, second;  // moments
  for (const FluidParticleState& p : particles) {
    const FluidDesc& f = run.fluids[p.fluid].fluid;
    const double m = f.density * f.spacing * f.spacing / change.heavier;
    BodyState s;
    s.x = p.position.x, s.y = p.position.y, s.vx = p.velocity.x, s.vy = p.velocity.y;
    s = change.back(s, time);
    take(sums, m, s, scene.world.gravity);
    mass += m;
    first = {first.x + m * s.x, first.y + m * s.y};
    second = {second.x + m * s.x * s.x, second.y + m * s.y * s.y};
  }
  if (mass == 0) return;
  sums.mean = {first.x / mass, first.y / mass};
  sums.spread = {std::sqrt(std::max(0.0, second.x / mass - sums.mean.x * sums.mean.x)),
                 std::sqrt(std::max(0.0, second.y / mass - sums.mean.y * sums.mean.y))};
}

}  // namespace

FluidSums sums_of(const World& world, const Scene& run, const Scene& scene, const Change& change, double time) {
  FluidSums sums;
  sums.height = 1e300;
  take_fluids(sums, world, run, scene, change, time);
  for (std::uint32_t k = 0; k < run.bodies.size(); ++k) {
    const BodyId id = world.id_of(k);
    if (run.bodies[k].type != BodyType::dynamic_body || !world.is_valid(id)) continue;
    BodyState s = *world.body(id);
    const Vec2 middle = *world.centre_of_mass(id);
    s.x = middle.x, s.y = middle.y;
    s = change.back(s, time);
    const BodyTraits traits = *world.traits(id);
    take(sums, traits.mass / change.heavier, s, scene.world.gravity);
    const double inertia = traits.inertia / (change.heavier * change.scale * change.scale);
    sums.kinetic += inertia * s.omega * s.omega / 2;
    sums.angular += inertia * s.omega;
    sums.moving += std::sqrt(inertia * traits.mass / change.heavier) * std::fabs(s.omega);
  }
  const double pull = std::hypot(scene.world.gravity.x, scene.world.gravity.y);
  sums.height = pull > 0 ? (sums.potential / sums.mass - sums.height) / pull : 0;
  sums.centre = {sums.centre.x / sums.mass, sums.centre.y / sums.mass};
  return sums;
}

std::vector<FluidSums> sums_course(const Scene& run, const Scene& scene, const Change& change, int frames) {
  const auto world = world_of(run);
  std::vector<FluidSums> course;
  for (int frame = 0; frame <= frames; ++frame) {
    if (frame > 0) world->step();
    course.push_back(sums_of(*world, run, scene, change, frame * run.world.dt));
  }
  return course;
}

namespace {

Vec2 from_body(Vec2 place, double angle, Vec2 point) {
  const double c = std::cos(angle), s = std::sin(angle), x = point.x - place.x, y = point.y - place.y;
  return {c * x + s * y, c * y - s * x};
}

double to_segment(Vec2 p, Vec2 a, Vec2 b) {
  const double x = b.x - a.x, y = b.y - a.y, square = x * x + y * y;
  const double t = square > 0 ? std::clamp(((p.x - a.x) * x + (p.y - a.y) * y) / square, 0.0, 1.0) : 0;
  return std::hypot(p.x - a.x - t * x, p.y - a.y - t * y);
}

double depth(const DiscShape& s, Vec2 p) { return s.radius - std::hypot(p.x, p.y); }
double depth(const SegmentShape&, Vec2) { return 0; }
double depth(const ChainShape&, Vec2) { return 0; }
double depth(const CapsuleShape& s, Vec2 p) { return s.radius - to_segment(p, s.p1, s.p2); }

double depth(const PolygonShape& s, Vec2 p) {
  double nearest = 1e300, inside = 1e300;
  for (std::size_t k = 0; k < s.vertices.size(); ++k) {
    const Vec2 a = s.vertices[k], b = s.vertices[(k + 1) % s.vertices.size()];
    nearest = std::min(nearest, to_segment(p, a, b));
    inside = std::min(inside, (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x));
  }
  return s.radius + (inside > 0 ? nearest : -nearest);
}

double depth(const BoxShape& s, Vec2 p) {
  const double x = s.width / 2, y = s.height / 2;
  return depth(PolygonShape{{{-x, -y}, {x, -y}, {x, y}, {-x, y}}, s.radius}, p);
}

double depth(const CompoundShape& s, Vec2 p) {
  double most = 0;
  for (const ShapePart& part : s.parts) {
    const Vec2 local = from_body(part.position, part.angle, p);
    most = std::max(most, std::visit([&](const auto& of) { return depth(of, local); }, part.shape));
  }
  return most;
}

}  // namespace

double depth_in(const Shape& shape, const BodyState& body, Vec2 point) {
  const Vec2 local = from_body({body.x, body.y}, body.angle, point);
  return std::visit([&](const auto& s) { return depth(s, local); }, shape);
}

}  // namespace psim::laws
