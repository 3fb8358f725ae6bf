// Emitters and drains of a world's fluids, and what a game asks of fluids: how much is where, and what they did to a body.
#include <algorithm>

#include "base/range_text.h"
#include "psim/limits.h"
#include "query/query_index.h"
#include "world/world_impl.h"

namespace psim {
namespace {

// The one of this id in a list by id, or its end.
template <class List>
auto find_by_id(List& list, std::uint32_t id) {
  const auto at = std::ranges::lower_bound(list, id, {}, [](const auto& of) { return of.id; });
  return at != list.end() && at->id == id ? at : list.end();
}

template <class List>
bool erase_by_id(List& list, std::uint32_t id) {
  const auto at = find_by_id(list, id);
  if (at == list.end()) return false;
  list.erase(at);
  return true;
}

std::string too_many(std::size_t most, const char* what) {
  return "a world has at most " + std::to_string(most) + " " + what;
}

// The outlines of the sensor shapes of a body that have a point in a box, seen from the lower left corner of the box.
std::vector<Outline> sensors_in(Owners& w, std::uint32_t id, const Bounds& box) {
  const Observed world = w.observed();
  const Vec2 low{box.xmin, box.ymin}, from = low - world.lattice.centre(), size = Vec2{box.xmax, box.ymax} - low;
  std::vector<Outline> found;
  for (const QueryIndex::Who who : {QueryIndex::kMoving, QueryIndex::kSleeping, QueryIndex::kFixed}) {
    const QueryIndex::Part& part = w.observers.queries.part(world, who);
    part.grid.in_box(from, from + size, [&](const QueryItem& item, Vec2 shift) {
      if (item.body != id || !w.bodies.is_sensor(w.bodies.kind(id), item.part)) return;
      found.push_back(QueryIndex::outline(world, part, item, item.seen_from(from, shift)));
    });
  }
  return found;
}

}  // namespace

EmitterId World::add_emitter(const EmitterDesc& desc, std::string& error) try {
  const FloatSettings settings;
  Owners& w = impl_->settled();
  FluidTaps& taps = w.fluids.taps();
  error = taps.emitters.size() < kMostEmitters && taps.next_emitter < kNoEmitter
              ? check_emitter(desc, w.fluids.kinds().size(), w.desc.bounds)
              : too_many(kMostEmitters, "emitters");
  if (!error.empty()) return kNoEmitter;
  FluidEmitter emitter;
  emitter.id = taps.next_emitter;
  emitter.desc = desc;
  taps.emitters.push_back(emitter);
  w.plan_stale = true;
  return taps.next_emitter++;
} catch (const std::bad_alloc&) {
  say_no_room(*impl_, "the emitter", error);
  return impl_->ran_out(kNoEmitter);
}

DrainId World::add_drain(const Bounds& region, std::string& error) try {
  const FloatSettings settings;
  Owners& w = impl_->settled();
  FluidTaps& taps = w.fluids.taps();
  error = taps.drains.size() < kMostDrains && taps.next_drain < kNoDrain ? check_drain(region)
                                                                         : too_many(kMostDrains, "drains");
  if (!error.empty()) return kNoDrain;
  taps.drains.push_back({taps.next_drain, region});
  w.plan_stale = true;
  return taps.next_drain++;
} catch (const std::bad_alloc&) {
  say_no_room(*impl_, "the drain", error);
  return impl_->ran_out(kNoDrain);
}

bool World::remove_emitter(EmitterId id) try {
  return erase_by_id(impl_->settled().fluids.taps().emitters, id);
} catch (const std::bad_alloc&) {
  return impl_->ran_out(false);
}

bool World::remove_drain(DrainId id) try {
  return erase_by_id(impl_->settled().fluids.taps().drains, id);
} catch (const std::bad_alloc&) {
  return impl_->ran_out(false);
}

bool World::set_emitter_speed(EmitterId id, double speed) try {
  auto& emitters = impl_->settled().fluids.taps().emitters;
  const auto at = find_by_id(emitters, id);
  if (at == emitters.end() || !limits::kVelocity.contains(speed)) return false;
  at->desc.speed = speed;
  return true;
} catch (const std::bad_alloc&) {
  return impl_->ran_out(false);
}

FluidAmount World::fluid_in(const Bounds& region, FluidId fluid) const {
  const FloatSettings settings;
  return impl_->fluids.amount_in(region, fluid, [](Vec2) { return true; });
}

std::optional<FluidAmount> World::fluid_in_sensor(BodyId id, FluidId fluid) const try {
  const FloatSettings settings;
  std::optional<Bounds> box = bounds_of(id);
  if (!box) return std::nullopt;
  Owners& w = *impl_;
  const Bounds& b = w.desc.bounds;
  const bool beyond = box->xmin < b.xmin || box->ymin < b.ymin || box->xmax > b.xmax || box->ymax > b.ymax;
  if (beyond && w.desc.boundary == Boundary::periodic) box = b;
  const std::vector<Outline> sensors = sensors_in(w, id.index, *box);
  if (sensors.empty()) return FluidAmount();
  Outline point;
  point.count = 1;
  return w.fluids.amount_in(*box, fluid, [&](Vec2 at) {
    point.v[0] = at - Vec2{box->xmin, box->ymin};
    return std::ranges::any_of(sensors, [&](const Outline& sensor) { return psim::overlap(point, sensor); });
  });
} catch (const std::bad_alloc&) {
  return nothing_found<std::optional<FluidAmount>>();
}

std::optional<FluidLoad> World::fluid_load(BodyId id) const {
  if (!is_valid(id)) return std::nullopt;
  const auto& forces = impl_->fluids.forces();
  const auto at = find_by_id(forces, id.index);
  if (at == forces.end() || at->generation != id.generation) return FluidLoad();
  return FluidLoad{at->force, at->torque};
}

}  // namespace psim
