// Which numbers the scene format allows. docs/scene.schema.json says the same, and tests/scene/scene_schema_test.cpp
// compares the two.
#pragma once

#include <cstddef>
#include <cstdint>

#include "file/parse_node.h"

namespace psim::scene {

inline constexpr double kMostMetres = 1e9;

inline constexpr Range kCoordinate{-kMostMetres, kMostMetres};
inline constexpr Range kLength{0, kMostMetres};
inline constexpr Range kRadius{0, 1e6, true};
inline constexpr double kLeastRadius = 1e-9;  // m: floats square it
inline constexpr Range kRounding{0, 1e6};
inline constexpr Range kDensity{1e-9, 1e9};
inline constexpr Range kMass{1e-9, 1e12};
inline constexpr Range kRestitution{0, 1};
inline constexpr Range kFriction{0, 100};
inline constexpr Range kGravity{-1e6, 1e6};
inline constexpr Range kVelocity{-1e6, 1e6};
inline constexpr Range kSpeed{0, 1e6};
inline constexpr Range kSkin{0.25, 4};
inline constexpr Range kAngle{-1e6, 1e6};
inline constexpr Range kAngularVelocity{-1e6, 1e6};
inline constexpr Range kGravityScale{-1e6, 1e6};
inline constexpr Range kDamping{0, 1e6};
inline constexpr Range kTimeStep{1e-6, 1};
inline constexpr Range kJitter{0, 1};
inline constexpr Range kWellStrength{-1e21, 1e21};
inline constexpr Range kWellExponent{0, 10};
inline constexpr Range kJointLength{0, kMostMetres, true};
inline constexpr Range kJointStiffness{0, 1e12};
inline constexpr Range kJointDamping{0, 1e12};
inline constexpr Range kMotorSpeed{-1e6, 1e6};
inline constexpr Range kMotorLimit{0, 1e12};

inline constexpr std::uint64_t kMostSubsteps = 64;
inline constexpr std::uint64_t kMostBodiesInGroup = 10'000'000;
inline constexpr std::uint64_t kLargestBodyId = 0xFFFFFFFEu;
inline constexpr std::uint64_t kAllCategories = 0xFFFFFFFFu;
inline constexpr std::int64_t kLargestGroup = 0x7FFFFFFF;
inline constexpr std::size_t kMostChainVertices = 10'000'000;

}  // namespace psim::scene
