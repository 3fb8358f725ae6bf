// Between the structs of C and those of C++. What comes from C is checked for what C++ cannot hold:
// numbers that are no enumerator and NULL vertices. Ranges are the engine's to check.
#pragma once

#include <psim.h>

#include <iterator>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "psim/geometry.h"
#include "psim/world.h"

namespace psim::capi {

inline psim_vec2 to_c(Vec2 v) { return {v.x, v.y}; }
inline psim_bounds to_c(const Bounds& b) { return {b.xmin, b.ymin, b.xmax, b.ymax}; }
inline psim_body_id to_c(BodyId id) { return {id.index, id.generation}; }
inline psim_joint_id to_c(JointId id) { return {id.index, id.generation}; }
inline psim_material to_c(const Material& m) { return {m.density, m.restitution, m.friction}; }
inline psim_filter to_c(const Filter& f) { return {f.category, f.mask, f.group}; }
inline psim_shape_hit to_c(const ShapeHit& h) { return {to_c(h.point), to_c(h.normal), h.fraction}; }
inline psim_shape_gap to_c(const ShapeGap& g) { return {g.distance, to_c(g.point_a), to_c(g.point_b), to_c(g.normal)}; }
inline psim_ray_hit to_c(const RayHit& h) { return {to_c(h.body), to_c(h.point), to_c(h.normal), h.fraction}; }
inline psim_shape_cast_hit to_c(const ShapeCastHit& h) {
  return {to_c(h.body), to_c(h.point), to_c(h.normal), h.fraction};
}
inline psim_closest_hit to_c(const ClosestHit& h) { return {to_c(h.body), to_c(h.point), h.distance}; }
inline psim_body_state to_c(const BodyState& s) {
  return {to_c(s.id), s.x, s.y, s.angle, s.vx, s.vy, s.omega, s.radius, static_cast<int32_t>(s.type), 0};
}
psim_cost_model to_c(const CostModel& m);
psim_body_traits to_c(const BodyTraits& traits);
psim_part_traits to_c(const PartTraits& traits);
PartTraits to_cpp(const psim_part_traits& traits);
psim_new_contact to_c(const NewContact& contact);
/// What the caller made of a contact.
void take_answer(const psim_new_contact& answer, NewContact& contact);
psim_joint_desc to_c(const JointDesc& desc);
psim_field to_c(const Field& field);
/// How many vertices a shape has that C points to.
std::size_t vertex_count(const PartShape& shape);
/// The vertices go to `corners`, to which the part points.
psim_shape_part to_c(const ShapePart& part, psim_vec2* corners);

inline Vec2 to_cpp(psim_vec2 v) { return {v.x, v.y}; }
inline Bounds to_cpp(const psim_bounds& b) { return {b.xmin, b.ymin, b.xmax, b.ymax}; }
inline BodyId to_cpp(psim_body_id id) { return {id.index, id.generation}; }
inline JointId to_cpp(psim_joint_id id) { return {id.index, id.generation}; }
inline Material to_cpp(const psim_material& m) { return {m.density, m.restitution, m.friction, 0, 0}; }
inline Filter to_cpp(const psim_filter& f) { return {f.category, f.mask, f.group}; }
inline Pose to_cpp(const psim_pose& at) { return {to_cpp(at.position), at.angle}; }
inline ShapeMove to_cpp(const psim_shape_move& m) { return {to_cpp(m.from), to_cpp(m.translation), m.rotation}; }
CostModel to_cpp(const psim_cost_model& m);

inline std::string number(std::int32_t value) { return std::to_string(value); }
inline constexpr const char* kNotZero = "reserved must be 0";
inline std::optional<double> given(std::int32_t has, double value) {
  return has != 0 ? std::optional<double>(value) : std::nullopt;
}

/// The enumerator of a number, or nothing.
template <class Enum>
std::optional<Enum> to_enum(std::int32_t value, Enum last) {
  if (value < 0 || value > static_cast<std::int32_t>(last)) return std::nullopt;
  return static_cast<Enum>(value);
}

/// Each of these returns one line of what is wrong, or nothing.
std::string convert(const psim_shape& shape, Shape& out);
std::string convert(const psim_field& field, Field& out);
bool is_medium(const Field& field);
psim_medium to_medium(const Field& field);
/// Appends fields.
std::string convert(const psim_medium* media, std::size_t count, std::vector<Field>& out);
std::string convert(const psim_field* fields, std::size_t count, std::vector<Field>& out);
std::string convert(const psim_world_desc& desc, WorldDesc& out);
std::string convert(const psim_run_options& options, RunOptions& out);
std::string convert(const psim_body_traits& traits, BodyTraits& out);
std::string convert(const psim_body_desc& desc, BodyDesc& out);
std::string convert(const psim_joint_desc& desc, JointDesc& out);

// Enumerators have the same numbers in both.
static_assert(static_cast<int>(BodyType::kinematic_body) == PSIM_BODY_KINEMATIC);
static_assert(static_cast<int>(BodyType::static_body) == PSIM_BODY_STATIC);
static_assert(static_cast<int>(Boundary::periodic) == PSIM_BOUNDARY_PERIODIC);
static_assert(static_cast<int>(Boundary::open) == PSIM_BOUNDARY_OPEN);
static_assert(static_cast<int>(Integrator::euler) == PSIM_INTEGRATOR_EULER);
static_assert(static_cast<int>(Integrator::rk4) == PSIM_INTEGRATOR_RK4);
static_assert(static_cast<int>(Integrator::symplectic4) == PSIM_INTEGRATOR_SYMPLECTIC4);
static_assert(static_cast<int>(Isa::scalar) == PSIM_ISA_SCALAR);
static_assert(static_cast<int>(Isa::sse) == PSIM_ISA_SSE);
static_assert(static_cast<int>(Isa::avx2) == PSIM_ISA_AVX2);
static_assert(static_cast<int>(Isa::neon) == PSIM_ISA_NEON);
static_assert(static_cast<int>(Isa::simd128) == PSIM_ISA_SIMD128);
inline constexpr Isa kLastIsa = std::end(kAllIsas)[-1];
static_assert(kLastIsa == Isa::simd128);
static_assert(static_cast<int>(JointType::spring) == PSIM_JOINT_SPRING);
static_assert(static_cast<int>(JointType::rope) == PSIM_JOINT_ROPE);
static_assert(static_cast<int>(JointType::revolute) == PSIM_JOINT_REVOLUTE);
static_assert(static_cast<int>(JointType::prismatic) == PSIM_JOINT_PRISMATIC);
static_assert(static_cast<int>(JointType::weld) == PSIM_JOINT_WELD);
// A compound has no number of its own: it is psim_body_desc::parts.
static_assert(std::variant_size_v<PartShape> == 6 && std::variant_size_v<Shape> == 7 &&
              std::variant_size_v<Field> == 4);
static_assert(kStageCount <= PSIM_STAGE_ROOM);

}  // namespace psim::capi
