#include "bodies/body_desc.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <span>
#include <utility>

#include "base/elementary.h"
#include "base/range_text.h"
#include "base/rotor.h"
#include "bodies/static_pieces.h"

namespace psim {
namespace {

// kg: of a disc.
double disc_mass(double radius, double mass, const Material& m) {
  return mass > 0 ? mass : m.density * std::numbers::pi * radius * radius;
}

void check_material(const Material& m, RangeCheck& check) {
  check("restitution", m.restitution, limits::kRestitution)("friction", m.friction, limits::kFriction);
  check("density", m.density, limits::kDensity);
  if (m.tangent_speed != 0) check("tangent speed", m.tangent_speed, limits::kTangentSpeed);
  if (m.rolling_resistance != 0) check("rolling resistance", m.rolling_resistance, limits::kRollingResistance);
}

// A direction of any length, 0 for none.
void check_one_way(Vec2 way, RangeCheck& check) {
  if (way.x == 0 && way.y == 0) return;
  check("one way", way, limits::kCoordinate)("the length of one way", length_of(way), limits::kAxis);
}

// The materials of a chain whose segments have their own.
const std::vector<Material>* materials_of(const Shape& shape) {
  const auto* chain = std::get_if<ChainShape>(&shape);
  return chain != nullptr && !chain->materials.empty() ? &chain->materials : nullptr;
}

// One line of what is wrong with the materials of segments, or nothing.
std::string check_chain_materials(const Shape& shape) {
  const std::vector<Material>* materials = materials_of(shape);
  if (materials == nullptr) return {};
  const auto& chain = std::get<ChainShape>(shape);
  const std::size_t segments = chain.vertices.size() - (chain.loop || chain.vertices.empty() ? 0 : 1);
  if (materials->size() != segments) return "the materials of a chain must be as many as its segments, or none";
  for (std::size_t k = 0; k < materials->size(); ++k) {
    RangeCheck check;
    check_material((*materials)[k], check);
    if (!check.error.empty()) return "material " + std::to_string(k) + ": " + check.error;
  }
  return {};
}

// A mass as it is given, 0 for none, and the one that results.
void check_mass(double given, double mass, RangeCheck& check) {
  if (given != 0) check("mass", given, limits::kMass);
  check("the mass of density and shape", mass, limits::kMassOfShape);
}

}  // namespace

void share_properties(std::vector<PartProperties> parts, NewBody& body) {
  Surface most;
  for (const PartProperties& p : parts) {
    most.restitution = greater(p.surface.restitution, most.restitution);
    most.friction = greater(p.surface.friction, most.friction);
  }
  body.properties.restitution = most.restitution;
  body.properties.friction = most.friction;
  const auto alike = [&](const auto& of) {
    const auto same = [&](const PartProperties& p) { return std::invoke(of, p) == std::invoke(of, parts[0]); };
    return std::ranges::all_of(parts, same);
  };
  body.kind.filter = alike(&PartProperties::filter) ? parts[0].filter : Filter{};
  body.kind.sensor = alike(&PartProperties::sensor) && parts[0].sensor != 0;
  body.kind.one_way = std::ranges::any_of(parts, &PartProperties::is_one_way);
  body.own.clear();
  if (!alike(std::identity{}) || parts[0].is_special() || parts[0].user_data() != 0) body.own = std::move(parts);
}

static std::string point_text(Vec2 point) { return "(" + exact_text(point.x) + ", " + exact_text(point.y) + ")"; }

std::string check(const BodyDesc& d, const Bounds& bounds) {
  RangeCheck check;
  check("type", d.type, BodyType::kinematic_body);
  check_material(d.material, check);
  check("position", d.position, limits::kCoordinate)("angle", d.angle, limits::kAngle);
  check("velocity", d.velocity, limits::kVelocity);
  check("angular velocity", d.angular_velocity, limits::kAngularVelocity);
  check("gravity scale", d.gravity_scale, limits::kGravityScale);
  check("linear damping", d.linear_damping, limits::kDamping)("angular damping", d.angular_damping, limits::kDamping);
  check_one_way(d.one_way, check);
  const Range radius{limits::kRadius.min,
                     lesser(limits::kRadius.max, greater(bounds.xmax - bounds.xmin, bounds.ymax - bounds.ymin))};
  const auto check_radius = [&](const auto& shape) {
    if (const auto* capsule = std::get_if<CapsuleShape>(&shape)) check("radius", capsule->radius, radius);
    if (const auto* disc = std::get_if<DiscShape>(&shape)) check("radius", disc->radius, radius);
  };
  check_radius(d.shape);
  if (const auto* compound = std::get_if<CompoundShape>(&d.shape)) {
    for (std::size_t k = 0; k < compound->parts.size() && check.error.empty(); ++k) {
      check_radius(compound->parts[k].shape);
      if (!check.error.empty()) return "part " + std::to_string(k) + ": " + check.error;
    }
  }
  if (const auto* disc = std::get_if<DiscShape>(&d.shape)) {
    check_mass(d.mass, disc_mass(disc->radius, d.mass, d.material), check);
  }
  if (!check.error.empty()) return check.error;
  if (!contains(bounds, d.position)) {
    return "position must lie inside the world's bounds, " + point_text({bounds.xmin, bounds.ymin}) + " to " +
           point_text({bounds.xmax, bounds.ymax}) + ", not at " + point_text(d.position);
  }
  return check_chain_materials(d.shape);
}

std::string check(const BodyTraits& t, BodyType type) {
  RangeCheck check;
  check_material({1, t.restitution, t.friction, t.tangent_speed, t.rolling_resistance}, check);
  check_one_way(t.one_way, check);
  if (type != BodyType::dynamic_body) return check.error;
  check("mass", t.mass, limits::kMass)("gravity scale", t.gravity_scale, limits::kGravityScale);
  if (t.inertia != 0) check("inertia", t.inertia, limits::kInertia);
  check("linear damping", t.linear_damping, limits::kDamping)("angular damping", t.angular_damping, limits::kDamping);
  return check.error;
}

std::string check(const PartTraits& t) {
  RangeCheck check;
  check_material({1, t.restitution, t.friction, t.tangent_speed, t.rolling_resistance}, check);
  check_one_way(t.one_way, check);
  return check.error;
}

std::string check(const DiscBatch& batch, const Bounds& bounds) {
  const std::size_t n = batch.x.size();
  const auto fits = [n](std::span<const double> s) { return s.empty() || s.size() == n; };
  RangeCheck common;
  check_material(batch.material, common);
  common("gravity scale", batch.gravity_scale, limits::kGravityScale);
  if (!common.error.empty()) return common.error;
  if (batch.y.size() != n) return "x and y must have the same length";
  if (batch.radius.size() != 1 && batch.radius.size() != n) return "radius must have one value or one a disc";
  if (!(fits(batch.angle) && fits(batch.vx) && fits(batch.vy) && fits(batch.angular_velocity))) {
    return "angle, vx, vy and angular_velocity must be empty or have one value a disc";
  }
  for (std::size_t i = 0; i < n; ++i) {
    const std::string error = check(disc_of(batch, i), bounds);
    if (!error.empty()) return "disc " + std::to_string(i) + " of the batch: " + error;
  }
  return {};
}

BodyDesc disc_of(const DiscBatch& batch, std::size_t i) {
  const auto value = [i](std::span<const double> s) { return s.empty() ? 0.0 : s[i]; };
  return {.type = batch.type,
          .shape = DiscShape{batch.radius[batch.radius.size() == 1 ? 0 : i]},
          .position = {batch.x[i], batch.y[i]},
          .angle = value(batch.angle),
          .velocity = {value(batch.vx), value(batch.vy)},
          .angular_velocity = value(batch.angular_velocity),
          .material = batch.material,
          .mass = batch.mass,
          .gravity_scale = batch.gravity_scale,
          .fixed_rotation = batch.fixed_rotation,
          .bullet = batch.bullet,
          .sensor = false,
          .filter = batch.filter};
}

PartProperties properties_of_part(const Material& material, const Filter& filter, bool sensor, Vec2 one_way,
                                  bool pre_solve) {
  const double length = length_of(one_way);
  const auto along = [length](double of) { return length > 0 ? coefficient(of / length) : 0.0f; };
  return {{coefficient(material.restitution), coefficient(material.friction), coefficient(material.tangent_speed),
           coefficient(material.rolling_resistance)},
          filter,
          static_cast<std::uint16_t>(sensor),
          static_cast<std::uint16_t>(pre_solve),
          along(one_way.x),
          along(one_way.y)};
}

PartProperties part_properties(const ShapePart& part, const BodyDesc& body) {
  const Material& of = body.material;
  PartProperties has = properties_of_part(
      {of.density, part.restitution.value_or(of.restitution), part.friction.value_or(of.friction),
       part.tangent_speed.value_or(of.tangent_speed), part.rolling_resistance.value_or(of.rolling_resistance)},
      part.filter.value_or(body.filter), part.sensor.value_or(body.sensor), part.one_way.value_or(body.one_way),
      part.pre_solve.value_or(body.pre_solve));
  has.set_user_data(part.user_data);
  return has;
}

namespace {

// The properties of a body of this radius and mass that turns as a disc does.
BodyProperties properties_of(const BodyDesc& d, double radius, double mass) {
  BodyProperties properties;
  properties.type_bits = static_cast<std::uint32_t>(d.type);
  properties.radius = static_cast<float>(radius);
  properties.restitution = coefficient(d.material.restitution);
  properties.friction = coefficient(d.material.friction);
  if (d.type == BodyType::dynamic_body) {
    properties.mass = static_cast<float>(mass);
    properties.inv_mass = static_cast<float>(1 / mass);
    properties.rim_gain = static_cast<float>(2 / mass);
    properties.gravity_scale = static_cast<float>(d.gravity_scale);
  }
  return properties;
}

// Of each part of a body: of a compound, of a chain whose segments have materials, else of the one shape.
std::vector<PartProperties> properties_of_parts(const BodyDesc& d) {
  std::vector<PartProperties> parts;
  if (const auto* compound = std::get_if<CompoundShape>(&d.shape)) {
    for (const ShapePart& part : compound->parts) parts.push_back(part_properties(part, d));
    if (parts.size() == 1) parts[0].set_user_data(0);  // it is the body's
  } else if (const std::vector<Material>* materials = materials_of(d.shape)) {
    for (const Material& m : *materials)
      parts.push_back(properties_of_part(m, d.filter, d.sensor, d.one_way, d.pre_solve));
  } else {
    parts.push_back(properties_of_part(d.material, d.filter, d.sensor, d.one_way, d.pre_solve));
  }
  return parts;
}

// As share_properties(), but the parts are returned.
std::vector<PartProperties> take_properties(const BodyDesc& d, NewBody& body) {
  const bool plain = !std::holds_alternative<CompoundShape>(d.shape) && materials_of(d.shape) == nullptr &&
                     d.material.tangent_speed == 0 && d.material.rolling_resistance == 0 && d.one_way == Vec2{} &&
                     !d.pre_solve;
  if (plain) {  // as most bodies are
    body.kind.filter = d.filter;
    body.kind.sensor = d.sensor;
    return {};
  }
  share_properties(properties_of_parts(d), body);
  return std::exchange(body.own, {});
}

bool has_chain(const Shape& shape) {
  if (std::holds_alternative<ChainShape>(shape)) return true;
  const auto* compound = std::get_if<CompoundShape>(&shape);
  return compound != nullptr && std::ranges::any_of(compound->parts, [](const ShapePart& part) {
           return std::holds_alternative<ChainShape>(part.shape);
         });
}

// Makes the pieces of a line. One line that says what is wrong with it, or nothing.
std::string cut_chain(const ChainShape& chain, Pieces& pieces) {
  const std::vector<Vec2>& points = chain.vertices;
  const std::size_t n = points.size();
  if (n < (chain.loop ? 3u : 2u)) {
    return chain.loop ? "a chain loop needs at least 3 vertices" : "a chain needs at least 2 vertices";
  }
  if (std::string error; !is_line(points, error)) return error;
  for (std::size_t k = 0; k < (chain.loop ? n : n - 1); ++k) {
    const Vec2 from = points[k], to = points[(k + 1) % n];
    if (from.x == to.x && from.y == to.y) {
      return "vertex " + std::to_string((k + 1) % n) + " must differ from vertex " + std::to_string(k);
    }
    const std::size_t first = pieces.list.size();
    pieces.segment(from, to, 0, false);
    if (chain.materials.empty()) continue;
    for (std::size_t p = first; p < pieces.list.size(); ++p) pieces.list[p].shape.part = static_cast<std::uint32_t>(k);
  }
  return {};
}

// Makes the pieces of one shape. One line that says what is wrong with it, or nothing.
std::string cut_shape(const Shape& shape, Pieces pieces) {
  if (const auto* line = std::get_if<SegmentShape>(&shape)) return cut_chain({{line->p1, line->p2}, false}, pieces);
  if (const auto* chain = std::get_if<ChainShape>(&shape)) return cut_chain(*chain, pieces);
  HullSet hulls;
  std::string error;
  if (make_hulls(shape, false, hulls, error)) {
    for (const Hull& hull : hulls.parts) pieces.solid(hull);
  }
  return error;
}

// Makes the pieces of all parts, each about its own place, so that a level as large as the world is as precise as one
// body for each part.
std::string cut_compound(const BodyDesc& d, const CompoundShape& compound, const Lattice& lattice,
                         std::vector<Piece>& pieces) {
  HullSet checked;
  std::string error;
  if (!make_hulls(d.shape, false, checked, error)) return error;
  const SineCosine turn = sine_cosine(d.angle);
  for (std::size_t k = 0; k < compound.parts.size(); ++k) {
    const ShapePart& part = compound.parts[k];
    const std::size_t first = pieces.size();
    error = cut_shape(shape_of(part),
                      Pieces(d.position + turned(turn, part.position), d.angle + part.angle, lattice, pieces));
    if (!error.empty()) return "part " + std::to_string(k) + ": " + error;
    const PartProperties has = part_properties(part, d);
    Pieces::mark(std::span(pieces).subspan(first), static_cast<std::uint32_t>(k), has);
    if (has.sensor != 0) pieces.resize(first);  // it stops nothing: only queries and events know it
  }
  return {};
}

}  // namespace

namespace {

bool make_shape(const BodyDesc& d, NewBody& body, std::string& error) {
  if (const auto* disc = std::get_if<DiscShape>(&d.shape)) {
    body.properties = properties_of(d, disc->radius, disc_mass(disc->radius, d.mass, d.material));
    body.own = take_properties(d, body);
    // Contacts of shapes alone know locks and special surfaces.
    const bool locked = d.type == BodyType::dynamic_body && (d.locks.x || d.locks.y);
    if (locked || !body.own.empty()) {
      body.hulls.push_back(disc_hull(body.properties.radius));
      body.kind.inner = body.properties.radius;
    }
    return true;
  }
  const bool dynamic = d.type == BodyType::dynamic_body;
  if (dynamic && has_chain(d.shape)) {
    error = "a chain is static or kinematic";
    return false;
  }
  HullSet hulls;
  if (!make_hulls(d.shape, true, hulls, error, d.material.density)) return false;
  const double mass = d.mass > 0 ? d.mass : d.material.density * hulls.mass.area;
  RangeCheck check;
  check_mass(d.mass, dynamic ? mass : 1, check);
  error = check.error;
  if (!error.empty()) return false;
  BodyKind& kind = body.kind;
  float reach = 0;
  kind.inner = hulls.parts[0].inner;
  for (const Hull& hull : hulls.parts) {
    reach = greater(hull.reach, reach);
    kind.inner = lesser(hull.inner, kind.inner);
  }
  kind.centre_x = static_cast<float>(hulls.mass.centre.x);
  kind.centre_y = static_cast<float>(hulls.mass.centre.y);
  body.properties = properties_of(d, reach, mass);
  if (dynamic) {
    const double r = reach, inertia = mass * hulls.mass.inertia;
    body.properties.rim_gain = static_cast<float>(r * r / inertia);
  }
  const std::vector<PartProperties> parts = take_properties(d, body);
  for (std::size_t k = 0; !parts.empty() && k < hulls.parts.size(); ++k)
    body.own.push_back(parts[hulls.part_of(k, parts.size())]);
  body.hulls = std::move(hulls.parts);
  return true;
}

}  // namespace

bool make_moving(const BodyDesc& d, NewBody& body, std::string& error) {
  if (!make_shape(d, body, error)) return false;
  if (d.locks.angle && !d.fixed_rotation) body.kind.locked_gain = body.properties.rim_gain;
  if (d.fixed_rotation || d.locks.angle) body.properties.rim_gain = 0;
  return true;
}

void turn_one_way(std::span<PartProperties> parts, double angle) {
  for (PartProperties& p : parts) {
    if (!p.is_one_way()) continue;
    const Vec2 way = turned(sine_cosine(angle), {p.one_way_x, p.one_way_y});
    p.one_way_x = coefficient(way.x);
    p.one_way_y = coefficient(way.y);
  }
}

// The hulls of a static body's sensors. What they have comes once more behind the parts, with the number of its part in
// place of user data.
std::string make_sensors(const BodyDesc& d, const std::vector<PartProperties>& parts, NewBody& body) {
  HullSet hulls;
  std::string error;
  if (!make_hulls(d.shape, false, hulls, error)) return error;
  body.own = parts;
  for (std::size_t k = 0; k < hulls.parts.size(); ++k) {
    const std::size_t part = hulls.part_of(k, parts.size());
    if (!parts.empty() && parts[part].sensor == 0) continue;
    body.hulls.push_back(hulls.parts[k]);
    if (parts.empty()) continue;
    body.own.push_back(parts[part]);
    body.own.back().set_user_data(part);
  }
  return {};
}

bool make_static(const BodyDesc& d, const Lattice& lattice, NewBody& body, std::vector<Piece>& pieces,
                 std::string& error) {
  const auto* disc = std::get_if<DiscShape>(&d.shape);
  const auto* compound = std::get_if<CompoundShape>(&d.shape);
  body.properties = properties_of(d, disc != nullptr ? disc->radius : 0, 0);
  if (compound != nullptr) {
    error = cut_compound(d, *compound, lattice, pieces);
  } else {
    error = cut_shape(d.shape, Pieces(d.position, d.angle, lattice, pieces));
    const std::vector<PartProperties> parts = properties_of_parts(d);
    for (Piece& piece : pieces) mark(piece.shape, parts[piece.shape.part]);
  }
  if (!error.empty()) return false;
  std::vector<PartProperties> parts = take_properties(d, body);
  turn_one_way(parts, d.angle);
  body.own = parts;
  if (body.kind.sensor) pieces.clear();
  const bool senses = std::ranges::any_of(parts, [](const PartProperties& p) { return p.sensor != 0; });
  if (body.kind.sensor || senses) error = make_sensors(d, parts, body);
  return error.empty();
}

}  // namespace psim
