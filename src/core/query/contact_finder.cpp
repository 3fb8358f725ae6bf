// Finds the contacts that World::contacts tells:
//
//   find_listed   by strip: the closed contacts of the lists, as references of 20 bytes
//   find_kept     by sleepers: contacts among bodies that lie still, from what they carried when they fell asleep
//   sort          the references by ids
//   write         where the bodies are now: normal, point, separation
//   order         several contacts of one pair, by place

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "base/sort_keys.h"
#include "query/contact_list.h"
#include "query/contact_writer.h"

namespace psim {
namespace {

using kernels::kBlock;
using Ref = ContactList::Ref;
using Meeting = ContactWriter::Meeting;

constexpr std::size_t kSleepers = 1024;  // a job
constexpr std::size_t kWritten = 4096;   // contacts a job

bool closed(float impulse) { return !std::signbit(impulse); }
double d(float v) { return static_cast<double>(v); }

bool by_ids(const Ref& x, const Ref& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; }

bool by_place(const Contact& x, const Contact& y) {
  const auto members = [](const Contact& c) {
    return std::tie(c.normal.x, c.normal.y, c.point.x, c.point.y, c.separation, c.impulse, c.friction, c.strip,
                    c.colour);
  };
  return members(x) < members(y);
}

// The colours of a strip's contacts, numbered through: pairs of discs, the four runs of manifolds, discs and fixed
// shapes.
class StripColours {
 public:
  StripColours(const Observed& world, const LastStep& last, std::size_t index)
      : known_(!last.begun), laid_(!world.contacts.bare), contacts_(world.contacts.discs) {
    if (!known_) return;
    const Manifolds& manifolds = world.contacts.manifolds;
    std::uint32_t next = laid_ ? world.table.strips[index].colours : 0;
    std::array<std::uint32_t, 4> used{};
    if (last.with_manifolds && index < manifolds.strip_count()) {
      for (const ManifoldPair& pair : manifolds.pairs_of(index)) {
        if (pair.lane == PairName::kNone || pair.colour == ManifoldPair::kAlone) continue;
        std::uint32_t& most = used[pair.colour / ManifoldPair::kColours];
        most = std::max(most, pair.colour % ManifoldPair::kColours + 1);
      }
    }
    for (std::size_t run = 0; run < used.size(); next += used[run++]) manifolds_[run] = next;
    statics_ = next;
  }
  std::uint16_t of_pair(std::uint32_t pair) const {
    if (!known_ || !laid_) return Ref::kNone;
    const std::uint32_t c = contacts_.colour_of_pair(pair);
    return c < ContactStore::kMostColours ? static_cast<std::uint16_t>(c) : Ref::kNone;
  }
  std::uint16_t of_manifold(const ManifoldPair& pair) const {
    if (!known_ || pair.colour == ManifoldPair::kAlone) return Ref::kNone;
    return static_cast<std::uint16_t>(manifolds_[pair.colour / ManifoldPair::kColours] +
                                      pair.colour % ManifoldPair::kColours);
  }
  std::uint16_t of_static(const Strip& strip, const StaticPair& static_pair, std::uint32_t sequence) const {
    if (!known_ || !laid_) return Ref::kNone;
    const std::uint32_t c = ContactStore::colour_of_static(strip, static_pair, sequence);
    return c < ContactStore::kMostColours ? static_cast<std::uint16_t>(statics_ + c) : Ref::kNone;
  }

 private:
  bool known_, laid_;
  const ContactStore& contacts_;
  std::array<std::uint32_t, 4> manifolds_{};
  std::uint32_t statics_ = 0;
};

class ContactFinder {
 public:
  ContactFinder(const Observed& world, const LastStep& last, ContactList& list)
      : world_(world), last_(last), list_(list), writer_(world) {}

  /// The contacts, in order.
  std::span<const Contact> find() {
    list_.found.resize(std::max(list_.found.size(), table_.strips.size()));
    for (std::vector<Ref>& strip : list_.found) strip.clear();
    if (world_.contacts.impulses_valid && bodies_.count != 0 && table_.body_count != 0) find_listed();
    list_.kept.clear();
    if (!world_.sleep.sleepers.empty() || !world_.sleep.sleepers.recent.empty()) {
      bodies_.find_slots();
      find_kept();
    }
    sort();
    write();
    return order();
  }

 private:
  std::uint32_t id_of(std::uint32_t slot) const {
    slot = list_.slot(slot);
    return slot == kNoSlot ? kNoSlot : bodies_.id[slot];
  }

  bool is_dynamic(std::uint32_t id) const { return bodies_.properties(id).type == BodyType::dynamic_body; }

  bool counts(float impulse) const { return last_.begun ? impulse > 0 : closed(impulse); }

  void put(std::size_t strip, std::uint32_t a, std::uint32_t b, Ref::Kind kind, std::size_t at, std::uint16_t colour,
           int point = 0) {
    list_.found[strip].push_back({std::min(a, b), std::max(a, b), static_cast<std::uint32_t>(at),
                                  static_cast<std::uint32_t>(strip), kind, static_cast<std::uint8_t>(point), colour});
  }

  // Closed contacts of the lists of the last step, by strip. If manifolds are not ordered by strip, because they are of
  // the next step, all of them count for the first.
  void find_listed() {
    const std::vector<ManifoldPair>& all = manifolds_.pairs();
    const bool by_strip = !last_.begun && last_.with_manifolds && manifolds_.by_strip();
    world_.pool.run(table_.strips.size(), [&](std::size_t index) {
      const StripColours colours(world_, last_, index);
      find_pairs(index, colours);
      find_statics(index, colours);
      if (!by_strip || index >= manifolds_.strip_count()) return;
      const std::span<const ManifoldPair> mine = manifolds_.pairs_of(index);
      const auto first = static_cast<std::size_t>(mine.data() - all.data());
      for (std::size_t k = 0; k < mine.size(); ++k) find_manifold(index, colours, first + k);
    });
    if (by_strip || !last_.with_manifolds) return;
    const StripColours unknown(world_, last_, 0);
    for (std::size_t k = 0; k < all.size(); ++k) find_manifold(0, unknown, k);
  }

  void find_pairs(std::size_t index, const StripColours& colours) {
    const Strip& s = table_.strips[index];
    for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) {
      if (!counts(contacts_.pairs.impulse[table_.contact[p]])) continue;
      const std::uint32_t a = id_of(table_.owner[p]), b = id_of(table_.other[p]);
      if (a == kNoSlot || b == kNoSlot || (any_kinematic_ && !is_dynamic(a) && !is_dynamic(b))) continue;
      put(index, a, b, Ref::kPair, p, colours.of_pair(p));
    }
  }

  void find_statics(std::size_t index, const StripColours& colours) {
    const bool gaps = !last_.begun && !world_.contacts.bare;
    const std::vector<StaticPair>& pairs = table_.static_contacts[index];
    std::uint32_t last = kNoSlot, sequence = 0;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const StaticPair& pair = pairs[k];
      sequence = pair.body == last ? sequence + 1 : 0;
      last = pair.body;
      if (!counts(contacts_.fixed.impulse[pair.contact])) continue;
      if (gaps && contacts_.fixed.gap[pair.contact] >= kNoGap) continue;
      const std::uint32_t id = id_of(pair.body);
      if (id == kNoSlot || (any_kinematic_ && !is_dynamic(id)) || !writer_.stands(pair.shape)) continue;
      put(index, id, writer_.owner(pair.shape), Ref::kStatic, k,
          colours.of_static(table_.strips[index], pair, sequence));
    }
  }

  void find_manifold(std::size_t strip, const StripColours& colours, std::size_t at) {
    const ManifoldPair& pair = manifolds_.pairs()[at];
    if (last_.begun ? pair.moved : pair.lane == PairName::kNone) return;
    if (id_of(pair.b) != pair.id_b || (pair.a != kNoSlot && id_of(pair.a) != pair.id_a)) return;
    if (pair.a == kNoSlot && !writer_.stands(pair.shape)) return;
    for (int point = 0; point < pair.manifold.count; ++point) {
      if (last_.begun || !manifolds_.lies(strip, pair) ? pair.impulse[point] > 0
                                                       : manifold_closed(strip, pair, point)) {
        put(strip, pair.id_a, pair.id_b, Ref::kManifold, at, colours.of_manifold(pair), point);
      }
    }
  }

  bool manifold_closed(std::size_t strip, const ManifoldPair& pair, int point) const {
    const kernels::ManifoldBlock& c = manifolds_.strip(strip).blocks[pair.lane / kBlock];
    return closed(c.point[point].impulse[pair.lane % kBlock]);
  }

  // A body that sleeps, or a kinematic one.
  bool lies_still(std::uint32_t id) const {
    if (id >= bodies_.id_count) return false;
    const Place place = bodies_.info[id].place;
    return place == Place::asleep || (place == Place::moving && !(bodies_.properties(id).inv_mass > 0));
  }

  bool is_ground(std::uint32_t shape) const {
    const StaticShapes& statics = world_.statics;
    return shape >= kWallLeft || (shape < statics.size() && statics[shape].alive && !statics[shape].asleep);
  }

  // Contacts among bodies that lie still, and of bodies that fell asleep or woke since the lists were made.
  void find_kept() {
    const std::size_t sleepers = world_.sleep.sleepers.list.size(), jobs = (sleepers + kSleepers - 1) / kSleepers;
    list_.by_sleepers.resize(jobs + 1);
    world_.pool.run(jobs, [&](std::size_t job) {
      std::vector<Contact>& out = list_.by_sleepers[job];
      out.clear();
      for (std::size_t k = job * kSleepers; k < std::min(sleepers, (job + 1) * kSleepers); ++k) keep_of_sleeper(k, out);
    });
    list_.by_sleepers[jobs].clear();
    keep_recent(list_.by_sleepers[jobs]);
    for (const std::vector<Contact>& some : list_.by_sleepers) {
      list_.kept.insert(list_.kept.end(), some.begin(), some.end());
    }
  }

  // Of two sleepers that touch, the one with the lower id tells.
  void keep_of_sleeper(std::size_t k, std::vector<Contact>& out) const {
    const Sleepers& sleepers = world_.sleep.sleepers;
    const double times = world_.desc.substeps;
    const auto touches_of = [&](const Sleeper& s) {
      return std::span(sleepers.touches).subspan(s.first_touch, s.touches);
    };
    const std::uint32_t id = sleepers.list[k].id;
    for (const Touch& touch : touches_of(sleepers.list[k])) {
      if (touch.of_fixed()) {
        if (is_ground(touch.second())) writer_.keep_fixed(touch, id, touch.second(), times, out);
        continue;
      }
      const std::uint32_t a = touch.first(), b = touch.second(), other = a == id ? b : a;
      if (!lies_still(other)) continue;  // the lists have the contact
      if (bodies_.info[other].place == Place::asleep && other < id) {
        const auto theirs = touches_of(sleepers.list[bodies_.info[other].slot]);
        if (std::any_of(theirs.begin(), theirs.end(), [&](const Touch& t) { return t.key == touch.key; })) continue;
      }
      writer_.keep_pair(touch, a, b, times, out);
    }
  }

  void keep_recent(std::vector<Contact>& out) const {
    const double times = world_.desc.substeps;
    const auto place = [&](std::uint32_t id) { return id < bodies_.id_count ? bodies_.info[id].place : Place::none; };
    const auto here = [&](std::uint32_t id) { return place(id) == Place::asleep || place(id) == Place::moving; };
    for (const Touch& touch : world_.sleep.sleepers.recent.all()) {
      const std::uint32_t a = touch.first(), b = touch.second();
      if (touch.of_fixed()) {
        if (place(a) == Place::moving && is_ground(b)) writer_.keep_fixed(touch, a, b, times, out);
      } else if (here(a) && here(b) && !(lies_still(a) && lies_still(b))) {
        writer_.keep_pair(touch, a, b, times, out);
      }
    }
  }

  void sort() {
    list_.refs.clear();
    for (const std::vector<Ref>& strip : list_.found) list_.refs.insert(list_.refs.end(), strip.begin(), strip.end());
    for (std::size_t k = 0; k < list_.kept.size(); ++k) {
      const Contact& kept = list_.kept[k];
      list_.refs.push_back({kept.a.index, kept.b.index, static_cast<std::uint32_t>(k), 0, Ref::kKept, 0, Ref::kNone});
    }
    sort_by_first(
        list_.refs, list_.sorted, list_.count, bodies_.id_count, [](const Ref& ref) { return ref.a; }, by_ids);
  }

  void write() {
    list_.out.resize(list_.refs.size());
    world_.pool.run((list_.refs.size() + kWritten - 1) / kWritten, [&](std::size_t job) {
      for (std::size_t n = job * kWritten; n < std::min(list_.refs.size(), (job + 1) * kWritten); ++n) {
        const Ref& ref = list_.refs[n];
        Contact& out = list_.out[n];
        switch (ref.kind) {
          case Ref::kPair:
            out = write_pair(ref);
            break;
          case Ref::kStatic:
            out = write_static(ref);
            break;
          case Ref::kManifold:
            out = write_manifold(ref);
            break;
          case Ref::kKept:
            out = list_.kept[ref.at];
        }
        out.impulse += 0.0;  // -0 becomes 0
        if (ref.kind == Ref::kKept || last_.begun) continue;
        out.strip = ref.strip;
        if (ref.colour != Ref::kNone) out.colour = ref.colour;
      }
    });
  }

  // Contacts that came from a saved state have no normals yet.
  Contact write_pair(const Ref& ref) const {
    const double pressed = last_.substeps * last_.disc_mass;
    const bool rough = contacts_.rough(), normals = !contacts_.pairs.nx.empty();
    const std::uint32_t lane = table_.contact[ref.at];
    std::uint32_t i = list_.slot(table_.owner[ref.at]), j = list_.slot(table_.other[ref.at]);
    const double sign = bodies_.id[i] == ref.a ? 1 : -1;
    if (sign < 0) std::swap(i, j);
    const LatticePoint at = world_.place(i);
    const double r = d(bodies_.radius[i]);
    const Meeting m = ContactWriter::discs(writer_.way(at, world_.place(j)), r + d(bodies_.radius[j]),
                                           normals ? sign * d(contacts_.pairs.nx[lane]) : 0,
                                           normals ? sign * d(contacts_.pairs.ny[lane]) : sign);
    return writer_.of_disc(ref.a, ref.b, at, r, 1, m, pressed, contacts_.pairs.impulse[lane],
                           rough ? contacts_.pairs.friction[lane] : 0);
  }

  Contact write_static(const Ref& ref) const {
    const double pressed = last_.substeps * last_.disc_mass;
    const StaticPair& pair = table_.static_contacts[ref.strip][ref.at];
    const std::uint32_t lane = pair.contact, slot = list_.slot(pair.body);
    const LatticePoint at = world_.place(slot);
    const double r = d(bodies_.radius[slot]);
    const Meeting m = writer_.fixed(at, r, pair.shape, d(contacts_.fixed.nx[lane]), d(contacts_.fixed.ny[lane]));
    return writer_.of_disc(writer_.owner(pair.shape), bodies_.id[slot], at, r, -1, m, pressed,
                           contacts_.fixed.impulse[lane], contacts_.rough() ? contacts_.fixed.friction[lane] : 0);
  }

  Contact write_manifold(const Ref& ref) const {
    const ManifoldPair& pair = manifolds_.pairs()[ref.at];
    float impulse = pair.impulse[ref.point], friction = pair.friction[ref.point];
    if (!last_.begun && manifolds_.lies(ref.strip, pair)) {
      const kernels::ManifoldBlock& c = manifolds_.strip(ref.strip).blocks[pair.lane / kBlock];
      impulse = c.point[ref.point].impulse[pair.lane % kBlock];
      friction = c.point[ref.point].friction[pair.lane % kBlock];
    }
    Vec2 point;
    const Meeting m = writer_.manifold(pair, list_.slot(pair.a), list_.slot(pair.b), ref.point, point);
    return writer_.contact(pair.id_a, pair.id_b, point, m, last_.substeps * d(impulse), last_.substeps * d(friction));
  }

  // Where the lists and the sleepers both have contacts of a pair, those of the lists count.
  std::span<const Contact> order() {
    const std::vector<Ref>& refs = list_.refs;
    std::size_t end = 0;
    for (std::size_t begin = 0; begin < refs.size();) {
      std::size_t next = begin + 1;
      bool listed = refs[begin].kind != Ref::kKept;
      for (; next < refs.size() && refs[next].a == refs[begin].a && refs[next].b == refs[begin].b; ++next) {
        listed = listed || refs[next].kind != Ref::kKept;
      }
      const std::size_t first = end;
      for (std::size_t n = begin; n < next; ++n) {
        if (listed && refs[n].kind == Ref::kKept) continue;
        if (end != n) list_.out[end] = list_.out[n];
        ++end;
      }
      if (end - first > 1) {
        const auto at = list_.out.begin();
        // Total order: all members that contacts of a pair can differ in.
        std::sort(at + static_cast<std::ptrdiff_t>(first), at + static_cast<std::ptrdiff_t>(end), by_place);
      }
      begin = next;
    }
    list_.out.resize(end);
    return list_.out;
  }

  const Observed& world_;
  const LastStep& last_;
  const BodyStore& bodies_ = world_.bodies;
  const ContactStore& contacts_ = world_.contacts.discs;
  const Manifolds& manifolds_ = world_.contacts.manifolds;
  const PairTable& table_ = world_.table;
  ContactList& list_;
  ContactWriter writer_;
  const bool any_kinematic_ = world_.any_kinematic();
};

}  // namespace

std::span<const Contact> find_contacts(const Observed& world, const LastStep& last, ContactList& list) {
  return ContactFinder(world, last, list).find();
}

}  // namespace psim
