#include "picture/moment.h"

#include "place/links.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace psim::cli {

std::size_t Moment::row_of(std::uint64_t body) const {
  if (body < id.size() && id[body] == body) return body;  // nobody left the world
  const auto at = std::lower_bound(id.begin(), id.end(), body);
  return at != id.end() && *at == body ? static_cast<std::size_t>(at - id.begin()) : id.size();
}

namespace {

void take_contacts(World& world, Moment& moment, Colouring colouring) {
  if (colouring == Colouring::solver) moment.group.assign(moment.size(), kNoColour);
  for (const Contact& c : world.contacts()) {
    if (colouring == Colouring::solver) moment.links.push_back({c.a.index, c.b.index, c.point, c.colour});
    for (const BodyId id : {c.a, c.b}) {
      const std::size_t row = id == kNoBody ? moment.size() : moment.row_of(id.index);
      if (row == moment.size()) continue;
      if (colouring == Colouring::force) {
        moment.force[row] += c.impulse / world.desc().dt;
      } else if (c.colour != kNoColour && moment.type[row] == BodyType::dynamic_body) {
        std::uint32_t& most = moment.group[row];
        most = most == kNoColour ? c.colour : std::max(most, c.colour);
      }
    }
  }
}

}  // namespace

std::size_t joints_of(const Scene& scene) { return all_joints(scene).size(); }

void take_moment(World& world, Moment& moment, Colouring colouring, std::size_t joints) {
  const PublishedState state = world.published();
  const auto copy = [](auto& into, const auto& from) { into.assign(from.begin(), from.end()); };
  copy(moment.id, state.id);
  copy(moment.x, state.x);
  copy(moment.y, state.y);
  copy(moment.angle, state.angle);
  copy(moment.vx, state.vx);
  copy(moment.vy, state.vy);
  copy(moment.omega, state.omega);
  copy(moment.radius, state.radius);
  copy(moment.type, state.type);
  moment.asleep.resize(state.id.size());
  for (std::size_t row = 0; row < state.id.size(); ++row) {
    moment.asleep[row] = state.type[row] != BodyType::static_body && !world.is_awake(world.id_of(state.id[row]));
  }
  world.fluid_particles(moment.particles);
  moment.lost.resize(joints);
  for (std::uint32_t k = 0; k < joints; ++k) moment.lost[k] = world.is_valid_joint({k, 0}) ? 0 : 1;
  moment.force.assign(colouring == Colouring::force ? moment.size() : 0, 0.0);
  moment.group.clear();
  moment.links.clear();
  if (colouring == Colouring::force || colouring == Colouring::solver) take_contacts(world, moment, colouring);
  if (colouring != Colouring::strip) return;
  const std::span<const std::uint32_t> strips = world.strips();
  for (const std::uint32_t id : moment.id) moment.group.push_back(strips[id]);
}

void place_between(const Moment& before, const Moment& after, double alpha, const WorldDesc& world, Moment& between) {
  between = after;
  const bool wraps = world.boundary == Boundary::periodic;
  const double period_x = world.bounds.xmax - world.bounds.xmin;
  const double period_y = world.bounds.ymax - world.bounds.ymin;
  const auto along = [&](double from, double to, double period) {
    double way = to - from;
    if (wraps) way -= period * std::round(way / period);
    return to - (1 - alpha) * way;
  };
  for (std::size_t row = 0; row < after.size(); ++row) {
    const std::size_t old = before.row_of(after.id[row]);
    if (old == before.size()) continue;
    between.x[row] = along(before.x[old], after.x[row], period_x);
    between.y[row] = along(before.y[old], after.y[row], period_y);
    between.angle[row] = after.angle[row] - (1 - alpha) * (after.angle[row] - before.angle[old]);
  }
  std::size_t old = 0;  // both lists are by id
  for (FluidParticleState& particle : between.particles) {
    while (old < before.particles.size() && before.particles[old].id < particle.id) ++old;
    if (old == before.particles.size()) break;
    if (before.particles[old].id != particle.id) continue;
    const Vec2 from = before.particles[old].position;
    particle.position = {along(from.x, particle.position.x, period_x), along(from.y, particle.position.y, period_y)};
  }
}

}  // namespace psim::cli
