#include "world_descs.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <type_traits>
#include <utility>
#include <variant>

namespace psim::fuzz {
namespace {

Field field(ByteSource& in) {
  if (in.chance(100)) return DragField{in.number(0, 2), in.number(0, 0.5)};
  WellField well;
  well.position = in.place(-kHalf, kHalf);
  well.strength = in.number(-200, 200);
  well.softening = in.number(0.2, 2);
  well.exponent = one_of(in, {2.0, 1.0, 0.0, 2.5});
  well.range = in.chance(128) ? 0 : in.number(0, 20);
  return well;
}

// From 1 g to 1 t, as many in every decade.
double mass(ByteSource& in) { return std::pow(10, in.number(-3, 3)); }

}  // namespace

WorldDesc world(ByteSource& in) {
  WorldDesc d;
  d.boundary = one_of(in, {Boundary::walls, Boundary::periodic, Boundary::open});
  const double half = in.rich ? one_of(in, {kHalf, 30.0, 100.0, 3e6, 1e9}) : one_of(in, {kHalf, 30.0, 500.0, 1e6});
  const double top = one_of(in, {half, 2 * half});
  const Vec2 home = in.home;
  d.bounds = {home.x - half, home.y - half, home.x + half, home.y + top};
  if (!in.tame && in.chance(10)) {
    const Vec2 low = in.vec2(-kHalf, 0), high = in.vec2(0, kHalf);
    d.bounds = {home.x + low.x, home.y + low.y, home.x + high.x, home.y + high.y};
  }
  d.gravity = one_of(in, {Vec2{0, -9.81}, Vec2{0, 0}, Vec2{3, 40}});
  if (in.chance(10)) d.gravity = in.vec2(-50, 50);
  if (in.chance(30)) d.linear_damping = in.number(0, 3);
  d.wall = material(in);
  while (in.chance(40) && d.fields.size() < 3) d.fields.push_back(field(in));
  d.dt = one_of(in, {1.0 / 60, 1.0 / 60, 1.0 / 30, 1.0 / 240});
  if (!in.tame && in.chance(10)) d.dt = in.number(1e-4, 0.2);
  d.substeps = one_of(in, {4, 4, 1, 8});
  if (!in.tame && in.chance(10)) d.substeps = in.byte() - 2;
  d.integrator = one_of(in, kAllIntegrators);
  const Digits digits({d.bounds.xmin, d.gravity.x + d.wall.friction + d.wall.restitution});
  ByteSource own(digits);
  if (own.chance(24)) d.wall.tangent_speed = own.uniform(-5, 5);
  if (own.chance(24)) d.wall.rolling_resistance = own.uniform(0, 0.5);
  if (own.chance(64)) d.mixing = {static_cast<Mixing>(own.below(5)), static_cast<Mixing>(own.below(5))};
  if (in.chance(20)) d.restitution_threshold = in.number(0, 2);
  d.sleeping = !in.chance(64);
  return d;
}

Material material(ByteSource& in) {
  Material m;
  m.density = in.number(0.2, 5);
  m.restitution = in.chance(128) ? 0 : in.number(0, 1);
  m.friction = in.chance(128) ? 0 : in.number(0, 1.5);
  return m;
}

namespace {

double size_of_shape(ByteSource& in) { return one_of(in, {0.5, 0.5, 0.2, 1.0, 3.0}); }

Shape simple_shape(ByteSource& in, double size, std::size_t kind) {
  switch (kind) {
    case 0:
      return SegmentShape{in.vec2(-size, size), in.vec2(-size, size)};
    case 1: {
      ChainShape chain;
      const std::size_t n = in.below(9);
      for (std::size_t k = 0; k < n; ++k) chain.vertices.push_back(in.vec2(-2 * size, 2 * size));
      chain.loop = in.chance(100);
      return chain;
    }
    case 2:
      return BoxShape{in.number(0.1, size), in.number(0.1, size), in.chance(50) ? in.number(0, 0.3) : 0};
    case 3: {
      PolygonShape polygon;
      const std::size_t n = in.below(11);
      const double phase = in.uniform(0, 6), r = in.number(0.2, size);
      for (std::size_t k = 0; k < n; ++k) {
        const double a = phase + 6.283185307179586 * static_cast<double>(k) / static_cast<double>(n);
        polygon.vertices.push_back({r * std::cos(a), r * std::sin(a)});
      }
      if (n > 0 && in.chance(30)) polygon.vertices[in.below(n)] = in.vec2(-size, size);
      if (in.chance(40)) polygon.radius = in.number(0, 0.2);
      return polygon;
    }
    case 4:
      return CapsuleShape{in.vec2(-size, size), in.vec2(-size, size), in.number(0.05, size)};
    default:
      return DiscShape{in.number(0.1, size)};
  }
}

// None to five shapes, mostly near each other, some with what is their own.
CompoundShape compound(ByteSource& in) {
  CompoundShape all;
  for (std::size_t n = in.below(6); n != 0; --n) {
    ShapePart part;
    const auto put = [&part](const auto& s) {
      if constexpr (!std::is_same_v<std::decay_t<decltype(s)>, CompoundShape>) part.shape = s;
    };
    const double size = size_of_shape(in);
    std::visit(put, simple_shape(in, size, in.below(7)));
    part.position = in.chance(230) ? in.vec2(-1, 1) : in.vec2(-100, 100);
    if (in.chance(100)) part.angle = in.number(-4, 4);
    if (in.chance(40)) part.density = in.number(0.2, 20);
    if (in.chance(40)) part.restitution = in.number(0, 1);
    if (in.chance(40)) part.friction = in.number(0, 2);
    const Digits digits(part.position);
    ByteSource own(digits);
    if (own.chance(40)) part.filter = Filter{1u << own.below(8), own.byte(), 0};
    if (own.chance(20)) part.sensor = own.chance(128);
    if (own.chance(20)) part.pre_solve = own.chance(128);
    all.parts.push_back(std::move(part));
  }
  return all;
}

}  // namespace

Shape shape(ByteSource& in) {
  const double size = size_of_shape(in);
  const std::size_t kind = in.below(8);
  return in.rich && kind == 7 ? compound(in) : simple_shape(in, size, kind);
}

Filter filter(ByteSource& in) {
  Filter f;
  if (!in.chance(20)) return f;
  f.category = 1u << in.below(8);
  f.mask = in.byte();
  f.group = static_cast<std::int32_t>(in.below(5)) - 2;
  return f;
}

BodyDesc body(ByteSource& in) {
  BodyDesc d;
  d.type = one_of(in, {BodyType::dynamic_body, BodyType::dynamic_body, BodyType::dynamic_body, BodyType::static_body,
                       BodyType::kinematic_body});
  d.shape = in.chance(128) ? Shape(DiscShape{in.number(0.1, 0.6)}) : shape(in);
  d.position = in.place(-kHalf, kHalf);
  if (in.chance(80)) d.angle = in.number(-4, 4);
  if (in.chance(128)) d.velocity = in.vec2(-20, 20);
  if (in.chance(40)) d.angular_velocity = in.number(-20, 20);
  if (in.chance(80)) d.material = material(in);
  if (in.chance(30)) d.mass = in.rich ? mass(in) : in.number(0, 100);
  if (in.chance(20)) d.gravity_scale = in.number(-1, 2);
  d.fixed_rotation = in.chance(10);
  d.bullet = in.chance(16);
  d.sensor = in.chance(16);
  d.filter = filter(in);
  const Digits digits(d.position);
  ByteSource own(digits);
  if (own.chance(24)) d.linear_damping = own.uniform(0, 30);
  if (own.chance(24)) d.angular_damping = own.uniform(0, 30);
  if (own.chance(24)) d.locks = {own.chance(128), own.chance(128), own.chance(128)};
  if (own.chance(24)) d.material.tangent_speed = own.uniform(-5, 5);
  if (own.chance(24)) d.material.rolling_resistance = own.uniform(0, 0.5);
  if (own.chance(16)) d.one_way = {own.uniform(-1, 1), own.uniform(-1, 1)};
  d.enabled = !own.chance(8);
  d.user_data = own.byte();
  d.pre_solve = own.chance(24);
  d.can_sleep = !own.chance(12);
  return d;
}

}  // namespace psim::fuzz
