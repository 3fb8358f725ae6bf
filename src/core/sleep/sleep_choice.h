// Who may sleep: bodies that have rested long enough, that something supports, and that touch nothing that moves.
//
// In: Sleepers::calm, contacts, stacks and joints. Out: a mark in Sleepers::state for each body that is chosen.
// O(bodies + contacts + joints).
#pragma once

#include "sleep/sleep.h"

namespace psim {

class SleepChoice {
 public:
  /// The mark of those that are chosen, in Sleepers::state.
  static constexpr std::uint8_t kChosen = 8;

  SleepChoice(const SleepSource& source, Sleepers& sleepers);

  /// False if nobody is chosen, or so few that new lists are not worth it.
  bool choose(std::uint64_t steps, double dt);

 private:
  bool may_sleep(std::uint32_t slot) const;
  bool worth_it(std::size_t bodies) const;
  std::size_t mark_calm(double dt);
  void mark_supported(std::uint32_t slot);
  void mark_by_contacts(double dt);
  void keep_stacks_awake();
  void keep_joined_awake();
  void join_bodies();
  std::uint32_t root_of(std::uint32_t id);
  bool is_free(std::uint32_t id) const;
  void mark_chosen();

  const SleepSource& source_;
  const BodyStore& bodies_;
  Sleepers& sleepers_;
  Column<std::uint8_t>& state_;
  bool patient_ = false;
};

/// Whether a body may sleep by its mark as a resting one, not only as one that creeps.
bool rests_firmly(std::uint8_t state);

}  // namespace psim
