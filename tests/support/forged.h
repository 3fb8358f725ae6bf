// Recordings that somebody changed and gave a checksum that fits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "state/archive.h"

namespace psim::test {

/// What stands before the state and the log.
struct RecordingHeader {
  std::uint64_t magic = 0, format = 0, size = 0, hash = 0, state = 0, steps = 0;
};

/// With another log: change(log, steps).
template <class Change>
std::vector<std::byte> forged(const std::vector<std::byte>& recording, const Change& change) {
  RecordingHeader header;
  std::memcpy(&header, recording.data(), sizeof header);
  const auto log_at = static_cast<std::ptrdiff_t>(sizeof header + header.state);
  std::vector<std::byte> log(recording.begin() + log_at, recording.end());
  change(log, header.steps);
  std::vector<std::byte> out(recording.begin(), recording.begin() + log_at);
  out.insert(out.end(), log.begin(), log.end());
  const std::span rest = std::span(out).subspan(sizeof header);
  header.size = out.size();
  header.hash = hash_of(rest) + 0x9E3779B97F4A7C15u * header.steps;
  std::memcpy(out.data(), &header, sizeof header);
  return out;
}

inline constexpr std::size_t kBytesOfAStep = 20, kBytesOfAHash = 9;

}  // namespace psim::test
