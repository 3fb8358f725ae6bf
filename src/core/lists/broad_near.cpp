#include "lists/broad_near.h"

#include <algorithm>
#include <atomic>
#include <span>

#include "lists/broad_search.h"

namespace psim {
namespace {

constexpr std::uint32_t kRun = 32;  // bodies of which it is asked at once whether anything is near

}  // namespace

void NearSearch::begin(const PairTable& table) {
  pieces_.clear();
  for (std::uint32_t s = 0; s < table.strips.size(); ++s) {
    Piece piece{s, table.strips[s].body_begin, table.strips[s].body_end};
    for (; s_.statics.any() && piece.end - piece.begin > kRun; piece.begin += kRun) {
      pieces_.push_back({s, piece.begin, piece.begin + kRun});
    }
    pieces_.push_back(piece);
  }
}

double NearSearch::expected(std::size_t strip) const {
  if (near_a_body_.empty()) return 0;
  const std::size_t large = near_a_body_.size() - 1;  // the group of large bodies, which lie near many shapes
  return strip == pieces_.back().strip ? near_a_body_[large] : most_beside(strip, large, near_a_body_, 0);
}

// The pieces of one strip run one after the other, because they write to one list.
bool NearSearch::run(PairTable& table, bool links, std::size_t begin, std::size_t end) {
  const std::span<const Piece> pieces = std::span(pieces_).subspan(begin, end - begin);
  const std::size_t first = pieces.front().strip;
  s_.pool.run(pieces.back().strip + 1 - first, [&](std::size_t n) {
    auto piece = std::ranges::lower_bound(pieces, first + n, {}, &Piece::strip);
    for (; piece != pieces.end() && piece->strip == first + n; ++piece) {
      search(*piece, table);
      if (links && piece->end == table.strips[first + n].body_end) {
        link_strip(table, first + n, s_.bodies.linked.data());
      }
    }
  });
  if (end != pieces_.size()) return false;
  pairs_ = 0;
  near_a_body_.resize(table.strips.size());
  for (std::size_t s = 0; s < table.strips.size(); ++s) {
    const std::size_t near = table.static_contacts[s].size();
    pairs_ += near;
    near_a_body_[s] = static_cast<double>(near) / std::max(table.strips[s].body_end - table.strips[s].body_begin, 1u);
  }
  return true;
}

void link_strip(const PairTable& table, std::size_t index, std::uint8_t* linked) {
  // Bytes may be anything's, so that the compiler would load what it knows of the strip after each mark.
  const std::uint32_t begin = table.strips[index].pair_begin, end = table.strips[index].pair_end;
  const std::uint32_t *const owner = table.owner.data(), *const other = table.other.data();
  // Relaxed: several strips may store the same mark, which is read after the run.
  const auto mark = [=](std::uint32_t slot) {
    std::atomic_ref<std::uint8_t>(linked[slot]).store(0xFF, std::memory_order_relaxed);
  };
  for (std::uint32_t p = begin; p < end; ++p) {
    mark(owner[p]);
    mark(other[p]);
  }
  for (const StaticPair& pair : table.static_contacts[index]) mark(pair.body);
}

// How far the common velocity goes within the margin's time: fixed shapes move by that against it.
double NearSearch::common_way() const {
  const kernels::ReachParams& m = params_.margin;
  return length_of({static_cast<double>(m.common_x), static_cast<double>(m.common_y)}) * static_cast<double>(m.time) +
         static_cast<double>(m.beside);
}

void NearSearch::near_body(std::uint32_t i, std::vector<std::uint32_t>& found, std::vector<StaticPair>& out) const {
  const BroadPhaseParams& p = params_;
  const double reach = static_cast<double>(s_.bodies.reach[i]) + common_way();
  const std::int32_t* at = s_.bodies.built.data() + 2 * std::size_t{i};
  if (p.walls) {
    const double x = at[0] * s_.lattice.pitch_x(), y = at[1] * s_.lattice.pitch_y();
    if (x - reach < p.bounds.xmin) out.push_back({i, kWallLeft, 0});
    if (x + reach > p.bounds.xmax) out.push_back({i, kWallRight, 0});
    if (y - reach < p.bounds.ymin) out.push_back({i, kWallBottom, 0});
    if (y + reach > p.bounds.ymax) out.push_back({i, kWallTop, 0});
  }
  if (s_.statics.any()) {
    found.clear();
    s_.statics.near(at[0], at[1], static_cast<float>(reach), found);
    for (const std::uint32_t shape : found) out.push_back({i, shape, 0});
  }
}

// Whether surely no wall or fixed shape is near the bodies [begin, end). Where only walls can be, the cells of the bodies
// tell of most runs; else the box around them does, that of whole blocks.
bool NearSearch::nothing_near(std::uint32_t begin, std::uint32_t end) const {
  using kernels::kBlock;
  const BodyStore& b = s_.bodies;
  const BroadPhaseParams& p = params_;
  const bool walls_only = !s_.statics.any() && end <= cells_.large_begin();
  const float most = walls_only ? cells_.most() : *std::max_element(b.reach.data() + begin, b.reach.data() + end);
  const double reach = static_cast<double>(most) + common_way();
  const Bounds inner{p.bounds.xmin + reach, p.bounds.ymin + reach, p.bounds.xmax - reach, p.bounds.ymax - reach};
  if (walls_only && cells_.surely_within(begin, end, inner)) return true;
  BodyExtent of;
  s_.kernels.extent(b.built.data(), of.box, begin / kBlock, (end + kBlock - 1) / kBlock);
  const double px = s_.lattice.pitch_x(), py = s_.lattice.pitch_y();
  const double xmin = of.box[0] * px, xmax = of.box[2] * px, ymin = of.box[1] * py, ymax = of.box[3] * py;
  if (p.walls && (xmin - reach < p.bounds.xmin || xmax + reach > p.bounds.xmax || ymin - reach < p.bounds.ymin ||
                  ymax + reach > p.bounds.ymax)) {
    return false;
  }
  const auto r = static_cast<double>(static_cast<float>(reach));  // rounded as the bodies' own queries are
  return !s_.statics.any() || s_.statics.surely_none({xmin - r, ymin - r, xmax + r, ymax + r});
}

void NearSearch::search(const Piece& piece, PairTable& table) const {
  std::vector<StaticPair>& out = table.static_contacts[piece.strip];
  if (piece.begin == table.strips[piece.strip].body_begin) out.clear();
  if (!params_.walls && !s_.statics.any()) return;
  for (std::uint32_t begin = piece.begin; begin < piece.end; begin += kRun) {
    const std::uint32_t end = std::min(begin + kRun, piece.end);
    if (nothing_near(begin, end)) continue;
    for (std::uint32_t i = begin; i < end; ++i) near_body(i, table.near_scratch[piece.strip], out);
  }
}

}  // namespace psim
