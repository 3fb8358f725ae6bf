// Bodies that are asleep: they leave the columns of those that move, and stand among the fixed shapes
// until they are woken. What they weigh, bear and touch is kept.
//
//   watch     every kWatchFrames: who has stayed within its rest ball for how long
//   choose    every second time: who may sleep, at most kMostAtOnce
//   recent    impulses of contacts whose sides fell asleep or woke, for the next build of the lists
//
// A body rests that has not left a ball of 2e-4 of its radius, at most 0.1 mm, for half a second; it wakes
// what sleeps beside it once it leaves one five times as large. A body without friction that lies between
// others also rests, loosely, if it has kept to a tenth of its radius for four seconds: piles without
// friction creep for minutes. A body sleeps once all that it touches rests too, and something bears it. docs/sleeping.md has the rules and what they were measured against.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "archive.h"
#include "body_store.h"
#include "column.h"
#include "lattice.h"
#include "sleeper_pack.h"
#include "static_shapes.h"
#include "tasks.h"
#include "worker_pool.h"

namespace psim {

/// What a contact carried, by who touched whom.
struct TouchKey {
  static std::uint64_t bodies(std::uint32_t a, std::uint32_t b) {
    return a < b ? std::uint64_t{a} << 32 | b : std::uint64_t{b} << 32 | a;
  }
  static std::uint64_t fixed(std::uint32_t body, std::uint32_t shape) {
    return std::uint64_t{1} << 63 | std::uint64_t{body} << 32 | shape;
  }
};

/// Of one contact: two points where shapes touch along an edge, in order along the edge.
struct Touch {
  std::uint64_t key = 0;
  float impulse[2] = {}, friction[2] = {};  ///< N s, or of discs `per_mass`, N s / kg
  std::uint32_t points = 1;
  bool per_mass = false;  ///< as lanes have them where all discs have one mass

  /// What brings it into the other unit, if that is wanted. `mass`: of its disc.
  float times(bool wanted_per_mass, float mass) const {
    return per_mass == wanted_per_mass ? 1.0f : per_mass ? mass : 1 / mass;
  }

  bool of_fixed() const { return key >> 63 != 0; }
  /// Ids of two bodies, the lower one first; or a body and a piece of fixed geometry.
  std::uint32_t first() const { return static_cast<std::uint32_t>(key >> 32) & 0x7FFFFFFFu; }
  std::uint32_t second() const { return static_cast<std::uint32_t>(key); }
};

/// Touches by key. Filled, read until the lists are made, forgotten.
class TouchMemory {
  friend struct Image;

 public:
  void add(const Touch& touch);
  const Touch* find(std::uint64_t key) const;
  bool empty() const { return list_.empty(); }
  const std::vector<Touch>& all() const { return list_; }
  void clear();
  /// For so many: adding them allocates nothing.
  void make_room(std::size_t touches);
  std::size_t bytes() const { return list_.capacity() * sizeof(Touch) + slot_.capacity() * 4; }

 private:
  void rehash(std::size_t size);

  std::vector<Touch> list_;
  std::vector<std::uint32_t> slot_;  // open addressing into list_; kNoSlot: free
};

struct Sleeper {
  LatticePoint at;            ///< of its centre
  double angle = 0;           ///< rad
  std::uint32_t id = 0;
  std::uint32_t first_shape = 0, shapes = 0;   ///< its pieces
  std::uint32_t first_touch = 0, touches = 0;  ///< in Sleepers::touches
  float depth = 0;            ///< m: of its deepest contact when it fell asleep
  std::uint32_t group = kNoSlot;  ///< of a column: they wake together
  bool loose = false;         ///< it crept: what creeps beside it does not wake it
};

/// What a plain disc is while it sleeps.
inline StaticShape lone_piece(const LatticePoint& at, std::uint32_t id, const Surface& surface) {
  StaticShape piece;
  piece.p = at;
  piece.radius = surface.radius;
  piece.restitution = surface.restitution;
  piece.friction = surface.friction;
  piece.owner = id;
  piece.lone = true;
  return piece;
}

/// Someone to wake, with `rings` rings of neighbours, or with all that may rest on it.
struct Waking {
  static constexpr std::uint32_t kAbove = 0xFFFFFFFFu;
  std::uint32_t id = 0, rings = 0;
};

class Sleepers {
  friend struct Image;

 public:
  explicit Sleepers(MemoryMeter& meter) : rest_(meter), state_(meter) {}

  static constexpr std::uint64_t kWatchFrames = 8;
  static constexpr std::uint32_t kMostAtOnce = 8192;  ///< that fall asleep in one step
  static constexpr std::uint32_t kRoomAhead = 4096;   ///< of these, that there is room for before the first sleep
  static constexpr std::size_t kMostAbove = 4096;     ///< that wake at once because something was taken away
  static constexpr double kRestTime = 0.5, kLooseTime = 4;             ///< s in the rest ball
  static constexpr float kBallOfRadius = 2e-4f, kLargestBall = 1e-4f;  ///< m
  static constexpr float kWaking = 5;                                  ///< balls
  static constexpr float kLooseOfRadius = 0.1f, kLargestLoose = 0.05f;
  static constexpr float kSlow = 0.05f;  ///< m/s: while all but one in kFewSlow are faster, nobody is watched
  static constexpr std::uint32_t kFewSlow = 64;

  /// m: how far a body may stray and rest.
  static float ball(float radius) { return std::fmin(kBallOfRadius * radius, kLargestBall); }
  /// The second ball: to rest loosely, without friction; else to wake others.
  static float wide_ball(float radius, bool smooth) {
    return smooth ? std::fmin(kLooseOfRadius * radius, kLargestLoose) : kWaking * ball(radius);
  }

  std::vector<Sleeper> list;     ///< by BodyInfo::slot of sleeping bodies
  std::vector<Touch> touches;    ///< runs of the list's bodies
  TouchMemory recent;
  bool woke = false;             ///< someone did, since the lists were made
  bool changed = false;          ///< someone fell asleep or woke, since events were told
  // Scratch.
  std::vector<Waking> queue;
  std::vector<std::uint32_t> found, number, roots;
  std::vector<std::uint8_t> wakeful;
  std::vector<Piece> pieces;
  bool empty() const { return list.empty(); }

  /// Whether enough of some 2,000 bodies are slow for a watch to be worth its while.
  bool anyone_slow(const BodyStore& bodies) const;
  /// For so many bodies that fall asleep in one step, with kTouchesOfBody touches each. So they allocate nothing
  /// then, unless they have more.
  void make_room(const BodyStore& bodies, std::size_t fall_asleep, bool joined);
  bool has_room(const BodyStore& bodies) const { return bodies.count <= room_of_; }

  /// Looks at every body: O(bodies). False if nobody is slow.
  bool watch(const BodyStore& bodies, const Lattice& lattice, WorkerPool& pool);
  bool watching() const { return watching_; }

  /// How many watches a body must have stayed in its ball to rest.
  static std::uint32_t needed(double dt, bool loose = false);
  /// For how many it has, by ball.
  std::uint32_t calm(std::uint32_t id, bool wide = false) const {
    return id < rest_.capacity() ? rest_[id].calm[wide] : 0;
  }
  /// It counts as moving: what sleeps and touches it wakes.
  void mark_moving(std::uint32_t id) {
    if (id < rest_.capacity()) rest_[id].calm[0] = rest_[id].calm[1] = 0;
  }
  /// It woke where it slept: it wakes others only once it leaves its ball.
  void mark_woken(const BodyStore& bodies, const Lattice& lattice, std::uint32_t id, std::int32_t x, std::int32_t y);
  /// Whether a body moves so that it wakes one that sleeps (`loose`ly): it left a ball, or did so of late.
  bool moves(const BodyStore& bodies, const Lattice& lattice, std::size_t slot, bool loose) const;

  Column<std::uint8_t>& state() { return state_; }
  /// Drops runs of touches that nobody has any more.
  void tidy();
  /// Of the list's k-th something is not as it was.
  void spoil_pack(std::size_t k) {
    if (k / SleeperPack::kEach < packs_.size()) packs_[k / SleeperPack::kEach].stale = true;
  }
  /// Makes the stale packs anew: for saving.
  void pack(const BodyStore& bodies, WorkerPool& pool);
  std::size_t bytes() const;
  std::size_t column_bytes() const { return rest_.bytes() + state_.bytes(); }
  /// Nobody sleeps or may: gives the memory back, but for what contacts are to take over.
  void release();

 private:
  static constexpr std::size_t kTouchesOfBody = 6;  // of equal discs, packed
  struct Ball;
  bool left_ball(const BodyStore& bodies, const Lattice& lattice, std::size_t slot, bool wide) const;

  // For both balls. A middle is in units of at least a 128th of the ball, modulo 2^16 of them: a body that moved on by
  // whole rounds of these, 256 balls at least, from one look to the next is taken for one that stayed.
  struct Rest {
    std::uint16_t x[2] = {}, y[2] = {};
    std::uint8_t calm[2] = {};  // watches in it
  };
  static Rest rest_at(const Surface& surface, const Lattice& lattice, std::int32_t x, std::int32_t y);
  Column<Rest> rest_;            // by id
  Column<std::uint8_t> state_;   // by slot: scratch of choosing
  std::vector<Touch> kept_;      // scratch of tidy
  std::vector<SleeperPack> packs_;  // of the last saved state
  std::vector<Rest> rests_;         // scratch of saving: of those awake
  std::vector<std::byte> recent_;   // and of `recent`
  struct Seen {                     // in a dry run: where they lie in the bytes
    InPlace<std::byte> others, recent;
    std::vector<InPlace<std::byte>> packs;
    std::size_t rests = 0;
  } seen_;
  bool watching_ = false;
  std::uint32_t room_of_ = 0;    // bodies
};

}  // namespace psim
