#include "lists/common_motion.h"

#include <algorithm>
#include <cmath>

#include "base/elementary.h"

namespace psim {
namespace {

constexpr std::uint32_t kSample = 8;  // one body in so many is looked at
constexpr std::uint32_t kLeast = 3;   // of these tell what a region has in common
constexpr double kPacked = 0.4;       // share of its area that bodies of a packed region cover, at least

template <class Number>
Number length(Number x, Number y) {
  return std::sqrt(x * x + y * y);
}
double length(Vec2 v) { return length(v.x, v.y); }

}  // namespace

// ---- the regions

double CommonMotion::edge(int axis) const {
  return static_cast<double>(1u << grid_.shift[axis]) * (axis == 0 ? s_.lattice.pitch_x() : s_.lattice.pitch_y());
}
double CommonMotion::shorter_edge() const { return lesser(edge(0), edge(1)); }
std::size_t CommonMotion::most_regions() const { return 64 + b_.count / 8; }

bool CommonMotion::cut(double least_edge) {
  stop();
  std::int32_t box[4] = {INT32_MAX, INT32_MAX, INT32_MIN, INT32_MIN};
  s_.kernels.extent(b_.pos.data(), box, 0, b_.blocks());
  Grid g;
  std::uint32_t n[2];
  for (const int axis : {0, 1}) {
    const double pitch = axis == 0 ? s_.lattice.pitch_x() : s_.lattice.pitch_y();
    std::uint32_t& shift = g.shift[axis];
    for (shift = 1; shift < 31 && static_cast<double>(1u << shift) * pitch < least_edge;) ++shift;
    g.low[axis] = box[axis];
    n[axis] = (static_cast<std::uint32_t>(wrap_sub(box[axis + 2], box[axis])) >> shift) + 1;
  }
  if (static_cast<double>(n[0]) * n[1] > static_cast<double>(most_regions())) return false;
  g.columns = n[0], g.rows = n[1];
  grid_ = g;
  counted_ = false;
  return true;
}

std::size_t CommonMotion::index_of(const std::int32_t* place) const {
  const auto at = [&](int axis) {
    return static_cast<std::uint32_t>(wrap_sub(place[axis], grid_.low[axis])) >> grid_.shift[axis];
  };
  const std::uint32_t column = at(0), row = at(1);
  if (column >= grid_.columns || row >= grid_.rows) return std::size_t{grid_.columns} * grid_.rows;
  return std::size_t{row} * grid_.columns + column;
}

// Calls each(region) for a region and those beside it.
template <class Each>
void CommonMotion::each_beside(std::size_t region, const Each& each) const {
  const std::uint32_t columns = grid_.columns, rows = grid_.rows;
  const bool round_x = columns == along(grid_.shift[0]), round_y = rows == along(grid_.shift[1]);
  const auto x = static_cast<std::uint32_t>(region % columns), y = static_cast<std::uint32_t>(region / columns);
  for (std::uint32_t dy = 0; dy < 3; ++dy) {
    for (std::uint32_t dx = 0; dx < 3; ++dx) {
      std::uint32_t u = x + dx - 1, v = y + dy - 1;  // what is before 0 is not below the number of them
      if (round_x && u >= columns) u = dx == 0 ? columns - 1 : 0;
      if (round_y && v >= rows) v = dy == 0 ? rows - 1 : 0;
      if (u < columns && v < rows) each(std::size_t{v} * columns + u);
    }
  }
}

void CommonMotion::count(const std::int32_t* places) {
  regions_.assign(std::size_t{grid_.columns} * grid_.rows + 1, {});
  for (std::size_t i = 0; i < b_.count; ++i) {
    if (b_.id[i] != kNoSlot) ++regions_[index_of(places + 2 * i)].members;
  }
  counted_ = true;
}

void CommonMotion::move_member(const std::int32_t* from, const std::int32_t* to) {
  if (!counted_) return;
  --regions_[index_of(from)].members;
  ++regions_[index_of(to)].members;
}

// ---- what is common

void CommonMotion::find_means(const std::int32_t* places) {
  sums_.assign(regions_.size(), {});
  for (std::size_t i = 0; i < b_.count; i += kSample) {
    if (b_.id[i] == kNoSlot) continue;
    Sum& s = sums_[index_of(places + 2 * i)];
    s.x += wrap_sub(b_.pos[2 * i], places[2 * i]);
    s.y += wrap_sub(b_.pos[2 * i + 1], places[2 * i + 1]);
    s.vx += static_cast<double>(b_.vel[2 * i]);
    s.vy += static_cast<double>(b_.vel[2 * i + 1]);
    s.area += 3.14159 * static_cast<double>(b_.radius[i]) * static_cast<double>(b_.radius[i]);
    ++s.n;
  }
  for (std::size_t k = 0; k < regions_.size(); ++k) {
    Region& r = regions_[k];
    const Sum& s = sums_[k];
    const std::uint32_t members = r.members;
    r = {};
    r.members = members;
    if (k + 1 == regions_.size() || s.n < kLeast) continue;
    r.packed = s.area / s.n * members >= kPacked * edge(0) * edge(1);
    if (!r.packed) continue;
    const auto n = static_cast<std::int64_t>(s.n);
    r.x = static_cast<std::int32_t>(s.x / n), r.y = static_cast<std::int32_t>(s.y / n);
    r.vx = static_cast<float>(s.vx / s.n), r.vy = static_cast<float>(s.vy / s.n);
  }
}

// Regions that are not packed move as those beside them do that are.
void CommonMotion::spread() {
  for (std::size_t k = 0; k + 1 < regions_.size(); ++k) {
    Region& r = regions_[k];
    if (r.packed) continue;
    Sum s;
    each_beside(k, [&](std::size_t other) {
      const Region& o = regions_[other];
      if (!o.packed) return;
      s.x += o.x, s.y += o.y;
      s.vx += static_cast<double>(o.vx), s.vy += static_cast<double>(o.vy);
      ++s.n;
    });
    if (s.n == 0) continue;
    const auto n = static_cast<std::int64_t>(s.n);
    r.x = static_cast<std::int32_t>(s.x / n), r.y = static_cast<std::int32_t>(s.y / n);
    r.vx = static_cast<float>(s.vx / s.n), r.vy = static_cast<float>(s.vy / s.n);
  }
}

void CommonMotion::compare() {
  Vec2 low, high;
  double fastest = 0;
  for (std::size_t k = 0; k + 1 < regions_.size(); ++k) {
    Region& r = regions_[k];
    const Vec2 way = way_of(r);
    low = {lesser(low.x, way.x), lesser(low.y, way.y)};
    high = {greater(high.x, way.x), greater(high.y, way.y)};
    fastest = greater(fastest, static_cast<double>(length(r.vx, r.vy)));
    double apart = 0;
    float parting = 0;
    each_beside(k, [&](std::size_t other) {
      const Region& o = regions_[other];
      if (o.members == 0 && r.members != 0) return;
      apart = greater(apart, length(way - way_of(o)));
      parting = greater(parting, length(r.vx - o.vx, r.vy - o.vy));
    });
    // A body that comes into an empty region bears alone what the ways there differ by: bodies beside it did not allow for it.
    const float share = r.members != 0 ? 0.5f : 1.0f;
    r.apart = share * static_cast<float>(apart);
    r.parting = share * parting;
  }
  // Bodies outside all regions do so, too; they have no way in common.
  differ_ = length(high - low);
  regions_.back().apart = static_cast<float>(differ_);
  regions_.back().parting = static_cast<float>(fastest);
}

// Nothing fixed is within an edge of most regions; their bodies may go three quarters of that.
void CommonMotion::find_room(const Fixed& fixed, double beside) {
  const double clear = shorter_edge();
  for (std::size_t k = 0; k < regions_.size(); ++k) {
    Region& r = regions_[k];
    r.room = static_cast<float>(beside);
    if (k + 1 == regions_.size() || r.members == 0) continue;
    const auto column = static_cast<std::uint32_t>(k % grid_.columns),
               row = static_cast<std::uint32_t>(k / grid_.columns);
    const auto begin = [&](int axis, std::uint32_t number) {
      return wrap_add(grid_.low[axis], static_cast<std::int32_t>(number << grid_.shift[axis]));
    };
    const Vec2 low = s_.lattice.metres(begin(0, column), begin(1, row));
    const Bounds box{low.x - clear, low.y - clear, low.x + edge(0) + clear, low.y + edge(1) + clear};
    const Bounds& all = fixed.bounds;
    if (fixed.walls && (box.xmin < all.xmin || box.ymin < all.ymin || box.xmax > all.xmax || box.ymax > all.ymax)) {
      continue;
    }
    if (!s_.statics.any() || s_.statics.surely_none(box)) r.room = static_cast<float>(0.75 * clear);
  }
}

bool CommonMotion::serve() const {
  const auto too_far = [&](const Region& r) {
    return r.members != 0 && length(way_of(r)) > static_cast<double>(r.room);
  };
  return differ_ <= shorter_edge() / 2 && std::ranges::none_of(regions_, too_far);
}

bool CommonMotion::update(const std::int32_t* places, const Fixed& fixed, double beside) {
  if (!counted_) count(places);
  find_means(places);
  spread();
  compare();
  find_room(fixed, beside);
  return serve();
}

// ---- a body

float CommonMotion::use(std::uint32_t slot, const std::int32_t* place, float time) const {
  const std::size_t i = slot;
  const Region& r = regions_[index_of(place)];
  const auto px = static_cast<float>(s_.lattice.pitch_x()), py = static_cast<float>(s_.lattice.pitch_y());
  const std::int32_t x = wrap_sub(b_.pos[2 * i], place[0]), y = wrap_sub(b_.pos[2 * i + 1], place[1]);
  const float u = b_.vel[2 * i], v = b_.vel[2 * i + 1];
  const float rest = length(static_cast<float>(wrap_sub(x, r.x)) * px, static_cast<float>(wrap_sub(y, r.y)) * py);
  const float among = rest + r.apart + (length(u - r.vx, v - r.vy) + r.parting) * time;
  const float alone = length(static_cast<float>(x) * px, static_cast<float>(y) * py) + length(u, v) * time - r.room;
  return greater(among, alone);
}

float CommonMotion::speed(std::uint32_t slot, const std::int32_t* place) const {
  const Region& r = regions_[index_of(place)];
  return length(b_.vel[2 * std::size_t{slot}] - r.vx, b_.vel[2 * std::size_t{slot} + 1] - r.vy) + r.parting;
}

void CommonMotion::find_place(std::uint32_t slot, std::int32_t* place) const {
  const std::size_t i = slot;
  for (int k = 0; k < 2; ++k) {  // the region tells the place, and the place the region
    const Region& r = regions_[index_of(place)];
    place[0] = wrap_sub(b_.pos[2 * i], r.x);
    place[1] = wrap_sub(b_.pos[2 * i + 1], r.y);
  }
}

}  // namespace psim
