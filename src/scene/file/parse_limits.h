// Which counts the scene format allows; its numbers are those of psim/limits.h. docs/scene.schema.json says the same,
// and tests/scene/scene_schema_test.cpp compares them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "psim/limits.h"

namespace psim::scene {

inline constexpr Range kJitter{0, 1};  // of a lattice's cell

inline constexpr std::uint64_t kMostBodiesInGroup = 10'000'000;
inline constexpr std::uint64_t kLargestBodyId = 0xFFFFFFFEu;
inline constexpr std::uint64_t kAllCategories = 0xFFFFFFFFu;
inline constexpr std::int64_t kLargestGroup = 0x7FFFFFFF;
/// Of psim::Mixing, in its order.
inline constexpr std::array<std::string_view, 5> kMixingNames = {"max", "min", "mean", "product", "geometric"};
inline constexpr std::size_t kMostParts = 1'000'000;
inline constexpr std::size_t kMostFluids = 1000, kMostFluidVertices = 1000;
inline constexpr std::size_t kMostChainVertices = 10'000'000;

}  // namespace psim::scene
