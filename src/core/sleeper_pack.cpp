#include "sleeper_pack.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "image.h"
#include "invariant.h"
#include "sleepers.h"

namespace psim {
namespace {

struct PackCounts {
  std::uint32_t sleepers = 0, flags = 0, runs = 0, names = 0;
  std::uint32_t touches = 0, told = 0;  // told: here, not with another sleeper
  std::uint32_t many = 0, spare = 0;
};

constexpr std::uint32_t kAngles = 1, kGroups = 2, kPieces = 4, kEachNumber = 8;
constexpr std::uint32_t kFriction = 16, kWide = 32, kPerMass = 64, kUnits = 128;  // of loads
constexpr std::uint16_t kShared = 0x8000, kFar = 0x4000, kFixed = 0x4001;
constexpr std::uint8_t kLoose = 0x80, kMany = 0x7F;

struct Run {
  std::uint32_t first = 0, number = 0;
};

// Two points, or of another unit than the rest.
struct Wide {
  float impulse[2] = {}, friction[2] = {};
  std::uint32_t points = 0;
};

bool same_load(const Touch& a, const Touch& b) {
  return std::memcmp(a.impulse, b.impulse, sizeof a.impulse) == 0 &&
         std::memcmp(a.friction, b.friction, sizeof a.friction) == 0 && a.points == b.points &&
         a.per_mass == b.per_mass;
}

bool zero(float value) { return std::bit_cast<std::uint32_t>(value) == 0; }

class Writer {
 public:
  explicit Writer(std::vector<std::byte>& out) : out_(out) { out_.clear(); }
  // n values, each(k) in turn.
  template <class T, class Each>
  void column(std::size_t n, const Each& each) {
    const std::size_t at = out_.size();
    out_.resize(at + (n * sizeof(T) + 3) / 4 * 4);
    for (std::size_t k = 0; k < n; ++k) {
      const T value = each(k);
      std::memcpy(out_.data() + at + k * sizeof(T), &value, sizeof value);
    }
  }
  template <class T>
  void column(const std::vector<T>& values) {
    const std::size_t at = out_.size();
    out_.resize(at + (values.size() * sizeof(T) + 3) / 4 * 4);
    if (!values.empty()) std::memcpy(out_.data() + at, values.data(), values.size() * sizeof(T));
  }

 private:
  std::vector<std::byte>& out_;
};

class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}
  template <class T>
  InPlace<T> column(std::size_t n) {
    InPlace<T> c;
    const std::size_t bytes = (n * sizeof(T) + 3) / 4 * 4;
    if (bytes > bytes_.size() - at_) {
      sound_ = false;
      return c;
    }
    c.count = n;
    c.from = bytes_.data() + at_;
    at_ += bytes;
    return c;
  }
  bool sound() const { return sound_; }
  bool at_end() const { return sound_ && at_ == bytes_.size(); }

 private:
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
  bool sound_ = true;
};

// What touches carry.
std::uint32_t flags_of(const std::vector<const Touch*>& touches) {
  std::uint32_t flags = 0;
  for (const Touch* t : touches) {
    if (!zero(t->friction[0])) flags |= kFriction;
    if (t->points != 1 || !zero(t->impulse[1]) || !zero(t->friction[1])) flags |= kWide;
    if (t->per_mass != touches[0]->per_mass) flags |= kUnits;
  }
  return touches.empty() || !touches[0]->per_mass ? flags : flags | kPerMass;
}

void put_loads(Writer& w, const std::vector<const Touch*>& touches, std::uint32_t flags) {
  const std::size_t n = touches.size();
  if ((flags & kWide) != 0) {
    w.column<Wide>(n, [&](std::size_t k) {
      const Touch& t = *touches[k];
      return Wide{{t.impulse[0], t.impulse[1]}, {t.friction[0], t.friction[1]}, t.points};
    });
  } else {
    w.column<float>(n, [&](std::size_t k) { return touches[k]->impulse[0]; });
    if ((flags & kFriction) != 0)
      w.column<float>(n, [&](std::size_t k) { return touches[k]->friction[0]; });
  }
  if ((flags & kUnits) != 0)
    w.column<std::uint8_t>(n, [&](std::size_t k) { return std::uint8_t{touches[k]->per_mass}; });
}

class Loads {
 public:
  Loads(Reader& r, std::size_t n, std::uint32_t flags) : flags_(flags), count_(n) {
    wide_ = r.column<Wide>(has(kWide) ? n : 0);
    impulses_ = r.column<float>(has(kWide) ? 0 : n);
    frictions_ = r.column<float>(!has(kWide) && has(kFriction) ? n : 0);
    units_ = r.column<std::uint8_t>(has(kUnits) ? n : 0);
  }
  // The next one.
  bool take(Touch& t) {
    if (at_ == count_) return false;
    if (has(kWide)) {
      const Wide load = wide_[at_];
      std::memcpy(t.impulse, load.impulse, sizeof t.impulse);
      std::memcpy(t.friction, load.friction, sizeof t.friction);
      t.points = load.points;
    } else {
      t.impulse[0] = impulses_[at_];
      if (has(kFriction)) t.friction[0] = frictions_[at_];
    }
    t.per_mass = has(kUnits) ? units_[at_] != 0 : has(kPerMass);
    ++at_;
    return true;
  }

 private:
  bool has(std::uint32_t flag) const { return (flags_ & flag) != 0; }

  std::uint32_t flags_;
  std::size_t count_, at_ = 0;
  InPlace<Wide> wide_;
  InPlace<float> impulses_, frictions_;
  InPlace<std::uint8_t> units_;
};

constexpr std::uint64_t kHis = 1ull << 31;  // in the key of a touch of two bodies

// Of two bodies, as the first of them that sleeps has it; or null.
const Touch* touch_of_sleeper(const Sleepers& sleepers, const BodyStore& bodies,
                              std::uint64_t key) {
  for (const std::uint64_t id : {key >> 32, key & 0xFFFFFFFFu}) {
    if (id >= bodies.id_count || bodies.info[id].place != Place::asleep) continue;
    const Sleeper& s = sleepers.list[bodies.info[id].slot];
    const Touch* const begin = sleepers.touches.data() + s.first_touch;
    const Touch* const end = begin + s.touches;
    const Touch* const at =
        std::find_if(begin, end, [key](const Touch& t) { return t.key == key; });
    return at == end ? nullptr : at;
  }
  return nullptr;
}

}  // namespace

void pack_sleepers(const Sleepers& sleepers, const BodyStore& bodies, std::size_t first,
                   std::vector<std::byte>& out) {
  const std::size_t n = std::min<std::size_t>(SleeperPack::kEach, sleepers.list.size() - first);
  const std::span<const Sleeper> list(sleepers.list.data() + first, n);
  PackCounts counts;
  counts.sleepers = static_cast<std::uint32_t>(n);
  std::vector<Run> runs;
  std::vector<std::uint32_t> names, many, told_from(n);
  std::vector<std::uint16_t> codes;
  std::vector<std::uint8_t> by_sleeper;
  std::vector<const Touch*> told;
  codes.reserve(4 * n);
  told.reserve(4 * n);
  by_sleeper.reserve(n);
  // In the pack; or n.
  const auto place_of = [&](std::uint32_t id) -> std::size_t {
    const BodyInfo& info = bodies.info[id];
    return info.place == Place::asleep && info.slot >= first && info.slot - first < n
               ? info.slot - first
               : n;
  };
  std::uint32_t next = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const Sleeper& s = list[k];
    if (std::bit_cast<std::uint64_t>(s.angle) != 0) counts.flags |= kAngles;
    if (s.group != kNoSlot) counts.flags |= kGroups;
    if (s.shapes != 1) counts.flags |= kPieces;
    if (k == 0 || s.first_shape != next)
      runs.push_back({static_cast<std::uint32_t>(k), s.first_shape});
    next = s.first_shape + s.shapes;
    by_sleeper.push_back(static_cast<std::uint8_t>(std::min<std::uint32_t>(s.touches, kMany) |
                                                   (s.loose ? kLoose : 0)));
    if (s.touches >= kMany) many.push_back(s.touches);
    counts.touches += s.touches;
    told_from[k] = static_cast<std::uint32_t>(codes.size());
    bool in_order = true;  // so far all were told by sleepers before, one after the other
    std::size_t before = 0;
    for (const Touch& t : std::span(sleepers.touches).subspan(s.first_touch, s.touches)) {
      if (t.of_fixed()) {
        PSIM_ASSERT(t.key == TouchKey::fixed(s.id, t.second()));
        codes.push_back(kFixed);
        names.push_back(t.second());
      } else {
        const std::uint32_t other = t.first() == s.id ? t.second() : t.first();
        PSIM_ASSERT(t.key == TouchKey::bodies(s.id, other));
        const std::size_t at = place_of(other);
        in_order = in_order && at < k && at >= before;
        if (in_order) {
          before = at + 1;
          std::uint32_t c = told_from[at];
          while (c < told_from[at + 1] && told[c]->key != t.key) ++c;
          in_order = c < told_from[at + 1] && same_load(t, *told[c]);
          if (in_order) {
            codes[c] |= kShared;
            continue;
          }
        }
        codes.push_back(at < n ? static_cast<std::uint16_t>(at) : kFar);
        if (at == n) names.push_back(other);
      }
      in_order = false;
      told.push_back(&t);
    }
  }
  if (2 * runs.size() > n) counts.flags |= kEachNumber;
  counts.runs = static_cast<std::uint32_t>(runs.size());
  counts.names = static_cast<std::uint32_t>(names.size());
  counts.told = static_cast<std::uint32_t>(told.size());
  counts.many = static_cast<std::uint32_t>(many.size());
  counts.flags |= flags_of(told);
  Writer w(out);
  w.column<PackCounts>(1, [&](std::size_t) { return counts; });
  if ((counts.flags & kAngles) != 0)
    w.column<double>(n, [&](std::size_t k) { return list[k].angle; });
  w.column<LatticePoint>(n, [&](std::size_t k) { return list[k].at; });
  w.column<std::uint32_t>(n, [&](std::size_t k) { return list[k].id; });
  w.column<float>(n, [&](std::size_t k) { return list[k].depth; });
  if ((counts.flags & kEachNumber) != 0) {
    w.column<std::uint32_t>(n, [&](std::size_t k) { return list[k].first_shape; });
  } else {
    w.column(runs);
  }
  if ((counts.flags & kGroups) != 0)
    w.column<std::uint32_t>(n, [&](std::size_t k) { return list[k].group; });
  if ((counts.flags & kPieces) != 0)
    w.column<std::uint32_t>(n, [&](std::size_t k) { return list[k].shapes; });
  w.column(names);
  put_loads(w, told, counts.flags);
  w.column(codes);
  w.column(by_sleeper);
  w.column(many);
}

namespace {

PackCounts counts_of(std::span<const std::byte> pack) {
  PackCounts counts;
  if (pack.size() >= sizeof counts) std::memcpy(&counts, pack.data(), sizeof counts);
  return counts;
}

}  // namespace

std::uint32_t count_in_pack(std::span<const std::byte> pack) { return counts_of(pack).sleepers; }

bool unpack_sleepers(std::span<const std::byte> pack, std::size_t first, Sleepers& sleepers,
                     BodyStore& bodies) {
  Reader r(pack);
  r.column<PackCounts>(1);
  if (!r.sound()) return false;
  const PackCounts counts = counts_of(pack);
  const std::size_t n = counts.sleepers;
  const auto has = [&](std::uint32_t flag) { return (counts.flags & flag) != 0; };
  const auto optional = [&](std::uint32_t flag) { return has(flag) ? n : 0; };
  const auto angles = r.column<double>(optional(kAngles));
  const auto places = r.column<LatticePoint>(n);
  const auto ids = r.column<std::uint32_t>(n);
  const auto depths = r.column<float>(n);
  const auto numbers = r.column<std::uint32_t>(optional(kEachNumber));
  const auto runs = r.column<Run>(has(kEachNumber) ? 0 : counts.runs);
  const auto groups = r.column<std::uint32_t>(optional(kGroups));
  const auto pieces = r.column<std::uint32_t>(optional(kPieces));
  const auto names = r.column<std::uint32_t>(counts.names);
  Loads loads(r, counts.told, counts.flags);
  const auto codes = r.column<std::uint16_t>(counts.told);
  const auto by_sleeper = r.column<std::uint8_t>(n);
  const auto many = r.column<std::uint32_t>(counts.many);
  if (!r.at_end() || n > SleeperPack::kEach || first + n > sleepers.list.size()) return false;
  if (n != 0 && !has(kEachNumber) && (runs.count == 0 || runs[0].first != 0)) return false;
  std::size_t long_one = 0, run = 0;
  std::uint32_t next = 0;
  std::size_t touches = sleepers.touches.size();
  for (std::size_t k = 0; k < n; ++k) {
    Sleeper& s = sleepers.list[first + k];
    s.at = places[k];
    s.angle = has(kAngles) ? angles[k] : 0;
    s.id = ids[k];
    s.depth = depths[k];
    s.group = has(kGroups) ? groups[k] : kNoSlot;
    s.shapes = has(kPieces) ? pieces[k] : 1;
    if (has(kEachNumber)) {
      s.first_shape = numbers[k];
    } else {
      if (run < runs.count && runs[run].first == k) next = runs[run++].number;
      s.first_shape = next;
      next += s.shapes;
    }
    s.loose = (by_sleeper[k] & kLoose) != 0;
    std::size_t mine = by_sleeper[k] & ~kLoose;
    if (mine == kMany) {
      if (long_one == many.count) return false;
      mine = many[long_one++];
    }
    if (s.id >= bodies.id_count || bodies.info[s.id].place != Place::asleep) return false;
    bodies.info[s.id].slot = static_cast<std::uint32_t>(first + k);
    s.first_touch = static_cast<std::uint32_t>(touches);
    s.touches = 0;
    touches += mine;
  }
  if (touches - sleepers.touches.size() != counts.touches ||
      counts.touches > 2 * std::size_t{counts.told})
    return false;
  sleepers.touches.resize(touches);
  const auto end_of = [&](std::size_t k) {
    return k + 1 < n ? std::size_t{sleepers.list[first + k + 1].first_touch} : touches;
  };
  std::size_t name = 0, code = 0;
  for (std::size_t k = 0; k < n; ++k) {
    Sleeper& s = sleepers.list[first + k];  // it has those that others told
    while (s.first_touch + s.touches < end_of(k)) {
      Touch& t = sleepers.touches[s.first_touch + s.touches++];
      if (code == codes.count) return false;
      const std::uint16_t what = codes[code++];
      const std::size_t at = what & ~kShared;
      if (what == kFixed || what == kFar) {
        if (name == names.count) return false;
        const std::uint32_t other = names[name++];
        t.key = what == kFixed ? TouchKey::fixed(s.id, other) : TouchKey::bodies(s.id, other);
      } else {
        if (at >= n) return false;
        t.key = TouchKey::bodies(s.id, ids[at]);
      }
      if (!loads.take(t)) return false;
      if ((what & kShared) == 0) continue;
      if (at <= k) return false;
      Sleeper& other = sleepers.list[first + at];
      if (other.first_touch + other.touches >= end_of(at)) return false;
      sleepers.touches[other.first_touch + other.touches++] = t;
    }
  }
  return code == codes.count;
}

// A touch of one who sleeps with one who does not is mostly his, too.
void pack_recent(const Sleepers& sleepers, const BodyStore& bodies, std::vector<std::byte>& out) {
  const auto his = [&](const Touch& t) {
    if (t.of_fixed() || (t.second() & kHis) != 0) return false;
    const Touch* const same = touch_of_sleeper(sleepers, bodies, t.key);
    return same != nullptr && same_load(*same, t);
  };
  std::vector<const Touch*> told;
  std::vector<std::uint64_t> keys;
  for (const Touch& t : sleepers.recent.all()) {
    const bool known = his(t);
    keys.push_back(known ? t.key | kHis : t.key);
    if (!known) told.push_back(&t);
  }
  PackCounts counts;
  counts.touches = static_cast<std::uint32_t>(keys.size());
  counts.told = static_cast<std::uint32_t>(told.size());
  counts.flags = flags_of(told);
  Writer w(out);
  if (keys.empty()) return;
  w.column<PackCounts>(1, [&](std::size_t) { return counts; });
  w.column(keys);
  put_loads(w, told, counts.flags);
}

bool unpack_recent(std::span<const std::byte> pack, const Sleepers& sleepers, const BodyStore& bodies, TouchMemory& out) {
  out.clear();
  if (pack.empty()) return true;
  Reader r(pack);
  const InPlace<PackCounts> head = r.column<PackCounts>(1);
  if (!r.sound()) return false;
  const auto keys = r.column<std::uint64_t>(head[0].touches);
  Loads loads(r, head[0].told, head[0].flags);
  if (!r.at_end()) return false;
  for (std::size_t k = 0; k < keys.count; ++k) {
    Touch t;
    t.key = keys[k];
    if (!t.of_fixed() && (t.key & kHis) != 0) {
      t.key &= ~kHis;
      const Touch* const same = touch_of_sleeper(sleepers, bodies, t.key);
      if (same == nullptr) return false;
      t = *same;
    } else if (!loads.take(t)) {
      return false;
    }
    out.add(t);
  }
  return true;
}

bool unpack_recent(std::span<const std::byte> pack, Sleepers& sleepers, const BodyStore& bodies) {
  return unpack_recent(pack, sleepers, bodies, sleepers.recent);
}

}  // namespace psim
