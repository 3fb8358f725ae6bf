#include "fluid/fluid_taps.h"

#include <algorithm>
#include <cmath>
#include <new>

#include "base/range_text.h"
#include "bodies/hull.h"
#include "fluid/fluids.h"
#include "psim/limits.h"

namespace psim {
namespace {

constexpr double kMostColumns = 1e7;  // as many as a world has particles

}  // namespace

std::string check_emitter(const EmitterDesc& d, std::size_t fluids, const Bounds& bounds) {
  if (d.fluid >= fluids) return "there is no such fluid";
  RangeCheck check;
  for (const Vec2 at : {d.from, d.to}) {
    check("an emitter's x", at.x, {bounds.xmin, bounds.xmax})("an emitter's y", at.y, {bounds.ymin, bounds.ymax});
  }
  check("an emitter's length", length_of(d.to - d.from), limits::kRodLength);
  check("an emitter's speed", d.speed, limits::kVelocity);
  if (!check.error.empty()) return check.error;
  if (!(d.start >= 0 && std::isfinite(d.start))) {
    return "an emitter's start must be 0 or more, not " + exact_text(d.start);
  }
  if (!(d.end >= d.start)) {
    return "an emitter's end must not be before its start, " + exact_text(d.start) + ", not " + exact_text(d.end);
  }
  return {};
}

std::string check_drain(const Bounds& r) {
  RangeCheck check;
  for (const double x : {r.xmin, r.xmax}) check("a drain's x", x, limits::kCoordinate);
  for (const double y : {r.ymin, r.ymax}) check("a drain's y", y, limits::kCoordinate);
  if (!check.error.empty()) return check.error;
  return r.xmin < r.xmax && r.ymin < r.ymax ? std::string() : "a drain's region must have a width and a height";
}

FluidOutflow outflow(const FluidEmitter& e, double spacing, double dt) {
  FluidOutflow flow;
  const double length = length_of(e.desc.to - e.desc.from);
  const double columns = std::clamp(std::round(length / spacing), 1.0, kMostColumns);
  flow.columns = static_cast<std::uint32_t>(columns);
  flow.pitch = columns * spacing * spacing / length;
  const double open = std::max(e.age, e.desc.start), shut = std::min(e.age + dt, e.desc.end);
  flow.left = e.rows;
  if (!(shut > open)) return flow;
  flow.late = e.age + dt - shut;
  flow.left += std::fabs(e.desc.speed) * (shut - open) / flow.pitch;
  flow.rows = std::floor(flow.left);
  flow.left -= flow.rows;
  return flow;
}

void Fluids::lay_corner(const Bounds& bounds, Vec2 first) {
  if (particles_.next_id() != 0 || space_.boundary != Boundary::open) return;
  const double spacing = kinds_[0].spacing;
  begin(fluid_space(bounds, space_.boundary, 2 * spacing, first - Vec2{spacing / 2, spacing / 2}));
}

void Fluids::drain() {
  for (const FluidDrain& d : taps_.drains) {
    if (particles_.size() == 0) return;
    const std::size_t removed = particles_.remove(d.region, true, solver_.grid(), space_);
    if (removed != 0) stir();
    taps_.drained += removed;
  }
}

// The first `count` particles of the rows that flow out, the oldest row first. Each has fallen since it left the segment.
void Fluids::let_out(FluidEmitter& e, const FluidOutflow& flow, std::size_t count, Vec2 gravity, const Bounds& bounds) {
  const Vec2 along = e.desc.to - e.desc.from;
  const double length = length_of(along), speed = std::fabs(e.desc.speed), side = e.desc.speed < 0 ? -1 : 1;
  const Vec2 out = (side / length) * Vec2{-along.y, along.x};
  for (std::size_t k = 0; k < count; ++k) {
    const double row = flow.rows - 1 - static_cast<double>(k / flow.columns);
    const double column = (static_cast<double>(k % flow.columns) + 0.5) / flow.columns;
    const double since = (flow.left + row) * flow.pitch / speed + flow.late;
    Vec2 at = e.desc.from + column * along + (since * speed) * out + (since * since / 2) * gravity;
    if (space_.boundary != Boundary::periodic) {
      at = {std::clamp(at.x, bounds.xmin, bounds.xmax), std::clamp(at.y, bounds.ymin, bounds.ymax)};
    }
    if (k == 0) lay_corner(bounds, at);
    add(e.desc.fluid, at, speed * out + since * gravity);
  }
  e.emitted += count;
  taps_.emitted += count;
}

bool Fluids::emit(double dt, Vec2 gravity, const Bounds& bounds) {
  bool room = true;
  for (FluidEmitter& e : taps_.emitters) {
    const FluidOutflow flow = outflow(e, kinds_[e.desc.fluid].spacing, dt);
    const auto ids = static_cast<double>(FluidParticles::kMostIds - particles_.next_id());
    const auto place = static_cast<double>(kMostParticles - particles_.size());
    const double allowed = static_cast<double>(e.desc.limit - e.emitted);
    const double wanted = std::min(flow.rows * flow.columns, allowed);
    double count = std::min({wanted, ids, place});
    try {
      if (count > 0) make_room(static_cast<std::size_t>(count));
    } catch (const std::bad_alloc&) {
      count = 0;
      room = false;
    }
    if (count > 0) let_out(e, flow, static_cast<std::size_t>(count), gravity, bounds);
    constexpr double kMostCounted = 1e15;
    taps_.withheld += static_cast<std::uint64_t>(std::min(wanted - count, kMostCounted));
    e.rows = flow.left;
    e.age += dt;
  }
  return room;
}

void Fluids::look_in(const Bounds& box, const SeeParticle& see) const {
  particles_.each_near(solver_.grid(), box, space_, [&](const kernels::FluidParticle& p, const FluidTile& tile) {
    const Vec2 at = FluidParticles::place_of(p, tile, space_);
    if (at.x >= box.xmin && at.x <= box.xmax && at.y >= box.ymin && at.y <= box.ymax) see(p, at);
  });
}

FluidAmount Fluids::amount_in(const Bounds& box, FluidId fluid, const std::function<bool(Vec2)>& holds) const {
  FluidAmount sum;
  Vec2 momentum;
  look_in(box, [&](const kernels::FluidParticle& p, Vec2 at) {
    if ((fluid != kNoFluid && p.fluid != fluid) || !holds(at)) return;
    const FluidKind& kind = kinds_[p.fluid];
    const double mass = kind.density * kind.spacing * kind.spacing;
    ++sum.particles;
    sum.mass += mass;
    momentum = momentum + mass * Vec2{double{p.u}, double{p.v}};
  });
  if (sum.mass > 0) sum.mean_velocity = (1 / sum.mass) * momentum;
  return sum;
}

}  // namespace psim
