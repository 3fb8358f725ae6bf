// Plain types shared by every public header. SI units, y up, radians, seconds.
#pragma once

#include <cstdint>

namespace psim {

/// A point or vector in world coordinates, metres (or m/s, m/s^2 where said so).
struct Vec2 {
  double x = 0;
  double y = 0;
};

/// An axis-aligned rectangle, metres. Valid when xmin < xmax and ymin < ymax.
struct Bounds {
  double xmin = 0;
  double ymin = 0;
  double xmax = 0;
  double ymax = 0;
};

/// A stable handle of a body. `index` is the body's id in every file and report; it is reused only
/// after the body was removed, and then with another `generation`, so that a stale handle is known.
struct BodyId {
  std::uint32_t index = 0xFFFFFFFFu;
  std::uint32_t generation = 0;
  friend bool operator==(const BodyId&, const BodyId&) = default;
};

inline constexpr BodyId kNoBody{};

enum class BodyType : std::uint8_t { dynamic_body, static_body, kinematic_body };

/// What the sides of the world do. `walls`: four planes; `periodic`: positions wrap and pairs see
/// across the seam; `open`: a body that leaves the bounds is removed and counted.
enum class Boundary : std::uint8_t { walls, periodic, open };

}  // namespace psim
