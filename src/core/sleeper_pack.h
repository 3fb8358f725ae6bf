// What sleeps, as the bytes of a saved state have it: columns of so many sleepers, in the order of their list, and of
// their touches. A pack is made when a state is saved and someone of it fell asleep, woke or moved up since the last
// time; a restored one that is the same bytes leaves its sleepers as they lie.
//
//   counts        PackCounts
//   angles        if any is not 0
//   places, ids, depths
//   numbers       of their pieces: runs (who is the first of it, its number), or one each where that is shorter
//   groups        if any has one
//   pieces        how many, if any has another number than 1
//   names         of whom they touch: ids of bodies of other packs, numbers of fixed pieces
//   impulses      by touch, then friction; two of each and the number of points where any has two points
//   touches       16 bits: the other's place in the pack, or kFar, kFixed: the next name; kShared: the other, which
//                 comes later in the pack, has the same touch, and in its run before what is told there
//   by sleeper    how many touches, shared ones included; kLoose; kMany: the next of `many` says how many
//   many          4 bytes each
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "body_store.h"

namespace psim {

class Sleepers;

struct SleeperPack {
  static constexpr std::uint32_t kEach = 8192;  ///< sleepers
  std::vector<std::byte> bytes;
  bool stale = true;  ///< the sleepers are others than these bytes say
};

/// The bytes of sleepers [first, first + kEach) of the list.
void pack_sleepers(const Sleepers& sleepers, const BodyStore& bodies, std::size_t first,
                   std::vector<std::byte>& out);

/// How many it says that it has.
std::uint32_t count_in_pack(std::span<const std::byte> pack);

/// Writes them into the list, which is long enough, their touches behind the others, and into BodyInfo where they
/// are. False if the bytes are not what pack_sleepers writes.
bool unpack_sleepers(std::span<const std::byte> pack, std::size_t first, Sleepers& sleepers,
                     BodyStore& bodies);

/// And what contacts are to take over: keys, and what they carry unless a sleeper has the same touch.
void pack_recent(const Sleepers& sleepers, const BodyStore& bodies, std::vector<std::byte>& out);
bool unpack_recent(std::span<const std::byte> pack, Sleepers& sleepers, const BodyStore& bodies);

}  // namespace psim
