// Which bodies sleep, and why they wake. Bodies that sleep are in no loop; docs/sleeping.md has the rules.
//
// In: bodies, their contacts and joints after a step. Out: bodies leave the columns and stand among the fixed shapes,
// or come back. Owns the sleepers, what they carried, and for how long each body has rested. A function that returns
// bool tells whether a body fell asleep or woke: lists and query grids that were made before do not hold any more.
//
//   sleep.cpp          the step of sleep: puts the chosen bodies to sleep
//   sleep_choice.cpp   who may sleep, and for the host why a body does not
//   wake.cpp           who wakes
#pragma once

#include <span>
#include <string>

#include "bodies/population.h"
#include "joints/joint_store.h"
#include "lists/pair_table.h"
#include "manifolds/contacts.h"
#include "sleep/sleepers.h"

namespace psim {

/// What sleep reads and changes.
struct SleepSource {
  Population& population;
  const Lattice& lattice;
  Vec2 gravity;  ///< m/s^2
  int substeps;  ///< of the last step
  const PairTable& table;
  Contacts& contacts;
  JointStore& joints;
  bool contacts_stand = true;   ///< table, contacts and slots belong together; else no contact is known
  bool with_manifolds = false;  ///< some contacts are manifolds
  bool per_mass = false;        ///< impulses of discs are divided by the mass, which is the same for all
};

class Sleep {
 public:
  explicit Sleep(const Surroundings& s) : sleepers(s) {}

  /// After the `steps`-th step, of dt seconds: wakes what moving bodies are about to meet and, every few steps, puts
  /// bodies to sleep. Depends on nothing but the number of the step.
  bool step(const SleepSource& source, std::uint64_t steps, double dt);
  /// Makes room for the first bodies that fall asleep, so that they allocate nothing. O(bodies) with shapes.
  void make_room(const SleepSource& source);

  /// Wakes what moving bodies touch, or will touch within the next frame.
  bool wake_reached(const SleepSource& source, double dt);
  /// Wakes what carries another load than when it fell asleep.
  bool wake_reloaded(const SleepSource& source, double dt);
  /// The host moves or pushes a body: it wakes, and counts as moving.
  bool disturb(const SleepSource& source, std::uint32_t id);
  /// A body goes, or moves by the will of the host: what leaned on it wakes.
  bool disturb_neighbours(const SleepSource& source, std::uint32_t id);
  /// Bodies that sleep go out of the world; each is named once and has no joints. What touched them, or was stacked with
  /// them, wakes. If there is no room for that, they stay asleep. Population::remove() comes next.
  bool let_go(const SleepSource& source, std::span<const std::uint32_t> ids);
  /// Wakes what touches a new static body.
  bool disturb_at_fixed(const SleepSource& source, std::uint32_t id);
  bool wake_body(const SleepSource& source, std::uint32_t id);
  bool wake_all(const SleepSource& source);
  /// Keeps the impulses between moving bodies and those that woke since the lists were made: from now on the two are
  /// pairs of bodies.
  void keep_touches_of_woken(const SleepSource& source, bool impulses_valid);

  /// One line for the host. `sleeping`: bodies of this world may fall asleep.
  std::string why_awake(const SleepSource& source, std::uint32_t id, bool sleeping, double dt) const;
  /// The state of any body.
  BodyState state_of(const Population& population, const Lattice& lattice, std::uint32_t id) const;

  Sleepers sleepers;

 private:
  bool choose(const SleepSource& source, std::uint64_t steps, double dt);
};

}  // namespace psim
