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
    if (info.place == Place::moving) {
      b.velocity = w_.bodies.velocity(info.slot);
      if (r > 0) b.spin = w_.bodies.omega_of(info.slot);
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

bool step_fluids(Owners& w, double dt) {
  w.observers.queries.forget(QueryIndex::kMoving);
  const WorldSolids solids(w);
  w.fluids.step(dt, w.desc.gravity, &solids);
  if (w.desc.boundary == Boundary::open) w.fluids.keep_within(w.desc.bounds);
  if (!w.fluids.taps().any()) return true;
  w.fluids.drain();
  return w.fluids.emit(dt, w.desc.gravity, w.desc.bounds);
}

void push_by_fluids(Owners& w) {
  for (const FluidForce& f : w.fluids.forces()) {
    const BodyId id{f.id, f.generation};
    if (!w.population.is_valid(id) || !(w.bodies.properties(f.id).inv_mass > 0) || !can_move(w, id)) continue;
    const BodyProperties& of = w.bodies.properties(f.id);
    const std::uint32_t slot = w.bodies.info[f.id].slot;
    const Vec2 v = w.bodies.velocity(slot) + wide(of.inv_mass) * f.impulse;
    w.bodies.put_velocity(slot, w.population.capped(v));
    if (of.rim_gain != 0 && f.spin_impulse != 0) {
      let_turn(w);
      const double u = wide(w.bodies.rim_speed_of(slot)) + wide(of.rim_gain) * f.spin_impulse / wide(of.radius);
      if (std::isfinite(u)) w.bodies.put_rim_speed(slot, u);
    }
    add_force(w, id, f.force, f.torque);
  }
}

}  // namespace psim
