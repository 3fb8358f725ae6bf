// Whether a state that was read in a dry run agrees with itself: counts with each other, numbers of bodies, slots,
// shapes, pairs and joints with the lists that they are of. Bytes of a file may be anything; what is sound here can be
// restored and stepped without reading or writing where nothing is. Numbers that only make a world odd (a place, a
// speed, an impulse) are let through. O(short lists), and one pass over the ids of all slots.
//
//   image_check.cpp           settings, events, and in which order all is looked at
//   image_check_bodies.cpp    who is there: tables, runs of bodies alike, ids of the slots, the plan
//   image_check_lists.cpp     fixed geometry, cells, strips and pairs
//   image_check_contacts.cpp  contacts of shapes, joints, sleepers
#pragma once

#include <algorithm>
#include <vector>

#include "image.h"

namespace psim {

template <class W>
struct Image::Check {
  using U32 = std::uint32_t;

  Loader& a;
  W& w;
  const W& now;
  bool lists;
  std::vector<std::uint64_t> of_place = std::vector<std::uint64_t>(kLastOf<Place> + 1);
  std::vector<U32> first_of_run = {};  // ids
  std::vector<U32> run_of_id = {};
  InPlace<U32> slot_ids = {};
  bool same_roster = false;  // the bodies that there are are those of `now`
  bool as_before = false;    // fixed geometry and what sleeps are those of `now`

  bool ok() const { return a.ok(); }
  void require(bool sound) { a.require(sound); }
  U32 ids() const { return w.bodies.id_count; }
  U32 slots() const { return w.bodies.count; }

  // Runs of bodies alike hold a range of ids each: found by bisection, or in a table if many ask.
  const AlikeBodies* run_of(U32 id) const {
    if (id >= ids()) return nullptr;
    if (!run_of_id.empty()) return &w.bodies.roster[run_of_id[id]];
    const auto at = std::upper_bound(first_of_run.begin(), first_of_run.end(), id);
    return &w.bodies.roster[static_cast<std::size_t>(at - first_of_run.begin()) - 1];
  }
  void many_ask(std::size_t how_many) {
    if (!run_of_id.empty() || how_many < ids() / 8 || first_of_run.size() < 8) return;
    run_of_id.resize(ids());
    for (std::size_t k = 0; k < first_of_run.size(); ++k) {
      std::fill_n(run_of_id.begin() + first_of_run[k], w.bodies.roster[k].count, static_cast<U32>(k));
    }
  }
  Place place_of(U32 id) const {
    const AlikeBodies* run = run_of(id);
    return run != nullptr ? run->place : Place::none;
  }
  const Surface& surface_of(U32 id) const { return w.bodies.surfaces[run_of(id)->surface]; }
  const Make& make_of(U32 id) const { return w.bodies.makes[surface_of(id).make]; }
  bool is_shape(U32 shape) const { return shape < w.shapes.count_ || (shape >= kWallLeft && shape <= kWallTop); }
  const StaticShape& shape(U32 number) const { return (as_before ? now : w).shapes.shapes_[number]; }
  // Whether bodies lie as contacts were laid out by.
  bool stands() const { return !w.ahead.sorted && w.saved.origin.empty(); }
  bool is_body(U32 id) const { return place_of(id) != Place::none; }

  // Free entries of a table: those without a user, each once.
  template <class IsFree>
  void free_list(const std::vector<U32>& list, std::size_t entries, std::size_t begin, const IsFree& is_free) {
    std::size_t all = 0;
    for (std::size_t k = begin; k < entries; ++k) all += is_free(k) ? 1 : 0;
    std::vector<U32> sorted(list);
    std::sort(sorted.begin(), sorted.end());
    require(sorted.size() == all && std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end());
    require(std::all_of(sorted.begin(), sorted.end(), [&](U32 k) { return k >= begin && k < entries && is_free(k); }));
  }
  // Bodies of a list stand where the list says.
  template <class List, class IdOf>
  void listed(Place place, const List& list, const IdOf& id_of) {
    U32 id = 0;
    for (const AlikeBodies& run : w.bodies.roster) {
      if (run.place == place) {
        require(run.slot < list.size() && run.count <= list.size() - run.slot);
        for (U32 k = 0; k < run.count && ok(); ++k) require(id_of(list[run.slot + k]) == id + k);
      }
      id += run.count;
    }
  }

  void all() {
    const auto each = [&](auto... part) { ((ok() ? (this->*part)() : void()), ...); };
    each(&Check::settings, &Check::tables, &Check::roster, &Check::unpack, &Check::columns, &Check::others, &Check::traits,
         &Check::shapes, &Check::broad, &Check::pairs, &Check::manifolds, &Check::joints, &Check::sleepers,
         &Check::events);
  }
  void settings();
  void unpack() { as_before = Image::unpack(a, w, now, same_roster); }
  // Who is there.
  void tables();
  void hull(const Hull& h) {
    require(h.count >= 1 && h.count <= Hull::kMost && h.radius >= 0 && h.reach >= 0 && h.inner >= 0);
  }
  void roster();
  void columns();
  void others();
  void traits();
  // Fixed geometry, and lists.
  void shapes();
  void broad();
  void grid();
  void axes();
  void cells();
  void pairs();
  void names();
  // Contacts of shapes.
  void manifolds();
  void fixed_side(const PairName& pair);
  void strip(std::size_t index, bool spread);
  // Joints.
  void joints();
  void joint(std::size_t k, std::size_t& alive);
  void chains(std::size_t alive);
  void sleepers();
  void events();
};

}  // namespace psim
