#include "manifolds/part_search.h"

#include <algorithm>
#include <cmath>

#include "base/elementary.h"
#include "base/rotor.h"
#include "manifolds/part_boxes.h"

namespace psim {
namespace {

Bounds box_of(const Hull& hull) {
  Bounds box{1e300, 1e300, -1e300, -1e300};
  for (int k = 0; k < hull.count; ++k) {
    const Vec2 v = hull.vertex(k);
    box = {lesser(v.x, box.xmin), lesser(v.y, box.ymin), greater(v.x, box.xmax), greater(v.y, box.ymax)};
  }
  const auto r = static_cast<double>(hull.radius);
  return {box.xmin - r, box.ymin - r, box.xmax + r, box.ymax + r};
}

Bounds grown(const Bounds& box, double by) { return {box.xmin - by, box.ymin - by, box.xmax + by, box.ymax + by}; }

// The box around a box that is turned and moved.
Bounds moved(const Bounds& box, SineCosine turn, Vec2 by) {
  const double u = (box.xmax - box.xmin) / 2, v = (box.ymax - box.ymin) / 2;
  const Vec2 middle = turned(turn, {(box.xmin + box.xmax) / 2, (box.ymin + box.ymax) / 2}) + by;
  const double half_x = std::fabs(turn.cosine) * u + std::fabs(turn.sine) * v,
               half_y = std::fabs(turn.sine) * u + std::fabs(turn.cosine) * v;
  return {middle.x - half_x, middle.y - half_y, middle.x + half_x, middle.y + half_y};
}

// Places near each other mostly get numbers near each other (Morton 1966).
std::uint32_t place_number(double x, double y) {
  const auto spread = [](double at) {
    auto bits = static_cast<std::uint32_t>(lesser(greater(at, 0.0), 1.0) * 65535);
    for (const int k : {8, 4, 2, 1})
      bits = (bits | bits << k) & (k == 8 ? 0x00FF00FFu : k == 4 ? 0x0F0F0F0Fu : k == 2 ? 0x33333333u : 0x55555555u);
    return bits;
  };
  return spread(x) | spread(y) << 1;
}

constexpr std::size_t kFan = 4;
constexpr double kRounding = 1e-5;  // share of a body's size: what floats may lose

Bounds around(const Bounds& a, const Bounds& b) {
  return {lesser(a.xmin, b.xmin), lesser(a.ymin, b.ymin), greater(a.xmax, b.xmax), greater(a.ymax, b.ymax)};
}

}  // namespace

PartSearch::Tree::Tree(std::span<const Hull> parts) {
  for (const Hull& hull : parts) {
    boxes.push_back(box_of(hull));
    const Bounds& b = boxes.back();
    for (const double edge : {-b.xmin, -b.ymin, b.xmax, b.ymax}) reach = greater(edge, reach);
  }
  std::vector<std::uint64_t> by_place;
  for (std::uint32_t k = 0; k < boxes.size(); ++k) {
    const Bounds& b = boxes[k];
    const double x = (b.xmin + b.xmax) / 4 / greater(reach, 1e-300) + 0.5,
                 y = (b.ymin + b.ymax) / 4 / greater(reach, 1e-300) + 0.5;
    by_place.push_back(std::uint64_t{place_number(x, y)} << 32 | k);
  }
  std::ranges::sort(by_place);  // Total order: the parts are in the numbers
  for (const std::uint64_t place : by_place) order.push_back(static_cast<std::uint32_t>(place));
  std::size_t below = order.size();
  do {
    const bool leaves = levels.empty();
    std::vector<Bounds> level((below + kFan - 1) / kFan);
    for (std::size_t k = 0; k < below; ++k) {
      const Bounds& box = leaves ? boxes[order[k]] : levels.back()[k];
      level[k / kFan] = k % kFan == 0 ? box : around(level[k / kFan], box);
    }
    below = level.size();
    levels.push_back(std::move(level));
  } while (below > 1);
}

// Appends the parts whose boxes meet a box in the frame of the shape, ascending.
void PartSearch::Tree::near(const Bounds& box, std::vector<std::uint32_t>& out) const {
  const auto first = static_cast<std::ptrdiff_t>(out.size());
  const auto down = [&](const auto& self, std::size_t level, std::size_t k) -> void {
    if (!overlap(levels[level][k], box)) return;
    const std::size_t begin = k * kFan;
    if (level == 0) {
      for (std::size_t p = begin; p < std::min(begin + kFan, order.size()); ++p) {
        if (overlap(boxes[order[p]], box)) out.push_back(order[p]);
      }
      return;
    }
    for (std::size_t n = begin; n < std::min(begin + kFan, levels[level - 1].size()); ++n) self(self, level - 1, n);
  };
  down(down, levels.size() - 1, 0);
  std::sort(out.begin() + first, out.end());  // Total order: each part once
}

bool PartSearch::has_many(std::uint32_t slot) const {
  const BodyStore& b = s_.bodies;
  const BodyProperties& properties = b.properties(b.id[slot]);
  const bool held = properties.type() == BodyType::kinematic_body;
  return b.kinds[properties.kind].hull_count >= (held ? kManyKinematic : kMany);
}

bool PartSearch::has_few(std::uint32_t slot) const {
  const BodyStore& b = s_.bodies;
  const BodyProperties& properties = b.properties(b.id[slot]);
  const std::uint32_t parts = b.kinds[properties.kind].hull_count;
  return properties.type() != BodyType::kinematic_body && parts > 1 && parts <= PartBoxes::kMost;
}

PartSearch::Noted PartSearch::noted(std::uint32_t slot, const kernels::ReachParams& margin, float ahead) const {
  const BodyStore& b = s_.bodies;
  const float rim = b.rim_speed_of(slot), size = b.radius[slot];
  const float skin = margin.of_radius != 0 ? std::min(margin.of_radius * size, margin.skin) : margin.skin;
  return {slot, b.angle_of(slot) + static_cast<double>(ahead) * b.omega_of(slot), skin + std::fabs(rim) * margin.time};
}

void PartSearch::note(std::span<const std::uint32_t> slots, const kernels::ReachParams& margin, float ahead,
                      bool lasts) {
  wide_.clear();
  few_.clear();
  common_way_ = length_of({static_cast<double>(margin.common_x), static_cast<double>(margin.common_y)}) *
                    static_cast<double>(margin.time) +
                static_cast<double>(margin.beside);
  for (const std::uint32_t slot : slots) {
    if (has_many(slot)) wide_.push_back(noted(slot, margin, ahead));
    if (lasts && has_few(slot)) few_.push_back(noted(slot, margin, ahead));
  }
}

void PartSearch::note_again(std::span<const std::uint32_t> slots, const kernels::ReachParams& margin) {
  auto at = few_.begin();
  for (const std::uint32_t slot : slots) {
    while (at != few_.end() && at->slot < slot) ++at;
    if (at != few_.end() && at->slot == slot) *at = noted(slot, margin, 0);
  }
}

void PartSearch::prepare() {
  const ShapeTable& shapes = s_.bodies.hulls;
  if (of_shapes_ != shapes.changes()) trees_.clear();
  of_shapes_ = shapes.changes();
  for (const Noted& w : wide_) {
    const BodyKind& kind = s_.bodies.kind(s_.bodies.id[w.slot]);
    std::unique_ptr<Tree>& tree = trees_[kind.first_hull];
    if (tree == nullptr) tree = std::make_unique<Tree>(std::span(&shapes[kind.first_hull], kind.hull_count));
  }
}

bool PartSearch::serves(const Noted& n, float time) const {
  const BodyStore& b = s_.bodies;
  const double turned_by = std::fabs(b.angle_of(n.slot) - n.angle) * static_cast<double>(b.radius[n.slot]);
  return turned_by + static_cast<double>(std::fabs(b.rim_speed_of(n.slot)) * time) <= static_cast<double>(n.turn);
}

bool PartSearch::serve(float time) const {
  return std::ranges::all_of(wide_, [&](const Noted& n) { return serves(n, time); });
}

std::span<const std::uint32_t> PartSearch::find_turned(float time) {
  turned_.clear();
  for (const Noted& n : few_) {
    if (s_.bodies.id[n.slot] != kNoSlot && !serves(n, time)) turned_.push_back(n.slot);
  }
  return turned_;
}

std::size_t PartSearch::bytes() const {
  std::size_t sum = bytes_of(wide_, few_, turned_);
  for (const auto& [part, tree] : trees_) {  // a sum of whole numbers: no order matters
    sum += sizeof(Tree) + bytes_of(tree->boxes, tree->order, tree->levels);
    for (const std::vector<Bounds>& level : tree->levels) sum += bytes_of(level);
  }
  return sum;
}

const PartSearch::Noted* PartSearch::find(const std::vector<Noted>& all, std::uint32_t slot) {
  const auto at = std::ranges::lower_bound(all, slot, {}, &Noted::slot);
  return at != all.end() && at->slot == slot ? &*at : nullptr;
}

const PartSearch::Tree& PartSearch::tree_of(std::uint32_t slot) const {
  return *trees_.at(s_.bodies.kind(s_.bodies.id[slot]).first_hull);
}

double PartSearch::margin_of(std::uint32_t slot) const {
  return static_cast<double>(s_.bodies.reach[slot]) - static_cast<double>(s_.bodies.radius[slot]);
}

Vec2 PartSearch::way(std::uint32_t from, std::uint32_t to) const {
  const auto& built = s_.bodies.built;
  return s_.lattice.metres(wrap_sub(built[2 * std::size_t{to}], built[2 * std::size_t{from}]),
                           wrap_sub(built[2 * std::size_t{to} + 1], built[2 * std::size_t{from} + 1]));
}

void PartSearch::near_body(std::uint32_t slot, std::uint32_t other, std::vector<std::uint32_t>& out) const {
  const Noted& w = *wide_of(slot);
  const Tree& tree = tree_of(slot);
  const Vec2 at = turned(sine_cosine(-w.angle), way(slot, other));
  const double within = static_cast<double>(s_.bodies.reach[other]) + margin_of(slot) + static_cast<double>(w.turn) +
                        kRounding * tree.reach;
  tree.near(grown({at.x, at.y, at.x, at.y}, within), out);
}

void PartSearch::near_part(std::uint32_t slot, std::uint32_t other, std::uint32_t part,
                           std::vector<std::uint32_t>& out) const {
  const Noted &mine = *wide_of(slot), &theirs = *wide_of(other);
  const Tree &tree = tree_of(slot), &of_other = tree_of(other);
  const Bounds there = moved(of_other.boxes[part], sine_cosine(theirs.angle - mine.angle),
                             turned(sine_cosine(-mine.angle), way(slot, other)));
  const double within = margin_of(slot) + margin_of(other) + static_cast<double>(mine.turn + theirs.turn) +
                        kRounding * (tree.reach + of_other.reach);
  tree.near(grown(there, within), out);
}

void PartSearch::near_piece(const StaticPair& pair, const Walls& walls, std::vector<std::uint32_t>& out) const {
  const Noted& w = *wide_of(pair.body);
  const Tree& tree = tree_of(pair.body);
  const double within = margin_of(pair.body) + static_cast<double>(w.turn) + common_way_ + kRounding * tree.reach;
  const std::size_t at = 2 * std::size_t{pair.body};
  const LatticePoint here{s_.bodies.built[at], s_.bodies.built[at + 1], 0, 0};
  if (pair.shape < kWallLeft) {
    const Hull piece = s_.statics.seen_from(pair.shape, here, 4 * (tree.reach + within));
    return tree.near(grown(moved(box_of(piece), sine_cosine(-w.angle), {}), within), out);
  }
  const SineCosine turn = sine_cosine(w.angle);
  const auto [nx, ny, height] = walls.face(pair.shape, here, s_.lattice);
  const Vec2 n{static_cast<double>(nx), static_cast<double>(ny)};
  for (std::uint32_t k = 0; k < tree.boxes.size(); ++k) {
    const Bounds box = moved(tree.boxes[k], turn, {});
    const double low = (n.x > 0 ? box.xmin : box.xmax) * n.x + (n.y > 0 ? box.ymin : box.ymax) * n.y;
    if (static_cast<double>(height) + low <= within) out.push_back(k);
  }
}

}  // namespace psim
