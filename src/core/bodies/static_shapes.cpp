#include "bodies/static_shapes.h"
#include "base/sort_keys.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace psim {
namespace {

// A hashed grid is faster (measured) where a shape shares its cell with more shapes than this on average.
constexpr double kCrowded = 128;

// Cuts a line to the part within `size` of the origin, where the body is.
void cut_to(Vec2 (&ends)[2], double size) {
  const Vec2 begin = ends[0], way = ends[1] - ends[0];
  const double length = length_of(way);
  if (!(length > 2 * size)) return;
  const double along = -dot(begin, way) / length;  // of the body on the line
  const double low = along - size, high = along + size;
  if (high > 0 && high < length) ends[1] = begin + high / length * way;
  if (low > 0 && low < length) ends[0] = begin + low / length * way;
}

}  // namespace

void StaticShapes::put(std::uint32_t number, const StaticShape& shape, const Hull* hull) {
  statics_[number] = shape;
  ++alive_;
  if (hull == nullptr) return;
  std::uint32_t& at = statics_[number].hull;
  if (free_hulls_.empty()) {
    at = static_cast<std::uint32_t>(hulls_.size());
    hulls_.push_back(*hull);
  } else {
    at = free_hulls_.back();
    free_hulls_.pop_back();
    hulls_[at] = *hull;
  }
}

std::uint32_t StaticShapes::add(const StaticShape& shape, const Hull* hull) {
  statics_.reserve(std::size_t{count_} + 1);
  put(count_, shape, hull);
  dirty_ = true;
  return count_++;
}

std::uint32_t StaticShapes::add_sleeping(const Piece* pieces, std::uint32_t count) {
  std::uint32_t first = count_;
  const bool again = count <= kLongestRun && !runs_[count].empty();
  if (again) {
    first = runs_[count].back();
    runs_[count].pop_back();
  } else {
    statics_.reserve(std::size_t{count_} + count);
    count_ += count;
  }
  for (std::uint32_t k = 0; k < count; ++k) {
    const StaticShape& piece = pieces[k].shape;
    put(first + k, piece, piece.whole ? &pieces[k].hull : nullptr);
    statics_[first + k].asleep = true;
    enter(sleepers_, first + k);
  }
  return first;
}

void StaticShapes::make_room(std::uint32_t pieces, std::uint32_t hulls) {
  statics_.reserve(std::size_t{count_} + pieces);
  sleepers_.make_room(count_ + pieces, pieces);
  hulls_.reserve(hulls_.size() + hulls);
}

void StaticShapes::enter(HashGrid& grid, std::uint32_t number) const {
  const StaticShape& s = statics_[number];
  const double px = lattice_->pitch_x(), py = lattice_->pitch_y();
  const std::int32_t way_x = s.segment ? wrap_sub(s.q.x, s.p.x) / 2 : 0;
  const std::int32_t way_y = s.segment ? wrap_sub(s.q.y, s.p.y) / 2 : 0;
  const double round = 2 * px + 2 * py + size_of(s);
  const auto half = [&](std::int32_t way, double pitch) {
    return static_cast<std::uint32_t>(std::fmin(std::abs(way) + round / pitch + 2, 0x1p31));
  };
  grid.insert(number, wrap_add(s.p.x, way_x), wrap_add(s.p.y, way_y), half(way_x, px), half(way_y, py));
}

// The reverse of put().
void StaticShapes::drop(std::uint32_t number) {
  statics_[number].alive = false;
  if (statics_[number].whole) free_hulls_.push_back(statics_[number].hull);
  --alive_;
}

void StaticShapes::remove_sleeping(std::uint32_t first, std::uint32_t count) {
  for (std::uint32_t k = first; k < first + count; ++k) {
    drop(k);
    sleepers_.remove(k);
  }
  left_.emplace_back(first, count);
}

void StaticShapes::remove(std::uint32_t first, std::uint32_t owner) {
  for (std::uint32_t i = first; i < count_ && statics_[i].owner == owner && statics_[i].alive; ++i) drop(i);
  dirty_ = true;
}

Hull StaticShapes::seen_from(std::uint32_t i, const LatticePoint& from, double size) const {
  const StaticShape& s = statics_[i];
  Vec2 ends[2] = {lattice_->way(from, s.p), {}};
  Hull hull;
  if (s.whole) {
    hull = hulls_[s.hull];
    for (int k = 0; k < hull.count; ++k) {
      hull.x[k] = static_cast<float>(static_cast<double>(hull.x[k]) + ends[0].x);
      hull.y[k] = static_cast<float>(static_cast<double>(hull.y[k]) + ends[0].y);
    }
    return hull;
  }
  hull.radius = s.radius;
  hull.count = s.segment ? 2 : 1;
  if (s.segment) {
    ends[1] = lattice_->way(from, s.q);
    cut_to(ends, size);
  }
  for (int k = 0; k < hull.count; ++k) {
    hull.x[k] = static_cast<float>(ends[k].x);
    hull.y[k] = static_cast<float>(ends[k].y);
  }
  finish_hull(hull);
  return hull;
}

const StaticShape* StaticShapes::chain_neighbour(std::uint32_t i, bool forward) const {
  const StaticShape& s = statics_[i];
  const auto of_chain = [&](std::uint32_t k) {
    return k < count_ && statics_[k].alive && statics_[k].owner == s.owner && statics_[k].segment && !statics_[k].face;
  };
  const auto goes_on = [&](const StaticShape& o) {
    const LatticePoint &mine = forward ? s.q : s.p, &other = forward ? o.p : o.q;
    return mine.x == other.x && mine.y == other.y && mine.dx == other.dx && mine.dy == other.dy;
  };
  if (!of_chain(i)) return nullptr;
  std::uint32_t k = forward ? i + 1 : i - 1;
  if (!of_chain(k)) {  // a loop goes on from its last segment to its first
    k = i;
    while (of_chain(forward ? k - 1 : k + 1)) k = forward ? k - 1 : k + 1;
  }
  return k != i && goes_on(statics_[k]) ? &statics_[k] : nullptr;
}

StaticShapes::Cells StaticShapes::cells_of(const Bounds& box) const {
  const auto clamp = [](double c, std::int64_t n) {
    if (!(c > 0)) return std::int64_t{0};
    return c >= static_cast<double>(n - 1) ? n - 1 : static_cast<std::int64_t>(c);
  };
  return {clamp((box.xmin - origin_x_) / cell_, cols_), clamp((box.xmax - origin_x_) / cell_, cols_),
          clamp((box.ymin - origin_y_) / cell_, rows_), clamp((box.ymax - origin_y_) / cell_, rows_)};
}

bool StaticShapes::meets_grid(const Bounds& box) const {
  return cols_ != 0 && box.xmax >= origin_x_ && box.ymax >= origin_y_ &&
         box.xmin <= origin_x_ + static_cast<double>(cols_) * cell_ &&
         box.ymin <= origin_y_ + static_cast<double>(rows_) * cell_;
}

void StaticShapes::build_grid() {
  for (const auto& [first, count] : left_) {
    if (count <= kLongestRun) runs_[count].push_back(first);
  }
  left_.clear();
  if (!dirty_) return;
  dirty_ = false;
  make_grid();
}

// Puts the shapes of static bodies into the hashed grid, because the cells of the other one are crowded.
void StaticShapes::hash_standing() {
  cols_ = rows_ = 0;
  for (std::uint32_t i = 0; i < count_; ++i) {
    if (statics_[i].alive && !statics_[i].asleep) enter(standing_, i);
  }
}

// A slanted segment takes only the cells near its line in each row.
void StaticShapes::narrow_row(const StaticShape& s, std::int64_t row, std::int64_t& first, std::int64_t& last) const {
  const double px = s.p.x * lattice_->pitch_x(), py = s.p.y * lattice_->pitch_y();
  const double qx = s.q.x * lattice_->pitch_x(), qy = s.q.y * lattice_->pitch_y();
  const double y0 = origin_y_ + static_cast<double>(row) * cell_ - cell_ * 0.01;
  const double y1 = y0 + cell_ * 1.02;
  const double t0 = std::clamp((y0 - py) / (qy - py), 0.0, 1.0);
  const double t1 = std::clamp((y1 - py) / (qy - py), 0.0, 1.0);
  const double xa = px + t0 * (qx - px), xb = px + t1 * (qx - px);
  const double round = static_cast<double>(s.radius);
  const Cells narrow =
      cells_of({std::fmin(xa, xb) - cell_ * 0.01 - round, y0, std::fmax(xa, xb) + cell_ * 0.01 + round, y1});
  first = narrow.first_col;
  last = narrow.last_col;
}

void StaticShapes::make_grid() {
  cols_ = rows_ = 0;
  standing_.clear();
  const auto stands = [&](std::uint32_t i) { return statics_[i].alive && !statics_[i].asleep; };
  std::size_t standing = 0;
  Bounds all{1e300, 1e300, -1e300, -1e300};
  double extent_sum = 0;
  for (std::uint32_t i = 0; i < count_; ++i) {
    if (!stands(i)) continue;
    ++standing;
    const Bounds b = box_of(statics_[i]);
    all = {std::fmin(all.xmin, b.xmin), std::fmin(all.ymin, b.ymin), std::fmax(all.xmax, b.xmax),
           std::fmax(all.ymax, b.ymax)};
    extent_sum += std::fmax(b.xmax - b.xmin, b.ymax - b.ymin);
  }
  if (standing == 0) return;
  const double width = std::fmax(all.xmax - all.xmin, 1e-9), height = std::fmax(all.ymax - all.ymin, 1e-9);
  const double n = static_cast<double>(standing);
  // There are about four cells for each shape, and no cell is smaller than a quarter of the mean shape.
  cell_ = std::fmax(std::sqrt(width * height / (4 * n + 16)), extent_sum / n / 4);
  cell_ = std::fmax(cell_, std::fmax(width, height) / 30000);
  origin_x_ = all.xmin;
  origin_y_ = all.ymin;
  cols_ = static_cast<std::int64_t>(width / cell_) + 1;
  rows_ = static_cast<std::int64_t>(height / cell_) + 1;
  const auto cells = static_cast<std::size_t>(cols_ * rows_);
  cell_start_.reserve(cells + 1);
  std::fill(cell_start_.data(), cell_start_.data() + cells + 1, 0u);
  const auto visit = [&](auto&& each) {
    for (std::uint32_t i = 0; i < count_; ++i) {
      if (!stands(i)) continue;
      const Cells r = cells_of(box_of(statics_[i]));
      const bool slanted = statics_[i].segment && r.last_row > r.first_row && r.last_col > r.first_col;
      for (std::int64_t row = r.first_row; row <= r.last_row; ++row) {
        std::int64_t c0 = r.first_col, c1 = r.last_col;
        if (slanted) narrow_row(statics_[i], row, c0, c1);
        for (std::int64_t c = c0; c <= c1; ++c) each(static_cast<std::size_t>(row * cols_ + c), i);
      }
    }
  };
  visit([&](std::size_t cell, std::uint32_t) { ++cell_start_[cell + 1]; });
  double sum = 0, squares = 0;
  for (std::size_t c = 1; c <= cells; ++c) {
    const double here = cell_start_[c];
    sum += here;
    squares += here * here;
  }
  if (squares > kCrowded * sum) return hash_standing();
  for (std::size_t c = 0; c < cells; ++c) cell_start_[c + 1] += cell_start_[c];
  cell_shape_.reserve(cell_start_[cells]);
  visit([&](std::size_t cell, std::uint32_t i) { cell_shape_[cell_start_[cell]++] = i; });
  for (std::size_t c = cells; c > 0; --c) cell_start_[c] = cell_start_[c - 1];
  cell_start_[0] = 0;
}

// Whether a square of half width `reach` at (x, y) lies beside the line that a segment is a part of.
bool StaticShapes::beside(const StaticShape& s, double x, double y, double reach) const {
  if (!s.segment) return false;
  const double px = s.p.x * lattice_->pitch_x(), py = s.p.y * lattice_->pitch_y();
  const double ux = s.q.x * lattice_->pitch_x() - px, uy = s.q.y * lattice_->pitch_y() - py;
  const double far = reach + static_cast<double>(s.radius) + 2 * lattice_->pitch_x() + 2 * lattice_->pitch_y();
  return std::fabs(ux * (y - py) - uy * (x - px)) > far * (std::fabs(ux) + std::fabs(uy));
}

bool StaticShapes::surely_none(const Bounds& box) const {
  constexpr std::int64_t kMostRows = 64;
  if (!standing_.empty() || !sleepers_.empty()) return false;
  if (!meets_grid(box)) return true;
  const Cells cells = cells_of(box);
  if (cells.last_row - cells.first_row >= kMostRows) return false;
  for (std::int64_t row = cells.first_row; row <= cells.last_row; ++row) {
    const std::uint32_t* const start = cell_start_.data() + row * cols_;
    if (start[cells.first_col] != start[cells.last_col + 1]) return false;
  }
  return true;
}

void StaticShapes::near(std::int32_t x, std::int32_t y, float reach, std::vector<std::uint32_t>& out) const {
  const double px = lattice_->pitch_x(), py = lattice_->pitch_y();
  const double mx = x * px, my = y * py;
  const double r = static_cast<double>(reach);
  const std::size_t from = out.size();
  const Bounds square{mx - r, my - r, mx + r, my + r};
  const auto steps = [&](double pitch) { return static_cast<std::uint32_t>(std::fmin(r / pitch + 1, 0x1p31)); };
  const auto apart = [&](std::uint32_t i) {
    if (!whole_wanted_ && statics_[i].whole) return true;
    const Bounds box = box_of(statics_[i]);
    return box.xmin > square.xmax || box.xmax < square.xmin || box.ymin > square.ymax || box.ymax < square.ymin;
  };
  // Drops those of the shapes found since `begin` that the test names.
  const auto drop = [&out](std::size_t begin, const auto& test) {
    out.erase(std::remove_if(out.begin() + static_cast<std::ptrdiff_t>(begin), out.end(), test), out.end());
  };
  if (!standing_.empty()) {
    standing_.near(x, y, steps(px), steps(py), out);
    drop(from, [&](std::uint32_t i) { return apart(i) || beside(statics_[i], mx, my, r); });
  } else if (meets_grid(square)) {
    const Cells cells = cells_of(square);
    for (std::int64_t row = cells.first_row; row <= cells.last_row; ++row) {
      for (std::int64_t c = cells.first_col; c <= cells.last_col; ++c) {
        const auto cell = static_cast<std::size_t>(row * cols_ + c);
        out.insert(out.end(), cell_shape_.data() + cell_start_[cell], cell_shape_.data() + cell_start_[cell + 1]);
      }
    }
    drop(from, apart);
  }
  if (!sleepers_.empty()) {
    const std::size_t standing = out.size();
    sleepers_.near(x, y, steps(px), steps(py), out);
    drop(standing, [&](std::uint32_t i) {  // as seen from the body: in a periodic world one may lie beyond the seam
      const StaticShape& s = statics_[i];
      if (!whole_wanted_ && s.whole) return true;
      const double ax = wrap_sub(s.p.x, x) * px, ay = wrap_sub(s.p.y, y) * py;
      const double bx = s.segment ? ax + wrap_sub(s.q.x, s.p.x) * px : ax;
      const double by = s.segment ? ay + wrap_sub(s.q.y, s.p.y) * py : ay;
      const double far = r + 2 * px + 2 * py + size_of(s);
      return std::fmin(ax, bx) > far || std::fmax(ax, bx) < -far || std::fmin(ay, by) > far || std::fmax(ay, by) < -far;
    });
  }
  const auto first = out.begin() + static_cast<std::ptrdiff_t>(from);
  if (out.end() - first < 2) return;
  sort_keys(first, out.end());
  out.erase(std::unique(first, out.end()), out.end());
}

}  // namespace psim
