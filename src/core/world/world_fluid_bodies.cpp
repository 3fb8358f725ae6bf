// Fluids and the bodies of a world: where their shapes are, and what they do to each other.
#include <algorithm>

#include "query/query_index.h"
#include "world/world_impl.h"

namespace psim {
namespace {

// The bodies of a world as its fluids see them. A sensor, and a shape that collides with nothing, do not meet fluids.
class WorldSolids : public SolidFinder {
 public:
  explicit WorldSolids(Owners& w) : w_(w), world_(w.observed()) { w.bodies.find_slots(); }

  bool any() const override { return w_.bodies.living() != 0; }

  void find(Vec2 corner, Vec2 low, Vec2 high, std::vector<Found>& out) const override {
    const Vec2 from = corner - world_.lattice.centre();
    const auto search = [&](QueryIndex::Who who) {
      const QueryIndex::Part& part = w_.observers.queries.part(world_, who);
      part.grid.in_box(from + low, from + high, [&](const QueryItem& item, Vec2 shift) {
        const Vec2 to = item.seen_from(from, shift);
        const double r = wide(item.radius);
        if (to.x + r < low.x || to.y + r < low.y || to.x - r > high.x || to.y - r > high.y || !meets(item)) return;
        const QueryPiece* piece = item.piece == QueryIndex::kDisc ? nullptr : &part.pieces[item.piece];
        const bool hull = piece != nullptr && piece->kind == QueryPiece::kHull;
        out.push_back({item.body,
                       piece == nullptr ? item.part
                       : hull           ? piece->hull
                                        : item.piece,
                       QueryIndex::outline(world_, part, item, to), hull ? to + piece->at : to});
      });
    };
    search(QueryIndex::kMoving);
    if (!w_.sleep.sleepers.empty()) search(QueryIndex::kSleeping);
    if (w_.population.fixed.size() != 0) search(QueryIndex::kFixed);
  }

  FluidBody body(std::uint32_t id) const override {
    FluidBody b;
    b.id = id;
    b.generation = w_.bodies.info[id].generation;
    const BodyInfo& info = w_.bodies.info[id];
    if (info.place != Place::moving && info.place != Place::asleep) return b;
    const BodyProperties& of = w_.bodies.properties(id);
    b.inv_mass = wide(w_.bodies.inv_mass_in_joints(id));
    const double r = wide(of.radius);
    if (r > 0) b.inv_inertia = wide(of.rim_gain) / (r * r);
    b.asleep = info.place == Place::asleep;
    if (b.asleep) {
      b.inv_mass = b.inv_inertia = 0;
    } else {
      b.velocity = w_.bodies.velocity(info.slot);
      if (r > 0) b.spin = w_.bodies.omega_of(info.slot);
      b.speed = length_of(b.velocity) + std::fabs(b.spin) * r;
      b.moves = b.inv_mass > 0 || b.spin != 0 || b.velocity != Vec2{};
    }
    return b;
  }

 private:
  bool meets(const QueryItem& item) const {
    const BodyKind& kind = w_.bodies.kind(item.body);
    return !w_.bodies.is_sensor(kind, item.part) && w_.bodies.filter_of(kind, item.part).mask != 0;
  }

  Owners& w_;
  const Observed world_;
};

}  // namespace

bool step_fluids(Owners& w, double dt, int most_parts) {
  w.observers.queries.forget(QueryIndex::kMoving);
  const WorldSolids solids(w);
  w.fluids.step(dt, w.desc.gravity, &solids, w.desc.sleeping, most_parts);
  if (w.desc.boundary == Boundary::open) w.fluids.keep_within(w.desc.bounds);
  if (!w.fluids.taps().any()) return true;
  w.fluids.drain();
  return w.fluids.emit(dt, w.desc.gravity, w.desc.bounds);
}

namespace {

// A body that a fluid bears may fall asleep after it was slow for so many seconds, in a step in which the fluid bears its weight
// to so small a share: what bobs passes there where it would come to rest.
constexpr double kSlowTime = 2, kBalance = 0.005;

bool is_balanced(const Owners& w, const FluidForce& f) {
  const BodyProperties& of = w.bodies.properties(f.id);
  const double mass = 1 / wide(of.inv_mass), pull = wide(of.gravity_scale);
  const double most = kBalance * mass * pull * length_of(w.desc.gravity);
  return f.slow >= kSlowTime && length_of(f.force + mass * pull * w.desc.gravity) <= most &&
         std::fabs(f.torque) <= most * wide(of.radius);
}

// Whether a body that sleeps feels something else than when it fell asleep, by more than this share of its weight.
bool is_stirred(const Owners& w, const FluidForce& f) {
  constexpr double kStirred = 0.05;
  const BodyProperties& of = w.bodies.properties(f.id);
  const double least = kStirred * length_of(w.desc.gravity) / wide(of.inv_mass);
  return length_of(f.stir_force) > least || std::fabs(f.stir_torque) > least * wide(of.radius);
}

}  // namespace

void push_by_fluids(Owners& w) {
  w.population.borne.clear();
  if (!w.fluids.active()) return;
  w.bodies.find_slots();
  for (const FluidForce& f : w.fluids.forces()) {
    const BodyId id{f.id, f.generation};
    if (!w.population.is_valid(id) || !(w.bodies.properties(f.id).inv_mass > 0)) continue;
    const Place place = w.bodies.info[f.id].place;
    // What wakes moves without this force in the next step, and is given all of it then.
    if (place == Place::asleep && f.asleep && is_stirred(w, f)) {
      disturb(w, f.id);
      w.bodies.find_slots();
    }
    if (place != Place::moving || f.asleep) continue;
    const BodyProperties& of = w.bodies.properties(f.id);
    const std::uint32_t slot = w.bodies.info[f.id].slot;
    const Vec2 v = w.bodies.velocity(slot) + wide(of.inv_mass) * f.impulse;
    w.bodies.put_velocity(slot, w.population.capped(v));
    if (of.rim_gain != 0 && f.spin_impulse != 0) {
      let_turn(w);
      const double u = wide(w.bodies.rim_speed_of(slot)) + wide(of.rim_gain) * f.spin_impulse / wide(of.radius);
      if (std::isfinite(u)) w.bodies.put_rim_speed(slot, u);
    }
    push_body(w, id, f.force, f.torque);
    if (is_balanced(w, f)) w.population.borne.push_back(f.id);
  }
}

void lay_down_in_fluids(Owners& w) {
  for (const FluidForce& f : w.fluids.forces()) {
    if (!w.population.is_valid({f.id, f.generation}) || w.bodies.info[f.id].place != Place::asleep) continue;
    if (!w.population.applied.has(f.id)) continue;
    w.population.applied.remove(f.id);
    w.fluids.lay_down(f.id);
  }
}

}  // namespace psim
