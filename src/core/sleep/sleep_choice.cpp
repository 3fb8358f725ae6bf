// Who may sleep: bodies that have rested long enough, that something supports, and that touch nothing that moves.
//
// In: Sleepers::calm, contacts, stacks and joints. Out: the chosen bodies at the end of Sleepers::list, and a mark for
// each. O(bodies + contacts + joints).
#include <algorithm>
#include <cstdio>

#include "base/elementary.h"
#include "bodies/static_pieces.h"
#include "sleep/sleep_contacts.h"

namespace psim {
namespace {

constexpr float kTouching = 2;  // balls apart that count as touching

// Marks in Sleepers::state beside Sleepers::kChosen. A body that creeps needs support twice, one that trembles (which counts
// as creeping) the support of a contact.
constexpr std::uint8_t kCalm = 1, kSupported = 2, kDisturbed = 4;
constexpr std::uint8_t kCreeping = 16, kSupportedTwice = 32, kCreepDisturbed = 64;

bool rests_firmly(std::uint8_t state) { return (state & (kCalm | kSupported | kDisturbed)) == (kCalm | kSupported); }

bool rests_creeping(std::uint8_t state) {
  return (state & (kCreeping | kSupportedTwice | kCreepDisturbed)) == (kCreeping | kSupportedTwice);
}

// Whether a body neither moves nor turns.
bool is_still(const BodyStore& b, std::size_t slot) {
  return b.vel[2 * slot] == 0 && b.vel[2 * slot + 1] == 0 && b.rim_speed_of(slot) == 0;
}

// Returns a function that tells the marks of a body that has stayed where it is for long enough, else 0.
auto calm_marks(const SleepSource& source, const Sleepers& sleepers, double dt) {
  const BodyStore& bodies = source.population.bodies;
  const bool turns = !bodies.arm_change.empty();
  const std::uint32_t needed = Sleepers::needed(dt), creeping = Sleepers::needed(dt, Sleepers::kCreepTime),
                      trembling = Sleepers::needed(
                          dt, source.joints.empty() ? Sleepers::kTrembleAlone : Sleepers::kTrembleTime);
  return [=, &bodies, &sleepers](std::uint32_t id) {
    const BodyProperties& properties = bodies.properties(id);
    const bool rests = sleepers.calm(id) >= needed;
    const Sleepers::BallKind ball = Sleepers::restless(properties);
    // A kinematic body is moved on purpose, however slowly.
    const bool creeps = (rests || properties.inv_mass > 0) && (turns || ball == Sleepers::kWide) &&
                        sleepers.calm(id, ball) >= (ball == Sleepers::kTremble ? trembling : creeping);
    return static_cast<std::uint8_t>((rests ? kCalm : 0) | (creeps ? kCreeping : 0));
  };
}

class SleepChoice {
 public:
  SleepChoice(const SleepSource& source, Sleepers& sleepers)
      : source_(source), bodies_(source.population.bodies), sleepers_(sleepers), state_(sleepers.state) {}

  // False if nobody is chosen, or so few that new lists are not worth it.
  bool choose(std::uint64_t steps, double dt) {
    const bool patient = bodies_.awake() > 256 && steps % (16 * Sleepers::kWatchFrames) != 0;
    const auto worth_it = [&](std::size_t n) { return n != 0 && !(patient && n < bodies_.awake() / 32); };
    if (!worth_it(mark_calm(dt))) return false;
    mark_by_contacts(dt);
    keep_stacks_awake();
    if (!source_.joints.empty()) keep_joined_awake();
    std::size_t chosen = 0;
    for (std::uint32_t i = 0; i < bodies_.count; ++i) chosen += may_sleep(i);
    if (!worth_it(chosen)) return false;
    mark_chosen();
    make_room();
    sleepers_.leaving = true;
    list_chosen();
    return true;
  }

 private:
  bool is_dynamic(std::uint32_t slot) const {
    return bodies_.id[slot] != kNoSlot && bodies_.properties(bodies_.id[slot]).inv_mass > 0;
  }
  bool may_sleep(std::uint32_t slot) const {
    if (!(rests_firmly(state_[slot]) || rests_creeping(state_[slot])) || !is_dynamic(slot)) return false;
    const BodyKind& kind = bodies_.kind(bodies_.id[slot]);
    return !kind.sleepless && !kind.one_way;  // fixed geometry does not know how it is turned
  }
  void disturb(std::uint32_t slot) { state_[slot] |= kDisturbed | kCreepDisturbed; }

  // Marks bodies that have rested long enough, and returns how many there are.
  std::size_t mark_calm(double dt) {
    state_.reserve(kernels::round_up_block(bodies_.count));
    const auto marks = calm_marks(source_, sleepers_, dt);
    std::size_t calm = 0;
    for (std::uint32_t i = 0; i < bodies_.count; ++i) {
      state_[i] = 0;
      if (bodies_.id[i] == kNoSlot) continue;
      state_[i] = marks(bodies_.id[i]);
      calm += state_[i] != 0;
      if (is_still(bodies_, i)) state_[i] |= kSupported;
    }
    for (const std::uint32_t id : source_.population.borne) {
      const BodyInfo& info = bodies_.info[id];
      if (info.place != Place::moving) continue;
      calm += state_[info.slot] == 0;
      state_[info.slot] |= kCreeping | kSupported | kSupportedTwice;
    }
    return calm;
  }

  // Marks who is supported, and who touches a body that moves.
  void mark_by_contacts(double dt) {
    const Population& population = source_.population;
    const auto support = [&](std::uint32_t slot) {
      const bool enough = (state_[slot] & kSupported) != 0 || bodies_.properties(bodies_.id[slot]).friction > 0;
      state_[slot] |= enough ? kSupported | kSupportedTwice : kSupported;
    };
    each_contact(source_, [&](const SleepContact& contact) {
      if (contact.loaded) {
        support(contact.b);
        if (contact.a != kNoSlot) support(contact.a);
      }
      if (contact.a == kNoSlot) return;
      // Gaps are those of the start of the frame: they may have closed within the frame, or may close in the next.
      const float near =
          kTouching * Sleepers::ball(lesser(bodies_.radius[contact.a], bodies_.radius[contact.b])) +
          2 * kClosing * static_cast<float>(dt) * (population.speed_of(contact.a) + population.speed_of(contact.b));
      if (!contact.loaded && contact.gap > near) return;
      for (const auto& [i, other] : {std::pair{contact.a, contact.b}, std::pair{contact.b, contact.a}}) {
        if ((state_[i] & kCalm) == 0) state_[other] |= kDisturbed;
        if ((state_[i] & kCreeping) == 0) state_[other] |= kCreepDisturbed;
      }
    });
  }

  // A stack is solved as one: if a body of it may not sleep, none does.
  void keep_stacks_awake() {
    each_stack(
        source_, [&](std::uint32_t slot) { return is_dynamic(slot); },
        [&](const auto& visit) {
          bool all = true;
          visit([&](std::uint32_t slot) { all = all && may_sleep(slot); });
          if (!all) visit([&](std::uint32_t slot) { disturb(slot); });
        });
  }

  bool moves(std::uint32_t id) const { return !is_world(id) && bodies_.info[id].place == Place::moving; }
  bool is_free(std::uint32_t id) const {
    return !is_world(id) && bodies_.info[id].place == Place::moving && bodies_.properties(id).inv_mass > 0;
  }

  std::uint32_t root_of(std::uint32_t id) {
    std::vector<std::uint32_t>& root = sleepers_.roots;
    while (root[id] != id) id = root[id] = root[root[id]];
    return id;
  }

  // Unites bodies that joints connect: roots[id] leads to the lowest id of its group. A joint counts as support; a body
  // that is joined to a moving kinematic body is disturbed.
  void join_bodies() {
    std::vector<std::uint32_t>& root = sleepers_.roots;
    root.resize(bodies_.id_count);
    for (std::uint32_t id = 0; id < bodies_.id_count; ++id) root[id] = id;
    source_.joints.each_pair([&](std::uint32_t a, std::uint32_t b) {
      for (const std::uint32_t id : {a, b}) {
        if (moves(id)) state_[bodies_.info[id].slot] |= kSupported;
      }
      if (is_free(a) && is_free(b)) {
        const std::uint32_t p = root_of(a), q = root_of(b);
        root[std::max(p, q)] = std::min(p, q);
        return;
      }
      for (const auto& [one, other] : {std::pair{a, b}, std::pair{b, a}}) {
        if (is_free(one) && moves(other) && (state_[bodies_.info[other].slot] & kCalm) == 0) {
          disturb(bodies_.info[one].slot);
        }
      }
    });
  }

  // Bodies that joints connect sleep together or not at all.
  void keep_joined_awake() {
    bodies_.find_slots();
    join_bodies();
    const auto each_free = [&](const auto& each) {
      source_.joints.each_pair([&](std::uint32_t a, std::uint32_t b) {
        for (const std::uint32_t id : {a, b}) {
          if (is_free(id)) each(bodies_.info[id].slot, bodies_.info[root_of(id)].slot);
        }
      });
    };
    // The lowest body tells for its group. What bears one body of a group bears all of it.
    const auto bear = [&](std::uint32_t from, std::uint32_t to) {
      if ((state_[from] & kSupportedTwice) != 0) state_[to] |= kSupportedTwice;
    };
    each_free([&](std::uint32_t slot, std::uint32_t root) { bear(slot, root); });
    each_free([&](std::uint32_t slot, std::uint32_t root) { bear(root, slot); });
    each_free([&](std::uint32_t slot, std::uint32_t root) {
      if (!may_sleep(slot)) disturb(root);
    });
    each_free([&](std::uint32_t slot, std::uint32_t root) {
      if (!may_sleep(root)) disturb(slot);
    });
  }

  // Marks at most kMostAtOnce; but what is joined is never divided.
  void mark_chosen() {
    bodies_.find_slots();
    std::uint32_t pieces = 0;
    for (std::uint32_t i = 0; i < bodies_.count; ++i) {
      if (!may_sleep(i)) continue;
      if (pieces >= Sleepers::kMostAtOnce && source_.joints.empty()) break;
      const BodyKind& kind = bodies_.kind(bodies_.id[i]);
      pieces += kind.hull_count == 0 ? 1 : 5 * kind.hull_count;
      state_[i] |= Sleepers::kChosen;
    }
  }

  // For all that the chosen bodies take with them: from here on nothing needs memory.
  void make_room() {
    std::size_t bodies = 0, touches = 0, recent = 0, longest = 1;
    PieceCount all;
    for (std::uint32_t i = 0; i < bodies_.count; ++i) {
      if (!sleepers_.chosen(i)) continue;
      const PieceCount mine = pieces_of(bodies_, bodies_.kind(bodies_.id[i]));
      ++bodies;
      all.pieces += mine.pieces;
      all.hulls += mine.hulls;
      longest = std::max<std::size_t>(longest, mine.pieces);
    }
    each_contact(source_, [&](const SleepContact& contact) {
      if (!contact.loaded) return;
      const bool a = contact.a != kNoSlot && sleepers_.chosen(contact.a), b = sleepers_.chosen(contact.b);
      touches += std::size_t{a} + b;
      recent += contact.a != kNoSlot && a != b;
    });
    sleepers_.make_room_for_more(bodies, touches, recent);
    sleepers_.pieces.reserve(longest);
    source_.population.statics.make_room(all.pieces, all.hulls);
  }

  // From here on a chosen body counts as asleep.
  void list_chosen() {
    for (std::uint32_t i = 0; i < bodies_.count; ++i) {
      if (!sleepers_.chosen(i)) continue;
      Sleeper s;
      s.at = bodies_.point(i);
      s.angle = bodies_.angle_of(i);
      s.id = bodies_.id[i];
      s.creeps = !rests_firmly(state_[i]);
      bodies_.info[s.id].place = Place::asleep;
      bodies_.info[s.id].slot = static_cast<std::uint32_t>(sleepers_.list.size());
      sleepers_.list.push_back(s);
    }
  }

  const SleepSource& source_;
  BodyStore& bodies_;
  Sleepers& sleepers_;
  Column<std::uint8_t>& state_;
};

}  // namespace

bool Sleep::choose(const SleepSource& source, std::uint64_t steps, double dt) {
  return SleepChoice(source, sleepers).choose(steps, dt);
}

// The questions come in the order in which SleepChoice asks them.
std::string Sleep::why_awake(const SleepSource& source, std::uint32_t id, bool sleeping, double dt) const {
  const BodyStore& bodies = source.population.bodies;
  const BodyInfo& info = bodies.info[id];
  if (info.place == Place::fixed) return "it is static";
  if (info.place == Place::frozen) return "it is frozen: its numbers were broken";
  if (info.place == Place::disabled) return "it is disabled";
  if (info.place == Place::asleep) return "it sleeps";
  if (!sleeping) return "awake: sleeping is off in this world";
  if (!(bodies.properties(id).inv_mass > 0)) return "awake: kinematic bodies never sleep";
  bodies.find_slots();
  const std::size_t slot = info.slot;
  char line[160];
  if (!sleepers.watching() || (sleepers.moves(slot, false) && sleepers.moves(slot, true))) {
    std::snprintf(line, sizeof line, "awake: it moves, at %.3g m/s: it left a ball of %.3g m in the last %d frames",
                  length_of(bodies.velocity(slot)), static_cast<double>(Sleepers::ball(bodies.radius[slot])),
                  static_cast<int>(Sleepers::kWatchFrames));
    return line;
  }
  const auto marks = calm_marks(source, sleepers, dt);
  const auto rested = [&](std::uint32_t body) { return marks(body) != 0; };
  if (!rested(id)) {
    const double watch = static_cast<double>(Sleepers::kWatchFrames) * dt;
    std::snprintf(line, sizeof line, "awake: it has rested for %.2f s of %.2f s", sleepers.calm(id) * watch,
                  Sleepers::needed(dt) * watch);
    return line;
  }
  std::uint32_t restless = kNoSlot, joined = kNoSlot;
  bool supported = is_still(bodies, slot);
  each_contact(source, [&](const SleepContact& contact) {
    if (contact.a != slot && contact.b != slot) return;
    supported = supported || contact.loaded;
    const std::uint32_t other = contact.a == slot ? contact.b : contact.a;
    if (other != kNoSlot && !rested(bodies.id[other])) restless = std::min(restless, bodies.id[other]);
  });
  source.joints.each_joined(id, [&](std::uint32_t other) {
    supported = true;
    if (!is_world(other) && bodies.info[other].place == Place::moving && !rested(other))
      joined = std::min(joined, other);
  });
  if (restless != kNoSlot)
    return "awake: it touches body " + std::to_string(restless) + ", which moves or did so of late";
  if (joined != kNoSlot)
    return "awake: it is joined to body " + std::to_string(joined) + ", which moves or did so of late";
  if (!supported) return "awake: it drifts, and nothing bears it";
  return "awake: it rests, and falls asleep with what it touches and is joined to, a share of the awake at a time";
}

}  // namespace psim
