// Finds which joints are solved together, and in which order their rows are eliminated. O(joints) for chains and trees.
#include <algorithm>
#include <numeric>

#include "joints/articulations.h"

namespace psim {
namespace {

// What a factorisation may take, in multiplications: of one articulation, and of all.
constexpr std::size_t kMostWork = 100'000;
constexpr std::uint32_t kMostJoints = 4096;  // of one articulation
constexpr std::size_t kRowWork = 40;         // of a row besides its entries

using Candidate = Articulations::Candidate;

// The lowest member of the group of a body, with the ways to it cut short.
std::uint32_t root_of(std::vector<std::uint32_t>& roots, std::uint32_t body) {
  while (roots[body] != body) body = roots[body] = roots[roots[body]];
  return body;
}

// Sorts the candidates by group: joints that share dynamic bodies. Returns where the groups begin, and the end.
std::vector<std::size_t> group(std::vector<Candidate>& all) {
  std::uint32_t bodies = 0;
  for (const Candidate& c : all) bodies = std::max({bodies, c.body[0] + 1, c.body[1] + 1});
  std::vector<std::uint32_t> roots(bodies);
  std::iota(roots.begin(), roots.end(), 0u);
  for (const Candidate& c : all) {
    if (!c.dynamic[0] || !c.dynamic[1]) continue;
    const std::uint32_t a = root_of(roots, c.body[0]), b = root_of(roots, c.body[1]);
    roots[std::max(a, b)] = std::min(a, b);
  }
  const auto group_of = [&](const Candidate& c) { return root_of(roots, c.body[c.dynamic[1] ? 1 : 0]); };
  std::stable_sort(all.begin(), all.end(),
                   [&](const Candidate& a, const Candidate& b) { return group_of(a) < group_of(b); });
  std::vector<std::size_t> begins;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (k == 0 || group_of(all[k]) != group_of(all[k - 1])) begins.push_back(k);
  }
  begins.push_back(all.size());
  return begins;
}

// Ragdolls: few pins, most of them with limits. They lie on contacts and press on their limits, and sweeps over joints and
// contacts in turn bring them to rest sooner.
bool is_ragdoll(std::span<const Candidate> joints) {
  constexpr std::size_t kMost = 32;
  const auto pinned = [](const Candidate& c) {
    return c.kind == kernels::JointKind::pin || c.kind == kernels::JointKind::driven;
  };
  const auto limited = std::count_if(joints.begin(), joints.end(), [](const Candidate& c) { return c.limited; });
  return joints.size() <= kMost && 2 * static_cast<std::size_t>(limited) > joints.size() &&
         std::all_of(joints.begin(), joints.end(), pinned);
}

// Linkages have more rows than an articulation knows, and all that hangs together is solved in one way.
bool has_linkage(std::span<const Candidate> joints) {
  return std::any_of(joints.begin(), joints.end(),
                     [](const Candidate& c) { return c.kind == kernels::JointKind::linkage; });
}

}  // namespace

// The order in which the joints of a group are eliminated: always one that is coupled with the fewest of those that are
// left (Tinney and Walker 1967). Eliminating it couples all of these with each other.
class Articulations::Elimination {
 public:
  explicit Elimination(std::span<const Candidate> joints) : behind_(joints.size()) {
    work_ = joints.size() > kMostJoints ? kMostWork + 1 : 0;
    if (work_ > kMostWork || !find_neighbours(joints)) return;
    std::vector<std::uint8_t> done(joints.size());
    for (std::size_t n = 0; n < joints.size(); ++n) {
      std::uint32_t next = kNone;
      for (std::uint32_t k = 0; k < joints.size(); ++k) {
        if (done[k] == 0 && (next == kNone || behind_[k].size() < behind_[next].size())) next = k;
      }
      done[next] = 1;
      order_.push_back(next);
      std::size_t entries = 0;
      for (const std::uint32_t k : behind_[next]) entries += rows_of(joints[k].kind);
      for (std::uint32_t r = rows_of(joints[next].kind); r > 0; --r) {
        const std::size_t all = entries + r - 1;
        work_ += kRowWork + 8 * all + all * all;
      }
      if (work_ > kMostWork) return;
      for (const std::uint32_t k : behind_[next]) connect(k, next);
    }
  }
  std::size_t work() const { return work_; }
  const std::vector<std::uint32_t>& order() const { return order_; }
  /// The joints that are left and coupled with one when it is eliminated.
  const std::vector<std::uint32_t>& behind(std::uint32_t joint) const { return behind_[joint]; }

 private:
  // False if a body has too many joints.
  bool find_neighbours(std::span<const Candidate> joints) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> ends;  // body, joint
    for (std::uint32_t k = 0; k < joints.size(); ++k) {
      for (const int side : {0, 1}) {
        if (joints[k].dynamic[side]) ends.emplace_back(joints[k].body[side], k);
      }
    }
    std::sort(ends.begin(), ends.end());  // a total order: no two pairs are alike
    for (std::size_t begin = 0, end = 0; begin < ends.size(); begin = end) {
      while (end < ends.size() && ends[end].first == ends[begin].first) ++end;
      work_ += (end - begin) * (end - begin);
      if (work_ > kMostWork) return false;
      for (std::size_t a = begin; a < end; ++a) {
        for (std::size_t b = begin; b < end; ++b) {
          if (a != b) behind_[ends[a].second].push_back(ends[b].second);
        }
      }
    }
    work_ = 0;
    for (auto& list : behind_) {
      std::sort(list.begin(), list.end());  // a total order: numbers
      list.erase(std::unique(list.begin(), list.end()), list.end());
    }
    return true;
  }
  // `done` is eliminated: what it was coupled with is coupled with k now.
  void connect(std::uint32_t k, std::uint32_t done) {
    std::vector<std::uint32_t> all;
    const auto& other = behind_[done];
    std::set_union(behind_[k].begin(), behind_[k].end(), other.begin(), other.end(), std::back_inserter(all));
    std::erase_if(all, [=](std::uint32_t n) { return n == k || n == done; });
    behind_[k] = std::move(all);
  }

  std::vector<std::vector<std::uint32_t>> behind_;
  std::vector<std::uint32_t> order_;
  std::size_t work_ = 0;
};

// Larger groups first, for sweeps err most there; of groups of one size all or none.
void Articulations::lay_out(std::span<const Candidate> candidates) {
  for (auto* list : {&columns_, &targets_, &walk_}) list->clear();
  islands_.clear(), bodies_.clear(), joints_.clear(), rows_.clear(), couplings_.clear();
  std::vector<Candidate> all(candidates.begin(), candidates.end());
  const std::vector<std::size_t> begins = group(all);
  const std::size_t groups = begins.size() - 1;
  const auto size = [&](std::size_t g) { return begins[g + 1] - begins[g]; };
  std::vector<std::size_t> by_size(groups);
  std::iota(by_size.begin(), by_size.end(), std::size_t{0});
  // A total order: of one size in the order of the groups.
  std::stable_sort(by_size.begin(), by_size.end(), [&](std::size_t a, std::size_t b) { return size(a) > size(b); });
  std::size_t left = kMostWork;
  for (std::size_t begin = 0, end = 0; begin < groups; begin = end) {
    while (end < groups && size(by_size[end]) == size(by_size[begin])) ++end;
    if (size(by_size[begin]) * (end - begin) * kRowWork > left) continue;
    const auto joints = [&](std::size_t k) { return std::span(all).subspan(begins[by_size[k]], size(by_size[k])); };
    std::vector<std::pair<std::size_t, Elimination>> orders;
    std::size_t work = 0;
    for (std::size_t k = begin; k < end && work <= left; ++k) {
      if (is_ragdoll(joints(k)) || has_linkage(joints(k))) continue;
      orders.emplace_back(k, joints(k));
      work += orders.back().second.work();
    }
    if (work > left) continue;
    left -= work;
    for (const auto& [k, order] : orders) add(joints(k), order);
  }
  upper_.assign(columns_.size(), 0);
  lower_.assign(columns_.size(), 0);
}

// A new articulation: its bodies, joints and rows.
void Articulations::add(std::span<const Candidate> group, const Elimination& elimination) {
  Island island;
  island.bodies.begin = static_cast<std::uint32_t>(bodies_.size());
  island.joints.begin = static_cast<std::uint32_t>(joints_.size());
  island.rows.begin = static_cast<std::uint32_t>(rows_.size());
  std::vector<std::uint32_t> ids;
  for (const Candidate& c : group) ids.insert(ids.end(), {c.body[0], c.body[1]});
  std::sort(ids.begin(), ids.end());  // a total order: numbers
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  for (const std::uint32_t id : ids) bodies_.push_back({.id = id});
  const auto body_of = [&](std::uint32_t id) {
    const auto at = std::lower_bound(ids.begin(), ids.end(), id) - ids.begin();
    return island.bodies.begin + static_cast<std::uint32_t>(at);
  };
  for (const std::uint32_t k : elimination.order()) {
    const Candidate& c = group[k];
    Joint j;
    j.geometry.kind = c.kind;
    j.joint = c.joint;
    j.first_row = static_cast<std::uint32_t>(rows_.size());
    for (const int side : {0, 1}) {
      j.body[side] = body_of(c.body[side]);
      if (!c.dynamic[side]) island.held = std::min(island.held, j.body[side]);
    }
    const auto number = static_cast<std::uint32_t>(joints_.size());
    for (std::uint32_t r = 0; r < j.geometry.rows(); ++r) rows_.push_back({.joint = number});
    joints_.push_back(j);
  }
  island.bodies.end = static_cast<std::uint32_t>(bodies_.size());
  island.joints.end = static_cast<std::uint32_t>(joints_.size());
  island.rows.end = static_cast<std::uint32_t>(rows_.size());
  // The rows behind each row: the others of its joint, then those of the joints behind, in order.
  std::vector<std::uint32_t> place(group.size());
  for (std::uint32_t n = 0; n < group.size(); ++n) place[elimination.order()[n]] = island.joints.begin + n;
  std::vector<std::uint32_t> behind;
  for (const std::uint32_t k : elimination.order()) {
    behind.clear();
    for (const std::uint32_t other : elimination.behind(k)) behind.push_back(place[other]);
    std::sort(behind.begin(), behind.end());  // a total order: numbers
    const Joint& j = joints_[place[k]];
    const std::uint32_t end = j.first_row + j.geometry.rows();
    for (std::uint32_t r = j.first_row; r < end; ++r) {
      rows_[r].entries.begin = static_cast<std::uint32_t>(columns_.size());
      for (std::uint32_t other = r + 1; other < end; ++other) columns_.push_back(other);
      for (const std::uint32_t n : behind) {
        for (std::uint32_t t = 0; t < joints_[n].geometry.rows(); ++t) columns_.push_back(joints_[n].first_row + t);
      }
      rows_[r].entries.end = static_cast<std::uint32_t>(columns_.size());
    }
  }
  couple(island);
  find_walk(island);
  islands_.push_back(island);
}

// From body to body over joints, so that the places of all follow from that of the first.
void Articulations::find_walk(Island& island) {
  island.walk.begin = static_cast<std::uint32_t>(walk_.size());
  std::vector<std::vector<std::uint32_t>> joints_of(island.bodies.end - island.bodies.begin);
  for (std::uint32_t n = island.joints.begin; n < island.joints.end; ++n) {
    for (const std::uint32_t body : joints_[n].body) joints_of[body - island.bodies.begin].push_back(n);
  }
  std::vector<std::uint8_t> reached(joints_of.size());
  std::vector<std::uint32_t> open{island.bodies.begin};
  reached[0] = 1;
  for (std::size_t k = 0; k < open.size(); ++k) {
    for (const std::uint32_t n : joints_of[open[k] - island.bodies.begin]) {
      const std::uint32_t side = joints_[n].body[0] == open[k] ? 1 : 0, body = joints_[n].body[side];
      if (reached[body - island.bodies.begin]++ != 0) continue;
      walk_.push_back(2 * n + side);
      open.push_back(body);
    }
  }
  island.walk.end = static_cast<std::uint32_t>(walk_.size());
}

// Which bodies coupled rows share, and which entries elimination changes.
void Articulations::couple(const Island& island) {
  for (std::uint32_t r = island.rows.begin; r < island.rows.end; ++r) {
    Row& row = rows_[r];
    const Joint& mine = joints_[row.joint];
    row.first_target = static_cast<std::uint32_t>(targets_.size());
    for (std::uint32_t e = row.entries.begin; e < row.entries.end; ++e) {
      const Joint& other = joints_[rows_[columns_[e]].joint];
      std::uint8_t shared = 0;
      for (const int a : {0, 1}) {
        for (const int b : {0, 1}) {
          if (mine.body[a] == other.body[b]) shared |= static_cast<std::uint8_t>(1 << (2 * a + b));
        }
      }
      couplings_.push_back(shared);
      for (std::uint32_t f = e + 1; f < row.entries.end; ++f) {
        const Range& of = rows_[columns_[e]].entries;
        const auto at = std::lower_bound(columns_.begin() + of.begin, columns_.begin() + of.end, columns_[f]);
        targets_.push_back(static_cast<std::uint32_t>(at - columns_.begin()));
      }
    }
  }
}

}  // namespace psim
