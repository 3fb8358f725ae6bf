// A world in which everything changes: a step, then forty calls of the public interface, chosen by a number, and so on.
// Bodies of all types and shapes come and go, one by one and many at once, with filters, sensors, bullets and joints of
// all types; the world is open and has fields; it is asked, saved, restored, recorded and replayed.
//
// After a season of 10,000 calls all bodies are removed. There are eight seasons, which come again and again, so that
// memory and time have no reason to grow.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "psim/psim.h"

namespace psim::soak {

class SoakCalls {
 public:
  static constexpr std::uint64_t kCallsAStep = 40, kSteps = 250, kSeasons = 8;

  SoakCalls(std::size_t bodies, int threads);

  /// A season, up to the removal of all bodies; that is the first thing of the next one. False, with `fault` set, if
  /// something that holds for every world does not.
  bool season();

  World& world() { return *world_; }
  const std::string& fault() const { return fault_; }
  std::uint64_t calls() const { return calls_; }
  std::uint64_t steps() const { return steps_; }
  std::uint64_t most_asleep() const { return most_asleep_; }
  std::uint64_t escaped() const { return world_->escaped_total(); }
  std::uint64_t events() const { return events_; }
  /// Bytes of the state without bodies, before the season, and of a world made from it. What the crowds of before took
  /// for lists is not in it, so that it has no reason at all to grow.
  std::size_t bare_bytes() const { return bare_bytes_; }

 private:
  void change();
  void add();
  void add_many();
  void add_static();
  void remove_many();
  void change_type();
  void join();
  void unjoin();
  void push();
  void set();
  void ask();
  void look();
  void save_and_restore();
  void record();
  void step();
  BodyDesc any_body();
  BodyId any();
  BodyId keep(const BodyDesc& body);
  double uniform(double low, double high);
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(uniform(0, static_cast<double>(n))); }
  bool require(bool holds, const std::string& what);

  std::unique_ptr<World> world_;
  BodyId floor_;
  std::size_t most_, bare_bytes_ = 0;
  std::uint64_t random_ = 0, season_ = 0, steps_ = 0, calls_ = 0, events_ = 0, most_asleep_ = 0;
  std::vector<BodyId> bodies_;  // those that left the world, too, until they are found out
  std::vector<JointId> joints_;
  std::vector<std::byte> state_;
  std::string fault_;
};

}  // namespace psim::soak
