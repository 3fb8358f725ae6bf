// What each part of a world must remember so that it goes on with the same bits: one visitor a part, for
// writing and reading alike (archive.h). A part lets Image see its members; nothing else reaches in.
#pragma once

#include "archive.h"
#include "world_impl.h"

namespace psim {

template <>
inline constexpr std::uint64_t kLastOf<BodyType> = 2;
template <>
inline constexpr std::uint64_t kLastOf<Boundary> = 2;
template <>
inline constexpr std::uint64_t kLastOf<Integrator> = 3;
template <>
inline constexpr std::uint64_t kLastOf<JointType> = 5;
template <>
inline constexpr std::uint64_t kLastOf<kernels::JointKind> = 5;
template <>
inline constexpr std::uint64_t kLastOf<kernels::Model> = 2;
template <>
inline constexpr std::uint64_t kLastOf<Place> = 4;
template <>
inline constexpr std::uint64_t kLastOf<Part> = static_cast<std::uint64_t>(Part::done);
template <>
inline constexpr std::uint64_t kLastOf<ManifoldPair::Column> = 2;

/// As in sleeper_pack.h, but of those who sleep in `sleepers` into `out`.
bool unpack_recent(std::span<const std::byte> pack, const Sleepers& sleepers, const BodyStore& bodies, TouchMemory& out);

struct Image {
  // Descriptions and short things.
  template <class A>
  static void visit(A& a, WorldDesc& d);
  template <class A>
  static void visit(A& a, Traits& t);
  template <class A>
  static void visit(A& a, Plan& p);
  template <class A>
  static void visit(A& a, Surface& s);
  template <class A>
  static void visit(A& a, Hull& h);
  template <class A>
  static void visit(A& a, Make& m);
  template <class A>
  static void visit(A& a, LatticePoint& p) {
    numbers(a, p.x, p.y, p.dx, p.dy);
  }
  template <class A>
  static void visit(A& a, BodyId& id) {
    numbers(a, id.index, id.generation);
  }
  template <class A>
  static void visit(A& a, JointDesc& d);
  template <class A>
  static void visit(A& a, ManifoldPair& p);
  template <class A>
  static void visit(A& a, StaticShape& s);

  // Parts of a world.
  template <class A>
  static void bodies(A& a, BodyStore& b, bool lists);
  template <class A>
  static void standing(A& a, StaticShapes& s);
  /// After the bodies. `read`, here and below: what a dry run has read them into.
  template <class A>
  static void shapes(A& a, StaticShapes& s, Sleepers& sleepers, BodyStore& b, const Sleepers* read);
  template <class A>
  static void broad(A& a, BroadPhase& b);
  template <class A>
  static void renewal(A& a, ListRenewal& r, std::size_t slots);
  template <class A>
  static void contacts(A& a, ContactStore& c);
  template <class A>
  static void manifolds(A& a, Manifolds& m, std::size_t slots);
  /// What was read of them, into those of a world; into the memory that they have, or what comes with it.
  static void take(Manifolds& m, Manifolds& read, std::size_t slots, bool keep_room);
  template <class A>
  static void joints(A& a, JointStore& j, JointStore* read);
  /// Whether what a dry run read agrees with itself (image_check.h), so that nothing that is made of it reads or
  /// writes where it must not. What is not so is told to the loader. `lists`: they last. What sleeps in `now` is sound.
  template <class W>
  static void check(Loader& a, W& seen, const W& now, bool lists);
  template <class A>
  static void sleepers(A& a, Sleepers& s, const BodyStore& b);
  template <class A>
  static void events(A& a, EventList& e);
  template <class A>
  static void table(A& a, PairTable& t);
  template <class A>
  static void solved(A& a, SolverBodies& s);
  /// What the governor counts of the last step, and no other part has.
  template <class A>
  static void counts(A& a, Solver& s, HeavyLoads& l, Continuous& c);

 private:
  template <class W>
  struct Check;
  static void take(JointStore& j, JointStore& read);
  template <class W>
  static bool unpack(Loader& a, W& seen, const W& now, bool same_roster);
};

template <>
void Image::shapes(Saver& a, StaticShapes& s, Sleepers& sleepers, BodyStore& b, const Sleepers* read);
template <>
void Image::shapes(Loader& a, StaticShapes& s, Sleepers& sleepers, BodyStore& b, const Sleepers* read);

}  // namespace psim
