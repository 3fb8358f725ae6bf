// World::contacts: who touched at the end of the last step, where, and how hard.
//
// In: the lists and what their contacts carry, what sleepers keep. Out: one Contact a point, by a, then b,
// then normal and point. Nothing runs and no memory is held unless it is called; changes no result.
//
//   find    by strip: closed contacts as references of 20 bytes
//   keep    by sleepers: contacts among those that lie still, from what they carried when they fell asleep
//   sort    references by ids
//   write   where the bodies are now: normal, point, separation
//
// O(contacts); docs/queries-events.md has what it takes.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "contact_writer.h"
#include "float_settings.h"
#include "tasks.h"
#include "world_impl.h"

namespace psim {
namespace {

using kernels::kBlock;
using Ref = ContactList::Ref;
using Meeting = ContactWriter::Meeting;

constexpr float kFar = 1e6f;     // m: gap of a contact that another one stands for (narrow_phase)
constexpr std::size_t kBeds = 1024;     // sleepers a job
constexpr std::size_t kWritten = 4096;  // contacts a job

bool closed(float impulse) { return !std::signbit(impulse); }
double d(float v) { return static_cast<double>(v); }

// By a, then b. Where there are many, by counting how many each a has.
void sort_refs(std::vector<Ref>& refs, std::vector<Ref>& scratch, std::vector<std::uint32_t>& count,
               std::uint32_t ids) {
  const auto before = [](const Ref& x, const Ref& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; };
  if (refs.size() < 256 || refs.size() < ids / 8) {
    std::stable_sort(refs.begin(), refs.end(), before);
    return;
  }
  count.assign(std::size_t{ids} + 1, 0);
  for (const Ref& ref : refs) ++count[std::size_t{ref.a} + 1];
  for (std::size_t k = 1; k < count.size(); ++k) count[k] += count[k - 1];
  scratch.resize(refs.size());
  for (const Ref& ref : refs) scratch[count[ref.a]++] = ref;
  refs.swap(scratch);
  for (std::size_t k = 1; k < refs.size(); ++k) {  // the few of each
    const Ref ref = refs[k];
    std::size_t at = k;
    for (; at > 0 && before(ref, refs[at - 1]); --at) refs[at] = refs[at - 1];
    refs[at] = ref;
  }
}

bool by_place(const Contact& x, const Contact& y) {
  if (x.normal.x != y.normal.x) return x.normal.x < y.normal.x;
  if (x.normal.y != y.normal.y) return x.normal.y < y.normal.y;
  return x.point.x != y.point.x ? x.point.x < y.point.x : x.point.y < y.point.y;
}

}  // namespace

// Colours of a strip's contacts, numbered through: pairs of discs, the four runs of manifolds, discs and fixed shapes.
class World::Impl::StripColours {
 public:
  StripColours(const Impl& w, std::size_t index) : known_(!w.touching.begun), laid_(!w.saved.bare), contacts_(w.contacts) {
    if (!known_) return;
    std::uint32_t next = laid_ ? w.table.strips[index].colours : 0;
    std::array<std::uint32_t, 4> used{};
    if (w.plan.shapes && index < w.manifolds.strip_count()) {
      for (const ManifoldPair& pair : std::as_const(w.manifolds).pairs_of(index)) {
        if (pair.lane == PairName::kNone || pair.colour == ManifoldPair::kAlone) continue;
        std::uint32_t& most = used[pair.colour / ManifoldPair::kColours];
        most = std::max(most, pair.colour % ManifoldPair::kColours + 1);
      }
    }
    for (std::size_t run = 0; run < used.size(); next += used[run++]) manifolds_[run] = next;
    singles_ = next;
  }
  std::uint16_t of_pair(std::uint32_t pair) const {
    if (!known_ || !laid_) return Ref::kNone;
    const std::uint32_t c = contacts_.colour_of_pair(pair);
    return c < ContactStore::kMostColours ? static_cast<std::uint16_t>(c) : Ref::kNone;
  }
  std::uint16_t of_manifold(const ManifoldPair& pair) const {
    if (!known_ || pair.colour == ManifoldPair::kAlone) return Ref::kNone;
    return static_cast<std::uint16_t>(manifolds_[pair.colour / ManifoldPair::kColours] + pair.colour % ManifoldPair::kColours);
  }
  std::uint16_t of_single(const Strip& strip, const SinglePair& single, std::uint32_t sequence) const {
    if (!known_ || !laid_) return Ref::kNone;
    const std::uint32_t c = ContactStore::colour_of_single(strip, single, sequence);
    return c < ContactStore::kMostColours ? static_cast<std::uint16_t>(singles_ + c) : Ref::kNone;
  }

 private:
  bool known_, laid_;
  const ContactStore& contacts_;
  std::array<std::uint32_t, 4> manifolds_{};
  std::uint32_t singles_ = 0;
};

// Closed contacts of the lists of the last step, by strip. While work for the next one is under way (begun), what
// is open and what overlaps without an impulse look alike, and bodies may lie in another order.
void World::Impl::find_contacts() {
  const ContactWriter writer(bodies, shapes, lattice, walls, sleepers);
  const bool begun = touching.begun;
  const bool gaps = !begun && !saved.bare;
  const auto dynamic = [&](std::uint32_t id) {
    return bodies.surface(id).type == BodyType::dynamic_body;
  };
  const auto counts = [begun](float impulse) { return begun ? impulse > 0 : closed(impulse); };
  const auto id_of = [&](std::uint32_t slot) {
    slot = touching.slot(slot);
    return slot == kNoSlot ? kNoSlot : bodies.id[slot];
  };
  const auto put = [&](std::size_t strip, std::uint32_t a, std::uint32_t b, Ref::Kind kind,
                       std::size_t at, std::uint16_t colour, int point = 0) {
    touching.found[strip].push_back({std::min(a, b), std::max(a, b), static_cast<std::uint32_t>(at),
                                     static_cast<std::uint32_t>(strip), kind,
                                     static_cast<std::uint8_t>(point), colour});
  };
  const std::vector<ManifoldPair>& all = std::as_const(manifolds).pairs();
  const bool by_strip = !begun && plan.shapes && manifolds.by_strip();
  const auto put_manifold = [&](std::size_t strip, const StripColours& colours, std::size_t at) {
    const ManifoldPair& pair = all[at];
    if (begun ? pair.moved : pair.lane == PairName::kNone) return;
    if (id_of(pair.b) != pair.id_b || (pair.a != kNoSlot && id_of(pair.a) != pair.id_a)) return;
    if (pair.a == kNoSlot && !writer.stands(pair.shape)) return;
    for (int point = 0; point < pair.manifold.count; ++point) {
      if (begun || !manifolds.lies(strip, pair) ? pair.impulse[point] > 0 : manifold_closed(strip, pair, point)) {
        put(strip, pair.id_a, pair.id_b, Ref::kManifold, at, colours.of_manifold(pair), point);
      }
    }
  };
  pool.run(table.strips.size(), [&](std::size_t index) {
    const Strip& s = table.strips[index];
    const StripColours colours(*this, index);
    for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) {
      if (!counts(contacts.impulse[table.contact[p]])) continue;
      const std::uint32_t a = id_of(table.owner[p]), b = id_of(table.other[p]);
      if (a == kNoSlot || b == kNoSlot || (!held.empty() && !dynamic(a) && !dynamic(b))) continue;
      put(index, a, b, Ref::kPair, p, colours.of_pair(p));
    }
    const std::vector<SinglePair>& singles = table.singles[index];
    std::uint32_t last = kNoSlot, sequence = 0;
    for (std::size_t k = 0; k < singles.size(); ++k) {
      const SinglePair& single = singles[k];
      sequence = single.body == last ? sequence + 1 : 0;
      last = single.body;
      if (!counts(contacts.s_impulse[single.contact])) continue;
      if (gaps && contacts.s_gap[single.contact] >= kFar) continue;
      const std::uint32_t id = id_of(single.body);
      if (id == kNoSlot || (!held.empty() && !dynamic(id)) || !writer.stands(single.shape)) {
        continue;
      }
      put(index, id, writer.owner(single.shape), Ref::kSingle, k, colours.of_single(s, single, sequence));
    }
    if (!by_strip || index >= manifolds.strip_count()) return;
    const std::span<const ManifoldPair> mine = std::as_const(manifolds).pairs_of(index);
    const auto first = static_cast<std::size_t>(mine.data() - all.data());
    for (std::size_t k = 0; k < mine.size(); ++k) put_manifold(index, colours, first + k);
  });
  if (by_strip || !plan.shapes) return;
  const StripColours unknown(*this, 0);
  for (std::size_t k = 0; k < all.size(); ++k) put_manifold(0, unknown, k);  // strips are of the next step
}

bool World::Impl::manifold_closed(std::size_t strip, const ManifoldPair& pair, int point) {
  const kernels::ManifoldBlock& c = manifolds.strip(strip).blocks[pair.lane / kBlock];
  return closed(c.point[point].impulse[pair.lane % kBlock]);
}

// Contacts among bodies that lie still, and of those that fell asleep or woke since the lists were made.
void World::Impl::find_kept() {
  const ContactWriter writer(bodies, shapes, lattice, walls, sleepers);
  const double times = desc.substeps;
  const auto place = [&](std::uint32_t id) {
    return id < bodies.id_count ? bodies.info[id].place : Place::none;
  };
  const auto lies = [&](std::uint32_t id) {
    return place(id) == Place::asleep ||
           (place(id) == Place::moving && !(bodies.surface(id).inv_mass > 0));
  };
  const auto here = [&](std::uint32_t id) {
    return place(id) == Place::asleep || place(id) == Place::moving;
  };
  const auto ground = [&](std::uint32_t shape) {
    return shape >= kWallLeft ||
           (shape < shapes.size() && shapes[shape].alive && !shapes[shape].asleep);
  };
  const auto touches_of = [&](const Sleeper& s) {
    return std::span(sleepers.touches).subspan(s.first_touch, s.touches);
  };
  const std::vector<Sleeper>& list = sleepers.list;
  const std::size_t jobs = (list.size() + kBeds - 1) / kBeds;
  touching.beds.resize(jobs + 1);
  pool.run(jobs, [&](std::size_t job) {
    std::vector<Contact>& out = touching.beds[job];
    out.clear();
    for (std::size_t k = job * kBeds; k < std::min(list.size(), (job + 1) * kBeds); ++k) {
      for (const Touch& touch : touches_of(list[k])) {
        if (touch.of_fixed()) {
          if (ground(touch.second()))
            writer.keep_fixed(touch, list[k].id, touch.second(), times, out);
          continue;
        }
        const std::uint32_t a = touch.first(), b = touch.second(), other = a == list[k].id ? b : a;
        if (!lies(other)) continue;                                 // the lists have it
        if (place(other) == Place::asleep && other < list[k].id) {  // it has the same touch
          const auto theirs = touches_of(list[bodies.info[other].slot]);
          if (std::any_of(theirs.begin(), theirs.end(),
                          [&](const Touch& t) { return t.key == touch.key; }))
            continue;
        }
        writer.keep_pair(touch, a, b, times, out);
      }
    }
  });
  std::vector<Contact>& out = touching.beds[jobs];
  out.clear();
  for (const Touch& touch : sleepers.recent.all()) {
    const std::uint32_t a = touch.first(), b = touch.second();
    if (touch.of_fixed()) {
      if (place(a) == Place::moving && ground(b)) writer.keep_fixed(touch, a, b, times, out);
    } else if (here(a) && here(b) && !(lies(a) && lies(b))) {
      writer.keep_pair(touch, a, b, times, out);
    }
  }
  touching.kept.clear();
  for (const std::vector<Contact>& bed : touching.beds)
    touching.kept.insert(touching.kept.end(), bed.begin(), bed.end());
}

// The contacts that were found, in order.
void World::Impl::write_contacts() {
  const ContactWriter writer(bodies, shapes, lattice, walls, sleepers);
  const bool plain = plan.model.model == kernels::Model::plain;
  const double pressed =
      substeps * (plain ? d(first_mass) : 1.0);  // where masses are alike lanes have them as 1
  const bool rough = contacts.rough();
  const bool normals = !contacts.nx.empty();  // restored contacts have none yet
  ContactList& t = touching;
  t.out.resize(t.refs.size());
  pool.run((t.refs.size() + kWritten - 1) / kWritten, [&](std::size_t job) {
    for (std::size_t n = job * kWritten; n < std::min(t.refs.size(), (job + 1) * kWritten); ++n) {
      const Ref& ref = t.refs[n];
      switch (ref.kind) {
        case Ref::kPair: {
          const std::uint32_t lane = table.contact[ref.at];
          std::uint32_t i = t.slot(table.owner[ref.at]), j = t.slot(table.other[ref.at]);
          const double sign = bodies.id[i] == ref.a ? 1 : -1;
          if (sign < 0) std::swap(i, j);
          const LatticePoint at = writer.place(i);
          const double r = d(bodies.radius[i]);
          const Meeting m =
              ContactWriter::discs(writer.way(at, writer.place(j)), r + d(bodies.radius[j]),
                                   normals ? sign * d(contacts.nx[lane]) : 0,
                                   normals ? sign * d(contacts.ny[lane]) : sign);
          const Vec2 centre = writer.world(at);
          const double arm = r + m.gap / 2;
          t.out[n] = writer.contact(ref.a, ref.b, {centre.x + arm * m.nx, centre.y + arm * m.ny}, m,
                                    pressed * d(contacts.impulse[lane]),
                                    rough ? pressed * d(contacts.friction[lane]) : 0);
          break;
        }
        case Ref::kSingle: {
          const SinglePair& single = table.singles[ref.strip][ref.at];
          const std::uint32_t lane = single.contact, slot = t.slot(single.body);
          const std::uint32_t id = bodies.id[slot];
          const LatticePoint at = writer.place(slot);
          const double r = d(bodies.radius[slot]);
          const Meeting m =
              writer.fixed(at, r, single.shape, d(contacts.s_nx[lane]), d(contacts.s_ny[lane]));
          const Vec2 centre = writer.world(at);
          const double arm = r + m.gap / 2;
          t.out[n] = writer.contact(writer.owner(single.shape), id,
                                    {centre.x - arm * m.nx, centre.y - arm * m.ny}, m,
                                    pressed * d(contacts.s_impulse[lane]),
                                    rough ? pressed * d(contacts.s_friction[lane]) : 0);
          break;
        }
        case Ref::kManifold: {
          const ManifoldPair& pair = std::as_const(manifolds).pairs()[ref.at];
          float impulse = pair.impulse[ref.point], friction = pair.friction[ref.point];
          if (!t.begun && manifolds.lies(ref.strip, pair)) {
            const kernels::ManifoldBlock& c = manifolds.strip(ref.strip).blocks[pair.lane / kBlock];
            impulse = c.point[ref.point].impulse[pair.lane % kBlock];
            friction = c.point[ref.point].friction[pair.lane % kBlock];
          }
          Vec2 point;
          const Meeting m =
              writer.manifold(pair, t.slot(pair.a), t.slot(pair.b), ref.point, point);
          t.out[n] = writer.contact(pair.id_a, pair.id_b, point, m, substeps * d(impulse),
                                    substeps * d(friction));
          break;
        }
        case Ref::kKept:
          t.out[n] = t.kept[ref.at];
      }
      t.out[n].impulse += 0.0;  // not -0
      if (ref.kind == Ref::kKept || t.begun) continue;
      t.out[n].strip = ref.strip;
      if (ref.colour != Ref::kNone) t.out[n].colour = ref.colour;
    }
  });
}

// Where bodies lie now that lay in a slot when contacts were laid out.
void World::Impl::find_moved() {
  std::vector<std::uint32_t> origin;
  broad.copy_origin(origin);
  touching.now.assign(std::max<std::size_t>(bodies.count, origin.size()), kNoSlot);
  for (std::size_t i = 0; i < origin.size(); ++i) {
    if (origin[i] == kNoSlot) continue;
    if (origin[i] >= touching.now.size()) touching.now.resize(std::size_t{origin[i]} + 1, kNoSlot);
    touching.now[origin[i]] = static_cast<std::uint32_t>(i);
  }
}

std::span<const std::uint32_t> World::strips() {
  Impl& w = *impl_;
  const FloatSettings settings;
  const WorkerPool::Awake awake(w.pool);
  w.settle_lists();
  ContactList& t = w.touching;
  t.strips.assign(w.bodies.id_count, kNoStrip);
  if (w.steps == 0) return t.strips;
  t.now.clear();
  if (w.ahead.sorted || w.broad.has_moved_on()) w.find_moved();
  w.turn_back();
  w.pool.run(w.table.body_count != 0 ? w.table.strips.size() : 0, [&](std::size_t index) {
    const Strip& s = w.table.strips[index];
    for (std::uint32_t i = s.body_begin; i < s.body_end; ++i) {
      const std::uint32_t slot = t.slot(i);
      const std::uint32_t id = slot < w.bodies.count ? w.bodies.id[slot] : kNoSlot;
      if (id != kNoSlot) t.strips[id] = static_cast<std::uint32_t>(index);
    }
  });
  w.turn_back();
  return t.strips;
}

std::span<const Contact> World::contacts() {
  Impl& w = *impl_;
  if (w.steps == 0) return {};
  const FloatSettings settings;
  const WorkerPool::Awake awake(w.pool);
  w.settle_lists();
  ContactList& t = w.touching;
  t.begun = w.ahead.part != Part::check || w.ahead.at != 0 || !w.contacts_stand();
  t.now.clear();
  if (w.ahead.sorted || w.broad.has_moved_on()) w.find_moved();
  w.turn_back();
  if (t.begun && w.plan.shapes) w.manifolds.keep_impulses(w.pool);
  t.found.resize(std::max(t.found.size(), w.table.strips.size()));
  for (std::vector<Ref>& strip : t.found) strip.clear();
  if (w.impulses_valid && w.bodies.count != 0 && w.table.body_count != 0) w.find_contacts();
  t.kept.clear();
  if (!w.sleepers.empty() || !w.sleepers.recent.empty()) {
    w.bodies.find_slots();
    w.find_kept();
  }
  t.refs.clear();
  for (const std::vector<Ref>& strip : t.found)
    t.refs.insert(t.refs.end(), strip.begin(), strip.end());
  for (std::size_t k = 0; k < t.kept.size(); ++k) {
    t.refs.push_back(
        {t.kept[k].a.index, t.kept[k].b.index, static_cast<std::uint32_t>(k), 0, Ref::kKept, 0, Ref::kNone});
  }
  sort_refs(t.refs, t.sorted, t.count, w.bodies.id_count);
  w.write_contacts();
  w.turn_back();
  // Several of one pair: in order of place; what the lists have comes before what was kept of it.
  std::size_t end = 0;
  for (std::size_t begin = 0; begin < t.refs.size();) {
    std::size_t next = begin + 1;
    bool listed = t.refs[begin].kind != Ref::kKept;
    for (; next < t.refs.size() && t.refs[next].a == t.refs[begin].a &&
           t.refs[next].b == t.refs[begin].b;
         ++next) {
      listed = listed || t.refs[next].kind != Ref::kKept;
    }
    const std::size_t first = end;
    for (std::size_t n = begin; n < next; ++n) {
      if (listed && t.refs[n].kind == Ref::kKept) continue;
      if (end != n) t.out[end] = t.out[n];
      ++end;
    }
    if (end - first > 1) {
      std::sort(t.out.begin() + static_cast<std::ptrdiff_t>(first),
                t.out.begin() + static_cast<std::ptrdiff_t>(end), by_place);
    }
    begin = next;
  }
  t.out.resize(end);
  return t.out;
}

}  // namespace psim
