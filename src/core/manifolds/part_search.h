// Which parts of a body of many parts may meet another body while the lists last. The lists know each body as a circle
// around its centre; a chain of 10,000 segments may have all others in its circle and few near any segment.
//
// In: bodies in cell order, their margins. Out: the parts within those margins, and whether the bodies of many parts have
// turned no further than they may. A search takes O(log bodies of many parts + parts nearby).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "bodies/surroundings.h"
#include "lists/pair_table.h"

namespace psim {

/// Manifolds collect their pairs by these settings.
struct CollectSettings {
  bool any_filter = false;
  Walls walls;
  kernels::ReachParams margin;  ///< of the lists
  float ahead = 0;              ///< s: the lists use the places that bodies will have
  bool surfaces = false;        ///< some surfaces run, resist rolling or are solid from one side
  bool wall_special = false;    ///< those of the walls do
  float step = 0;               ///< s: the pairs serve a single step of this length; 0: several
  Vec2 gravity;                 ///< m/s^2
};

class PartSearch {
 public:
  /// A body of fewer parts has no tree of them.
  static constexpr std::uint32_t kMany = 9;
  /// The same of kinematic bodies: there are few of them, and many a one has all others within it, as a drum has.
  static constexpr std::uint32_t kManyKinematic = 4;

  explicit PartSearch(const Surroundings& s) : s_(s) {}

  void describe(class Archive& a);  ///< for saved states

  struct Noted {
    std::uint32_t slot = 0;
    double angle = 0;  ///< rad, when the lists were made
    float turn = 0;    ///< m: how far the rim may turn from there
  };

  /// Notes how the bodies of many parts among those in `slots`, ascending, lie when lists are made with such margins; if
  /// the lists last, those of several parts, too.
  void note(std::span<const std::uint32_t> slots, const kernels::ReachParams& margin, float ahead, bool lasts);
  /// The lists are made anew with such margins for the bodies in `slots`, ascending.
  void note_again(std::span<const std::uint32_t> slots, const kernels::ReachParams& margin);
  /// The bodies of several parts, but not many, by slot.
  std::span<const Noted> few() const { return few_; }
  const Noted* few_of(std::uint32_t slot) const { return find(few_, slot); }
  /// Finds which bodies of several parts turn further than the lists allow within `time` seconds. O(such bodies).
  std::span<const std::uint32_t> find_turned(float time);
  /// Makes the trees of their shapes, if they are not there. Call before find().
  void prepare();
  /// Whether the bodies of many parts turn no further than the lists allow for `time` seconds more. O(such bodies).
  bool serve(float time) const;

  /// How far a body may go from where the lists were made, m.
  double margin_of(std::uint32_t slot) const;
  /// From one body to another, m, where the lists were made.
  Vec2 way(std::uint32_t from, std::uint32_t to) const;

  std::size_t bytes() const;

  /// Whether a body has so many parts that they are searched for.
  bool has(std::uint32_t slot) const { return !wide_.empty() && wide_of(slot) != nullptr; }
  /// The parts of a body of many parts that may meet any part of another body, ascending.
  void near_body(std::uint32_t slot, std::uint32_t other, std::vector<std::uint32_t>& out) const;
  /// The parts of a body of many parts that may meet one part of another such body, ascending.
  void near_part(std::uint32_t slot, std::uint32_t other, std::uint32_t part, std::vector<std::uint32_t>& out) const;
  /// The parts of a body of many parts that may meet a piece of fixed geometry or a wall, ascending.
  void near_piece(const StaticPair& pair, const Walls& walls, std::vector<std::uint32_t>& out) const;

 private:
  // The parts of a shape by place, in its own frame: boxes of four neighbours, of four such boxes, and so on.
  struct Tree {
    explicit Tree(std::span<const Hull> parts);
    void near(const Bounds& box, std::vector<std::uint32_t>& out) const;
    std::vector<Bounds> boxes;                // of the parts, m
    std::vector<std::uint32_t> order;         // parts by place
    std::vector<std::vector<Bounds>> levels;  // boxes of four of the level below, the first ones of four parts
    double reach = 0;                         // m, of all parts
  };

  bool has_many(std::uint32_t slot) const;
  bool has_few(std::uint32_t slot) const;
  Noted noted(std::uint32_t slot, const kernels::ReachParams& margin, float ahead) const;
  bool serves(const Noted& n, float time) const;
  static const Noted* find(const std::vector<Noted>& all, std::uint32_t slot);
  const Noted* wide_of(std::uint32_t slot) const { return find(wide_, slot); }
  const Tree& tree_of(std::uint32_t slot) const;
  const Surroundings s_;
  std::vector<Noted> wide_, few_;                                   // by slot: bodies of many parts, of several
  std::vector<std::uint32_t> turned_;                               // slots
  double common_way_ = 0;                                           // m: how far all bodies go together meanwhile
  std::unordered_map<std::uint32_t, std::unique_ptr<Tree>> trees_;  // by the first part; look-up only, but for a sum
  std::uint64_t of_shapes_ = 0;                                     // ShapeTable::changes() that trees_ are made for
};

}  // namespace psim
