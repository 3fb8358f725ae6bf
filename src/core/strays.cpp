// Bodies that left the bounds, are too fast or are no numbers any more. All of it is rare: the
// integrate stage tells whether there is any, and only then every body is looked at. O(bodies).
#include <algorithm>
#include <cmath>

#include "world_impl.h"

namespace psim {

// The engine's cap: kFarSteps a frame, so that no body can wrap around the lattice.
double World::Impl::speed_limit(double dt) const {
  const double pitch = std::fmin(lattice.pitch_x(), lattice.pitch_y());
  return std::fmin(kFarSteps * pitch / dt, 1e15);
}

// The fast body is slowed to the cap; the broken one is frozen where the lists last saw it.
void World::Impl::settle_bad_bodies(double dt, StepReport& report) {
  const auto limit = static_cast<float>(speed_limit(dt));
  for (std::uint32_t i = 0; i < bodies.count; ++i) {
    if (bodies.id[i] == kNoSlot) continue;
    float& vx = bodies.vel[2 * std::size_t{i}];
    float& vy = bodies.vel[2 * std::size_t{i} + 1];
    const float dx = bodies.disp[2 * std::size_t{i}], dy = bodies.disp[2 * std::size_t{i} + 1];
    const bool spins = bodies.spin.empty() || (std::isfinite(bodies.spin[i]) && std::isfinite(bodies.angle[i]));
    if (!std::isfinite(vx) || !std::isfinite(vy) || !std::isfinite(dx) || !std::isfinite(dy) ||
        !spins) {
      BodyState last = state_of(bodies.id[i]);
      if (!std::isfinite(last.angle)) last.angle = 0;
      const Vec2 at = lattice.to_world(bodies.built[2 * std::size_t{i}],
                                       bodies.built[2 * std::size_t{i} + 1], 0, 0);
      last.x = at.x;
      last.y = at.y;
      last.vx = last.vy = last.omega = 0;
      freeze(bodies.id[i], last);
      ++report.quarantined;
      continue;
    }
    const float speed = std::sqrt(vx * vx + vy * vy);
    if (speed > limit) {
      const float scale = std::isfinite(speed) ? limit / speed * 0.999f : 0.0f;
      vx *= scale;
      vy *= scale;
    }
  }
}

void World::Impl::freeze_doubtful(StepReport& report) {
  for (const BodyId id : doubtful) {
    const BodyInfo& info = bodies.info[id.index];
    if (info.place != Place::moving || info.generation != id.generation) continue;  // gone, or frozen already
    BodyState last = state_of(id.index);
    last.vx = last.vy = last.omega = 0;
    freeze(id.index, last);
    ++report.quarantined;
  }
  doubtful.clear();
}

// True if all centres of the blocks lie within the bounds (to a lattice step).
bool World::Impl::walls_hold(BlockRange r) const {
  const std::int32_t* first = bodies.pos.data() + 2 * std::size_t{r.begin} * kernels::kBlock;
  std::int32_t extent[4] = {first[0], first[1], first[0], first[1]};
  kernels.extent(bodies.pos.data(), extent, r.begin, r.end);
  return extent[0] > walls.low.x && extent[1] > walls.low.y && extent[2] < walls.high.x &&
         extent[3] < walls.high.y;
}

// Open worlds: bodies whose centre left the bounds are taken out and counted.
void World::Impl::remove_escaped(StepReport& report) {
  for (std::uint32_t i = 0; i < bodies.count; ++i) {
    if (bodies.id[i] == kNoSlot) continue;
    const BodyState s = state_of(bodies.id[i]);
    if (s.x >= desc.bounds.xmin && s.x <= desc.bounds.xmax && s.y >= desc.bounds.ymin &&
        s.y <= desc.bounds.ymax) {
      continue;
    }
    remove(bodies.id[i]);
    ++report.escaped;
  }
  escaped += report.escaped;
}

// Walls: a disc that met more impacts in a substep than the sweeps settle may come out behind a
// wall. It is put back to where it touches the wall from inside, its speed reversed. Kinematic
// bodies pass through walls, and stop only where the lattice ends.
void World::Impl::bring_back() {
  const Bounds& b = desc.bounds;
  const auto back = [](double& x, float& v, double low, double high, double radius, float e) {
    if (x >= low && x <= high) return;
    const double room = std::fmin(radius, (high - low) / 2);
    const bool left = x < low;
    x = left ? low + room : high - room;
    if ((v < 0) == left) v = -e * v;
  };
  for (std::uint32_t i = 0; i < bodies.count; ++i) {
    if (bodies.id[i] == kNoSlot) continue;
    const Surface& surface = bodies.surfaces[bodies.info[bodies.id[i]].surface];
    std::int32_t* pos = bodies.pos.data() + 2 * std::size_t{i};
    float* disp = bodies.disp.data() + 2 * std::size_t{i};
    float* vel = bodies.vel.data() + 2 * std::size_t{i};
    if (surface.type == BodyType::kinematic_body) {
      for (int axis = 0; axis < 2; ++axis) pos[axis] = std::clamp(pos[axis], -kFarSteps, kFarSteps);
      continue;
    }
    Vec2 at = lattice.to_world(pos[0], pos[1], disp[0], disp[1]);
    const Vec2 before = at;
    const float e = std::fmax(surface.restitution, static_cast<float>(desc.wall.restitution));
    const auto radius = static_cast<double>(surface.radius);
    back(at.x, vel[0], b.xmin, b.xmax, radius, e);
    back(at.y, vel[1], b.ymin, b.ymax, radius, e);
    if (at.x == before.x && at.y == before.y) continue;
    const LatticePoint p = lattice.to_lattice(at);
    pos[0] = p.x;
    pos[1] = p.y;
    disp[0] = p.dx;
    disp[1] = p.dy;
    forces_stale = true;
  }
}

}  // namespace psim
