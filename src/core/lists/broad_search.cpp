#include "lists/broad_search.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>
#include <numeric>

namespace psim {
namespace {

using kernels::kBlock;

constexpr std::uint32_t kLargePiece = 16;  // large bodies whose search is one piece

double pairs_a_body_of(const Strip& s) {
  return static_cast<double>(s.pair_end - s.pair_begin) / std::max(s.body_end - s.body_begin, 1u);
}

}  // namespace

// From the last build: of a strip and its neighbours, or of a piece of the large bodies, which keep their order from
// build to build.
double PairSearch::expected(std::size_t n, std::size_t strips) const {
  if (n < strips) return 1.15 * most_beside(n, pairs_a_body_.size(), pairs_a_body_, 1);
  const bool same = pairs_a_piece_.size() == large_.size();
  return std::max(16.0, 1.25 * (same ? pairs_a_piece_[n - strips] : pairs_a_large_));
}

void PairSearch::begin(PairTable& table, double pairs_a_body, double growth) {
  const BodyStore& b = s_.bodies;
  held_.find(s_);
  if (pairs_a_body > 0) pairs_a_body_.assign(table.strips.size() - 1, held_.share_of_pairs() * pairs_a_body);
  for (std::vector<double>* pairs : {&pairs_a_body_, &pairs_a_piece_}) {
    for (double& each : *pairs) each *= growth;
  }
  large_.clear();
  for (std::uint32_t i = table.large_begin; i < b.count; i += kLargePiece) {
    large_.push_back({.body_begin = i, .body_end = std::min(i + kLargePiece, b.count)});
  }
  large_cells_.build(b.built.data(), b.reach.data(), table.large_begin, b.count, s_.lattice);
  pending_.resize(table.strips.size() - 1 + large_.size());
  std::iota(pending_.begin(), pending_.end(), 0u);
  full_.assign(pending_.size(), 0);
  searched_ = 0;
  give_room(table, true);
}

// Gives room to the pending searches: at first for the expected pairs, then more, by how far they came. What the others
// found stays.
void PairSearch::give_room(PairTable& table, bool first) {
  constexpr double kReserve = 1.2, kMost = 16;
  const std::size_t strips = table.strips.size() - 1;
  const bool all = pending_.size() == full_.size();
  scattered_ = !all && (scattered_ || pending_.back() >= strips);
  double room = all ? 0 : table.pair_room;
  for (const std::uint32_t n : pending_) {
    Strip& s = job(n, table);
    const double bodies = s.body_end - s.body_begin;
    double pairs = expected(n, strips) * bodies + 64;
    if (!first) {
      const std::uint32_t reached = table.owner[s.pair_end - kBlock];  // of the last block that is surely written
      const double done = reached - s.body_begin + 0.5;
      pairs = (s.pair_end - s.pair_begin) * std::min(kReserve * std::max(bodies / done, 1.0), kMost);
    }
    s.pair_begin = static_cast<std::uint32_t>(room);
    room += std::floor(pairs) + kBlock;
    if (!(room <= PairTable::kMostPairs)) throw std::bad_alloc();
    s.pair_end = static_cast<std::uint32_t>(room);
  }
  const auto pairs = static_cast<std::uint32_t>(room);
  for (Column<std::uint32_t>* column : {&table.owner, &table.other}) {
    if (all) column->release_if_short(pairs + kBlock);
    column->reserve_loosely(pairs + kBlock);
  }
  table.pair_room = pairs;
}

// Which searches ran out of room is the same on every ISA.
bool PairSearch::run(PairTable& table, std::size_t begin, std::size_t end) {
  s_.pool.run(end - begin, [&](std::size_t n) {
    const std::uint32_t job = pending_[begin - searched_ + n];
    full_[job] = !search(job, table);
  });
  if (end != searches()) return false;
  searched_ = end;
  std::erase_if(pending_, [&](std::uint32_t job) { return full_[job] == 0; });
  if (!pending_.empty()) {
    give_room(table, false);
    return false;
  }
  join_large(table);
  note_pairs(table);
  return true;
}

bool PairSearch::search(std::size_t n, PairTable& table) {
  Strip& s = job(n, table);
  kernels::PairList list{table.owner.data(), table.other.data(), table.first.data(), s.pair_begin, s.pair_end};
  const bool strip = n + 1 < table.strips.size();
  if (!(strip ? cells_.find_pairs(s, held_, list) : search_large(s, list))) return false;
  s.pair_end = list.count;
  return true;
}

// Compares some of the large bodies with the bodies in the cells under their box, and with the large bodies after them.
bool PairSearch::search_large(const Strip& piece, kernels::PairList& list) const {
  const kernels::KernelTable& k = s_.kernels;
  for (std::uint32_t i = piece.body_begin; i < piece.body_end; ++i) {
    list.first[i] = list.count;
    if (!cells_.find_around(i, list)) return false;
    if (!(large_cells_.any() ? large_cells_.find(i, k, list)
                             : k.find_near(cells_.view(), i, i + 1, s_.bodies.count, list))) {
      return false;
    }
    held_.drop_pairs(i, list);
  }
  return true;
}

bool PairSearch::around(std::uint32_t i, kernels::PairList& list) const {
  const BodyStore& b = s_.bodies;
  if (!cells_.find_around(i, list)) return false;
  if (large_cells_.any()) return large_cells_.around(b.built.data() + 2 * std::size_t{i}, b.reach[i], list);
  return s_.kernels.find_near(cells_.view(), i, cells_.large_begin(), b.count, list);
}

// Moves the pairs of the large bodies' pieces side by side.
void PairSearch::join_large(PairTable& table) {
  Strip& s = table.strips.back();
  s.pair_begin = s.pair_end = table.pair_room;
  if (large_.empty()) return;
  if (!scattered_) {
    s.pair_begin = large_.front().pair_begin;
  } else {
    for (const Strip& p : large_) table.pair_room += p.pair_end - p.pair_begin;
    table.owner.reserve_loosely(table.pair_room + kBlock);
    table.other.reserve_loosely(table.pair_room + kBlock);
  }
  std::uint32_t to = s.pair_begin;
  for (const Strip& p : large_) {
    const std::uint32_t n = p.pair_end - p.pair_begin, shift = p.pair_begin - to;
    if (shift != 0) {
      for (auto* column : {&table.owner, &table.other}) {
        std::memmove(column->data() + to, column->data() + p.pair_begin, n * sizeof(std::uint32_t));
      }
      for (std::uint32_t i = p.body_begin; i < p.body_end; ++i) table.first[i] -= shift;
    }
    to += n;
  }
  s.pair_end = to;
}

// Notes the number of pairs, from which the next build guesses.
void PairSearch::note_pairs(const PairTable& table) {
  const auto note = [](auto begin, auto end, std::vector<double>& out) {
    out.resize(static_cast<std::size_t>(end - begin));
    std::transform(begin, end, out.begin(), pairs_a_body_of);
  };
  note(table.strips.begin(), table.strips.end() - 1, pairs_a_body_);
  note(large_.begin(), large_.end(), pairs_a_piece_);
  pairs_a_large_ = pairs_a_body_of(table.strips.back());
}

PairSearch::Work PairSearch::work_of(std::size_t search, const PairTable& table) const {
  const std::size_t n = pending_[search - searched_], strips = table.strips.size() - 1;
  const bool large = n >= strips;
  const Strip& s = large ? large_[n - strips] : table.strips[n];
  Work work{static_cast<double>(s.body_end - s.body_begin), expected(n, strips), large};
  if (large) work.others = large_cells_.any() ? large_cells_.tests() : table.body_count - s.body_begin;
  return work;
}

}  // namespace psim
