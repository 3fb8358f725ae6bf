// Which numbers a description may hold: the same for scene files, C++ and C. What lies outside is refused with one
// line that names the range. docs/scene.schema.json says the same of each key.
#pragma once

#include "psim/types.h"

namespace psim {

/// The numbers from min to max, without min itself if `above`.
struct Range {
  double min = 0;      ///< the least number
  double max = 0;      ///< the largest
  bool above = false;  ///< whether numbers must be above min
  /// Whether the number is one of them. NaN is not.
  constexpr bool contains(double v) const { return v <= max && (above ? v > min : v >= min); }
  /// The same of both coordinates.
  constexpr bool contains(Vec2 v) const { return contains(v.x) && contains(v.y); }
};

/// The ranges of all numbers in descriptions, in SI units.
namespace limits {

inline constexpr Range kCoordinate{-1e9, 1e9};       ///< m: bounds, places, vertices, anchors, limits of a slide
inline constexpr Range kExtent{1e-9, 1e9};           ///< m: width and height of the bounds, and of a shape as a whole
inline constexpr Range kRadius{1e-9, 1e6};           ///< m: of a disc or capsule, and sides of a box; floats square it
inline constexpr Range kRounding{0, 1e6};            ///< m: around a box or polygon; 1e-9 at least where it is not 0
inline constexpr Range kAngle{-1e9, 1e9};            ///< rad: of bodies and joints
inline constexpr Range kVelocity{-1e6, 1e6};         ///< m/s, along an axis
inline constexpr Range kAngularVelocity{-1e6, 1e6};  ///< rad/s
inline constexpr Range kDensity{1e-9, 1e9};          ///< kg/m^2
inline constexpr Range kMass{1e-9, 1e12};            ///< kg, where it is given
inline constexpr Range kMassOfShape{1e-30, 1e30};    ///< kg, where it follows from density and shape
inline constexpr Range kRestitution{0, 1};           ///< 1: no energy is lost
inline constexpr Range kFriction{0, 1000};           ///< Coulomb's coefficient
inline constexpr Range kTangentSpeed{-1e4, 1e4};     ///< m/s: of a surface that runs like a belt
inline constexpr Range kRollingResistance{0, 1};     ///< length / radius
inline constexpr Range kInertia{1e-30, 1e30};        ///< kg m^2, where it is given and not 0
inline constexpr Range kGravityScale{-1e6, 1e6};     ///< times gravity

inline constexpr Range kGravity{-1e6, 1e6};         ///< m/s^2, along an axis
inline constexpr Range kDamping{0, 1e6};            ///< 1/s or 1/m: of the world and of drag
inline constexpr Range kTimeStep{0, 10, true};      ///< s
inline constexpr Range kSubsteps{1, 64};            ///< a step
inline constexpr Range kSpeed{0, 1e6};              ///< m/s, without a direction: the threshold of restitution
inline constexpr Range kSkin{0.25, 4};              ///< times the skin of the lists
inline constexpr Range kWellStrength{-1e21, 1e21};  ///< m^3/s^2 for exponent 2
inline constexpr Range kWellExponent{0, 16};        ///< the power of the distance
inline constexpr Range kWellLength{0, 1e9};         ///< m: softening and range
inline constexpr Range kWindFactor{0, 1000};        ///< drag and lift of wind
inline constexpr Range kPressure{-1e12, 1e12};      ///< N/m, of a joint
inline constexpr Range kArea{-1e18, 1e18};          ///< m^2, of a joint
inline constexpr Range kThreads{1, 256};            ///< of a world

inline constexpr Range kLength{0, 1e9};           ///< m: of a spring
inline constexpr Range kRodLength{0, 1e9, true};  ///< m: of a rod or rope
inline constexpr Range kAxis{1e-9, 2e9};          ///< the length of a direction
inline constexpr Range kStiffness{0, 1e12};       ///< N/m or N m/rad
inline constexpr Range kJointDamping{0, 1e12};    ///< N s/m or N m s
inline constexpr Range kForce{-1e30, 1e30};       ///< N along an axis, or N m: for a step
inline constexpr Range kBlastLength{0, 1e6};      ///< m: radius and falloff of an explosion
inline constexpr Range kBlast{-1e12, 1e12};       ///< N s/m: of an explosion
inline constexpr Range kMotorSpeed{-1e6, 1e6};    ///< m/s or rad/s
inline constexpr Range kMotorLimit{0, 1e30};      ///< N or N m; the largest is as good as none
inline constexpr Range kFrequency{0, 1e6, true};  ///< Hz: of a spring
inline constexpr Range kDampingRatio{0, 1e6};     ///< of a spring: 1 is the least damping without a swing
inline constexpr Range kCorrection{0, 1};         ///< of a motor: the share of its way in a step
inline constexpr Range kRatio{-1e6, 1e6};         ///< of a gear, 1e-6 at least without its sign
inline constexpr Range kPulleyRatio{1e-6, 1e6};   ///< of a pulley

inline constexpr Range kSpacing{1e-3, 1e3};      ///< m: of the particles of a fluid
inline constexpr Range kViscosity{0, 1e6};       ///< m^2/s: of a fluid
inline constexpr Range kSurfaceTension{0, 1e6};  ///< N/m: of a fluid

}  // namespace limits
}  // namespace psim
