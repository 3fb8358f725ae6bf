// A world that never comes to an end: bodies of all shapes rain into a yard with machines, the oldest
// are taken out, ropes and pins are made and cut, rays and regions asked, events heard; now and then it
// rests so that bodies fall asleep, or is shaken awake. Everything follows from the frame's number.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <string>

#include "psim/psim.h"

namespace psim::soak {

class SoakWorld {
 public:
  SoakWorld(std::size_t bodies, int threads);

  /// One frame of 1/60 s. False, with `fault` set, if something that holds for every world does not.
  bool step();

  World& world() { return *world_; }
  const std::string& fault() const { return fault_; }
  std::uint64_t spawned() const { return spawned_; }
  std::uint64_t removed() const { return removed_; }
  std::uint64_t events() const { return events_; }
  std::uint64_t answers() const { return answers_; }
  std::uint64_t asleep() const { return asleep_; }  ///< after the last step

 private:
  void build_yard();
  void spawn();
  void remove_oldest();
  void join();
  void shake();
  void ask();
  void look();
  double uniform(double low, double high);
  bool require(bool holds, const char* what);
  BodyId add(const BodyDesc& body);

  std::unique_ptr<World> world_;
  std::size_t most_;
  std::uint64_t frame_ = 0, random_ = 1;
  std::deque<BodyId> bodies_;
  std::deque<JointId> joints_;
  std::uint64_t spawned_ = 0, removed_ = 0, events_ = 0, answers_ = 0, asleep_ = 0;
  std::string fault_;
};

}  // namespace psim::soak
