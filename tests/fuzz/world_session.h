// Calls of a world out of bytes, and what they must do; used by the files world_input*.cpp alone.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "byte_source.h"
#include "inputs.h"
#include "psim/psim.h"
#include "psim/recording.h"
#include "psim/scene.h"

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
    std::vector<BodyId> by_index;  // the living body of each index, kNoBody where there is none
    std::vector<JointId> joints;
    std::set<std::uint32_t> broken;  // given NaN since the last step
    bool maybe_broken = false, jointed = false;
  };

  using Worlds = std::vector<std::unique_ptr<World>>;

  // world_input.cpp
  bool create();
  void call();
  void call_rich(std::size_t kind);
  bool spent() const;
  void ask();
  void replace_last();
  void go_back();

  // world_input_bodies.cpp
  void add_body();
  void add_discs();
  void live(BodyId id);
  BodyId some_body();
  void remove_body();
  void bury(const std::vector<BodyId>& gone);
  bool is_live(BodyId id) const;
  void move_body();
  void change_body(BodyId id, Vec2 place);
  void push_body(BodyId id, Vec2 place);  // world_input_forces.cpp
  void change_fields(ByteSource& own);
  void pour();
  void touch_taps();
  void add_joint();
  JointId some_joint();
  void touch_joint();
  void change_joint(JointId id, bool whole);
  JointDesc joint_of(JointType type);

  // world_input_many.cpp
  BodyId add(const BodyDesc& desc);
  std::size_t add(const DiscBatch& batch);
  JointId add(const JointDesc& desc);
  GroupDesc group(std::size_t most);
  void add_pile();
  void add_net();
  void add_terrain();
  void add_giant();
  void add_kinematic();
  void add_tower();
  void push_many();
  void remove_many();

  // world_input_start.cpp
  bool create_from_scene(const WorldDesc& desc, const RunOptions& options, bool twins);

  // world_input_record.cpp
  void start_recording();
  void end_recording();
  void starve();
  void count();

  // world_input_steps.cpp
  void step(double dt);
  template <class Stepper>
  void step_all(std::vector<StepReport>& reports, const Stepper& stepper) {
    for (auto& w : worlds_) {
      reports.push_back(recorder_ && w == worlds_.back() ? stepper(*recorder_) : stepper(*w));
    }
  }
  void stepped(const std::vector<StepReport>& reports);
  void say_fastest(World& world) const;
  void look(bool all);
  void replay(std::optional<double> dt);
  void govern();
  void change_options();

  // The same question to every world has the same answer.
  template <class Answer, class Call>
  Answer same(const char* what, const Call& call) {
    const Answer first = call(*worlds_.front());
    for (std::size_t k = 1; k < worlds_.size(); ++k) {
      require(call(*worlds_[k]) == first, std::string(what) + ": two variants differ");
    }
    return first;
  }

  // The same change of every world has the same answer. The last world is changed through its recorder, if it has one.
  template <class Answer, class Call>
  Answer change(const char* what, const Call& call) {
    const auto on_last = [&] { return recorder_ ? call(*recorder_) : call(*worlds_.back()); };
    if (worlds_.size() == 1) return on_last();
    const Answer first = call(*worlds_.front());
    require(on_last() == first, std::string(what) + ": two variants differ");
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
  std::unique_ptr<Recorder> recorder_;  // of the last world
  std::size_t most_bodies_ = 120, most_joints_ = 80;
  std::size_t segments_ = 0;  // of long chains
  std::uint64_t work_ = 0;    // done by steps, as stepped() counts it
  bool over_ = false;         // the world has ended for want of memory
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
