#include "bodies/static_shapes.h"
#include "base/elementary.h"
#include "base/sort_keys.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>

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

std::uint32_t steps_of(double steps) { return static_cast<std::uint32_t>(lesser(steps, 0x1p31)); }

// The ratio of the pitches as the nearest power of two.
int shift_of(const Lattice& lattice) { return std::ilogb(lattice.pitch_x() / lattice.pitch_y() / 0.75); }

}  // namespace

StaticShapes::StaticShapes(MemoryMeter& meter, const Lattice& lattice)
    : cell_start_(meter),
      cell_shape_(meter),
      statics_(meter),
      sleepers_(meter, shift_of(lattice)),
      standing_(meter, shift_of(lattice)),
      lattice_(&lattice) {}

void StaticShapes::put(std::uint32_t number, const Piece& piece) {
  statics_[number] = piece.shape;
  ++alive_;
  if (!piece.shape.whole) return;
  std::uint32_t& at = statics_[number].hull;
  if (free_hulls_.empty()) {
    at = static_cast<std::uint32_t>(hulls_.size());
    hulls_.push_back(piece.hull);
  } else {
    at = free_hulls_.back();
    free_hulls_.pop_back();
    hulls_[at] = piece.hull;
  }
}

// Numbers for the pieces of a body that are free, else new ones. Among the longer runs the one that fits best is cut.
std::uint32_t StaticShapes::take_numbers(std::uint32_t count) {
  std::uint32_t first = count_;
  auto gap = gaps_.end();
  for (auto run = gaps_.begin(); count > kLongestRun && run != gaps_.end(); ++run) {
    if (run->second >= count && (gap == gaps_.end() || run->second < gap->second)) gap = run;
  }
  if (gap != gaps_.end()) {
    first = gap->first;
    gap->first += count;
    gap->second -= count;
    if (gap->second == 0) gaps_.erase(gap);
  } else if (count <= kLongestRun && !runs_[count].empty()) {
    first = runs_[count].back();
    runs_[count].pop_back();
  } else {
    statics_.reserve(std::size_t{count_} + count);
    count_ += count;
  }
  return first;
}

std::uint32_t StaticShapes::add(const std::vector<Piece>& pieces) {
  const auto count = static_cast<std::uint32_t>(pieces.size());
  const std::uint32_t first = take_numbers(count);
  for (std::uint32_t k = 0; k < count; ++k) put(first + k, pieces[k]);
  dirty_ = true;
  return first;
}

std::uint32_t StaticShapes::add_sleeping(const std::vector<Piece>& pieces) {
  const auto count = static_cast<std::uint32_t>(pieces.size());
  const std::uint32_t first = take_numbers(count);
  for (std::uint32_t k = 0; k < count; ++k) {
    put(first + k, pieces[k]);
    statics_[first + k].asleep = true;
    enter(sleepers_, first + k);
  }
  return first;
}

void StaticShapes::reserve(std::size_t pieces) {
  while (!gone_.empty() && gone_.back().first >= listed_) {
    set_free(gone_.back().first, gone_.back().second);
    gone_.pop_back();
  }
  join_gaps();
  statics_.reserve(count_ + pieces);
  const std::size_t hulls = hulls_.size() + pieces;
  if (hulls > hulls_.capacity()) hulls_.reserve(std::max(hulls, 2 * hulls_.size()));
  free_hulls_.reserve(hulls_.capacity());
}

void StaticShapes::make_room(std::uint32_t pieces, std::uint32_t hulls) {
  statics_.reserve(std::size_t{count_} + pieces);
  sleepers_.make_room(count_ + pieces, pieces);
  const std::size_t all = hulls_.size() + hulls;
  if (all > hulls_.capacity()) hulls_.reserve(std::max(all, 2 * hulls_.size()));
}

// The box of a piece, wider by `far`, m, on each side.
StaticShapes::LatticeBox StaticShapes::around(std::uint32_t number, double far) const {
  const StaticShape& s = statics_[number];
  const std::int32_t way_x = s.segment ? wrap_sub(s.q.x, s.p.x) / 2 : 0;
  const std::int32_t way_y = s.segment ? wrap_sub(s.q.y, s.p.y) / 2 : 0;
  const Bounds e = extent_of(s);
  const auto half = [&](double room, std::int32_t way, double pitch) {
    return steps_of((room + far) / pitch + 2 + std::abs(way));
  };
  return {wrap_add(s.p.x, way_x), wrap_add(s.p.y, way_y), half(greater(-e.xmin, e.xmax), way_x, lattice_->pitch_x()),
          half(greater(-e.ymin, e.ymax), way_y, lattice_->pitch_y())};
}

void StaticShapes::enter(HashGrid& grid, std::uint32_t number) const {
  const LatticeBox box = around(number, 0);
  grid.insert(number, box.x, box.y, box.half_x, box.half_y);
}

void StaticShapes::sleepers_near(std::uint32_t number, double far, std::vector<std::uint32_t>& out) const {
  const LatticeBox box = around(number, far);
  sleepers_.near(box.x, box.y, box.half_x, box.half_y, out);
}

// The reverse of put().
void StaticShapes::drop(std::uint32_t number) {
  statics_[number].alive = false;
  if (statics_[number].whole) free_hulls_.push_back(statics_[number].hull);
  --alive_;
}

void StaticShapes::make_room_to_leave(std::size_t bodies, bool fixed) {
  free_hulls_.reserve(hulls_.capacity());
  std::vector<Run>& runs = fixed ? gone_ : left_;
  const std::size_t size = runs.size() + bodies;
  if (size > runs.capacity()) runs.reserve(2 * size);
}

void StaticShapes::lift_sleeping(std::uint32_t first, std::uint32_t count) {
  for (std::uint32_t k = first; k < first + count; ++k) sleepers_.remove(k);
}

void StaticShapes::lay_back(std::uint32_t first, std::uint32_t count) {
  for (std::uint32_t k = first; k < first + count; ++k) enter(sleepers_, k);
}

void StaticShapes::drop_lifted(std::uint32_t first, std::uint32_t count) {
  for (std::uint32_t k = first; k < first + count; ++k) drop(k);
  left_.emplace_back(first, count);
}

void StaticShapes::remove(std::uint32_t first, std::uint32_t owner) {
  std::uint32_t end = first;
  for (; end < count_ && statics_[end].owner == owner && statics_[end].alive; ++end) drop(end);
  if (end != first) gone_.emplace_back(first, end - first);
  dirty_ = true;
}

Hull StaticShapes::seen_from(std::uint32_t i, const LatticePoint& from, double size) const {
  const StaticShape& s = statics_[i];
  const Vec2 p = lattice_->way(from, s.p);
  if (s.whole) {
    Hull hull = hulls_[s.hull];
    for (int k = 0; k < hull.count; ++k) hull.set_vertex(k, hull.vertex(k) + p);
    return hull;
  }
  Vec2 ends[2] = {p, s.segment ? lattice_->way(from, s.q) : p};
  cut_to(ends, size);
  Hull hull;
  hull.radius = s.radius;
  hull.count = s.segment ? 2 : 1;
  for (int k = 0; k < hull.count; ++k) hull.set_vertex(k, ends[k]);
  finish_hull(hull);
  return hull;
}

StaticShapes::Cells StaticShapes::cells_of(const Bounds& box) const {
  const auto clamp = [](double c, std::int64_t n) {
    if (!(c > 0)) return std::int64_t{0};
    return c >= static_cast<double>(n - 1) ? n - 1 : static_cast<std::int64_t>(c);
  };
  return {clamp((box.xmin - origin_x_) / cell_, cols_), clamp((box.xmax - origin_x_) / cell_, cols_),
          clamp((box.ymin - origin_y_) / cell_, rows_), clamp((box.ymax - origin_y_) / cell_, rows_)};
}

// The cells of a row that a shape may meet: a slanted segment takes only those near its line.
StaticShapes::Cells StaticShapes::cells_of(const StaticShape& s, std::int64_t row) const {
  const Vec2 p = metres(s.p), q = metres(s.q);
  const double slack = cell_ * 0.01, round = s.radius;
  const double y0 = origin_y_ + static_cast<double>(row) * cell_ - slack, y1 = y0 + cell_ * 1.02;
  const auto crossing = [&](double y) { return p.x + std::clamp((y - p.y) / (q.y - p.y), 0.0, 1.0) * (q.x - p.x); };
  const double xa = crossing(y0 - round), xb = crossing(y1 + round);
  return cells_of({lesser(xa, xb) - slack - round, y0, greater(xa, xb) + slack + round, y1});
}

bool StaticShapes::meets_grid(const Bounds& box) const {
  const auto width = static_cast<double>(cols_) * cell_, height = static_cast<double>(rows_) * cell_;
  return cols_ != 0 && overlap(box, {origin_x_, origin_y_, origin_x_ + width, origin_y_ + height});
}

// Nobody has these numbers any more, and no list names them.
void StaticShapes::set_free(std::uint32_t first, std::uint32_t count) {
  if (count <= kLongestRun) {
    runs_[count].push_back(first);
  } else {
    gaps_.emplace_back(first, count);
  }
}

void StaticShapes::join_gaps() {
  const auto meet = [](const Run& a, const Run& b) { return a.first + a.second >= b.first; };
  if (std::adjacent_find(gaps_.begin(), gaps_.end(), meet) == gaps_.end()) return;
  std::ranges::sort(gaps_);  // total order: no two have the same first number
  auto last = gaps_.begin();
  for (auto next = last + 1; next != gaps_.end(); ++next) {
    if (last->first + last->second == next->first) {
      last->second += next->second;
    } else {
      *++last = *next;
    }
  }
  gaps_.erase(last + 1, gaps_.end());
}

void StaticShapes::build_grid() {
  for (std::vector<Run>* runs : {&left_, &gone_}) {
    for (const auto& [first, count] : *runs) set_free(first, count);
    runs->clear();
  }
  join_gaps();
  listed_ = count_;
  if (!dirty_) return;
  dirty_ = false;
  make_grid();
}

void StaticShapes::make_grid() {
  cols_ = rows_ = 0;
  standing_.clear();
  std::vector<std::uint32_t> standing;
  Bounds all{1e300, 1e300, -1e300, -1e300};
  double extent_sum = 0;
  for (std::uint32_t i = 0; i < count_; ++i) {
    if (!statics_[i].alive || statics_[i].asleep) continue;
    standing.push_back(i);
    const Bounds b = box_of(statics_[i]);
    all = {lesser(all.xmin, b.xmin), lesser(all.ymin, b.ymin), greater(all.xmax, b.xmax), greater(all.ymax, b.ymax)};
    extent_sum += greater(b.xmax - b.xmin, b.ymax - b.ymin);
  }
  if (standing.empty()) return;
  const double width = greater(all.xmax - all.xmin, 1e-9), height = greater(all.ymax - all.ymin, 1e-9);
  const double n = static_cast<double>(standing.size());
  // There are about four cells for each shape, and no cell is smaller than a quarter of the mean shape.
  cell_ = greater(std::sqrt(width * height / (4 * n + 16)), extent_sum / n / 4);
  cell_ = greater(greater(width, height) / 30000, cell_);
  origin_x_ = all.xmin;
  origin_y_ = all.ymin;
  cols_ = static_cast<std::int64_t>(width / cell_) + 1;
  rows_ = static_cast<std::int64_t>(height / cell_) + 1;
  if (!lattice_->wraps() && fill_cells(standing)) return;
  cols_ = rows_ = 0;
  for (const std::uint32_t i : standing) enter(standing_, i);
}

// Sorts shapes into the cells of the grid. False if these are crowded.
bool StaticShapes::fill_cells(const std::vector<std::uint32_t>& standing) {
  const auto visit = [&](auto&& each) {
    for (const std::uint32_t i : standing) {
      const StaticShape& s = statics_[i];
      const Cells all = cells_of(box_of(s));
      const bool slanted = s.segment && all.last_row > all.first_row && all.last_col > all.first_col;
      for (std::int64_t row = all.first_row; row <= all.last_row; ++row) {
        const Cells here = slanted ? cells_of(s, row) : all;
        const std::int64_t first = row * cols_ + here.first_col, last = row * cols_ + here.last_col;
        for (std::int64_t cell = first; cell <= last; ++cell) each(static_cast<std::size_t>(cell), i);
      }
    }
  };
  // The shapes of cell c begin at cell_start_[c]. Until they are all there cell_start_[c + 1] says where the next one
  // goes.
  const auto cells = static_cast<std::size_t>(cols_ * rows_);
  cell_start_.reserve(cells + 2);
  std::uint32_t* const start = cell_start_.data();
  std::fill_n(start, cells + 2, 0u);
  visit([&](std::size_t cell, std::uint32_t) { ++start[cell + 2]; });
  double sum = 0, squares = 0;
  for (std::size_t c = 0; c < cells; ++c) {
    const double here = start[c + 2];
    sum += here;
    squares += here * here;
  }
  if (squares > kCrowded * sum) return false;
  std::partial_sum(start, start + cells + 2, start);
  cell_shape_.reserve(start[cells + 1]);
  visit([&](std::size_t cell, std::uint32_t i) { cell_shape_[start[cell + 1]++] = i; });
  return true;
}

// Whether a square of half width `reach` lies beside the line that a segment is a part of.
bool StaticShapes::beside(const StaticShape& s, Vec2 at, double reach) const {
  if (!s.segment) return false;
  const Vec2 p = metres(s.p), u = metres(s.q) - p;
  const double far = reach + s.radius + 2 * lattice_->pitch_x() + 2 * lattice_->pitch_y();
  return std::fabs(cross(u, at - p)) > far * (std::fabs(u.x) + std::fabs(u.y));
}

bool StaticShapes::is_inside(const StaticShape& whole, const LatticePoint& at) const {
  const Hull& hull = hulls_[whole.hull];
  const Vec2 way = lattice_->steps(whole.p, at);
  for (int k = 0; k < hull.count; ++k) {
    const Vec2 normal{hull.nx[k], hull.ny[k]};
    if (dot(normal, way - hull.vertex(k)) > 0) return false;
  }
  return true;
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
  const Vec2 m = lattice_->metres(x, y);
  const double r = reach;
  const auto from = static_cast<std::ptrdiff_t>(out.size());
  const Bounds square{m.x - r, m.y - r, m.x + r, m.y + r};
  const auto find_in = [&](const HashGrid& grid) { grid.near(x, y, steps_of(r / px + 1), steps_of(r / py + 1), out); };
  // Drops those of the shapes found since `begin` that are not wanted or that the test names. The edges of a polygon are
  // all there if the place is inside.
  const auto drop = [&](std::ptrdiff_t begin, const auto& test) {
    const auto end = static_cast<std::ptrdiff_t>(out.size());
    for (std::ptrdiff_t k = begin; k < end; ++k) {
      const std::uint32_t whole = out[static_cast<std::size_t>(k)];
      const StaticShape& s = statics_[whole];
      if (!s.whole || !is_inside(s, {x, y})) continue;
      for (std::uint32_t edge = whole; edge-- != 0 && statics_[edge].face && statics_[edge].owner == s.owner;) {
        out.push_back(edge);
      }
    }
    const auto gone = [&](std::uint32_t i) { return (statics_[i].whole && !whole_wanted_) || test(statics_[i]); };
    out.erase(std::remove_if(out.begin() + begin, out.begin() + end, gone), out.begin() + end);
  };
  // Ways are measured from the place, so that they cross a periodic seam.
  const auto beyond = [&](const StaticShape& s) {
    const Vec2 a = lattice_->steps({x, y}, s.p), b = s.segment ? a + lattice_->steps(s.p, s.q) : a;
    const Bounds e = extent_of(s);
    return lesser(a.x, b.x) + e.xmin > r || greater(a.x, b.x) + e.xmax < -r || lesser(a.y, b.y) + e.ymin > r ||
           greater(a.y, b.y) + e.ymax < -r;
  };
  const auto apart = [&](const StaticShape& s) { return !overlap(box_of(s), square); };
  if (!standing_.empty()) {
    find_in(standing_);
    if (lattice_->wraps()) {
      drop(from, beyond);
    } else {
      drop(from, [&](const StaticShape& s) { return apart(s) || beside(s, m, r); });
    }
  } else if (meets_grid(square)) {
    const Cells cells = cells_of(square);
    for (std::int64_t row = cells.first_row; row <= cells.last_row; ++row) {
      const std::uint32_t* const start = cell_start_.data() + row * cols_;
      out.insert(out.end(), cell_shape_.data() + start[cells.first_col],
                 cell_shape_.data() + start[cells.last_col + 1]);
    }
    drop(from, apart);
  }
  if (!sleepers_.empty()) {
    const auto standing = static_cast<std::ptrdiff_t>(out.size());
    find_in(sleepers_);
    drop(standing, beyond);
  }
  const auto first = out.begin() + from;
  if (out.end() - first < 2) return;
  sort_keys(first, out.end());
  out.erase(std::unique(first, out.end()), out.end());
}

void StaticShapes::near_way(const LatticePoint& place, Vec2 offset, Vec2 way, float radius,
                            std::vector<std::uint32_t>& out) const {
  // Bounded, since a body thrown out of the world may have moved by any amount.
  const auto steps = [](double d, double pitch) {
    return static_cast<std::int32_t>(lesser(greater(std::nearbyint(d / pitch), -0x1p30), 0x1p30));
  };
  const Vec2 middle = offset + 0.5 * way;
  near(wrap_add(place.x, steps(middle.x, lattice_->pitch_x())), wrap_add(place.y, steps(middle.y, lattice_->pitch_y())),
       static_cast<float>(double{radius} + 0.5 * length_of(way)), out);
}

}  // namespace psim
