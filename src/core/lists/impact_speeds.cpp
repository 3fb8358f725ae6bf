#include "lists/impact_speeds.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "base/elementary.h"
#include "base/tasks.h"

namespace psim {
namespace {

constexpr std::uint32_t kLooks = 64;  // bodies sampled a strip
// By chance the means of two strips' samples hardly ever differ by more than this share of the r.m.s. speed.
constexpr double kChance = 0.5;

constexpr std::size_t kManySegments = 8192;  // from here on threads gain more than they cost

}  // namespace

// The r.m.s. speed about the mean velocity.
double StripSpeeds::Sum::spread() const {
  if (!(bodies > 0)) return 0;
  const Vec2 common = mean();
  return std::sqrt(greater(square / bodies - common.x * common.x - common.y * common.y, 0));
}

void StripSpeeds::Box::add(Vec2 v) {
  low = {lesser(v.x, low.x), lesser(v.y, low.y)};
  high = {greater(v.x, high.x), greater(v.y, high.y)};
}

StripSpeeds::Sum StripSpeeds::look(const Strip& strip) const {
  const BodyStore& b = s_.bodies;
  Sum sum;
  const std::uint32_t stride = std::max(1u, (strip.body_end - strip.body_begin) / kLooks);
  for (std::uint32_t i = strip.body_begin; i < strip.body_end; i += stride) {
    if (b.id[i] == kNoSlot) continue;
    const Vec2 v = b.velocity(i);
    sum.add({1, v, dot(v, v)});
  }
  return sum;
}

void StripSpeeds::measure(const std::vector<Strip>& strips) {
  const std::size_t grid = strips.size() - 1;
  sums_.resize(grid);
  s_.pool.run(grid, [&](std::size_t s) { sums_[s] = look(strips[s]); });
  speed_.resize(strips.size());
  closing_.assign(strips.size(), 0);
  for (std::size_t s = 0; s < grid; ++s) {
    Sum about;
    Box means;
    const auto join = [&](std::size_t strip) {
      if (sums_[strip].bodies > 0) means.add(sums_[strip].mean());
      about.add(sums_[strip]);
    };
    join(s);
    if (s != 0 || s_.lattice.wraps()) join(s == 0 ? grid - 1 : s - 1);
    if (s + 1 != grid || s_.lattice.wraps()) join(s + 1 == grid ? 0 : s + 1);
    speed_[s] = about.spread();
    if (std::isnan(speed_[s])) speed_[s] = std::numeric_limits<double>::infinity();
    closing_[s] = about.bodies > 0 ? greater(means.across() - kChance * speed_[s], 0) : 0;
  }
  speed_[grid] = std::numeric_limits<double>::infinity();
}

double SegmentSpeeds::Box::across() const {
  const double x = static_cast<double>(side[0]) + static_cast<double>(side[2]);
  const double y = static_cast<double>(side[1]) + static_cast<double>(side[3]);
  return x >= 0 ? std::sqrt(x * x + y * y) : 0;  // below 0: nobody is there
}

void SegmentSpeeds::cut(const PairTable& table) {
  parts_.resize(table.strips.size());
  std::uint32_t segments = 0;
  for (std::size_t s = 0; s < parts_.size(); ++s) {
    Run& run = parts_[s].run;
    run.begin = table.strips[s].body_begin;
    run.end = table.strips[s].body_end;
    run.segment = segments;
    run.shift = s + 1 == parts_.size() ? 0 : std::countr_zero(kSegment);
    if (run.begin < run.end) segments = run.of(run.end - 1) + 1;
  }
  boxes_.resize(segments);
}

void SegmentSpeeds::find_boxes(const Run& run) {
  const BodyStore& b = s_.bodies;
  const float none = -1e30f;
  for (std::uint32_t i = run.begin; i < run.end;) {
    const std::uint32_t end = std::min(run.end, i + run.bodies());
    Box box{{none, none, none, none}};
    Box& out = boxes_[run.of(i)];
    for (; i < end; ++i) {
      if (b.id[i] == kNoSlot) continue;
      const float u = b.vel[2 * std::size_t{i}], v = b.vel[2 * std::size_t{i} + 1];
      box.add({{-u, -v, u, v}});
    }
    out = box;
  }
}

// Which segments the pairs of a strip join. Most pairs join what one of the last few did.
void SegmentSpeeds::find_edges(const PairTable& table, std::size_t index) {
  const std::uint32_t begin = table.strips[index].pair_begin, end = table.strips[index].pair_end;
  const std::uint32_t *const owner = table.owner.data(), *const other = table.other.data();
  const Run mine = parts_[index].run;
  Run there = parts_[index + 1 < parts_.size() ? index + 1 : 0].run;  // where the last partner in another strip was
  std::vector<Edge>& edges = parts_[index].edges;
  edges.clear();
  std::array<std::uint32_t, 4> last{};
  std::uint32_t now = kNoSlot, n = 0;
  for (std::uint32_t p = begin; p < end; ++p) {
    const std::uint32_t j = other[p], a = mine.of(owner[p]);
    const bool here = mine.has(j);
    if (!here && !there.has(j)) there = parts_[table.strip_of(j)].run;
    const std::uint32_t b = here ? mine.of(j) : there.of(j);
    if (a != now) last.fill(a);
    now = a;
    if (b == a || std::ranges::find(last, b) != last.end()) continue;
    last[n++ % 4] = b;
    edges.push_back({a, b});
  }
}

void SegmentSpeeds::measure(const PairTable& table) {
  cut(table);
  s_.pool.run(parts_.size(), [&](std::size_t strip) {
    find_boxes(parts_[strip].run);
    find_edges(table, strip);
  });
  for (int hop = 0; hop < kHops; ++hop) {
    next_ = boxes_;
    const auto join = [&](std::size_t strip) {
      for (const Edge e : parts_[strip].edges) {
        next_[e.a].add(boxes_[e.b]);
        next_[e.b].add(boxes_[e.a]);
      }
    };
    if (boxes_.size() >= kManySegments) {
      run_phases(parts_.size(), s_.pool, join);
    } else {
      for (std::size_t strip = 0; strip < parts_.size(); ++strip) join(strip);
    }
    boxes_.swap(next_);
  }
}

void SegmentSpeeds::find_reach(double most, double time) {
  const BodyStore& b = s_.bodies;
  reach_.reserve(kernels::round_up_block(b.count));
  s_.pool.run(parts_.size(), [&](std::size_t strip) {
    const Run run = parts_[strip].run;
    for (std::uint32_t i = run.begin; i < run.end;) {
      const std::uint32_t end = std::min(run.end, i + run.bodies());
      const auto half = static_cast<float>(lesser(most, kGain * boxes_[run.of(i)].across()) * time / 2);
      for (; i < end; ++i) reach_[i] = b.radius[i] + half;
    }
  });
}

std::size_t SegmentSpeeds::bytes() const {
  std::size_t sum = bytes_of(parts_, boxes_, next_);
  for (const Part& part : parts_) sum += bytes_of(part.edges);
  return sum;
}

void SegmentSpeeds::spare(std::size_t bodies) {
  boxes_.reserve(bodies);
  next_.reserve(bodies);
  reach_.reserve(kernels::round_up_block(bodies));
}

void SegmentSpeeds::release() { give_back(parts_, boxes_, next_, reach_); }

}  // namespace psim
