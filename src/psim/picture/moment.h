// What is drawn of a world: its bodies at one moment, by id.
#pragma once

#include <cstdint>
#include <vector>

#include "options/picture_options.h"
#include "psim/scene.h"
#include "psim/world.h"

namespace psim::cli {

struct Moment {
  std::vector<std::uint32_t> id;
  std::vector<double> x, y, angle;    ///< metres, radians
  std::vector<double> vx, vy, omega;  ///< m/s, rad/s
  std::vector<double> radius;         ///< metres, as PublishedState::radius
  std::vector<BodyType> type;
  std::vector<std::uint8_t> asleep;  ///< 1: it moves no more, but is not static
  /// N: sum of what a body's contacts press it with; empty unless asked for
  std::vector<double> force;
  /// By row, for Colouring::strip and solver: the strip, or the highest colour of its contacts; kNoStrip, kNoColour
  std::vector<std::uint32_t> group;
  /// Of Colouring::solver.
  struct Link {
    std::uint32_t a = 0, b = 0;  ///< ids; kNoBody.index for a wall
    Vec2 point;                  ///< metres
    std::uint32_t colour = 0;    ///< Contact::colour
  };
  std::vector<Link> links;
  std::vector<FluidParticleState> particles;  ///< of fluids, by id
  std::vector<std::uint8_t> lost;             ///< 1: a joint of the scene, by its number, is gone; empty: none is

  std::size_t size() const { return id.size(); }
  /// The row of a body, or size(). O(log n).
  std::size_t row_of(std::uint64_t body) const;
};

/// Number of the joints of a scene, with those of its links.
std::size_t joints_of(const Scene& scene);

/// The present state, and what the colouring needs, of a world that was built from a scene of some joints with their
/// links. O(bodies, joints and particles), for force and solver O(contacts).
void take_moment(World& world, Moment& moment, Colouring colouring, std::size_t joints = 0);

/// Bodies and particles of `after`, their places and angles at the share `alpha` of the way from `before`, straight on
/// and by the nearest way round a periodic world. Who has no row in `before` is where it is in `after`.
void place_between(const Moment& before, const Moment& after, double alpha, const WorldDesc& world, Moment& between);

}  // namespace psim::cli
