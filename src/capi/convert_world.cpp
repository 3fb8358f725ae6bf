// Descriptions of worlds, of what acts in them, and of joints.
#include "convert.h"
#include "structs.h"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace psim::capi {

psim_field to_c(const Field& field) {
  if (const auto* drag = std::get_if<DragField>(&field)) {
    return psim_drag(drag->linear, drag->quadratic);
  }
  const auto& well = std::get<WellField>(field);
  psim_field out = psim_well(to_c(well.position), well.strength, well.softening);
  out.exponent = well.exponent;
  out.range = well.range;
  return out;
}

std::string convert(const psim_field& field, Field& out) {
  if (field.reserved != 0) return kNotZero;
  switch (field.type) {
    case PSIM_FIELD_WELL:
      out = WellField{to_cpp(field.position), field.strength, field.softening, field.exponent, field.range};
      return {};
    case PSIM_FIELD_DRAG:
      out = DragField{field.linear, field.quadratic};
      return {};
    default:
      return "field type " + number(field.type) + " is none of psim_field_type, 0 or 1";
  }
}

bool is_medium(const Field& field) {
  return std::holds_alternative<BuoyancyField>(field) || std::holds_alternative<WindField>(field);
}

psim_medium to_medium(const Field& field) {
  psim_medium out{};
  if (const auto* wind = std::get_if<WindField>(&field)) {
    out.type = PSIM_MEDIUM_WIND;
    out.has_region = wind->region.has_value();
    out.region = to_c(wind->region.value_or(Bounds{0, 0, 0, 0}));
    out.velocity = to_c(wind->velocity);
    out.density = wind->density, out.drag = wind->drag, out.lift = wind->lift;
    out.mask = wind->mask;
    return out;
  }
  const auto& water = std::get<BuoyancyField>(field);
  out.type = PSIM_MEDIUM_WATER;
  out.has_region = 1;
  out.region = to_c(water.region);
  out.velocity = to_c(water.flow);
  out.density = water.density;
  out.linear_damping = water.linear_damping, out.angular_damping = water.angular_damping;
  out.mask = water.mask;
  return out;
}

std::string convert(const psim_medium& medium, Field& out) {
  if (medium.reserved != 0) return kNotZero;
  const Bounds region = to_cpp(medium.region);
  switch (medium.type) {
    case PSIM_MEDIUM_WATER:
      out = BuoyancyField{
          region, medium.density, medium.linear_damping, medium.angular_damping, to_cpp(medium.velocity), medium.mask};
      return {};
    case PSIM_MEDIUM_WIND:
      out = WindField{to_cpp(medium.velocity),
                      medium.density,
                      medium.drag,
                      medium.lift,
                      medium.has_region != 0 ? std::optional(region) : std::nullopt,
                      medium.mask};
      return {};
    default:
      return "medium type " + number(medium.type) + " is none of psim_medium_type, 0 or 1";
  }
}

std::string convert(const psim_medium* media, std::size_t count, std::vector<Field>& out) {
  if (media == nullptr && count != 0) return "media must not be NULL";
  for (std::size_t k = 0; k < count; ++k) {
    const std::string wrong = convert(media[k], out.emplace_back());
    if (!wrong.empty()) return "medium " + std::to_string(k) + ": " + wrong;
  }
  return {};
}

std::string convert(const psim_field* fields, std::size_t count, std::vector<Field>& out) {
  if (fields == nullptr && count != 0) return "fields must not be NULL";
  for (std::size_t k = 0; k < count; ++k) {
    Field field;
    const std::string wrong = convert(fields[k], field);
    if (!wrong.empty()) return "field " + std::to_string(k) + ": " + wrong;
    out.push_back(field);
  }
  return {};
}

std::string convert(const psim_world_desc& desc, WorldDesc& out) {
  const auto boundary = to_enum(desc.boundary, Boundary::open);
  if (!boundary) return "boundary " + number(desc.boundary) + " is none of psim_boundary, 0 to 2";
  const auto integrator = to_enum(desc.integrator, Integrator::symplectic4);
  if (!integrator) {
    return "integrator " + number(desc.integrator) + " is none of psim_integrator, 0 to 3";
  }
  if (desc.reserved != 0) return kNotZero;
  out.fields.clear();
  if (std::string wrong = convert(desc.fields, desc.field_count, out.fields); !wrong.empty()) return wrong;
  if (std::string wrong = convert(desc.media, desc.medium_count, out.fields); !wrong.empty()) return wrong;
  out.bounds = to_cpp(desc.bounds);
  out.boundary = *boundary;
  out.gravity = to_cpp(desc.gravity);
  out.linear_damping = desc.linear_damping;
  out.wall = to_cpp(desc.wall);
  out.wall.tangent_speed = desc.wall_tangent_speed;
  out.wall.rolling_resistance = desc.wall_rolling_resistance;
  out.dt = desc.dt;
  out.substeps = desc.substeps;
  out.integrator = *integrator;
  out.restitution_threshold = desc.restitution_threshold;
  out.sleeping = desc.sleeping != 0;
  out.skin = desc.skin;
  out.max_bytes = static_cast<std::size_t>(std::min<std::uint64_t>(desc.max_bytes, SIZE_MAX));
  for (const auto& [given, rule] : {std::pair(desc.restitution_mixing, &out.mixing.restitution),
                                    std::pair(desc.friction_mixing, &out.mixing.friction)}) {
    const auto mixing = to_enum(given, Mixing::geometric);
    if (!mixing) return "mixing " + number(given) + " is none of psim_mixing, 0 to 4";
    *rule = *mixing;
  }
  return {};
}

std::string convert(const psim_joint_desc& desc, JointDesc& out) {
  const auto type = to_enum(desc.type, JointType::filter);
  if (!type) return "joint type " + number(desc.type) + " is none of psim_joint_type, 0 to 11";
  if (desc.reserved != 0) return kNotZero;
  out.type = *type;
  out.a = to_cpp(desc.a);
  out.b = to_cpp(desc.b);
  out.anchor_a = to_cpp(desc.anchor_a);
  out.anchor_b = to_cpp(desc.anchor_b);
  out.length = given(desc.has_length, desc.length);
  out.stiffness = desc.stiffness;
  out.damping = desc.damping;
  out.axis = to_cpp(desc.axis);
  out.reference = given(desc.has_reference, desc.reference);
  out.lower = given(desc.has_lower, desc.lower);
  out.upper = given(desc.has_upper, desc.upper);
  out.motor_speed = desc.motor_speed;
  out.motor_limit = desc.motor_limit;
  out.collide = desc.collide != 0;
  out.target = to_cpp(desc.target);
  out.rest = desc.rest;
  out.linear_velocity = to_cpp(desc.linear_velocity);
  out.angular_velocity = desc.angular_velocity;
  out.force_limit = desc.force_limit;
  out.torque_limit = desc.torque_limit;
  out.linear_stiffness = desc.linear_stiffness;
  out.linear_damping = desc.linear_damping;
  out.correction = desc.correction;
  out.offset = to_cpp(desc.offset);
  out.ground_a = to_cpp(desc.ground_a);
  out.ground_b = to_cpp(desc.ground_b);
  out.ratio = desc.ratio;
  out.joint_a = to_cpp(desc.joint_a);
  out.joint_b = to_cpp(desc.joint_b);
  out.frequency = given(desc.frequency != 0, desc.frequency);
  out.damping_ratio = desc.damping_ratio;
  out.break_force = desc.break_force;
  out.break_torque = desc.break_torque;
  out.user_data = desc.user_data;
  out.pressure = desc.pressure;
  out.wind_drag = desc.wind_drag;
  out.wind_lift = desc.wind_lift;
  out.area = desc.area;
  return {};
}

psim_joint_desc to_c(const JointDesc& d) {
  psim_joint_desc out;
  set_defaults(out);
  out.struct_size = static_cast<std::uint32_t>(sizeof out);
  out.type = static_cast<std::int32_t>(d.type);
  out.a = to_c(d.a);
  out.b = to_c(d.b);
  out.anchor_a = to_c(d.anchor_a);
  out.anchor_b = to_c(d.anchor_b);
  const auto set = [](const std::optional<double>& value, double& to, std::int32_t& has) {
    has = value.has_value();
    to = value.value_or(0);
  };
  set(d.length, out.length, out.has_length);
  set(d.reference, out.reference, out.has_reference);
  set(d.lower, out.lower, out.has_lower);
  set(d.upper, out.upper, out.has_upper);
  out.stiffness = d.stiffness;
  out.damping = d.damping;
  out.axis = to_c(d.axis);
  out.motor_speed = d.motor_speed;
  out.motor_limit = d.motor_limit;
  out.collide = d.collide;
  out.target = to_c(d.target);
  out.rest = d.rest;
  out.linear_velocity = to_c(d.linear_velocity);
  out.angular_velocity = d.angular_velocity;
  out.force_limit = d.force_limit;
  out.torque_limit = d.torque_limit;
  out.linear_stiffness = d.linear_stiffness;
  out.linear_damping = d.linear_damping;
  out.correction = d.correction;
  out.offset = to_c(d.offset);
  out.ground_a = to_c(d.ground_a);
  out.ground_b = to_c(d.ground_b);
  out.ratio = d.ratio;
  out.joint_a = to_c(d.joint_a);
  out.joint_b = to_c(d.joint_b);
  out.frequency = d.frequency.value_or(0);
  out.damping_ratio = d.damping_ratio;
  out.break_force = d.break_force;
  out.break_torque = d.break_torque;
  out.user_data = d.user_data;
  out.pressure = d.pressure;
  out.wind_drag = d.wind_drag;
  out.wind_lift = d.wind_lift;
  out.area = d.area;
  return out;
}

}  // namespace psim::capi
