// The columns of contacts of discs, by lane. Columns that the contact model of the plan does not read own no memory.
// ContactStore owns two sets of them: contacts of two moving bodies, and contacts of one body with fixed geometry.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "base/column.h"
#include "base/elementary.h"
#include "bodies/body_properties.h"
#include "contacts/contact_model.h"

namespace psim {

/// The classes of the contacts of a strip: their colours, and what overflows into blocks of one lane. Contacts under
/// heavy loads have the colours from kLoaded on, and an overflow of their own.
struct ContactClass {
  static constexpr std::uint32_t kColours = 31, kLoaded = 16;
  static constexpr std::uint32_t kOverflow = kColours, kLoadedOverflow = kColours + 1;
  using Counts = std::array<std::uint32_t, kColours + 2>;  ///< lanes of each class
};

/// Contacts with `sides` moving bodies. Side B is the last of them; the other side is A.
struct ContactLanes {
  ContactLanes(std::size_t moving_sides, MemoryMeter& memory) : sides(moving_sides), meter(memory) {}

  /// Makes room for so many lanes in the columns that a model reads. The others give their memory back.
  void make_room(ContactModel model, std::size_t lanes);
  void swap_impulses();
  /// Makes a lane that does nothing: resting dummies beyond the bodies, far from anything.
  void pad(ContactModel model, std::size_t lane, std::uint32_t dummy);
  /// Writes all numbers that follow from the properties of the sides.
  void fill(ContactModel model, const MixingRules& rules, std::size_t lane, const BodyProperties& a,
            const BodyProperties& b) {
    if (model.bounce) e[lane] = mixed(rules.restitution, a.restitution, b.restitution);
    if (!model.massed()) return;
    const float w = a.inv_mass + b.inv_mass;
    if (sides == 2) wa[lane] = a.inv_mass;
    wb[lane] = b.inv_mass;
    mass[lane] = w > 0 ? 1 / w : 0;
    if (!model.rough()) return;
    mu[lane] = mixed(rules.friction, a.friction, b.friction);
    if (sides == 2) qa[lane] = a.rim_gain;
    qb[lane] = b.rim_gain;
    const float wt = w + a.rim_gain + b.rim_gain;
    tmass[lane] = wt > 0 ? 1 / wt : 0;
  }
  /// The same for many lanes whose sides are all alike.
  void fill_all(ContactModel model, const MixingRules& rules, std::size_t begin, std::size_t end,
                const BodyProperties& both);
  void put(ContactModel model, std::size_t lane, float normal_impulse, float tangent_impulse) {
    impulse[lane] = greater(normal_impulse, 0.0f);  // open contacts have an impulse of -0
    if (model.rough()) friction[lane] = tangent_impulse;
  }
  static constexpr std::uint32_t kNoLane = 0xFFFFFFFFu;
  /// Takes the impulses over from a lane of the last layout; kNoLane: the contact begins without any.
  void carry(ContactModel model, std::size_t lane, std::uint32_t before) {
    if (before == kNoLane) return put(model, lane, 0, 0);
    put(model, lane, old_impulse[before], model.rough() ? old_friction[before] : 0);
  }

  std::size_t mass_bytes() const { return mass.bytes() + wa.bytes() + wb.bytes(); }
  std::size_t bounce_bytes() const { return e.bytes() + impact.bytes() + start.bytes(); }
  std::size_t friction_bytes() const {
    return mu.bytes() + friction.bytes() + old_friction.bytes() + tmass.bytes() + qa.bytes() + qb.bytes();
  }

  const std::size_t sides;
  MemoryMeter& meter;
  Column<std::uint32_t> body{meter};  ///< `sides` numbers a lane, see SolverBodies
  Column<float> nx{meter}, ny{meter}, gap{meter}, rsum{meter}, impulse{meter}, old_impulse{meter};
  Column<float> mass{meter}, wa{meter}, wb{meter};
  Column<float> mu{meter}, friction{meter}, old_friction{meter}, tmass{meter}, qa{meter}, qb{meter};
  Column<float> e{meter}, impact{meter}, start{meter};
  std::vector<ContactClass::Counts> counts;  ///< by strip
  std::uint32_t blocks = 0;
  std::uint64_t count = 0;
};

struct PairLanes : ContactLanes {
  explicit PairLanes(MemoryMeter& memory) : ContactLanes(2, memory) {}
  kernels::ContactView view();
};

struct StaticLanes : ContactLanes {
  explicit StaticLanes(MemoryMeter& memory) : ContactLanes(1, memory) {}
  void make_room(ContactModel model, std::size_t lanes);
  void swap_impulses();  ///< and normals: the narrow phase keeps a pressed contact on its side of a segment
  void pad(ContactModel model, std::size_t lane, std::uint32_t dummy);
  kernels::StaticContactView view();

  Column<std::uint32_t> shape{meter};
  Column<float> base_x{meter}, base_y{meter}, refresh{meter}, old_nx{meter}, old_ny{meter};
};

}  // namespace psim
