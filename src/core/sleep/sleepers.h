// The bodies that sleep, and for how long each body has rested. A body that falls asleep leaves the columns of the
// moving bodies and stands among the fixed shapes until it wakes; the impulses of its contacts are kept.
//
//   watch     every kWatchFrames: counts for how long each body has stayed within its ball
//   recent    impulses of contacts whose sides fell asleep or woke, until the contacts are laid out anew
//
// A body rests if it has not left a ball of 2e-4 of its radius, at most 0.1 mm, for half a second; it wakes
// what sleeps beside it once it leaves a ball five times as large. A body without friction that lies between
// others creeps, which lets it rest, too, if it has kept to a tenth of its radius for four seconds: piles without
// friction creep for minutes. A body with friction that a contact bears may tremble: it rests, too, if it has kept to 3 % of
// its radius for two seconds. A body sleeps once all that it touches rests too, and something supports it.
// docs/sleeping.md has the rules and how they were measured.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "base/elementary.h"
#include "base/tasks.h"
#include "bodies/surroundings.h"
#include "contacts/touch_memory.h"

namespace psim {

struct Sleeper {
  LatticePoint at;   ///< the centre of the body
  double angle = 0;  ///< rad
  std::uint32_t id = 0;
  std::uint32_t first_shape = 0, pieces = 0;   ///< in StaticShapes
  std::uint32_t first_touch = 0, touches = 0;  ///< in Sleepers::touches
  float substep = 0;                           ///< s: its touches carried their impulses in so long a time
  std::uint32_t group = kNoSlot;               ///< bodies of one stack have the same group and wake together
  bool creeps = false;  ///< it crept or trembled when it fell asleep: one that does so beside it does not wake it
  bool goes = false;    ///< Sleep::let_go() is at work, and it does not wake any more
};

/// The only piece of a plain disc that sleeps.
inline StaticShape lone_piece(const LatticePoint& at, std::uint32_t id, const BodyProperties& properties) {
  StaticShape piece;
  piece.p = at;
  piece.radius = properties.radius;
  piece.restitution = properties.restitution;
  piece.friction = properties.friction;
  piece.owner = id;
  piece.lone = true;
  return piece;
}

/// A body to wake, with `rings` rings of neighbours, or with all that may rest on it (kAbove).
struct Waking {
  static constexpr std::uint32_t kAbove = 0xFFFFFFFFu;
  std::uint32_t id = 0, rings = 0;
};

/// A moving body presses on a sleeper.
struct Press {
  std::uint64_t key = 0;            ///< of their contact
  std::uint32_t owner = 0, by = 0;  ///< id of the sleeper; slot of the body
  double force = 0;                 ///< N
};

class Sleepers {
 public:
  explicit Sleepers(const Surroundings& s) : state(s.memory), s_(s), b_(s.bodies), watched_(s.memory) {}

  static constexpr std::uint64_t kWatchFrames = 8;
  static constexpr std::uint32_t kMostAtOnce = 8192;  ///< bodies that fall asleep in one step
  static constexpr std::uint32_t kRoomAhead = 4096;   ///< bodies that there is room for before the first one sleeps
  static constexpr std::size_t kMostAbove = 4096;     ///< bodies that wake at once because a body was taken away
  /// s: who stays in its ball for so long rests. What joints tie trembles for longer than what comes to rest alone.
  static constexpr double kRestTime = 0.5, kCreepTime = 4, kTrembleTime = 2, kTrembleAlone = 5;
  static constexpr float kBallOfRadius = 2e-4f, kLargestBall = 1e-4f;  ///< share; m
  static constexpr float kWaking = 5;  ///< the ball that wakes others is so many times as large
  static constexpr float kCreepOfRadius = 0.1f, kLargestCreep = 0.05f;
  static constexpr float kTrembleOfRadius = 0.03f, kLargestTremble = 0.015f;
  /// The balls of a body: who stays in the first one rests. The second one is wide_ball(). The third one is for bodies with
  /// friction, in worlds with shapes or joints: who stays in it trembles, however fast; its angle stays in it, too.
  enum BallKind : std::uint8_t { kRest, kWide, kTremble, kBalls };
  static constexpr float kSlow = 0.05f;  ///< m/s: while all but one body in kFewSlow are faster, no body is watched
  static constexpr std::uint32_t kFewSlow = 64;

  /// How far a body may move, m, and still rest.
  static float ball(float radius) { return lesser(kBallOfRadius * radius, kLargestBall); }
  /// The second ball, m: a body without friction that stays in it creeps; another one that leaves it wakes others.
  static float wide_ball(float radius, bool smooth) {
    return smooth ? lesser(kCreepOfRadius * radius, kLargestCreep) : kWaking * ball(radius);
  }

  /// For saved states; behind the bodies and the fixed geometry, into which those that are read are put.
  void describe(class Archive& a, BodyStore& bodies, StaticShapes& statics);

  std::vector<Sleeper> list;   ///< by BodyInfo::slot of sleeping bodies
  std::vector<Touch> touches;  ///< in runs: Sleeper::first_touch
  std::size_t dropped = 0;     ///< number of touches in runs of bodies that woke
  float widest = 0;            ///< m: no sleeper has a larger radius
  TouchMemory recent;
  bool woke = false;          ///< a body woke since the lists were made
  bool changed = false;       ///< a body fell asleep or woke since events were collected
  std::uint64_t changes = 0;  ///< how often one did
  bool leaving = false;       ///< bodies are falling asleep: some are in the columns and in the list
  // Scratch of sleeping and waking.
  std::vector<Waking> queue;
  std::vector<std::uint32_t> found, roots;
  std::vector<Piece> pieces;
  std::vector<Press> presses;
  Column<std::uint8_t> state;  ///< by slot: marks of choosing (sleep_choice.cpp)
  /// The mark of the bodies that were chosen to sleep.
  static constexpr std::uint8_t kChosen = 8;
  bool chosen(std::uint32_t slot) const { return (state[slot] & kChosen) != 0; }
  bool empty() const { return list.empty(); }

  /// Whether enough bodies of a sample of 2,000 are slow, so that watching is worth its time.
  bool anyone_slow() const;
  /// Makes room for so many bodies that fall asleep in one step: they allocate nothing then, unless they have more than
  /// kTouchesOfBody touches each.
  void make_room(std::size_t fall_asleep, bool joined);
  bool has_room() const { return b_.count <= room_of_; }
  /// Makes room for so many sleepers more, with so many touches, some of them with bodies that stay awake.
  void make_room_for_more(std::size_t bodies, std::size_t with_touches, std::size_t of_awake);

  /// Looks at every body and counts for how long it has rested. O(bodies). False if no body is slow.
  bool watch();
  bool watching() const { return watching_; }

  /// Returns the number of watches that `time` seconds take.
  static std::uint32_t needed(double dt, double time = kRestTime);
  /// For how many watches a body has stayed in one of its balls.
  std::uint32_t calm(std::uint32_t id, BallKind ball = kRest) const {
    return id < watched_.capacity() ? watched_[id].calm[ball] : 0;
  }
  /// The ball of a body that creeps or trembles.
  static BallKind restless(const BodyProperties& properties) { return properties.friction > 0 ? kTremble : kWide; }
  /// The body counts as moving from now on: sleepers that touch it wake.
  void mark_moving(std::uint32_t id) {
    if (id < watched_.capacity()) std::ranges::fill(watched_[id].calm, std::uint8_t{0});
  }
  /// The body woke where it slept: it wakes others only once it leaves its ball.
  void mark_woken(std::uint32_t id, const LatticePoint& at, double angle);
  /// Whether a body wakes a sleeper that it touches: it is outside of its ball, or was so at the last watch. `creeps`:
  /// the sleeper crept when it fell asleep.
  bool moves(std::size_t slot, bool creeps) const;

  /// Drops the runs of touches that belong to no sleeper any more.
  void tidy();
  std::size_t bytes() const;
  std::size_t column_bytes() const { return watched_.bytes() + state.bytes(); }
  /// Gives the memory back, but for `recent`. No body sleeps or may sleep.
  void release();

 private:
  static constexpr std::size_t kTouchesOfBody = 6;  // as many as equal discs have in a dense packing
  struct Ball;

  // The middles of the balls, in units of at least a 128th of the ball, modulo 2^16 units. A body that moves by a
  // multiple of 2^16 units, which is 256 balls at least, between two watches is taken for one that stayed.
  struct Watched {
    std::uint16_t x[kBalls] = {}, y[kBalls] = {};
    std::uint16_t turned = 0;        // the angle in the middle of kTremble, as a way of the rim
    std::uint8_t calm[kBalls] = {};  // watches that the body has stayed
  };
  const Surroundings s_;
  const BodyStore& b_;
  Column<Watched> watched_;  // by id
  std::vector<Touch> kept_;  // scratch of tidy
  bool watching_ = false;
  std::uint32_t room_of_ = 0;  // bodies that there is room for
};

}  // namespace psim
