#include "huffman.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace psim::cli {
namespace {

constexpr std::size_t kLongest = 15;
using ByLength = std::array<std::uint32_t, kLongest + 1>;  // number of codes of each length

struct Leaf {
  std::uint64_t count;
  std::size_t symbol;
};

std::vector<Leaf> leaves_of(std::span<const std::uint32_t> counts) {
  std::vector<Leaf> leaves;
  for (std::size_t s = 0; s < counts.size(); ++s) {
    if (counts[s] > 0) leaves.push_back({counts[s], s});
  }
  for (std::size_t s = 0; leaves.size() < 2; ++s) {
    if (counts[s] == 0) leaves.push_back({0, s});
  }
  std::ranges::sort(leaves, [](const Leaf& a, const Leaf& b) {
    return a.count != b.count ? a.count < b.count : a.symbol < b.symbol;
  });
  return leaves;
}

// The two rarest become one, again and again; sums arise in order, so that the rarest is the next leaf or the next sum.
ByLength lengths_of(const std::vector<Leaf>& leaves, std::size_t longest) {
  const std::size_t n = leaves.size(), root = 2 * n - 2;
  std::vector<std::uint64_t> sums;
  std::vector<std::size_t> parent(root + 1), depth(root + 1);
  std::size_t leaf = 0, sum = 0;
  const auto rarest = [&] {
    return leaf < n && (sum == sums.size() || leaves[leaf].count <= sums[sum]) ? leaf++ : n + sum++;
  };
  const auto count = [&](std::size_t node) { return node < n ? leaves[node].count : sums[node - n]; };
  for (std::size_t node = n; node <= root; ++node) {
    const std::size_t a = rarest(), b = rarest();
    parent[a] = parent[b] = node;
    sums.push_back(count(a) + count(b));
  }
  ByLength lengths{};
  for (std::size_t node = root; node-- > 0;) {
    depth[node] = depth[parent[node]] + 1;
    if (node < n) ++lengths[std::min(depth[node], longest)];
  }
  return lengths;
}

// What was cut to `longest` takes more than there is, in units of the longest code: each time one of them goes beside a
// shorter one, which becomes longer by a bit.
void make_room(ByLength& lengths, std::size_t longest) {
  std::uint64_t taken = 0;
  for (std::size_t l = 1; l <= longest; ++l) taken += std::uint64_t{lengths[l]} << (longest - l);
  for (; taken > std::uint64_t{1} << longest; --taken) {
    std::size_t l = longest - 1;
    while (lengths[l] == 0) --l;
    --lengths[longest];
    --lengths[l];
    lengths[l + 1] += 2;
  }
}

std::uint16_t reversed(std::uint32_t bits, std::size_t length) {
  std::uint32_t out = 0;
  for (std::size_t k = 0; k < length; ++k) out |= (bits >> k & 1) << (length - 1 - k);
  return static_cast<std::uint16_t>(out);
}

}  // namespace

void make_code(std::span<const std::uint32_t> counts, int longest, std::span<PrefixCode> code) {
  const auto most = static_cast<std::size_t>(longest);
  const std::vector<Leaf> leaves = leaves_of(counts);
  ByLength lengths = lengths_of(leaves, most);
  make_room(lengths, most);
  std::ranges::fill(code, PrefixCode{});
  auto leaf = leaves.begin();
  for (std::size_t l = most; l > 0; --l) {
    for (std::uint32_t k = 0; k < lengths[l]; ++k) code[leaf++->symbol].length = static_cast<std::uint16_t>(l);
  }
  std::uint32_t next = 0;
  for (std::size_t l = 1; l <= most; ++l, next <<= 1) {
    for (PrefixCode& c : code) {
      if (c.length == l) c.bits = reversed(next++, l);
    }
  }
}

}  // namespace psim::cli
