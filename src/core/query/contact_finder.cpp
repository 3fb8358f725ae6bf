// Finds the contacts that World::contacts tells:
//
//   find_listed   by strip: the closed contacts of the lists
//   find_kept     by sleepers: contacts among bodies that lie still, from what they carried when they fell asleep
//   in_order      all of them by ids, several contacts of one pair by place

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "base/elementary.h"
#include "base/sort_keys.h"
#include "base/tasks.h"
#include "query/contact_list.h"
#include "query/contact_writer.h"

namespace psim {
namespace {

using kernels::kBlock;
using Ref = ContactList::Ref;

constexpr std::size_t kSleepers = 1024;  // a job
constexpr std::size_t kSorted = 4096;    // contacts a job

bool by_place(const Contact& x, const Contact& y) {
  const auto members = [](const Contact& c) {
    return std::tie(c.normal.x, c.normal.y, c.point.x, c.point.y, c.separation, c.impulse, c.friction, c.strip,
                    c.colour, c.part_a, c.part_b);
  };
  return members(x) < members(y);
}

template <class T>
bool same_pair(const T& x, const T& y) {
  return x.a == y.a && x.b == y.b;
}

// The colours of a strip's contacts, numbered through: pairs of discs, the four runs of manifolds, discs and fixed
// shapes. None is known while the work for the next step is under way.
class StripColours {
 public:
  StripColours(const Observed& world, const LastStep& last, std::size_t index)
      : laid_(!last.begun && !world.contacts.bare), contacts_(world.contacts.discs) {
    const Manifolds& manifolds = world.contacts.manifolds;
    std::uint32_t next = laid_ ? world.table.strips[index].colours : 0;
    std::array<std::uint32_t, 4> used{};
    if (!last.begun && last.with_manifolds && index < manifolds.strip_count()) {
      for (const ManifoldPair& pair : manifolds.pairs_of(index)) {
        if (pair.lane == PairName::kNone || pair.colour == ManifoldPair::kAlone) continue;
        std::uint32_t& most = used[pair.colour / ManifoldPair::kColours];
        most = std::max(most, pair.colour % ManifoldPair::kColours + 1);
      }
    }
    for (std::size_t run = 0; run < used.size(); next += used[run++]) manifolds_[run] = next;
    statics_ = next;
  }
  std::uint32_t of_pair(std::uint32_t pair) const {
    return laid_ ? numbered(contacts_.colour_of_pair(pair), 0) : kNoColour;
  }
  std::uint32_t of_static(const Strip& strip, const StaticPair& pair, std::uint32_t sequence) const {
    return laid_ ? numbered(ContactStore::colour_of_static(strip, pair, sequence), statics_) : kNoColour;
  }
  std::uint32_t of_manifold(const ManifoldPair& pair) const {
    if (pair.colour == ManifoldPair::kAlone) return kNoColour;
    return manifolds_[pair.colour / ManifoldPair::kColours] + pair.colour % ManifoldPair::kColours;
  }

 private:
  static std::uint32_t numbered(std::uint32_t colour, std::uint32_t first) {
    return colour < ContactClass::kColours ? first + colour : kNoColour;
  }

  const bool laid_;
  const ContactStore& contacts_;
  std::array<std::uint32_t, 4> manifolds_{};
  std::uint32_t statics_ = 0;
};

class ContactFinder {
 public:
  ContactFinder(const Observed& world, const LastStep& last, ContactList& list, const std::vector<std::uint8_t>* only)
      : world_(world), last_(last), list_(list), only_(only) {}

  /// The contacts, in order.
  std::span<const Contact> find() {
    gather();
    return in_order();
  }

  /// m: the deepest overlap, or 0.
  double deepest() {
    overlaps_ = true;
    bodies_.find_slots();
    gather();
    double most = 0;
    for (const std::vector<Contact>& some : list_.found) {
      for (const Contact& c : some) most = greater(-c.separation, most);
    }
    return most;
  }

 private:
  void gather() {
    const std::size_t jobs = only_ != nullptr ? 0 : jobs_for(sleepers_.list.size(), kSleepers);
    list_.found.resize(std::max(list_.found.size(), strips_ + jobs + 1));
    for (std::vector<Contact>& some : list_.found) some.clear();
    world_.pool.run(strips_, [&](std::size_t strip) { find_listed(strip); });
    if (only_ == nullptr && (jobs != 0 || !sleepers_.recent.empty())) {
      bodies_.find_slots();
      run_each(sleepers_.list.size(), kSleepers, world_.pool,
               [&](std::size_t k, std::size_t job) { find_kept(sleepers_.list[k], list_.found[strips_ + job]); });
      find_recent(list_.found[strips_ + jobs]);
    }
  }

  std::uint32_t id_at(std::uint32_t slot) const { return slot == kNoSlot ? kNoSlot : bodies_.id[slot]; }
  std::uint32_t id_of(std::uint32_t slot_of_lists) const { return id_at(list_.slot(slot_of_lists)); }

  ContactWriter::Load load_of(const ContactLanes& c, std::uint32_t lane) const {
    return {times_, c.impulse[lane], rough_ ? c.friction[lane] : 0};
  }
  // Walls always.
  bool wanted(std::uint32_t id) const { return only_ == nullptr || id == kNoSlot || (*only_)[id] != 0; }
  bool counts(float impulse) const { return last_.begun ? impulse > 0 : closed(impulse); }

  void put(std::size_t strip, Contact contact, std::uint32_t colour) {
    if (overlaps_ && contact.separation >= 0) return;
    if (!last_.begun) {
      contact.strip = static_cast<std::uint32_t>(strip);
      contact.colour = colour;
    }
    list_.found[strip].push_back(contact);
  }

  // Closed contacts of the last step that the lists of a strip have.
  void find_listed(std::size_t strip) {
    const StripColours colours(world_, last_, strip);
    find_pairs(strip, colours);
    find_statics(strip, colours);
    for (const ManifoldPair& pair : manifolds_of(strip)) find_manifold(strip, colours, pair);
  }

  void find_pairs(std::size_t strip, const StripColours& colours) {
    const Strip& s = table_.strips[strip];
    for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) {
      const std::uint32_t lane = table_.contact[p];
      if (!overlaps_ && !counts(contacts_.pairs.impulse[lane])) continue;
      std::uint32_t i = list_.slot(table_.owner[p]), j = list_.slot(table_.other[p]);
      if (id_at(i) == kNoSlot || id_at(j) == kNoSlot || !world_.tells_of(id_at(i), id_at(j))) continue;
      if (!wanted(id_at(i)) || !wanted(id_at(j))) continue;
      Vec2 normal{0, 1};  // contacts that came from a saved state have no normals yet
      if (!contacts_.pairs.nx.empty()) normal = {wide(contacts_.pairs.nx[lane]), wide(contacts_.pairs.ny[lane])};
      if (bodies_.id[i] > bodies_.id[j]) {
        std::swap(i, j);
        normal = -1 * normal;
      }
      const LatticePoint at = bodies_.point(i);
      const double r = wide(bodies_.radius[i]);
      const Vec2 way = world_.lattice.way(at, bodies_.point(j));
      const ContactWriter::Meeting m = ContactWriter::discs(way, r + wide(bodies_.radius[j]), normal);
      put(strip, writer_.of_disc({bodies_.id[i]}, {bodies_.id[j]}, at, r, m, load_of(contacts_.pairs, lane)),
          colours.of_pair(p));
    }
  }

  void find_statics(std::size_t strip, const StripColours& colours) {
    const bool gaps = !last_.begun && !world_.contacts.bare;
    std::uint32_t last = kNoSlot, sequence = 0;
    for (const StaticPair& pair : table_.static_contacts[strip]) {
      sequence = pair.body == last ? sequence + 1 : 0;
      last = pair.body;
      const std::uint32_t lane = pair.contact, slot = list_.slot(pair.body), id = id_at(slot);
      if (gaps && contacts_.fixed.gap[lane] >= kNoGap) continue;
      if (!(gaps && overlaps_) && !counts(contacts_.fixed.impulse[lane])) continue;
      if (id == kNoSlot || !world_.tells_of(id) || !writer_.stands(pair.shape)) continue;
      if (!wanted(id) || !wanted(writer_.side(pair.shape).id)) continue;
      const LatticePoint at = bodies_.point(slot);
      const double r = wide(bodies_.radius[slot]);
      const Vec2 normal{wide(contacts_.fixed.nx[lane]), wide(contacts_.fixed.ny[lane])};
      const ContactWriter::Meeting m = writer_.fixed(at, r, pair.shape, normal);
      put(strip, writer_.of_disc(writer_.side(pair.shape), {id}, at, -r, m, load_of(contacts_.fixed, lane)),
          colours.of_static(table_.strips[strip], pair, sequence));
    }
  }

  // If manifolds are not ordered by strip, because they are of the next step, all of them count for the first.
  std::span<const ManifoldPair> manifolds_of(std::size_t strip) const {
    const bool by_strip = !last_.begun && manifolds_.by_strip();
    if (!last_.with_manifolds || strip >= (by_strip ? manifolds_.strip_count() : 1)) return {};
    return by_strip ? manifolds_.pairs_of(strip) : manifolds_.pairs();
  }

  // Overlaps are those of the hulls as they stand now: the normal of a manifold is that of the start of the step, and
  // hulls may overlap by another one since, or another pair of them.
  void find_manifold(std::size_t strip, const StripColours& colours, const ManifoldPair& pair) {
    if (last_.begun ? pair.moved : pair.lane == PairName::kNone && !overlaps_) return;
    if (id_of(pair.b) != pair.id_b || (pair.a != kNoSlot && id_of(pair.a) != pair.id_a)) return;
    if (pair.a == kNoSlot && !writer_.stands(pair.shape)) return;
    if (!wanted(pair.id_a) || !wanted(pair.id_b)) return;
    if (overlaps_) {
      Contact overlap;
      overlap.separation = writer_.distance(pair);
      return put(strip, overlap, kNoColour);
    }
    const bool laid = !last_.begun && manifolds_.lies(strip, pair);
    for (int k = 0; k < pair.manifold.count; ++k) {
      float impulse = pair.impulse[k], friction = pair.friction[k];
      if (laid) {
        const auto& point = manifolds_.strip(strip).blocks[pair.lane / kBlock].point[k];
        impulse = point.impulse[pair.lane % kBlock];
        friction = point.friction[pair.lane % kBlock];
      }
      if (laid ? !closed(impulse) : !(impulse > 0)) continue;
      Vec2 point;
      const ContactWriter::Meeting m = writer_.manifold(pair, list_.slot(pair.a), list_.slot(pair.b), k, point);
      const ContactWriter::Load load{static_cast<double>(last_.substeps), impulse, friction};
      put(strip, writer_.contact(writer_.first_of(pair), writer_.second_of(pair), point, m, load),
          colours.of_manifold(pair));
    }
  }

  // A body that sleeps, or a kinematic one.
  bool lies_still(std::uint32_t id) const {
    const Place place = place_of(id);
    return place == Place::asleep || (place == Place::moving && !(bodies_.properties(id).inv_mass > 0));
  }
  Place place_of(std::uint32_t id) const { return id < bodies_.id_count ? bodies_.info[id].place : Place::none; }

  bool is_ground(std::uint32_t shape) const {
    const StaticShapes& statics = world_.statics;
    return shape >= kWallLeft || (shape < statics.size() && statics[shape].alive && !statics[shape].asleep);
  }

  std::span<const Touch> touches_of(const Sleeper& s) const {
    return std::span(sleepers_.touches).subspan(s.first_touch, s.touches);
  }

  // Contacts of a sleeper with bodies that lie still.
  void find_kept(const Sleeper& sleeper, std::vector<Contact>& out) const {
    for (const Touch& touch : touches_of(sleeper)) {
      if (tells(sleeper.id, touch)) writer_.keep(touch, out);
    }
  }

  // Of two sleepers that touch, the one with the lower id tells. The lists have the contacts with bodies that move.
  bool tells(std::uint32_t sleeper, const Touch& touch) const {
    if (touch.of_fixed()) return is_ground(touch.second());
    const std::uint32_t other = touch.first() == sleeper ? touch.second() : touch.first();
    if (!lies_still(other)) return false;
    if (other > sleeper || place_of(other) != Place::asleep) return true;
    const std::span<const Touch> theirs = touches_of(sleepers_.list[bodies_.info[other].slot]);
    return std::none_of(theirs.begin(), theirs.end(), [&](const Touch& t) { return t.same(touch); });
  }

  // Contacts of bodies that fell asleep or woke since the lists were made.
  void find_recent(std::vector<Contact>& out) const {
    const auto here = [&](std::uint32_t id) { return place_of(id) == Place::asleep || place_of(id) == Place::moving; };
    for (const Touch& touch : sleepers_.recent.all()) {
      const std::uint32_t a = touch.first(), b = touch.second();
      if (touch.of_fixed() ? place_of(a) == Place::moving && is_ground(b)
                           : here(a) && here(b) && !(lies_still(a) && lies_still(b))) {
        writer_.keep(touch, out);
      }
    }
  }

  std::span<const Contact> in_order() {
    sort_refs();
    std::vector<Contact>& out = list_.out;
    out.resize(list_.refs.size());
    run_each(out.size(), kSorted, world_.pool,
             [&](std::size_t n, std::size_t) { out[n] = list_.found[list_.refs[n].list][list_.refs[n].at]; });
    for (auto first = out.begin(); first != out.end();) {
      const auto last = std::find_if(first, out.end(), [&](const Contact& c) { return !same_pair(c, *first); });
      // Total order: all members that contacts of a pair can differ in.
      if (last - first > 1) std::sort(first, last, by_place);
      first = last;
    }
    return out;
  }

  // Where the lists and the sleepers both have contacts of a pair, those of the lists count.
  void sort_refs() {
    std::vector<Ref>& refs = list_.refs;
    refs.clear();
    for (std::uint32_t list = 0; list < list_.found.size(); ++list) {
      std::uint32_t at = 0;
      for (const Contact& c : list_.found[list]) refs.push_back({c.a.index, c.b.index, list, at++});
    }
    sort_by_first(
        refs, list_.sorted, list_.count, bodies_.id_count, [](const Ref& ref) { return ref.a; },
        [](const Ref& x, const Ref& y) { return std::tie(x.a, x.b) < std::tie(y.a, y.b); });
    std::size_t end = 0;
    for (const Ref& ref : refs) {  // of a pair, the contacts of the lists come first
      const bool told = end != 0 && same_pair(refs[end - 1], ref) && refs[end - 1].list < strips_;
      if (!told || ref.list < strips_) refs[end++] = ref;
    }
    refs.resize(end);
  }

  const Observed& world_;
  const LastStep& last_;
  const BodyStore& bodies_ = world_.bodies;
  const ContactStore& contacts_ = world_.contacts.discs;
  const Manifolds& manifolds_ = world_.contacts.manifolds;
  const PairTable& table_ = world_.table;
  const Sleepers& sleepers_ = world_.sleep.sleepers;
  ContactList& list_;
  const std::vector<std::uint8_t>* const only_;
  bool overlaps_ = false;  // only overlaps are wanted, whether the solver pressed there or not
  const ContactWriter writer_{world_};
  const bool rough_ = contacts_.model().rough();
  const double times_ = last_.substeps * last_.disc_mass;  // turns the impulses of discs into N s
  const bool valid_ = world_.contacts.impulses_valid && bodies_.count != 0 && table_.body_count != 0;
  const std::size_t strips_ = valid_ ? table_.strips.size() : 0;  // that have contacts
};

}  // namespace

std::span<const Contact> find_contacts(const Observed& world, const LastStep& last, ContactList& list,
                                       const std::vector<std::uint8_t>* only) {
  return ContactFinder(world, last, list, only).find();
}

double deepest_contact(const Observed& world, const LastStep& last, ContactList& list) {
  return ContactFinder(world, last, list, nullptr).deepest();
}

}  // namespace psim
