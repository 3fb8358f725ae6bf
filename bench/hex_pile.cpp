#include "hex_pile.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "base/machine.h"
#include "kernel_table.h"

namespace psim::bench {
namespace {

using kernels::kBlock;

constexpr std::uint32_t kMostColours = 16;  // first fit on 6 neighbours needs at most 11

std::uint32_t columns_of(std::uint32_t n) {
  return static_cast<std::uint32_t>(std::ceil(std::sqrt(n * std::sqrt(0.75))));
}

// Bodies a strip, as in the broad phase.
std::uint32_t strip_bodies(std::uint32_t n) { return std::clamp<std::uint32_t>(n / 192, 128, 1024); }

Placement hexagonal(std::uint32_t n, double spacing, double speed) {
  const double row_height = spacing * std::sqrt(0.75);
  const std::uint32_t columns = columns_of(n);
  Random random(1);
  Placement p;
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t row = i / columns, column = i % columns;
    p.x.push_back(spacing * (column + 0.5 * (row % 2)));
    p.y.push_back(row_height * row);
    p.vx.push_back(random.uniform(-speed, speed));
    p.vy.push_back(random.uniform(-speed, speed));
  }
  p.bounds = {-1, -1, spacing * (columns + 1) + 1, p.y.back() + 1};
  return p;
}

}  // namespace

HexPile::HexPile(std::uint32_t n, double spacing, double speed)
    : Discs(hexagonal(n, spacing, speed), n / 32 + 16), columns_(columns_of(n)) {
  const std::uint32_t rows = (n + columns_ - 1) / columns_;
  const std::uint32_t rows_a_strip = (strip_bodies(n) + columns_ - 1) / columns_;
  std::vector<std::vector<Pair>> strips;
  for (std::uint32_t row = 0; row < rows; row += rows_a_strip) {
    strips.push_back(pairs_of_rows(row, std::min(rows, row + rows_a_strip)));
    contact_count += static_cast<std::uint32_t>(strips.back().size());
  }
  lay_out(strips);
  kernels_of(Isa::scalar).prepare(view(), contacts(), contact_params(lattice), 0, blocks_of_contacts);
}

// Every pair once, from the lower body: the one to the right, the two above.
std::vector<HexPile::Pair> HexPile::pairs_of_rows(std::uint32_t row_begin, std::uint32_t row_end) const {
  std::vector<Pair> pairs;
  for (std::uint32_t row = row_begin; row < row_end; ++row) {
    for (std::uint32_t column = 0; column < columns_; ++column) {
      const std::uint32_t i = row * columns_ + column;
      const auto add = [&](std::uint32_t r, std::int64_t c) {
        if (c < 0 || c >= columns_) return;
        const auto j = r * columns_ + static_cast<std::uint32_t>(c);
        if (i < count && j < count) pairs.push_back({i, j});
      };
      const std::int64_t left = std::int64_t{column} - (row % 2 == 0 ? 1 : 0);
      add(row, std::int64_t{column} + 1);
      add(row + 1, left);
      add(row + 1, left + 1);
    }
  }
  return pairs;
}

void HexPile::lay_out(const std::vector<std::vector<Pair>>& strips) {
  const std::size_t most = contact_count + strips.size() * kMostColours * kBlock;
  body.reserve(2 * most);
  for (Column<float>* c :
       {&nx, &ny, &gap, &impulse, &rsum, &mass, &wa, &wb, &mu, &friction, &tmass, &qa, &qb, &e, &impact, &start}) {
    c->reserve(most);
  }
  std::vector<std::uint32_t> used(count);  // colours of a body's contacts, in the present strip
  std::uint32_t dummy = blocks() * kBlock;
  for (const std::vector<Pair>& pairs : strips) {
    for (const Pair& p : pairs) used[p.a] = used[p.b] = 0;
    std::array<std::vector<Pair>, kMostColours> colours;
    for (const Pair& p : pairs) {
      const int colour = std::countr_zero(~(used[p.a] | used[p.b]));
      used[p.a] |= 1u << colour;
      used[p.b] |= 1u << colour;
      colours[static_cast<std::size_t>(colour)].push_back(p);
    }
    for (const std::vector<Pair>& colour : colours) {
      std::size_t lane = lanes();
      for (const Pair& p : colour) fill_lane(lane++, p);
      while (lane % kBlock != 0) pad_lane(lane++, dummy);
      blocks_of_contacts = static_cast<std::uint32_t>(lane / kBlock);
    }
    dummy += 2;
  }
}

void HexPile::fill_lane(std::size_t lane, Pair pair) {
  body[2 * lane] = pair.a;
  body[2 * lane + 1] = pair.b;
  rsum[lane] = radius[pair.a] + radius[pair.b];
  wa[lane] = wb[lane] = 1;
  mass[lane] = 0.5f;
  mu[lane] = e[lane] = 0.5f;
  qa[lane] = qb[lane] = 2;  // r^2 / inertia of a full disc
  tmass[lane] = 1.0f / 6;
}

void HexPile::pad_lane(std::size_t lane, std::uint32_t dummy) {
  body[2 * lane] = dummy;
  body[2 * lane + 1] = dummy + 1;
  rsum[lane] = -1;
  impact[lane] = 1;
}

kernels::ContactView HexPile::contacts() {
  kernels::ContactView v;
  v.body = body.data();
  v.nx = nx.data();
  v.ny = ny.data();
  v.gap = gap.data();
  v.impulse = impulse.data();
  v.rsum = rsum.data();
  v.mass = mass.data();
  v.wa = wa.data();
  v.wb = wb.data();
  v.mu = mu.data();
  v.friction = friction.data();
  v.tmass = tmass.data();
  v.qa = qa.data();
  v.qb = qb.data();
  v.e = e.data();
  v.impact = impact.data();
  v.start = start.data();
  return v;
}

}  // namespace psim::bench
