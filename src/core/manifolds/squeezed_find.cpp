// Finds the light bodies that heavier ones squeeze. How they are solved is in squeezed.cpp.
#include <algorithm>
#include <tuple>
#include <utility>

#include "base/sort_keys.h"
#include "manifolds/squeezed.h"

namespace psim {
namespace {

constexpr int kRounds = 2;  // contacts from a heavy body that squeezes others up to which all are solved together
constexpr double kOpposes = -0.1;  // cosine between the pushes of two bodies that squeeze a third one

bool has(const std::vector<std::uint32_t>& ascending, std::uint32_t body) {
  return std::ranges::binary_search(ascending, body);
}

}  // namespace

void Squeezed::find(const BodyStore& bodies, const PairTable& table, const kernels::ContactParams& p) {
  rows_.clear();
  blocks_.clear();
  if (!loads_.any()) return;
  light_.clear();
  heavy_.clear();
  add_rows(bodies, table, [&](const SqueezedRow& row, std::uint32_t slot) {
    return loads_.pressed(slot) && HeavyLoads::is_heavy(row.wo, row.wl);
  });
  make_blocks([&](std::span<SqueezedRow> rows) {
    for (SqueezedRow& row : rows) row.w_heavy = row.wo;
    return is_squeezed(rows);
  });
  if (blocks_.empty()) return;
  for (const SqueezedRow& row : rows_) {
    light_.push_back(row.light);
    if (row.wo > 0) heavy_.push_back(row.other);
  }
  sort_keys(light_.begin(), light_.end());
  // Whatever else the heavy bodies lie on, and what that lies on, takes a share of their loads.
  for (int round = 0; round < kRounds; ++round) {
    for (const SqueezedRow& row : found_) {
      if (round == 0) continue;
      heavy_.push_back(row.light);
      if (row.wo > 0) heavy_.push_back(row.other);
    }
    sort_keys(heavy_.begin(), heavy_.end());
    add_rows(bodies, table, [&](const SqueezedRow& row, std::uint32_t) {
      const bool of_light = HeavyLoads::is_heavy(row.wo, row.wl) && (row.wo > 0 || has(light_, row.light));
      return !of_light && (has(heavy_, row.light) || has(heavy_, row.other));
    });
  }
  make_blocks([](std::span<SqueezedRow> rows) {
    for (SqueezedRow& row : rows) row.w_heavy = row.wl;
    return true;
  });
  for (Block& block : blocks_) {
    couple(p, block);
    set_lanes(p, block);
  }
}

// Gives the lanes of shapes what the block has: no half-reactions, and the mean softness of their points.
void Squeezed::set_lanes(const kernels::ContactParams& p, const Block& block) {
  const std::span<SqueezedRow> rows = rows_of(block);
  for (SqueezedRow& row : rows) {
    if (row.block == nullptr || row.point != 0) continue;
    double soft = 0, points = 0;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      if (rows[k].block != row.block || rows[k].lane != row.lane) continue;
      soft += rows[k].compliance / block.a[k][k];
      ++points;
    }
    const std::uint32_t l = row.lane;
    row.was = {row.block->share_a[l], row.block->share_b[l], row.block->soft[l], row.block->rate[l]};
    put(row, {1, 1, static_cast<float>(soft / points), p.soft_rate / p.soft_mass});
  }
}

void Squeezed::put(const SqueezedRow& row, const SqueezedRow::Lane& lane) {
  row.block->share_a[row.lane] = lane.share_a;
  row.block->share_b[row.lane] = lane.share_b;
  row.block->soft[row.lane] = lane.soft;
  row.block->rate[row.lane] = lane.rate;
}

void Squeezed::finish() {
  for (const SqueezedRow& row : rows_) {
    if (row.block != nullptr && row.point == 0) put(row, row.was);
  }
}

// Finds the contacts for which wanted(row, slot of the light body) is true.
template <class Wanted>
void Squeezed::add_rows(const BodyStore& bodies, const PairTable& table, const Wanted& wanted) {
  found_.clear();
  for (std::size_t strip = 0; strip < table.strips.size(); ++strip) {
    if (table.strips[strip].loaded) add_discs(bodies, table, strip, wanted);
    if (manifolds_.any()) add_shapes(bodies, strip, wanted);
  }
}

template <class Wanted>
void Squeezed::add_discs(const BodyStore& bodies, const PairTable& table, std::size_t index, const Wanted& wanted) {
  const Strip& s = table.strips[index];
  const auto weight = [&](std::uint32_t slot) { return double{bodies.properties(bodies.id[slot]).inv_mass}; };
  for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) {
    const std::uint32_t a = table.owner[p], b = table.other[p], lane = table.contact[p];
    SqueezedRow row;
    row.light_b = weight(b) > weight(a);
    row.wl = weight(row.light_b ? b : a);
    row.wo = weight(row.light_b ? a : b);
    row.light = discs_.pairs.body[2 * std::size_t{lane} + (row.light_b ? 1 : 0)];
    row.other = discs_.pairs.body[2 * std::size_t{lane} + (row.light_b ? 0 : 1)];
    if (!wanted(row, row.light_b ? b : a)) continue;
    row.lane = lane;
    row.gap = discs_.pairs.gap[lane];
    row.unit = discs_.model().massed() ? 1 : 1 / row.wl;
    found_.push_back(row);
  }
  for (const StaticPair& pair : table.static_contacts[index]) {
    SqueezedRow row;
    row.wl = weight(pair.body);
    row.light = discs_.fixed.body[pair.contact];
    if (!wanted(row, pair.body)) continue;
    row.lane = pair.contact;
    row.gap = discs_.fixed.gap[pair.contact];
    row.unit = discs_.model().massed() ? 1 : 1 / row.wl;
    found_.push_back(row);
  }
}

template <class Wanted>
void Squeezed::add_shapes(const BodyStore& b, std::size_t index, const Wanted& wanted) {
  Manifolds::StripBlocks& strip = manifolds_.strip(index);
  for (const std::uint32_t k : strip.active) {
    const ManifoldPair& pair = manifolds_.pairs()[k];
    if (pair.stack != ManifoldPair::kNoStack) continue;
    SqueezedRow row;
    row.block = &strip.blocks[pair.lane / kernels::kBlock];
    row.lane = pair.lane % kernels::kBlock;
    const float wa = row.block->wa[row.lane], wb = row.block->wb[row.lane];
    row.light_b = pair.fixed_a || wb > wa;
    row.light = row.light_b ? pair.b : pair.a;
    row.other = row.light_b ? pair.a : pair.b;
    // One of several parts has more contacts than a block: blocks that each press on it as if there were no other went
    // on without end.
    if (b.kind(b.id[row.light]).hull_count > 1) continue;
    row.wl = row.light_b ? wb : wa;
    row.wo = row.light_b ? wa : wb;
    if (!wanted(row, row.light)) continue;
    for (int point = 0; point < pair.manifold.count; ++point) {
      row.point = static_cast<std::uint32_t>(point);
      row.offset = pair.offset[point];
      row.gap = row.block->point[row.point].gap[row.lane] - row.offset;
      found_.push_back(row);
    }
  }
}

// The direction in which an impulse of a row pushes the light body.
Vec2 Squeezed::along(const SqueezedRow& row) {
  const double sign = row.light_b ? 1 : -1;
  if (row.block != nullptr) return sign * Vec2{row.block->nx[row.lane], row.block->ny[row.lane]};
  const ContactLanes& c = lanes_of(row);
  return sign * Vec2{c.nx[row.lane], c.ny[row.lane]};
}

// Whether some rows of a body squeeze it, and a moving one is among these.
bool Squeezed::is_squeezed(std::span<const SqueezedRow> rows) {
  return std::ranges::any_of(rows, [&](const SqueezedRow& row) {
    return row.wo > 0 && std::ranges::any_of(rows, [&](const SqueezedRow& against) {
             return dot(along(row), along(against)) < kOpposes;
           });
  });
}

// Makes blocks of the rows that were found, those of a body side by side, the nearest first. take(rows) says whether
// they are wanted.
template <class Take>
void Squeezed::make_blocks(const Take& take) {
  for (std::uint32_t k = 0; k < found_.size(); ++k) found_[k].order = k;
  // Total order: no two rows have the same number.
  std::ranges::sort(found_, {}, [](const SqueezedRow& row) { return std::tuple(row.light, row.gap, row.order); });
  for (std::size_t begin = 0, end = 0; begin < found_.size(); begin = end) {
    while (end < found_.size() && end - begin < kMost && found_[end].light == found_[begin].light) ++end;
    const std::span rows = std::span(found_).subspan(begin, end - begin);
    if (!take(rows)) continue;
    blocks_.push_back({static_cast<std::uint32_t>(rows_.size()), static_cast<std::uint32_t>(rows.size()), {}});
    rows_.insert(rows_.end(), rows.begin(), rows.end());
  }
}

}  // namespace psim
