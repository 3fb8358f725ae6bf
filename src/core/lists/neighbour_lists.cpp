#include "lists/neighbour_lists.h"

#include <algorithm>
#include <cmath>

#include "bodies/body_store.h"

namespace psim {

void NeighbourLists::measure(const ListSettings& world, double dt) {
  const WorldDesc& desc = *world.desc;
  const ListPlan plan = plan_lists(bodies, world, dt);
  const bool selected = plan.mode != ListMode::persistent;
  const double reach = plan.outer + (selected ? 0 : 2 * kMarginFrames * dt * plan.speed);
  const double growth = made.reach > 0 ? reach * reach / (made.reach * made.reach) : 1;
  const bool changed =
      broad.cells().density() == 0 || selected != selects() || plan.frames != made.frames || desc.skin != made.skin;
  mode = plan.mode;
  made.frames = plan.frames;
  made.reach = reach;
  made.skin = desc.skin;
  made.speed = plan.speed;
  made.crowding = plan.crowding;
  made.impact_rate = plan.impacts;
  BroadPhaseParams p;
  p.margin = plan.margin;
  p.ahead = plan.ahead;
  p.outer = changed ? plan.outer : 0;
  p.sample = world.governed;
  if (!changed && world.makes_room) p.growth = std::clamp(growth, 1.0, 4.0);
  p.walls = desc.boundary == Boundary::walls;
  p.periodic = desc.boundary == Boundary::periodic;
  p.mixed_radii = world.mixed_radii;
  p.link_all = world.link_all;
  const Vec2 c = broad.lattice().centre();
  p.bounds = {desc.bounds.xmin - c.x, desc.bounds.ymin - c.y, desc.bounds.xmax - c.x, desc.bounds.ymax - c.y};
  renewal.forget();
  broad.measure(p);
}

bool NeighbourLists::move(std::size_t begin, std::size_t end) {
  const bool last = end == broad.cells().moves();
  if (last && !selects()) table.swap(old_table);
  broad.move(found(), begin, end);
  return last;
}

void NeighbourLists::select(const ListSettings& world, double dt, std::size_t begin, std::size_t end) {
  constexpr double kReserve = 8;  // of the r.m.s. speed: all of the sample's speed where one body in 64 moves
  if (begin == 0) {
    table.swap(old_table);
    const bool periodic = world.desc->boundary == Boundary::periodic;
    speeds.measure(bodies, candidates.strips, {world.uneven, periodic, broad.lattice().pitch_y(), kMarginFrames * dt},
                   pool);
    slack.resize(candidates.strips.size());
  }
  for (std::size_t s = begin; s < end; ++s) {
    const double speed = std::fmin(made.speed, kReserve * speeds.at(s));
    slack[s] = static_cast<float>(impact_slack(world, speed, made.crowding, dt));
  }
  broad.select(static_cast<float>(kMarginFrames * dt), slack, world.link_all, candidates, table, begin, end);
}

}  // namespace psim
