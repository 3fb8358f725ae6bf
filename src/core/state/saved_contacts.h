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
  /// Takes them out of a world. `named`: with their names; `gaps`: with those to fixed shapes.
  void gather(const PairTable& table, const ContactStore& contacts, bool named, bool gaps);
  /// There are none, in as many strips.
  void gather_none(const PairTable& table);

  template <class A>
  void describe(A& a, const PairTable& table, const StaticShapes& statics, bool named);
  bool empty() const { return impulse_.empty() && renewed_.empty() && s_impulse_.empty(); }

  /// Makes `table`, whose strips are there, of the names: contacts lie in the order of their pairs.
  void make_table(PairTable& table, ContactStore& contacts) const;
  /// Into the lanes of lists that were made again. False if those have other contacts.
  bool put_back(const PairTable& table, ContactStore& contacts) const;

 private:
  struct Renewed {  // a pair that is no strip's (renewal.h)
    std::uint32_t owner = 0, other = 0;
    float impulse = 0, friction = 0;
  };
  void clear();

  std::vector<std::uint32_t> strip_pairs_, strip_statics_;  // by strip: how many
  std::vector<float> impulse_, friction_;                   // by pair; no friction where there is none
  std::vector<float> s_impulse_, s_friction_, s_nx_, s_ny_, s_gap_;
  std::vector<std::uint32_t> owned_, other_;  // names: by body, by pair
  std::vector<std::uint32_t> s_body_, s_shape_;
  std::vector<Renewed> renewed_;
};

}  // namespace psim
