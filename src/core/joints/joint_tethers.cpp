// Tethers: ropes from the supports of a net to bodies in it, as long as the shortest way there through its joints. No way
// through joints can be longer than it is, so a tether forbids nothing that the joints allow; but it hands the load of what
// hangs far below to the support at once, where sweeps over the joints carry it one joint far.
#include <algorithm>
#include <map>
#include <numeric>
#include <queue>

#include "joints/joint_store.h"

namespace psim {

namespace {

constexpr std::uint32_t kSmallNet = 8192;               // bodies with joints
constexpr std::uint32_t kLinks = 2, kLinksOfLarge = 8;  // from one body with tethers to the next
constexpr std::uint8_t kMostWays = 2;
constexpr double kApart = 0.5;  // of a second way: how far its support is from the first one, at least

// Springs, slides and linkages do not keep a distance.
bool far_kept(kernels::JointKind kind) {
  return kind != kernels::JointKind::spring && kind != kernels::JointKind::slide && kind != kernels::JointKind::linkage;
}

}  // namespace

// A way through joints from a support to an anchor of a body, which it reaches last.
struct JointStore::Way {
  double length = 0;               // m
  std::uint32_t joint = 0;         // the last one
  std::uint32_t side = 0;          // of the body in that joint
  std::uint32_t support = 0;       // the first joint
  std::uint32_t links = 1;         // the number of joints
  std::uint32_t parent = kNoSlot;  // the way that it goes on from
  std::uint32_t tethers = 0;       // on this way and on those that go on from it
  std::uint32_t next = 0;          // where those of the next one begin that goes on from it
  bool tethered = false;

  bool operator<(const Way& o) const {  // the shortest one is on top of a queue
    return length != o.length ? length > o.length : joint != o.joint ? joint > o.joint : support > o.support;
  }
};

// The shortest ways to each body from the supports that are nearest (Dijkstra 1959), in ascending order of their length.
std::vector<JointStore::Way> JointStore::find_ways() const {
  const auto keeps = [](const Joint& j) {
    return j.alive && !j.dormant && j.articulated == kNoSlot && far_kept(j.kind);
  };
  const auto length = [](const Joint& j) { return j.kind == kernels::JointKind::rod ? *j.desc.length : 0; };
  // A total order: by length, joint and support.
  std::priority_queue<Way> ahead;
  std::vector<std::uint32_t> begin(bodies_.size() + 1), of_body;
  for (std::uint32_t i = 0; i < joints_.size(); ++i) {
    const Joint& j = joints_[i];
    if (!keeps(j)) continue;
    if (j.held) ahead.push({.length = length(j), .joint = i, .side = 1, .support = i});
    for (const std::uint32_t b : j.body) ++begin[b];
  }
  std::vector<Way> ways;
  if (ahead.empty()) return ways;
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  of_body.resize(begin.back());
  for (auto i = static_cast<std::uint32_t>(joints_.size()); i-- > 0;) {
    if (!keeps(joints_[i])) continue;
    for (const std::uint32_t b : joints_[i].body) of_body[--begin[b]] = i;
  }
  const std::uint32_t links = bodies_.size() > kSmallNet ? kLinksOfLarge : kLinks;
  std::vector<std::uint8_t> count(bodies_.size());
  std::vector<std::uint32_t> first(bodies_.size());                          // the first way to a body
  std::map<std::pair<std::uint32_t, std::uint32_t>, double> supports_apart;  // m, along joints
  while (!ahead.empty()) {
    Way at = ahead.top();
    ahead.pop();
    const Joint& in = joints_[at.joint];
    const std::uint32_t body = in.body[at.side], held_by = joints_[at.support].body[0];
    if (count[body] >= kMostWays) continue;
    at.tethered = at.links > 1 && at.links % links == 0;
    if (count[body] == 0) {
      first[body] = static_cast<std::uint32_t>(ways.size());
    } else {
      const std::uint32_t other = joints_[ways[first[body]].support].body[0];
      if (other == held_by) continue;
      const double both = ways[first[body]].length + at.length;
      const double apart = supports_apart.try_emplace(std::minmax(other, held_by), both).first->second;
      at.tethered = at.tethered && apart >= kApart * at.length;
    }
    ++count[body];
    const auto parent = static_cast<std::uint32_t>(ways.size());
    ways.push_back(at);
    for (std::uint32_t k = begin[body]; k < begin[body + 1]; ++k) {
      const Joint& out = joints_[of_body[k]];
      const std::uint32_t side = out.body[0] == body ? 1 : 0;
      if (out.held || count[out.body[side]] >= kMostWays) continue;
      const double inside = length_of(out.anchor(1 - side) - in.anchor(at.side));
      ahead.push({.length = at.length + inside + length(out),
                  .joint = of_body[k],
                  .side = side,
                  .support = at.support,
                  .links = at.links + 1,
                  .parent = parent});
    }
  }
  return ways;
}

// Makes the tethers anew; those that were there before keep their impulses. Those on a way and on all that go on from it
// lie side by side. O(joints log joints).
void JointStore::find_tethers() {
  std::vector<Way> ways = find_ways();
  std::uint32_t all = 0;
  for (std::size_t k = ways.size(); k-- > 0;) {
    Way& w = ways[k];
    if (w.tethered) ++w.tethers;
    (w.parent == kNoSlot ? all : ways[w.parent].tethers) += w.tethers;
  }
  std::vector<Tether> old(all);
  tethers_.swap(old);
  tether_ranges_.clear();
  std::uint32_t first = 0;
  for (Way& w : ways) {
    std::uint32_t& begin = w.parent == kNoSlot ? first : ways[w.parent].next;
    w.next = begin;
    if (w.tethers != 0) tether_ranges_.push_back({w.joint, w.side, {begin, begin + w.tethers}});
    begin += w.tethers;
    if (!w.tethered) continue;
    const Joint &in = joints_[w.joint], &support = joints_[w.support];
    tethers_[w.next++] = {.key = {w.joint, w.side, w.support},
                          .body = {support.body[0], in.body[w.side]},
                          .anchor = {support.anchor(0), in.anchor(w.side)},
                          .length = w.length};
  }
  const auto earlier = [](const auto& a, const auto& b) { return a.key < b.key; };
  std::sort(old.begin(), old.end(), earlier);  // a total order: no two have one key
  for (Tether& t : tethers_) {
    const auto it = std::lower_bound(old.begin(), old.end(), t, earlier);
    if (it != old.end() && it->key == t.key) t.impulse = it->impulse;
  }
  std::sort(tether_ranges_.begin(), tether_ranges_.end());  // a total order: a way each
}

// Returns the impulse, N s, that tethers carry past a joint, as it would act on the body at the joint's side B.
Vec2 JointStore::tethered_load(std::uint32_t joint) const {
  Vec2 sum;
  const auto& blocks = lists_.rods(true);
  auto it = std::lower_bound(tether_ranges_.begin(), tether_ranges_.end(), TetherRange{joint, 0, {}});
  for (; it != tether_ranges_.end() && it->joint == joint; ++it) {
    for (std::uint32_t n = it->tethers.begin; n < it->tethers.end; ++n) {
      const kernels::LineBlock& b = blocks[tethers_[n].lane / kBlock];
      const std::uint32_t k = tethers_[n].lane % kBlock;
      const double l = it->side == 1 ? b.l[k] : -b.l[k];
      sum = sum + l * Vec2{b.nx[k], b.ny[k]};
    }
  }
  return sum;
}

}  // namespace psim
