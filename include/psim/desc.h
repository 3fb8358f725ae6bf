// What a world is made of: descriptions that the host fills in. Plain data, no behaviour.
// psim/limits.h says which numbers are allowed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "psim/integrator.h"
#include "psim/isa.h"
#include "psim/types.h"

namespace psim {

/// Surface and bulk properties. Two materials in contact mix by the rules of the world (WorldDesc::mixing); the larger
/// rolling resistance counts.
struct Material {
  double density = 1;      ///< kg/m^2, > 0
  double restitution = 0;  ///< 0..1
  double friction = 0;     ///< Coulomb coefficient, 0..1000
  /// m/s: the surface runs like a belt. Positive carries what lies on it to the right, seen with the outward normal up.
  double tangent_speed = 0;
  /// 0..1: the torque against rolling is at most this times the radius of what rolls times the normal force.
  double rolling_resistance = 0;
};

/// How the numbers a and b of two materials in contact give that of the contact.
enum class Mixing : std::uint8_t {
  max,       ///< the larger
  min,       ///< the smaller
  mean,      ///< (a + b) / 2
  product,   ///< a b
  geometric  ///< sqrt(a b)
};

/// The rules of a world.
struct MixingRules {
  Mixing restitution = Mixing::max;     ///< of a contact
  Mixing friction = Mixing::geometric;  ///< of a contact
  /// Both alike.
  friend bool operator==(const MixingRules&, const MixingRules&) = default;
};

/// Directions in which a body does not move, and whether it turns.
struct Locks {
  bool x = false;      ///< of the world
  bool y = false;      ///< of the world
  bool angle = false;  ///< it does not turn
  /// All three alike.
  friend bool operator==(const Locks&, const Locks&) = default;
};

/// A disc about the body's place.
struct DiscShape {
  double radius = 0.5;  ///< metres, 1e-9 to 1e6
};

/// A line from p1 to p2 in the body's frame; no thickness; solid from both sides. A dynamic one is a
/// thin rod: its density is kg/m.
struct SegmentShape {
  Vec2 p1 = {};  ///< metres
  Vec2 p2 = {};  ///< metres; differs from p1
};

/// Segments joined end to end (and last to first if `loop`), in the body's frame; static or
/// kinematic. Nothing feels a bump at the joints of a straight or convex run.
struct ChainShape {
  std::vector<Vec2> vertices = {};       ///< metres; at least 2 (3 if loop), no two in a row alike
  bool loop = false;                     ///< the last joined to the first
  std::vector<Material> materials = {};  ///< one for each segment, or none: all have the body's
};

/// A rectangle about the body's place.
struct BoxShape {
  double width = 1;   ///< metres, > 0
  double height = 1;  ///< metres, > 0
  double radius = 0;  ///< metres, >= 0: rounds it, outside of width and height
};

/// Of a polygon.
inline constexpr int kMostPolygonVertices = 8;

/// A convex polygon in the body's frame, counter-clockwise, or clockwise, which is turned round; need not be centred.
struct PolygonShape {
  std::vector<Vec2> vertices = {};  ///< metres; 3 to kMostPolygonVertices
  double radius = 0;                ///< metres, >= 0: rounds it, outside of the vertices
};

/// All points within `radius` of the line from p1 to p2, in the body's frame.
struct CapsuleShape {
  Vec2 p1 = {};         ///< metres
  Vec2 p2 = {};         ///< metres
  double radius = 0.5;  ///< metres, > 0
};

/// Who collides with whom. Two bodies of the same group other than 0 always do (group > 0) or never
/// (group < 0); else if each one's category is in the other's mask.
struct Filter {
  std::uint32_t category = 1;        ///< bits: what the body is
  std::uint32_t mask = 0xFFFFFFFFu;  ///< bits: the categories that it collides with
  std::int32_t group = 0;            ///< 0: none
  /// All three alike.
  friend bool operator==(const Filter&, const Filter&) = default;
};

/// A part of a body has one of these shapes.
using PartShape = std::variant<DiscShape, SegmentShape, ChainShape, BoxShape, PolygonShape, CapsuleShape>;

/// One of the shapes of a body. What it has of its own wins over what the body has.
struct ShapePart {
  PartShape shape = DiscShape{};                  ///< in the part's frame
  Vec2 position = {};                             ///< metres: of the part's frame in the body's
  double angle = 0;                               ///< radians: of the part's frame in the body's
  std::optional<double> density = {};             ///< kg/m^2, > 0
  std::optional<double> restitution = {};         ///< 0..1
  std::optional<double> friction = {};            ///< Coulomb coefficient, 0..1000
  std::optional<Filter> filter = {};              ///< who it collides with
  std::optional<bool> sensor = {};                ///< touches nothing, tells who overlaps it; its mass counts
  std::optional<double> tangent_speed = {};       ///< m/s, as in Material
  std::optional<double> rolling_resistance = {};  ///< 0..1, as in Material
  std::optional<Vec2> one_way = {};               ///< as in BodyDesc
  std::optional<bool> pre_solve = {};             ///< as in BodyDesc
  std::uint64_t user_data = 0;                    ///< whatever the host likes: PartTraits::user_data
};

/// Several shapes that move as one. They may overlap: mass, centre of mass and inertia are the sums over the parts.
struct CompoundShape {
  std::vector<ShapePart> parts = {};  ///< at least 1; no chain in a dynamic body
};

/// A body has one of these shapes.
using Shape = std::variant<DiscShape, SegmentShape, ChainShape, BoxShape, PolygonShape, CapsuleShape, CompoundShape>;

/// One body. `mass` wins over the material's density; inertia follows from shape and mass (a
/// disc's is m r^2 / 2). Dynamic bodies turn about their centre of mass, kinematic ones about
/// `position`; `velocity` is that of the point that the body turns about.
struct BodyDesc {
  BodyType type = BodyType::dynamic_body;  ///< what moves it
  Shape shape = DiscShape{};               ///< a chain is static or kinematic
  Vec2 position = {};                      ///< metres, inside the world's bounds
  double angle = 0;                        ///< radians
  Vec2 velocity = {};                      ///< m/s
  double angular_velocity = 0;             ///< rad/s
  Material material = {};                  ///< what it is made of
  double mass = 0;                         ///< kg; 0 = from the density
  double gravity_scale = 1;                ///< factor on the world's gravity and wells
  bool fixed_rotation = false;             ///< contacts do not turn it
  bool bullet = false;                     ///< does not pass through other moving bodies either, however fast
  bool sensor = false;                     ///< touches nothing but the world's walls, tells who overlaps it
  Filter filter = {};                      ///< who it collides with
  double linear_damping = 0;               ///< 1/s: dv/dt = -c v, integrated exactly; of a dynamic body
  double angular_damping = 0;              ///< 1/s: the same of the angular velocity
  Locks locks = {};                        ///< of a dynamic body
  /// Solid only for what comes against this direction, in the body's frame; of any length. Zero: from all sides.
  Vec2 one_way = {};
  bool enabled = true;          ///< else it takes no part in the world until World::set_enabled
  std::uint64_t user_data = 0;  ///< whatever the host likes: World::user_data
  bool pre_solve = false;       ///< the host is shown its new contacts, before they are solved: World::set_pre_solve
  bool can_sleep = true;        ///< else it stays awake, of a dynamic body
};

/// What can be changed of a body at any time (World::set_traits).
struct BodyTraits {
  Filter filter = {};             ///< who it collides with; of a compound whose parts differ: the usual one
  double restitution = 0;         ///< 0..1; where parts differ, the largest
  double friction = 0;            ///< 0..1000; where parts differ, the largest
  double tangent_speed = 0;       ///< m/s, as in Material; where parts differ, 0
  double rolling_resistance = 0;  ///< 0..1, as in Material; where parts differ, 0
  Vec2 one_way = {};              ///< as in BodyDesc; where parts differ, 0
  bool sensor = false;            ///< as in BodyDesc; a static body does not change it
  bool bullet = false;            ///< as in BodyDesc; of a body that moves
  double mass = 0;                ///< kg, of a dynamic body, else 0
  double inertia = 0;             ///< kg m^2 about the centre of mass, of a dynamic body; 0: it does not turn
  double gravity_scale = 1;       ///< of a dynamic body, as all that follows
  double linear_damping = 0;      ///< 1/s
  double angular_damping = 0;     ///< 1/s
  Locks locks = {};               ///< directions in which it does not move
  bool pre_solve = false;         ///< as in BodyDesc; where parts differ, false
  bool can_sleep = true;          ///< as in BodyDesc
  /// All alike.
  friend bool operator==(const BodyTraits&, const BodyTraits&) = default;
};

/// What can be changed of a part of a body at any time (World::set_part_traits).
struct PartTraits {
  Filter filter = {};             ///< who it collides with
  double restitution = 0;         ///< 0..1
  double friction = 0;            ///< 0..1000
  double tangent_speed = 0;       ///< m/s, as in Material
  double rolling_resistance = 0;  ///< 0..1, as in Material
  Vec2 one_way = {};              ///< as in BodyDesc
  bool sensor = false;            ///< as in ShapePart; a static body does not change it
  bool pre_solve = false;         ///< as in BodyDesc
  std::uint64_t user_data = 0;    ///< whatever the host likes; of a body of one part, World::user_data
  /// All alike.
  friend bool operator==(const PartTraits&, const PartTraits&) = default;
};

/// Many discs that share everything but place, size and speed. Spans of length n, or empty for
/// "all zero"; `radius` has length n or 1.
struct DiscBatch {
  std::span<const double> x = {};                 ///< metres, inside the world's bounds
  std::span<const double> y = {};                 ///< metres
  std::span<const double> radius = {};            ///< metres, > 0
  std::span<const double> angle = {};             ///< radians
  std::span<const double> vx = {};                ///< m/s
  std::span<const double> vy = {};                ///< m/s
  std::span<const double> angular_velocity = {};  ///< rad/s
  BodyType type = BodyType::dynamic_body;         ///< what moves them
  Material material = {};                         ///< what they are made of
  double mass = 0;                                ///< kg each; 0 = from the density
  double gravity_scale = 1;                       ///< factor on the world's gravity and wells
  bool fixed_rotation = false;                    ///< contacts do not turn them
  bool bullet = false;                            ///< as in BodyDesc
  Filter filter = {};                             ///< who they collide with
};

/// Acceleration `strength * d / (|d|^2 + softening^2)^((exponent+1)/2)` towards `position`, zero
/// beyond `range` (0 = no limit).
struct WellField {
  Vec2 position = {};    ///< metres
  double strength = 0;   ///< GM for exponent 2: m^3/s^2
  double softening = 0;  ///< metres
  double exponent = 2;   ///< 0 to 16
  double range = 0;      ///< metres
};

/// dv/dt = -linear v - quadratic |v| v.
struct DragField {
  double linear = 0;     ///< 1/s
  double quadratic = 0;  ///< 1/m
};

/// Water, or another liquid, without its particles: what lies in the region is lifted by the weight of what it displaces,
/// of each part where its area is, and slowed. Rods have no area. Sensors meet nothing.
struct BuoyancyField {
  Bounds region = {};                ///< metres: a side of it is the surface, whatever gravity is
  double density = 1;                ///< kg/m^2, > 0: what is lighter floats
  double linear_damping = 0;         ///< 1/s, of a body that is wholly in it; else the share of its area
  double angular_damping = 0;        ///< 1/s, likewise
  Vec2 flow = {};                    ///< m/s: what is slowed takes this velocity
  std::uint32_t mask = 0xFFFFFFFFu;  ///< parts whose category is in it
};

/// Wind on all bodies, of which each part is met by itself. A width w that faces the air, which comes with the speed u as
/// seen from there, is pushed along the wind by drag * density * w u^2 / 2; and if it leans by the angle a, to the side by
/// lift * density * w sin(a) u^2 / 2.
struct WindField {
  Vec2 velocity = {};                 ///< m/s, of the air
  double density = 1;                 ///< kg/m^2, > 0, of the air
  double drag = 1;                    ///< 0 to 1000
  double lift = 0;                    ///< 0 to 1000
  std::optional<Bounds> region = {};  ///< metres: bodies whose centre of mass is there; else all
  std::uint32_t mask = 0xFFFFFFFFu;   ///< parts whose category is in it
};

/// What acts on every body.
using Field = std::variant<WellField, DragField, BuoyancyField, WindField>;

/// A push away from a point: on each part of a body it is `impulse_per_length` times the width that the part shows to the
/// point, at the part's nearest point.
struct Explosion {
  Vec2 position = {};                ///< metres
  double radius = 0;                 ///< metres: up to here the push is whole
  double falloff = 0;                ///< metres: beyond `radius` the push fades over these to nothing
  double impulse_per_length = 0;     ///< N s/m; below 0 it pulls
  std::uint32_t mask = 0xFFFFFFFFu;  ///< bodies whose category is in it
};

/// The bounds of a world that is as good as without: 1,000 km and more on each side of the origin. What a step costs
/// depends on the bodies alone.
inline constexpr Bounds kOpenBounds{-0x1p20, -0x1p20, 0x1p20, 0x1p20};

/// The world and how it is stepped. Checked by World::create.
struct WorldDesc {
  Bounds bounds{-500, -500, 500, 500};         ///< metres; 1e-9 to 1e9 m wide
  Boundary boundary = Boundary::walls;         ///< what its sides do
  Vec2 gravity{0, -9.81};                      ///< m/s^2
  double linear_damping = 0;                   ///< 1/s: dv/dt = -c v, integrated exactly
  Material wall = {};                          ///< of the four sides, when boundary is `walls`
  MixingRules mixing = {};                     ///< of materials in contact
  std::vector<Field> fields = {};              ///< wells, drag, wind, water
  double dt = 1.0 / 60;                        ///< seconds a frame, above 0, at most 10
  int substeps = 4;                            ///< 1..64
  Integrator integrator = Integrator::verlet;  ///< of wells and drag
  double restitution_threshold = 0;            ///< m/s: slower impacts do not bounce
  bool sleeping = true;                        ///< bodies at rest are left out of the steps
  /// 0.25 to 4: factor on the skin that neighbour lists have around bodies. With less they are made anew more often,
  /// with more they name more pairs; no contact is missed (docs/step.md).
  double skin = 1;
  /// Bytes that the world may take, 0 for any number. What would grow beyond it is refused, and the world stays as it
  /// is. No part of the world's state.
  std::size_t max_bytes = 0;
};

/// How the host wants the world run. None of it changes a bit of the result.
struct RunOptions {
  Isa isa = best_isa();  ///< must be available
  int threads = 1;       ///< 1..256; 1 runs without a pool
};

}  // namespace psim
