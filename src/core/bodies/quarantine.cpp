#include "bodies/quarantine.h"

#include <algorithm>
#include <cmath>

#include "base/elementary.h"
#include "bodies/body_desc.h"

namespace psim {

namespace {

BodyState at_rest(BodyState s) {
  s.vx = s.vy = s.omega = 0;
  return s;
}

}  // namespace

std::uint32_t Quarantine::freeze_doubtful(const Population& population, const Freeze& freeze) {
  std::uint32_t frozen = 0;
  for (const BodyId id : doubtful) {
    if (!population.is_valid(id) || population.bodies.info[id.index].place != Place::moving) continue;
    freeze(at_rest(population.state_of(id.index)));
    ++frozen;
  }
  doubtful.clear();
  return frozen;
}

std::uint32_t Quarantine::settle(Population& population, const Lattice& lattice, double dt, const Freeze& freeze) {
  BodyStore& bodies = population.bodies;
  const auto limit = static_cast<float>(speed_limit(lattice, dt));
  std::uint32_t frozen = 0;
  for (std::size_t i = 0; i < bodies.count; ++i) {
    if (bodies.id[i] == kNoSlot) continue;
    const LatticePoint at = bodies.point(i);
    if (!finite(bodies.velocity(i)) || !finite(Vec2{at.dx, at.dy}) || !finite(bodies.rim_speed_of(i)) ||
        !finite(bodies.angle_of(i))) {
      BodyState last = at_rest(population.state_of(bodies.id[i]));
      if (!finite(last.angle)) last.angle = 0;
      const Vec2 seen = lattice.to_world({bodies.built[2 * i], bodies.built[2 * i + 1]});
      last.x = seen.x, last.y = seen.y;
      freeze(last);
      ++frozen;
      continue;
    }
    float &vx = bodies.vel[2 * i], &vy = bodies.vel[2 * i + 1];
    const float speed = std::sqrt(vx * vx + vy * vy);
    if (speed <= limit) continue;
    const float scale = std::isfinite(speed) ? limit / speed * 0.999f : 0.0f;
    vx *= scale;
    vy *= scale;
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

void Quarantine::remove_escaped(const Population& population, const Bounds& b, const Remove& remove) {
  const BodyStore& bodies = population.bodies;
  for (std::size_t i = 0; i < bodies.count; ++i) {
    if (bodies.id[i] == kNoSlot) continue;
    const BodyState s = population.state_of(bodies.id[i]);
    if (contains(b, {s.x, s.y})) continue;
    remove(bodies.id[i]);
    ++escaped;
  }
}

// A disc that met more impacts in a substep than the sweeps settle may come out behind a wall. It is put back to where
// it touches the wall from inside, and its speed is reversed. Kinematic bodies pass through walls; they stop only
// where the lattice ends.
void Quarantine::bring_back(Population& population, const Lattice& lattice, const WorldDesc& desc) {
  BodyStore& bodies = population.bodies;
  const Bounds& b = desc.bounds;
  for (std::size_t i = 0; i < bodies.count; ++i) {
    if (bodies.id[i] == kNoSlot) continue;
    const BodyProperties& properties = bodies.properties(bodies.id[i]);
    if (properties.type() == BodyType::kinematic_body) {
      for (const std::size_t k : {2 * i, 2 * i + 1}) bodies.pos[k] = std::clamp(bodies.pos[k], -kFarSteps, kFarSteps);
      continue;
    }
    const float e = mixed(desc.mixing.restitution, properties.restitution, coefficient(desc.wall.restitution));
    const auto back = [&](double& x, float& v, double low, double high) {
      if (x >= low && x <= high) return false;
      const double room = lesser(double{properties.radius}, (high - low) / 2);
      const bool left = x < low;
      x = left ? low + room : high - room;
      if ((v < 0) == left) v = -e * v;
      return true;
    };
    Vec2 at = lattice.to_world(bodies.point(i));
    const bool was_beside = back(at.x, bodies.vel[2 * i], b.xmin, b.xmax);
    const bool was_beyond = back(at.y, bodies.vel[2 * i + 1], b.ymin, b.ymax);
    if (was_beside || was_beyond) bodies.put_point(i, lattice.to_lattice(at));
  }
}

}  // namespace psim
