// Bodies are pushed, something explodes, fields change, fluids are poured, bodies get other descriptions.
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "world_descs.h"
#include "world_session.h"

namespace psim::fuzz {
namespace {

// Decides by who meets whom; some of its numbers are wrong.
void decide(std::span<NewContact> contacts) {
  for (NewContact& c : contacts) {
    const std::uint32_t which = (c.a.index * 31 + c.b.index * 17 + c.part_a * 5 + c.part_b) % 12;
    if (which == 0) c.enabled = false;
    if (which == 1) c.friction = 2;
    if (which == 2) c.restitution = 0.9;
    if (which == 3) c.tangent_speed = -3, c.friction = 1;
    if (which == 4) c.friction = std::numeric_limits<double>::quiet_NaN();
    if (which == 5) c.restitution = 7, c.enabled = c.speed < 5;
  }
}

Field medium(ByteSource& own) {
  const Bounds region{own.number(-kHalf, 0), own.number(-kHalf, 0), own.number(1, kHalf), own.number(1, kHalf)};
  if (own.chance(128)) {
    return BuoyancyField{region, own.number(0.1, 5), own.number(0, 3), own.number(0, 3), own.vec2(-3, 3), 0xFFFFFFFFu};
  }
  WindField wind;
  wind.velocity = own.vec2(-30, 30);
  wind.density = own.number(0.01, 2);
  wind.drag = own.number(0, 2);
  wind.lift = own.chance(128) ? own.number(0, 2) : 0;
  if (own.chance(64)) wind.region = region;
  wind.mask = own.byte();
  return wind;
}

}  // namespace

void Session::push_body(BodyId id, Vec2 place) {
  const Digits digits({place.y, place.x});
  ByteSource own(digits);
  if (broken_.contains(id.index)) return;  // the next step freezes it
  const double nan = std::numeric_limits<double>::quiet_NaN();
  if (own.chance(64)) {
    const bool wrong = own.chance(8);
    const Vec2 force = wrong ? Vec2{0, nan} : own.vec2(-500, 500), at = own.vec2(-kHalf, kHalf);
    const double torque = wrong ? nan : own.number(-50, 50);
    const std::size_t which = own.below(3);
    say("force %u by %zu: %g %g torque %g at %g %g", id.index, which, force.x, force.y, torque, at.x, at.y);
    const bool pushed = change<bool>("applying a force", [&](auto& w) {
      if (which == 0) return w.apply_force(id, force);
      if (which == 1) return w.apply_force_at(id, force, {in_.home.x + at.x, in_.home.y + at.y});
      return w.apply_torque(id, torque);
    });
    require(!pushed || (is_live(id) && !wrong), "a force on a body that is not there, or no number");
  }
  if (own.chance(16)) {
    const Explosion blast{{in_.home.x + own.number(-kHalf, kHalf), in_.home.y + own.number(-kHalf, kHalf)},
                          own.number(0, 5),
                          own.number(0, 5),
                          own.number(-20, 50),
                          own.byte()};
    say("explode at %g %g", blast.position.x, blast.position.y);
    change<std::optional<std::size_t>>("explode", [&](auto& w) { return w.explode(blast); });
  }
  if (own.chance(12)) change_fields(own);
  if (own.chance(12)) {
    const bool on = own.chance(192);
    say("pre_solve %d", on);
    change<bool>("set_pre_solve", [&](auto& w) { return w.set_pre_solve(on ? PreSolve(decide) : PreSolve()), true; });
    for (const auto& w : worlds_) require((w->pre_solve() != nullptr) == on, "set_pre_solve does so");
  }
  if (own.chance(24)) {
    const BodyDesc to = body(own);
    say("body %u becomes type %d shape %zu", id.index, static_cast<int>(to.type), to.shape.index());
    const bool done = change<bool>("set_body", [&](auto& w) {
      std::string error;
      const bool changed = w.set_body(id, to, error);
      if (!changed) refused(error);
      return changed;
    });
    require(!done || is_live(id), "set_body: a body that is not there");
    if (done) {
      require(worlds_.front()->body(id)->type == to.type, "set_body: the type");
      require(worlds_.front()->is_enabled(id) == to.enabled, "set_body: whether it is enabled");
    }
  }
}

void Session::change_fields(ByteSource& own) {
  std::vector<Field> fields;
  while (fields.size() < 3 && own.chance(128)) {
    if (own.chance(96)) {
      fields.push_back(medium(own));
    } else if (own.chance(128)) {
      fields.push_back(WellField{own.vec2(-kHalf, kHalf), own.number(-50, 50), own.number(0, 1), own.number(0, 3),
                                 own.chance(128) ? own.number(0, 10) : 0});
    } else {
      fields.push_back(DragField{own.number(0, 2), own.chance(128) ? own.number(0, 1) : 0});
    }
  }
  say("%zu fields", fields.size());
  const bool done = change<bool>("set_fields", [&](auto& w) {
    std::string error;
    const bool changed = w.set_fields(fields, error);
    if (!changed) refused(error);
    return changed;
  });
  require(!done || worlds_.front()->desc().fields.size() == fields.size(), "set_fields does so");
}

// A fluid, and some particles of it or of an earlier one.
void Session::pour() {
  constexpr std::size_t kMostPoured = 300;
  FluidDesc desc{in_.number(0.3, 1), in_.number(1, 2000), in_.chance(64) ? in_.number(0, 1) : 0};
  if (!in_.tame && in_.chance(40)) desc.spacing = in_.number(-1e-3, 1e-2);
  const std::size_t columns = in_.below(12), rows = in_.below(12);
  const auto which = static_cast<FluidId>(in_.below(3));
  const Vec2 corner = in_.place(-kHalf, kHalf), velocity = in_.vec2(-20, 20);
  say("pour %zu x %zu of fluid %u, spacing %g, at %g %g", columns, rows, which, desc.spacing, corner.x, corner.y);
  std::vector<Vec2> places, velocities;
  for (std::size_t k = 0; k < columns * rows; ++k) {
    const auto i = static_cast<double>(k % columns), j = static_cast<double>(k / columns);
    places.push_back({corner.x + i * desc.spacing, corner.y + j * desc.spacing});
    if (which == 1) velocities.push_back(velocity);
  }
  const std::size_t before = worlds_.front()->fluid_report().particles;
  if (before > kMostPoured) return;
  const auto fluid = change<FluidId>("add_fluid", [&](auto& w) {
    std::string error;
    const FluidId id = w.add_fluid(desc, error);
    if (id == kNoFluid) refused(error);
    return id;
  });
  const bool done = change<bool>("add_particles", [&](auto& w) {
    std::string error;
    const bool added = w.add_particles(which == 0 ? fluid : which, places, velocities, error);
    if (!added) refused(error);
    return added;
  });
  const std::size_t after = before + (done ? places.size() : 0);
  require(worlds_.front()->fluid_report().particles == after, "add_particles: the number of particles");
  std::vector<FluidParticleState> particles;
  worlds_.front()->fluid_particles(particles);
  require(particles.size() == after, "fluid_particles: one for each");
  for (std::size_t k = 1; k < particles.size(); ++k) {
    require(particles[k - 1].id < particles[k].id, "fluid_particles: by id");
  }
}

// Taps and drains come and go, and the world says how much is where.
void Session::touch_taps() {
  World& world = *worlds_.front();
  EmitterDesc desc;
  desc.fluid = static_cast<FluidId>(in_.below(3));
  desc.from = in_.place(-kHalf, kHalf);
  desc.to = in_.place(-kHalf, kHalf);
  desc.speed = in_.number(-3, 3);
  desc.limit = in_.below(100);
  if (in_.chance(64)) desc.end = desc.start + in_.number(0, 2);
  const Vec2 corner = in_.place(-kHalf, kHalf);
  const Bounds region{corner.x, corner.y, corner.x + in_.number(0, 5), corner.y + in_.number(0, 5)};
  const auto which = static_cast<std::uint32_t>(in_.below(4));
  say("taps of fluid %u, speed %g, limit %u", desc.fluid, desc.speed, static_cast<unsigned>(desc.limit));
  const auto emitter = change<EmitterId>("add_emitter", [&](auto& w) {
    std::string error;
    const EmitterId id = w.add_emitter(desc, error);
    if (id == kNoEmitter) refused(error);
    return id;
  });
  if (in_.chance(128)) {
    change<DrainId>("add_drain", [&](auto& w) {
      std::string error;
      const DrainId id = w.add_drain(region, error);
      if (id == kNoDrain) refused(error);
      return id;
    });
  }
  change<bool>("set_emitter_speed", [&](auto& w) { return w.set_emitter_speed(which, -desc.speed); });
  if (in_.chance(64)) change<bool>("remove_drain", [&](auto& w) { return w.remove_drain(which); });
  if (in_.chance(64) && emitter != kNoEmitter) {
    require(change<bool>("remove_emitter", [&](auto& w) { return w.remove_emitter(emitter); }), "remove_emitter");
  }
  const std::size_t all = world.fluid_report().particles;
  require(world.fluid_in(region).particles <= all, "fluid_in: at most all");
  const BodyId body = some_body();
  const auto in = world.fluid_in_sensor(body);
  require(in.has_value() == world.is_valid(body) && (!in || in->particles <= all), "fluid_in_sensor");
  require(world.fluid_load(body).has_value() == world.is_valid(body), "fluid_load");
}

}  // namespace psim::fuzz
