// Why a body is awake, in one line for the host.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "contact_visit.h"
#include "world_impl.h"

namespace psim {

std::string World::why_awake(BodyId id) const {
  if (!is_valid(id)) return "there is no such body";
  impl_->settle_lists();
  return impl_->why_awake(id.index);
}

// In the order in which choose_sleepers asks.
std::string World::Impl::why_awake(std::uint32_t id) const {
  const BodyInfo& info = bodies.info[id];
  if (info.place == Place::fixed) return "it is static";
  if (info.place == Place::frozen) return "it is frozen: its numbers were broken";
  if (info.place == Place::asleep) return "it sleeps";
  if (!desc.sleeping) return "awake: sleeping is off in this world";
  if (!(bodies.surface(id).inv_mass > 0)) return "awake: kinematic bodies never sleep";
  bodies.find_slots();
  const std::size_t slot = info.slot;
  const auto moves = [&](std::size_t i) {
    return !sleepers.watching() ||
           (sleepers.moves(bodies, lattice, i, false) && sleepers.moves(bodies, lattice, i, true));
  };
  char line[160];
  if (moves(slot)) {
    const double vx = static_cast<double>(bodies.vel[2 * slot]), vy = static_cast<double>(bodies.vel[2 * slot + 1]);
    std::snprintf(line, sizeof line, "awake: it moves, at %.3g m/s: it left a ball of %.3g m in the last %d frames",
                  std::sqrt(vx * vx + vy * vy), static_cast<double>(Sleepers::ball(bodies.radius[slot])),
                  static_cast<int>(Sleepers::kWatchFrames));
    return line;
  }
  const std::uint32_t needed = Sleepers::needed(desc.dt), long_needed = Sleepers::needed(desc.dt, true);
  const double watch = static_cast<double>(Sleepers::kWatchFrames) * desc.dt;
  const auto rested = [&](std::uint32_t body) {
    return sleepers.calm(body) >= needed ||
           (sleepers.calm(body, true) >= long_needed && bodies.surface(body).friction == 0);
  };
  if (!rested(id)) {
    std::snprintf(line, sizeof line, "awake: it has rested for %.2f s of %.2f s", sleepers.calm(id) * watch,
                  needed * watch);
    return line;
  }
  std::uint32_t restless = kNoSlot, joined = kNoSlot;
  bool borne = bodies.vel[2 * slot] == 0 && bodies.vel[2 * slot + 1] == 0;
  each_contact([&](const Met& met) {
    if (met.a != slot && met.b != slot) return;
    borne = borne || met.bears;
    const std::uint32_t other = met.a == slot ? met.b : met.a;
    if (other != kNoSlot && !rested(bodies.id[other])) restless = std::min(restless, bodies.id[other]);
  });
  joints.each_joined(id, [&](std::uint32_t other) {
    borne = true;
    if (bodies.info[other].place == Place::moving && !rested(other)) joined = std::min(joined, other);
  });
  if (restless != kNoSlot) return "awake: it touches body " + std::to_string(restless) + ", which moves or did so of late";
  if (joined != kNoSlot) return "awake: it is joined to body " + std::to_string(joined) + ", which moves or did so of late";
  if (!borne) return "awake: it drifts, and nothing bears it";
  return "awake: it rests, and falls asleep with what it touches and is joined to, a share of the awake at a time";
}

}  // namespace psim
