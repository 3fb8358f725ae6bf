// Calls of a world out of bytes, and what they must do; used by the files world_input*.cpp alone.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "byte_source.h"
#include "inputs.h"
#include "psim/psim.h"

namespace psim::fuzz {

struct Fault {
  std::string what;
};

inline void require(bool holds, const std::string& what) {
  if (!holds) throw Fault{what};
}

class Session {
 public:
  explicit Session(Bytes calls) : in_(calls) {}

  void run();

 private:
  // What the worlds must know, too.
  struct Known {
    std::vector<BodyId> bodies, dead;
    std::vector<JointId> joints;
    std::set<std::uint32_t> broken;  // given NaN since the last step
    bool maybe_broken = false, jointed = false;
  };

  using Worlds = std::vector<std::unique_ptr<World>>;

  // world_input.cpp
  bool create();
  void call();
  void ask();
  void replace_last();
  void go_back();

  // world_input_bodies.cpp
  void add_body();
  void add_discs();
  void live(BodyId id);
  BodyId some_body();
  void remove_body();
  void bury(BodyId id);
  bool is_live(BodyId id) const;
  void move_body();
  void add_joint();
  JointId some_joint();
  void touch_joint();

  // world_input_steps.cpp
  void step(double dt);
  void stepped(const std::vector<StepReport>& reports);
  void say_fastest(World& world) const;
  void look();
  void replay();
  void govern();
  void change_options();

  // The same call on every world gives the same answer.
  template <class Answer, class Call>
  Answer same(const char* what, const Call& call) {
    const Answer first = call(*worlds_.front());
    for (std::size_t k = 1; k < worlds_.size(); ++k) {
      require(call(*worlds_[k]) == first, std::string(what) + ": two variants differ");
    }
    return first;
  }

  static void refused(const std::string& error) {
    require(!error.empty() && error.find('\n') == error.npos, "an error of one line: " + error);
  }

  template <class... Values>
  void say(const char* format, Values... values) const {
    if (!talks_) return;
    std::fprintf(stderr, format, values...);
    std::fputc('\n', stderr);
  }

  const bool talks_ = std::getenv("PSIM_FUZZ_TALK") != nullptr;
  ByteSource in_;
  Worlds worlds_;
  bool open_ = false, restores_ = false, snapshots_ = false;
  int replaced_ = 0;
  GovernorDesc governor_;
  int steps_ = 0;
  Known known_;
  std::vector<BodyId>&bodies_ = known_.bodies, &dead_ = known_.dead;
  std::vector<JointId>& joints_ = known_.joints;
  std::set<std::uint32_t>& broken_ = known_.broken;
  bool &maybe_broken_ = known_.maybe_broken, &jointed_ = known_.jointed;
  struct {
    std::vector<std::vector<std::byte>> states;  // by world
    std::uint64_t hash = 0;
    Known known;
  } kept_;
};

}  // namespace psim::fuzz
