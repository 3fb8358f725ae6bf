// Plain types shared by every public header. SI units, y up, radians, seconds.
#pragma once

#include <cstdint>

/// The whole of psim.
namespace psim {

/// A point or vector in world coordinates, metres (or m/s, m/s^2 where said so).
struct Vec2 {
  double x = 0;  ///< to the right
  double y = 0;  ///< up
  /// The same numbers.
  friend bool operator==(const Vec2&, const Vec2&) = default;
};

/// An axis-aligned rectangle, metres. Valid when xmin < xmax and ymin < ymax.
struct Bounds {
  double xmin = 0;  ///< left
  double ymin = 0;  ///< bottom
  double xmax = 0;  ///< right
  double ymax = 0;  ///< top
};

/// A stable handle of a body. `index` is the body's id in every file and report; it is reused only
/// after the body was removed, and then with another `generation`, so that a stale handle is known.
struct BodyId {
  std::uint32_t index = 0xFFFFFFFFu;  ///< the body's id
  std::uint32_t generation = 0;       ///< how many bodies had the index before
  /// The same body.
  friend bool operator==(const BodyId&, const BodyId&) = default;
};

/// No body.
inline constexpr BodyId kNoBody{};

/// What moves a body.
enum class BodyType : std::uint8_t {
  dynamic_body,   ///< forces and contacts
  static_body,    ///< nothing
  kinematic_body  ///< its velocity, which only the host changes
};

/// What the sides of the world do.
enum class Boundary : std::uint8_t {
  walls,     ///< four planes
  periodic,  ///< positions wrap and pairs see across the seam
  open       ///< a body that leaves the bounds is removed and counted
};

}  // namespace psim
