#include "query/fluid_events.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <tuple>

namespace psim {
namespace {

// By sensor, part and particle. A sensor that has the number of one that is gone comes after that one.
auto place_in_order(const FluidEvent& e) { return std::tuple(e.sensor.index, e.sensor.generation, e.part, e.particle); }

bool comes_before(const FluidEvent& e, const FluidEvent& f) { return place_in_order(e) < place_in_order(f); }

// Appends those of a list that are not in another one.
void add_new(const std::vector<FluidEvent>& from, const std::vector<FluidEvent>& without, std::vector<FluidEvent>& to) {
  to.clear();
  std::set_difference(from.begin(), from.end(), without.begin(), without.end(), std::back_inserter(to), comes_before);
}

// The way that is the shortest one in a periodic world.
double shortest(double way, double period) { return period > 0 ? way - period * std::rint(way / period) : way; }

}  // namespace

// Finds the particles in the sensors of a part of the index.
void FluidEventList::look(const Observed& world, const QueryIndex::Part& part, const Fluids& fluids) {
  const BodyStore& b = world.bodies;
  const Vec2 centre = world.lattice.centre(), period = world.period();
  const Bounds& bounds = world.desc.bounds;
  Outline point;
  point.count = 1;
  for (const QueryItem& item : part.grid.items()) {
    const BodyKind& kind = b.kind(item.body);
    if (!b.is_sensor(kind, item.part) || is_out(b.info[item.body].place)) continue;
    if (b.filter_of(kind, item.part).mask == 0) continue;
    const Outline sensor = QueryIndex::outline(world, part, item, {});
    const Vec2 at = item.at + centre;
    const double r = wide(item.radius);
    Bounds box{at.x - r, at.y - r, at.x + r, at.y + r};
    const bool beyond =
        box.xmin < bounds.xmin || box.ymin < bounds.ymin || box.xmax > bounds.xmax || box.ymax > bounds.ymax;
    if (beyond && period.x > 0) box = bounds;
    const BodyId id = world.handle(item.body);
    fluids.look_in(box, [&](const kernels::FluidParticle& p, Vec2 place) {
      point.v[0] = {shortest(place.x - at.x, period.x), shortest(place.y - at.y, period.y)};
      if (overlap(point, sensor)) now_.push_back({id, item.part, p.fluid, p.id});
    });
  }
}

void FluidEventList::collect(const Observed& world, const QueryIndex& index, const Fluids& fluids) {
  now_.clear();
  if (fluids.size() != 0 && world.population.traits.sensors != 0) {
    for (const QueryIndex::Who who : {QueryIndex::kMoving, QueryIndex::kSleeping, QueryIndex::kFixed}) {
      look(world, index.part(world, who), fluids);
    }
  }
  // Total order: a particle is listed again only for another piece of the same part, and then all is alike.
  std::ranges::sort(now_, comes_before);
  now_.erase(std::unique(now_.begin(), now_.end()), now_.end());
  add_new(now_, inside_, begin);
  add_new(inside_, now_, end);
  inside_.swap(now_);
}

}  // namespace psim
