#include "state/archive.h"

namespace psim {

std::uint64_t hash_of(const std::byte* data, std::size_t size) {
  std::uint64_t hash = 0x9E3779B97F4A7C15u ^ size;
  const auto mix = [](std::uint64_t& to, std::uint64_t v) {
    to = (to ^ v) * 0xD6E8FEB86659FD93u;
    to ^= to >> 32;
  };
  const auto take = [&] {
    std::uint64_t v;
    std::memcpy(&v, data, 8);
    data += 8, size -= 8;
    return v;
  };
  if (size >= 32) {  // four that do not wait for each other
    std::uint64_t lane[4] = {hash, hash + 1, hash + 2, hash + 3};
    while (size >= 32) {
      for (std::uint64_t& l : lane) mix(l, take());
    }
    for (const std::uint64_t l : lane) mix(hash, l);
  }
  while (size >= 8) mix(hash, take());
  std::uint64_t last = 0;
  if (size != 0) std::memcpy(&last, data, size);
  mix(hash, last);
  return hash ^ (hash >> 29);
}

}  // namespace psim
