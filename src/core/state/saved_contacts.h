// What contacts of discs carry from step to step, on its way out of a world or back: impulses by pair, in the order of
// the table of pairs. Where lists last they are made again in the same order, and need no more. Elsewhere the pairs
// have names: how many each body owns, and the partner of each.
#pragma once

#include <cstdint>
#include <vector>

#include "bodies/static_shapes.h"
#include "contacts/contact_store.h"
#include "lists/pair_table.h"

namespace psim {

class SavedContacts {
 public:
  /// Takes them out of a world, if there are any. `named`: with their names, and without those of dead slots if `ids`,
  /// by slot, is given; `gaps`: with those to fixed shapes.
  void gather(const PairTable& table, const ContactStore& contacts, bool any, bool named, bool gaps,
              const std::uint32_t* ids);

  void describe(class Archive& a, const PairTable& table, const StaticShapes& statics, bool named);
  bool empty() const { return empty(kImpulse) && renewed_.empty() && empty(kStatic); }

  /// Makes `table`, whose strips are there, of the names: contacts lie in the order of their pairs.
  void make_table(PairTable& table, ContactStore& contacts) const;
  /// Into the lanes of lists that were made again. False if those have other contacts.
  bool put_back(const PairTable& table, ContactStore& contacts) const;

 private:
  // What contacts carry, and where it lies in their store: by pair, and from kStatic on by static contact. There is no
  // friction where nothing rubs, and gaps only if they are asked for.
  enum Carried { kImpulse, kFriction, kStatic, kStaticFriction, kNormalX, kNormalY, kGap, kColumns };
  static auto& column(auto& store, int k) {
    using Lanes = ContactLanes;
    constexpr Column<float> Lanes::*kLanes[kColumns] = {
        &Lanes::impulse, &Lanes::friction, &Lanes::impulse, &Lanes::friction, &Lanes::nx, &Lanes::ny, &Lanes::gap};
    return k < kStatic ? store.pairs.*kLanes[k] : store.fixed.*kLanes[k];
  }
  static bool is_friction(int column) { return column == kFriction || column == kStaticFriction; }
  bool empty(int column) const { return carried_[column].empty(); }

  std::vector<std::uint32_t> strip_pairs_, strip_statics_;  // by strip: how many
  std::vector<float> carried_[kColumns];
  std::vector<std::uint32_t> owned_, other_;  // names: by body, by pair
  std::vector<std::uint32_t> s_body_, s_shape_;
  std::vector<PairImpulse> renewed_;  // of pairs that are no strip's (renewal.h)
};

}  // namespace psim
