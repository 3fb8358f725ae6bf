#include "bodies/quarantine.h"

#include <algorithm>
#include <cmath>

namespace psim {

std::uint32_t Quarantine::freeze_doubtful(const Population& population, const Freeze& freeze) {
  std::uint32_t frozen = 0;
  for (const BodyId id : doubtful) {
    const BodyInfo& info = population.bodies.info[id.index];
    if (info.place != Place::moving || info.generation != id.generation) continue;  // gone, or frozen already
    BodyState last = population.state_of(id.index);
    last.vx = last.vy = last.omega = 0;
    freeze(id.index, last);
    ++frozen;
  }
  doubtful.clear();
  return frozen;
}

std::uint32_t Quarantine::settle(Population& population, const Lattice& lattice, double dt, const Freeze& freeze) {
  BodyStore& bodies = population.bodies;
  const auto limit = static_cast<float>(speed_limit(lattice, dt));
  std::uint32_t frozen = 0;
  for (std::uint32_t i = 0; i < bodies.count; ++i) {
    if (bodies.id[i] == kNoSlot) continue;
    float& vx = bodies.vel[2 * std::size_t{i}];
    float& vy = bodies.vel[2 * std::size_t{i} + 1];
    const LatticePoint at = bodies.point(i);
    const bool turns =
        bodies.rim_speed.empty() || (std::isfinite(bodies.rim_speed[i]) && std::isfinite(bodies.angle[i]));
    if (!std::isfinite(vx) || !std::isfinite(vy) || !std::isfinite(at.dx) || !std::isfinite(at.dy) || !turns) {
      BodyState last = population.state_of(bodies.id[i]);
      if (!std::isfinite(last.angle)) last.angle = 0;
      const Vec2 seen = lattice.to_world({bodies.built[2 * i], bodies.built[2 * i + 1]});
      last.x = seen.x;
      last.y = seen.y;
      last.vx = last.vy = last.omega = 0;
      freeze(bodies.id[i], last);
      ++frozen;
      continue;
    }
    const float speed = std::sqrt(vx * vx + vy * vy);
    if (speed > limit) {
      const float scale = std::isfinite(speed) ? limit / speed * 0.999f : 0.0f;
      vx *= scale;
      vy *= scale;
    }
  }
  return frozen;
}

bool Quarantine::walls_hold(const BodyStore& bodies, const Walls& walls, const kernels::KernelTable& kernels,
                            BlockRange r) {
  const std::int32_t* first = bodies.pos.data() + 2 * std::size_t{r.begin} * kernels::kBlock;
  std::int32_t extent[4] = {first[0], first[1], first[0], first[1]};
  kernels.extent(bodies.pos.data(), extent, r.begin, r.end);
  return extent[0] > walls.low.x && extent[1] > walls.low.y && extent[2] < walls.high.x && extent[3] < walls.high.y;
}

std::uint32_t Quarantine::remove_escaped(const Population& population, const Bounds& b, const Remove& remove) {
  const BodyStore& bodies = population.bodies;
  std::uint32_t removed = 0;
  for (std::uint32_t i = 0; i < bodies.count; ++i) {
    if (bodies.id[i] == kNoSlot) continue;
    const BodyState s = population.state_of(bodies.id[i]);
    if (s.x >= b.xmin && s.x <= b.xmax && s.y >= b.ymin && s.y <= b.ymax) continue;
    remove(bodies.id[i]);
    ++removed;
  }
  escaped += removed;
  return removed;
}

// A disc that met more impacts in a substep than the sweeps settle may come out behind a wall. It is put back to where
// it touches the wall from inside, and its speed is reversed. Kinematic bodies pass through walls; they stop only
// where the lattice ends.
bool Quarantine::bring_back(Population& population, const Lattice& lattice, const WorldDesc& desc) {
  BodyStore& bodies = population.bodies;
  const Bounds& b = desc.bounds;
  bool any = false;
  const auto back = [](double& x, float& v, double low, double high, double radius, float e) {
    if (x >= low && x <= high) return;
    const double room = std::fmin(radius, (high - low) / 2);
    const bool left = x < low;
    x = left ? low + room : high - room;
    if ((v < 0) == left) v = -e * v;
  };
  for (std::uint32_t i = 0; i < bodies.count; ++i) {
    if (bodies.id[i] == kNoSlot) continue;
    const BodyProperties& properties = bodies.properties(bodies.id[i]);
    std::int32_t* pos = bodies.pos.data() + 2 * std::size_t{i};
    float* vel = bodies.vel.data() + 2 * std::size_t{i};
    if (properties.type == BodyType::kinematic_body) {
      for (int axis = 0; axis < 2; ++axis) pos[axis] = std::clamp(pos[axis], -kFarSteps, kFarSteps);
      continue;
    }
    Vec2 at = lattice.to_world(bodies.point(i));
    const Vec2 before = at;
    const float e = std::fmax(properties.restitution, static_cast<float>(desc.wall.restitution));
    const auto radius = static_cast<double>(properties.radius);
    back(at.x, vel[0], b.xmin, b.xmax, radius, e);
    back(at.y, vel[1], b.ymin, b.ymax, radius, e);
    if (at.x == before.x && at.y == before.y) continue;
    bodies.put_point(i, lattice.to_lattice(at));
    any = true;
  }
  return any;
}

}  // namespace psim
