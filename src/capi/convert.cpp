#include "convert.h"
#include "structs.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <type_traits>
#include <utility>

namespace psim::capi {
namespace {

std::string copy_vertices(const psim_shape& shape, std::size_t most, std::vector<Vec2>& out) {
  if (shape.vertices == nullptr && shape.vertex_count != 0) return "vertices must not be NULL";
  if (shape.vertex_count > most) {
    return "a polygon has 3 to " + std::to_string(most) + " vertices";
  }
  out.reserve(shape.vertex_count);
  for (std::size_t k = 0; k < shape.vertex_count; ++k) out.push_back(to_cpp(shape.vertices[k]));
  return {};
}

}  // namespace

// The numbers of a model lie in a psim_cost_model one after the other (tests/capi/abi_v1.c).
static_assert(offsetof(psim_cost_model, step) + sizeof(CostModel::Numbers) == sizeof(psim_cost_model));

psim_cost_model to_c(const CostModel& m) {
  psim_cost_model out{};
  out.struct_size = sizeof out;
  std::memcpy(&out.step, m.numbers().data(), sizeof(CostModel::Numbers));
  return out;
}

CostModel to_cpp(const psim_cost_model& m) {
  CostModel::Numbers numbers;
  std::memcpy(numbers.data(), &m.step, sizeof numbers);
  return CostModel(numbers);
}

std::string convert(const psim_shape& shape, Shape& out) {
  switch (shape.type) {
    case PSIM_SHAPE_DISC:
      out = DiscShape{shape.radius};
      return {};
    case PSIM_SHAPE_SEGMENT:
      out = SegmentShape{to_cpp(shape.p1), to_cpp(shape.p2)};
      return {};
    case PSIM_SHAPE_CHAIN: {
      ChainShape chain;
      chain.loop = shape.loop != 0;
      std::string wrong = copy_vertices(shape, SIZE_MAX, chain.vertices);
      out = std::move(chain);
      return wrong;
    }
    case PSIM_SHAPE_BOX:
      out = BoxShape{shape.width, shape.height, shape.radius};
      return {};
    case PSIM_SHAPE_POLYGON: {
      PolygonShape polygon;
      polygon.radius = shape.radius;
      std::string wrong = copy_vertices(shape, kMostPolygonVertices, polygon.vertices);
      out = std::move(polygon);
      return wrong;
    }
    case PSIM_SHAPE_CAPSULE:
      out = CapsuleShape{to_cpp(shape.p1), to_cpp(shape.p2), shape.radius};
      return {};
    default:
      return "shape type " + number(shape.type) + " is none of psim_shape_type, 0 to 5";
  }
}

namespace {

struct ToC {
  psim_vec2* corners;

  const psim_vec2* copy(const std::vector<Vec2>& vertices) const {
    std::transform(vertices.begin(), vertices.end(), corners, [](Vec2 v) { return psim::capi::to_c(v); });
    return corners;
  }

  psim_shape operator()(const DiscShape& s) const { return psim_disc(s.radius); }
  psim_shape operator()(const SegmentShape& s) const {
    return psim_segment(psim::capi::to_c(s.p1), psim::capi::to_c(s.p2));
  }
  psim_shape operator()(const ChainShape& s) const {
    return psim_chain(copy(s.vertices), s.vertices.size(), s.loop ? 1 : 0);
  }
  psim_shape operator()(const BoxShape& s) const {
    psim_shape box = psim_box(s.width, s.height);
    box.radius = s.radius;
    return box;
  }
  psim_shape operator()(const PolygonShape& s) const {
    psim_shape polygon = psim_polygon(copy(s.vertices), s.vertices.size());
    polygon.radius = s.radius;
    return polygon;
  }
  psim_shape operator()(const CapsuleShape& s) const {
    return psim_capsule(psim::capi::to_c(s.p1), psim::capi::to_c(s.p2), s.radius);
  }
};

template <class Value, class Out>
void give(const std::optional<Value>& value, Out& out, std::int32_t& has) {
  has = value.has_value();
  if (!value) return;
  if constexpr (std::is_arithmetic_v<Value>) {
    out = *value;
  } else {
    out = to_c(*value);
  }
}

}  // namespace

std::size_t vertex_count(const PartShape& shape) {
  if (const auto* polygon = std::get_if<PolygonShape>(&shape)) return polygon->vertices.size();
  const auto* chain = std::get_if<ChainShape>(&shape);
  return chain != nullptr ? chain->vertices.size() : 0;
}

psim_shape_part to_c(const ShapePart& part, psim_vec2* corners) {
  psim_shape_part out{};
  out.shape = std::visit(ToC{corners}, part.shape);
  out.position = to_c(part.position);
  out.angle = part.angle;
  give(part.density, out.density, out.has_density);
  give(part.restitution, out.restitution, out.has_restitution);
  give(part.friction, out.friction, out.has_friction);
  give(part.tangent_speed, out.tangent_speed, out.has_tangent_speed);
  give(part.rolling_resistance, out.rolling_resistance, out.has_rolling_resistance);
  give(part.filter, out.filter, out.has_filter);
  give(part.sensor, out.sensor, out.has_sensor);
  give(part.one_way, out.one_way, out.has_one_way);
  out.has_pre_solve = part.pre_solve.has_value();
  out.pre_solve = part.pre_solve.value_or(false);
  return out;
}

std::string convert(const psim_run_options& options, RunOptions& out) {
  if (options.reserved != 0) return kNotZero;
  out.threads = options.threads;
  if (options.isa == PSIM_ISA_BEST) return {};
  const auto isa = to_enum(options.isa, kLastIsa);
  if (!isa) return "isa " + number(options.isa) + " is none of psim_isa, -1 to 2";
  out.isa = *isa;
  return {};
}

namespace {

std::string convert(const psim_shape_part& part, ShapePart& out) {
  Shape shape;
  std::string wrong = psim::capi::convert(part.shape, shape);
  if (!wrong.empty()) return wrong;
  const auto simple = [&](auto& s) {
    if constexpr (!std::is_same_v<std::decay_t<decltype(s)>, CompoundShape>) out.shape = std::move(s);
  };
  std::visit(simple, shape);
  out.position = to_cpp(part.position);
  out.angle = part.angle;
  out.density = given(part.has_density, part.density);
  out.restitution = given(part.has_restitution, part.restitution);
  out.friction = given(part.has_friction, part.friction);
  out.tangent_speed = given(part.has_tangent_speed, part.tangent_speed);
  out.rolling_resistance = given(part.has_rolling_resistance, part.rolling_resistance);
  if (part.has_one_way != 0) out.one_way = to_cpp(part.one_way);
  if (part.has_filter != 0) out.filter = to_cpp(part.filter);
  if (part.has_sensor != 0) out.sensor = part.sensor != 0;
  if (part.has_pre_solve != 0) out.pre_solve = part.pre_solve != 0;
  return {};
}

std::string convert_parts(const psim_body_desc& desc, Shape& out) {
  CompoundShape compound;
  for (std::size_t k = 0; k < desc.part_count; ++k) {
    const std::string wrong = convert(desc.parts[k], compound.parts.emplace_back());
    if (!wrong.empty()) return "part " + std::to_string(k) + ": " + wrong;
  }
  out = std::move(compound);
  return {};
}

std::string convert_surfaces(const psim_body_desc& desc, Shape& out) {
  if (desc.surface_count == 0) return {};
  if (desc.surfaces == nullptr) return "surfaces must not be NULL";
  auto* chain = std::get_if<ChainShape>(&out);
  if (chain == nullptr) return "surfaces are those of the segments of a chain";
  for (std::size_t k = 0; k < desc.surface_count; ++k) {
    const psim_surface& s = desc.surfaces[k];
    chain->materials.push_back({1, s.restitution, s.friction, s.tangent_speed, s.rolling_resistance});
  }
  return {};
}

}  // namespace

std::string convert(const psim_body_traits& traits, BodyTraits& out) {
  if (traits.reserved_2 != 0) return kNotZero;
  out.can_sleep = traits.sleepless == 0;
  const psim_surface& s = traits.surface;
  out.filter = to_cpp(traits.filter);
  out.restitution = s.restitution, out.friction = s.friction;
  out.tangent_speed = s.tangent_speed, out.rolling_resistance = s.rolling_resistance;
  out.one_way = to_cpp(traits.one_way);
  out.sensor = traits.sensor != 0;
  out.bullet = traits.bullet != 0;
  out.mass = traits.mass;
  out.inertia = traits.inertia;
  out.gravity_scale = traits.gravity_scale;
  out.linear_damping = traits.linear_damping;
  out.angular_damping = traits.angular_damping;
  out.locks = {traits.lock_x != 0, traits.lock_y != 0, traits.lock_angle != 0};
  out.pre_solve = traits.pre_solve != 0;
  return {};
}

psim_body_traits to_c(const BodyTraits& t) {
  psim_body_traits out;
  set_defaults(out);
  out.filter = to_c(t.filter);
  out.surface = {t.restitution, t.friction, t.tangent_speed, t.rolling_resistance};
  out.one_way = to_c(t.one_way);
  out.sensor = t.sensor;
  out.bullet = t.bullet;
  out.mass = t.mass;
  out.inertia = t.inertia;
  out.gravity_scale = t.gravity_scale;
  out.linear_damping = t.linear_damping;
  out.angular_damping = t.angular_damping;
  out.lock_x = t.locks.x, out.lock_y = t.locks.y, out.lock_angle = t.locks.angle;
  out.pre_solve = t.pre_solve;
  out.sleepless = !t.can_sleep;
  return out;
}

std::string convert(const psim_body_desc& desc, BodyDesc& out) {
  const auto type = to_enum(desc.type, BodyType::kinematic_body);
  if (!type) return "body type " + number(desc.type) + " is none of psim_body_type, 0 to 2";
  if (desc.parts == nullptr && desc.part_count != 0) return "parts must not be NULL";
  std::string wrong = desc.parts != nullptr ? convert_parts(desc, out.shape) : convert(desc.shape, out.shape);
  if (!wrong.empty()) return wrong;
  out.type = *type;
  out.position = to_cpp(desc.position);
  out.angle = desc.angle;
  out.velocity = to_cpp(desc.velocity);
  out.angular_velocity = desc.angular_velocity;
  out.material = to_cpp(desc.material);
  out.mass = desc.mass;
  out.gravity_scale = desc.gravity_scale;
  out.fixed_rotation = desc.fixed_rotation != 0;
  out.bullet = desc.bullet != 0;
  out.sensor = desc.sensor != 0;
  out.filter = to_cpp(desc.filter);
  if (desc.reserved != 0 || desc.reserved_3 != 0) return kNotZero;
  out.can_sleep = desc.sleepless == 0;
  out.material.tangent_speed = desc.tangent_speed;
  out.material.rolling_resistance = desc.rolling_resistance;
  out.one_way = to_cpp(desc.one_way);
  out.enabled = desc.disabled == 0;
  out.user_data = desc.user_data;
  out.pre_solve = desc.pre_solve != 0;
  if (wrong = convert_surfaces(desc, out.shape); !wrong.empty()) return wrong;
  out.linear_damping = desc.linear_damping;
  out.angular_damping = desc.angular_damping;
  out.locks = {desc.lock_x != 0, desc.lock_y != 0, desc.lock_angle != 0};
  return {};
}

psim_part_traits to_c(const PartTraits& t) {
  psim_part_traits out;
  std::memset(&out, 0, sizeof out);
  out.struct_size = sizeof out;
  out.filter = to_c(t.filter);
  out.surface = {t.restitution, t.friction, t.tangent_speed, t.rolling_resistance};
  out.one_way = to_c(t.one_way);
  out.sensor = t.sensor, out.pre_solve = t.pre_solve;
  out.user_data = t.user_data;
  return out;
}

PartTraits to_cpp(const psim_part_traits& t) {
  const psim_surface& s = t.surface;
  return {to_cpp(t.filter),  s.restitution, s.friction,       s.tangent_speed, s.rolling_resistance,
          to_cpp(t.one_way), t.sensor != 0, t.pre_solve != 0, t.user_data};
}

psim_new_contact to_c(const NewContact& c) {
  return {to_c(c.a), to_c(c.b), c.part_a, c.part_b,   to_c(c.point), to_c(c.normal),  c.separation,
          c.speed,   c.enabled, 0,        c.friction, c.restitution, c.tangent_speed, c.rolling_resistance};
}

void take_answer(const psim_new_contact& answer, NewContact& contact) {
  contact.enabled = answer.enabled != 0;
  contact.friction = answer.friction;
  contact.restitution = answer.restitution;
  contact.tangent_speed = answer.tangent_speed;
  contact.rolling_resistance = answer.rolling_resistance;
}

}  // namespace psim::capi
