// The bodies of a scene as they are placed: what `--check` looks at. O(n).
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "check/overlaps.h"
#include "psim/scene.h"

namespace psim {

/// Of the radius: what rounding and a lattice that just fits may overlap.
inline constexpr double kOverlapTolerance = 1e-4;

/// What the rules need to know of a body or a group. The radius of a body that is no disc is that of
/// the largest circle about its centre that fits into it (a segment: half its length).
struct Owner {
  std::string name;
  BodyType type = BodyType::dynamic_body;
  bool has_bodies = false;  ///< other than segments and chains that stand
  bool is_disc = false;
  double radius_min = std::numeric_limits<double>::infinity(), radius_max = 0;
  double mass_min = std::numeric_limits<double>::infinity(), mass_max = 0;
  double speed_over_radius = 0;  ///< of the body for which this is largest, 1/s
  double fastest = 0, fastest_radius = 0;
  double gravity_scale = 1;
  double restitution = 0;
  std::size_t outside = 0;  ///< bodies beyond the sides of the world
};

struct Survey {
  std::vector<Owner> owners;  ///< bodies, then groups
  std::vector<PlacedBody> bodies;
  std::vector<PlacedSegment> segments;
  std::vector<std::string> misplaced;
};

Survey look_at(const Scene& scene);

/// `bodies[3] "ball"`
std::string body_name(const Scene& scene, std::size_t k);

}  // namespace psim
