// Why a body is awake, in one line for the host.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "sleep/sleep_contacts.h"

namespace psim {
namespace {

std::string how_it_moves(const BodyStore& bodies, std::size_t slot) {
  const double vx = static_cast<double>(bodies.vel[2 * slot]), vy = static_cast<double>(bodies.vel[2 * slot + 1]);
  char line[160];
  std::snprintf(line, sizeof line, "awake: it moves, at %.3g m/s: it left a ball of %.3g m in the last %d frames",
                std::sqrt(vx * vx + vy * vy), static_cast<double>(Sleepers::ball(bodies.radius[slot])),
                static_cast<int>(Sleepers::kWatchFrames));
  return line;
}

}  // namespace

// The questions come in the order in which SleepChoice asks them.
std::string Sleep::why_awake(const SleepSource& source, std::uint32_t id, bool sleeping, double dt) const {
  const BodyStore& bodies = source.population.bodies;
  const BodyInfo& info = bodies.info[id];
  if (info.place == Place::fixed) return "it is static";
  if (info.place == Place::frozen) return "it is frozen: its numbers were broken";
  if (info.place == Place::asleep) return "it sleeps";
  if (!sleeping) return "awake: sleeping is off in this world";
  if (!(bodies.properties(id).inv_mass > 0)) return "awake: kinematic bodies never sleep";
  bodies.find_slots();
  const std::size_t slot = info.slot;
  const Lattice& lattice = source.lattice;
  const bool moves = !sleepers.watching() ||
                     (sleepers.moves(bodies, lattice, slot, false) && sleepers.moves(bodies, lattice, slot, true));
  if (moves) return how_it_moves(bodies, slot);
  const std::uint32_t needed = Sleepers::needed(dt), long_needed = Sleepers::needed(dt, true);
  const auto rested = [&](std::uint32_t body) {
    return sleepers.calm(body) >= needed ||
           (sleepers.calm(body, true) >= long_needed && bodies.properties(body).friction == 0);
  };
  if (!rested(id)) {
    const double watch = static_cast<double>(Sleepers::kWatchFrames) * dt;
    char line[160];
    std::snprintf(line, sizeof line, "awake: it has rested for %.2f s of %.2f s", sleepers.calm(id) * watch,
                  needed * watch);
    return line;
  }
  std::uint32_t restless = kNoSlot, joined = kNoSlot;
  bool supported = bodies.vel[2 * slot] == 0 && bodies.vel[2 * slot + 1] == 0;
  each_contact(source, [&](const SleepContact& contact) {
    if (contact.a != slot && contact.b != slot) return;
    supported = supported || contact.loaded;
    const std::uint32_t other = contact.a == slot ? contact.b : contact.a;
    if (other != kNoSlot && !rested(bodies.id[other])) restless = std::min(restless, bodies.id[other]);
  });
  source.joints.each_joined(id, [&](std::uint32_t other) {
    supported = true;
    if (bodies.info[other].place == Place::moving && !rested(other)) joined = std::min(joined, other);
  });
  if (restless != kNoSlot)
    return "awake: it touches body " + std::to_string(restless) + ", which moves or did so of late";
  if (joined != kNoSlot)
    return "awake: it is joined to body " + std::to_string(joined) + ", which moves or did so of late";
  if (!supported) return "awake: it drifts, and nothing bears it";
  return "awake: it rests, and falls asleep with what it touches and is joined to, a share of the awake at a time";
}

}  // namespace psim
