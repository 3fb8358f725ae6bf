// What contacts carry from step to step, taken out of a world and brought back (World::save, restore).
//
// Lists that last are not saved: they are made again from where the bodies were when they were made, and
// impulses go to the same pairs. That waits until somebody needs the lists. Where lists are for one step, or
// are to be made anew, who is a pair is saved, too, and comes back into a table when somebody needs it. What was made of a step that is under way
// over frames is made again from a list of what was done.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "archive.h"

namespace psim {

/// So many values in memory that only grows: what is new is not set, nothing is cleared.
template <class T>
class Refilled {
 public:
  using value_type = T;
  void resize(std::size_t n) {
    if (n > room_.size()) room_.resize(n + n / 8);
    size_ = n;
  }
  void clear() { size_ = 0; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  T* data() { return room_.data(); }
  const T* data() const { return room_.data(); }
  T* begin() { return data(); }
  T& operator[](std::size_t i) { return room_[i]; }
  const T& operator[](std::size_t i) const { return room_[i]; }

 private:
  std::vector<T> room_;
  std::size_t size_ = 0;
};

/// What contacts carry: of pairs of discs, then of singles. A single's gap says whether a sleeper is about to be met.
template <template <class> class List>
struct Carried {
  List<float> impulse, friction, s_impulse, s_friction, s_nx, s_ny, s_gap;
  static constexpr std::size_t kOfPairs = 2;
  std::array<List<float>*, 7> all() {
    return {&impulse, &friction, &s_impulse, &s_friction, &s_nx, &s_ny, &s_gap};
  }
};

struct Saved {
  Carried<Refilled> kept;  ///< of lists that last, until they are made again
  /// Contacts in the bytes of a state, while it is written or read. Where lists do not last they have names:
  struct InBytes : Carried<InPlace> {
    InPlace<std::uint8_t> of_body;     ///< by slot: pairs that it owns; kMany: see the next of `many`
    InPlace<std::uint32_t> many;       ///< by strip: room for as many as can be
    InPlace<std::uint16_t> near;       ///< by pair: the partner, counted from the strip's first body
    InPlace<std::uint32_t> far;        ///< or its slot, in strips where that takes more than 16 bits
    InPlace<std::uint32_t> s_body, s_shape;
    /// each(column), of names.
    template <class Each>
    void each_name(const Each& each) {
      each(of_body), each(many), each(near), each(far), each(s_body), each(s_shape);
    }
  };
  static constexpr std::uint8_t kMany = 255;
  struct Lengths {
    std::uint32_t pairs = 0, singles = 0, near = 0, far = 0, many = 0;
  };
  InBytes bytes;
  Refilled<std::byte> names;  ///< while they wait, `bytes` lies here
  bool named = false;         ///< the table's pairs are still names
  struct Pair {
    std::uint32_t owner = 0, other = 0;
    float impulse = 0, friction = 0;
  };
  std::vector<Pair> renewed;  ///< those that are no strip's (renewal.h), where lists do not last
  std::vector<float> dead_radii;
  std::vector<std::uint32_t> strip_pairs, strip_singles;  ///< by strip: how many
  std::vector<std::uint32_t> first_pair, first_single, first_partner, first_many;  ///< and where they begin
  bool missing = false;       ///< the lists of a restored state are
  bool shaped = false;        ///< and manifolds wait for them
  bool large = false;         ///< in much memory
  bool undone = false;        ///< so is the work of its step that was under way over frames
  /// What a step under way over frames consists of so far, in order: work up to a piece of a part, and bodies
  /// that the host pushed in between. Done again, it comes out the same.
  struct Done {
    std::uint32_t part = 0, at = 0;
    double span = 0;       ///< s: that the work was for; 0: a push
    std::uint32_t id = 0;  ///< of the body, and how it moved before, m/s
    float vx = 0, vy = 0, spin = 0;
  };
  std::vector<Done> done;
  std::uint64_t candidates = 0;       ///< how many there are, where they are not
  std::vector<std::uint32_t> origin;  ///< where bodies lay when the contacts were laid out, if they moved on
  bool bare = false;          ///< contacts have impulses alone
  std::uint64_t builds = 0;   ///< ContactStore::builds() then
  Saver saver;                ///< its memory
};

}  // namespace psim
