#include "manifolds/part_search.h"

#include <algorithm>
#include <cmath>

#include "base/elementary.h"
#include "base/rotor.h"

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

constexpr double kGridReach = 0x1p29;  // of HashGrid's places
constexpr double kRounding = 1e-5;     // share of a body's size: what floats and the grid may lose

}  // namespace

PartSearch::Grid::Grid(MemoryMeter& meter, std::span<const Hull> parts) : grid(meter, 0) {
  boxes.reserve(parts.size());
  for (const Hull& hull : parts) {
    boxes.push_back(box_of(hull));
    const Bounds& b = boxes.back();
    for (const double edge : {-b.xmin, -b.ymin, b.xmax, b.ymax}) reach = greater(edge, reach);
  }
  steps = kGridReach / greater(reach, 1e-30);
  grid.make_room(static_cast<std::uint32_t>(parts.size()), parts.size());
  for (std::uint32_t k = 0; k < boxes.size(); ++k) {
    const Bounds& b = boxes[k];
    const auto middle = [this](double low, double high) {
      return static_cast<std::int32_t>(std::floor((low + high) / 2 * steps));
    };
    const auto half = [this](double low, double high) {
      return static_cast<std::uint32_t>(std::ceil((high - low) / 2 * steps)) + 1;
    };
    grid.insert(k, middle(b.xmin, b.xmax), middle(b.ymin, b.ymax), half(b.xmin, b.xmax), half(b.ymin, b.ymax));
  }
}

// Appends the parts whose boxes meet a box in the frame of the shape, ascending.
void PartSearch::Grid::near(const Bounds& box, std::vector<std::uint32_t>& out) const {
  const Bounds all{greater(box.xmin, -reach), greater(box.ymin, -reach), lesser(box.xmax, reach),
                   lesser(box.ymax, reach)};
  if (!(all.xmin <= all.xmax && all.ymin <= all.ymax)) return;
  const auto middle = [this](double low, double high) {
    return static_cast<std::int32_t>(std::floor((low + high) / 2 * steps));
  };
  const auto half = [this](double low, double high) {
    return static_cast<std::uint32_t>(std::ceil((high - low) / 2 * steps)) + 2;
  };
  const auto first = static_cast<std::ptrdiff_t>(out.size());
  grid.near(middle(all.xmin, all.xmax), middle(all.ymin, all.ymax), half(all.xmin, all.xmax), half(all.ymin, all.ymax),
            out);
  const auto misses = [&](std::uint32_t k) {
    const Bounds& b = boxes[k];
    return b.xmax < box.xmin || b.xmin > box.xmax || b.ymax < box.ymin || b.ymin > box.ymax;
  };
  out.erase(std::remove_if(out.begin() + first, out.end(), misses), out.end());
  std::sort(out.begin() + first, out.end());
}

void PartSearch::note(std::span<const std::uint32_t> slots, const kernels::ReachParams& margin, float ahead) {
  const BodyStore& b = s_.bodies;
  wide_.clear();
  common_way_ = length_of({static_cast<double>(margin.common_x), static_cast<double>(margin.common_y)}) *
                static_cast<double>(margin.time);
  for (const std::uint32_t slot : slots) {
    if (b.kind(b.id[slot]).hull_count < kMany) continue;
    const float rim = b.rim_speed_of(slot), size = b.radius[slot];
    const float skin = margin.of_radius != 0 ? std::min(margin.of_radius * size, margin.skin) : margin.skin;
    wide_.push_back(
        {slot, b.angle_of(slot) + static_cast<double>(ahead) * b.omega_of(slot), skin + std::fabs(rim) * margin.time});
  }
}

void PartSearch::prepare() {
  const ShapeTable& shapes = s_.bodies.hulls;
  if (of_shapes_ != shapes.changes()) grids_.clear();
  of_shapes_ = shapes.changes();
  for (const Wide& w : wide_) {
    const BodyKind& kind = s_.bodies.kind(s_.bodies.id[w.slot]);
    std::unique_ptr<Grid>& grid = grids_[kind.first_hull];
    if (grid == nullptr) grid = std::make_unique<Grid>(s_.memory, std::span(&shapes[kind.first_hull], kind.hull_count));
  }
}

bool PartSearch::serve(float time) const {
  const BodyStore& b = s_.bodies;
  return std::ranges::all_of(wide_, [&](const Wide& w) {
    const double turned_by = std::fabs(b.angle_of(w.slot) - w.angle) * static_cast<double>(b.radius[w.slot]);
    return turned_by + static_cast<double>(std::fabs(b.rim_speed_of(w.slot)) * time) <= static_cast<double>(w.turn);
  });
}

const PartSearch::Wide* PartSearch::wide_of(std::uint32_t slot) const {
  const auto at = std::ranges::lower_bound(wide_, slot, {}, &Wide::slot);
  return at != wide_.end() && at->slot == slot ? &*at : nullptr;
}

const PartSearch::Grid& PartSearch::grid_of(std::uint32_t slot) const {
  return *grids_.at(s_.bodies.kind(s_.bodies.id[slot]).first_hull);
}

// How far a body may go from where the lists were made.
double PartSearch::margin_of(std::uint32_t slot) const {
  return static_cast<double>(s_.bodies.reach[slot]) - static_cast<double>(s_.bodies.radius[slot]);
}

// From one body to another, m, where the lists were made.
Vec2 PartSearch::way(std::uint32_t from, std::uint32_t to) const {
  const auto& built = s_.bodies.built;
  return s_.lattice.metres(wrap_sub(built[2 * std::size_t{to}], built[2 * std::size_t{from}]),
                           wrap_sub(built[2 * std::size_t{to} + 1], built[2 * std::size_t{from} + 1]));
}

void PartSearch::near_body(std::uint32_t slot, std::uint32_t other, std::vector<std::uint32_t>& out) const {
  const Wide& w = *wide_of(slot);
  const Grid& grid = grid_of(slot);
  const Vec2 at = turned(sine_cosine(-w.angle), way(slot, other));
  const double within = static_cast<double>(s_.bodies.reach[other]) + margin_of(slot) + static_cast<double>(w.turn) +
                        kRounding * grid.reach;
  grid.near(grown({at.x, at.y, at.x, at.y}, within), out);
}

void PartSearch::near_part(std::uint32_t slot, std::uint32_t other, std::uint32_t part,
                           std::vector<std::uint32_t>& out) const {
  const Wide &mine = *wide_of(slot), &theirs = *wide_of(other);
  const Grid &grid = grid_of(slot), &of_other = grid_of(other);
  const Bounds there = moved(of_other.boxes[part], sine_cosine(theirs.angle - mine.angle),
                             turned(sine_cosine(-mine.angle), way(slot, other)));
  const double within = margin_of(slot) + margin_of(other) + static_cast<double>(mine.turn + theirs.turn) +
                        kRounding * (grid.reach + of_other.reach);
  grid.near(grown(there, within), out);
}

void PartSearch::near_piece(const StaticPair& pair, const Walls& walls, std::vector<std::uint32_t>& out) const {
  const Wide& w = *wide_of(pair.body);
  const Grid& grid = grid_of(pair.body);
  const double within = margin_of(pair.body) + static_cast<double>(w.turn) + common_way_ + kRounding * grid.reach;
  const std::size_t at = 2 * std::size_t{pair.body};
  const LatticePoint here{s_.bodies.built[at], s_.bodies.built[at + 1], 0, 0};
  if (pair.shape < kWallLeft) {
    const Hull piece = s_.statics.seen_from(pair.shape, here, 4 * (grid.reach + within));
    return grid.near(grown(moved(box_of(piece), sine_cosine(-w.angle), {}), within), out);
  }
  const SineCosine turn = sine_cosine(w.angle);
  const auto [nx, ny, height] = walls.face(pair.shape, here, s_.lattice);
  const Vec2 n{static_cast<double>(nx), static_cast<double>(ny)};
  for (std::uint32_t k = 0; k < grid.boxes.size(); ++k) {
    const Bounds box = moved(grid.boxes[k], turn, {});
    const double low = (n.x > 0 ? box.xmin : box.xmax) * n.x + (n.y > 0 ? box.ymin : box.ymax) * n.y;
    if (static_cast<double>(height) + low <= within) out.push_back(k);
  }
}

}  // namespace psim
