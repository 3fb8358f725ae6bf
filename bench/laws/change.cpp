#include "change.h"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <variant>

namespace psim::laws {
namespace {

// Changes each part of a compound by change(shape, part).
template <class Change>
void each_part(CompoundShape& compound, const Change& change) {
  for (ShapePart& part : compound.parts) {
    Shape shape = std::visit([](const auto& s) -> Shape { return s; }, part.shape);
    change(shape, part);
    const auto put = [&part](const auto& s) {
      if constexpr (!std::is_same_v<std::decay_t<decltype(s)>, CompoundShape>) part.shape = s;
    };
    std::visit(put, shape);
  }
}

// A shape with all its points mapped. Maps that mirror turn the order of a polygon's vertices round.
template <class Map>
Shape mapped(const Shape& shape, bool mirror, double scale, const Map& map) {
  Shape out = shape;
  if (auto* s = std::get_if<DiscShape>(&out)) s->radius *= scale;
  if (auto* s = std::get_if<BoxShape>(&out)) {
    s->width *= scale;
    s->height *= scale;
    s->radius *= scale;
  }
  if (auto* s = std::get_if<SegmentShape>(&out)) *s = {map(s->p1), map(s->p2)};
  if (auto* s = std::get_if<CapsuleShape>(&out)) *s = {map(s->p1), map(s->p2), s->radius * scale};
  if (auto* s = std::get_if<ChainShape>(&out)) {
    for (Vec2& v : s->vertices) v = map(v);
  }
  if (auto* s = std::get_if<PolygonShape>(&out)) {
    for (Vec2& v : s->vertices) v = map(v);
    if (mirror) std::reverse(s->vertices.begin(), s->vertices.end());
    s->radius *= scale;
  }
  if (auto* s = std::get_if<CompoundShape>(&out)) {
    each_part(*s, [&](Shape& of, ShapePart& part) {
      of = mapped(of, mirror, scale, map);
      part.position = map(part.position);
      if (mirror) part.angle = -part.angle;
    });
  }
  return out;
}

// A quarter turn of a box is a box that is as wide as it was high.
Shape turned_box(const Shape& shape, int quarters) {
  Shape out = shape;
  if (auto* s = std::get_if<BoxShape>(&out); s != nullptr && quarters % 2 != 0) std::swap(s->width, s->height);
  if (auto* s = std::get_if<CompoundShape>(&out)) {
    each_part(*s, [quarters](Shape& of, ShapePart&) { of = turned_box(of, quarters); });
  }
  return out;
}

Bounds mapped(const Bounds& b, const Change& change) {
  const Vec2 p = change.direction({b.xmin, b.ymin}), q = change.direction({b.xmax, b.ymax});
  const double s = change.scale;
  return {s * std::min(p.x, q.x) + change.shift.x, s * std::min(p.y, q.y) + change.shift.y,
          s * std::max(p.x, q.x) + change.shift.x, s * std::max(p.y, q.y) + change.shift.y};
}

void change_joint(JointDesc& j, const Change& c) {
  const double k = c.heavier, length = c.scale, time = c.slower, force = k * length / (time * time);
  const auto place = [&](Vec2 v) {
    const Vec2 d = c.direction(v);
    return Vec2{length * d.x, length * d.y};
  };
  j.anchor_a = place(j.anchor_a);
  j.anchor_b = place(j.anchor_b);
  j.axis = c.direction(j.axis);
  if (j.length) *j.length *= length;
  const bool angular = j.type == JointType::revolute || j.type == JointType::weld;
  const double unit = angular ? 1 : length, push = angular ? force * length : force;
  j.stiffness *= push / unit;
  j.damping *= push * time / unit;
  j.motor_speed *= unit / time;
  j.motor_limit *= push;
  for (auto* limit : {&j.lower, &j.upper}) {
    if (*limit) **limit *= unit;
  }
  if (!c.mirror) return;
  if (j.reference) *j.reference = -*j.reference;
  if (j.type != JointType::revolute) return;
  j.motor_speed = -j.motor_speed;
  std::swap(j.lower, j.upper);
  for (auto* limit : {&j.lower, &j.upper}) {
    if (*limit) **limit = -**limit;
  }
}

// Particles keep their mass over the factor: density times the square of the spacing.
void change_fluid(SceneFluid& f, const Change& c) {
  const double k = c.heavier, length = c.scale, time = c.slower;
  f.fluid.spacing *= length;
  f.fluid.density *= k / (length * length);
  f.fluid.viscosity *= length * length / time;
  f.fluid.surface_tension *= k * length / (time * time);
  const auto place = [&](Vec2 v) {
    const Vec2 d = c.direction(v);
    return Vec2{length * d.x + c.shift.x, length * d.y + c.shift.y};
  };
  const auto velocity = [&](Vec2 v) {
    const Vec2 d = c.direction(v);
    return Vec2{length / time * d.x + c.boost.x, length / time * d.y + c.boost.y};
  };
  if (auto* b = std::get_if<Bounds>(&f.place)) *b = mapped(*b, c);
  if (auto* d = std::get_if<FluidDisc>(&f.place)) *d = {place(d->position), length * d->radius};
  if (auto* p = std::get_if<FluidPolygon>(&f.place)) {
    for (Vec2& v : p->vertices) v = place(v);
  }
  if (auto* list = std::get_if<FluidList>(&f.place)) {
    for (std::size_t n = 0; n < list->x.size(); ++n) {
      const Vec2 at = place({list->x[n], list->y[n]});
      list->x[n] = at.x, list->y[n] = at.y;
    }
    for (std::size_t n = 0; n < list->vx.size(); ++n) {
      const Vec2 v = velocity({list->vx[n], list->vy[n]});
      list->vx[n] = v.x, list->vy[n] = v.y;
    }
  }
  f.velocity = velocity(f.velocity);
}

}  // namespace

Vec2 Change::direction(Vec2 v) const {
  if (mirror) v.x = -v.x;
  for (int k = 0; k < quarters % 4; ++k) v = {-v.y, v.x};
  return v;
}

Scene Change::of(const Scene& scene) const {
  Scene out = scene;
  const double speed = scale / slower, flip = mirror ? -1 : 1;
  const auto place = [&](Vec2 v) {
    const Vec2 d = direction(v);
    return Vec2{scale * d.x, scale * d.y};
  };
  out.world.bounds = mapped(scene.world.bounds, *this);
  const Vec2 g = direction(scene.world.gravity);
  out.world.gravity = {speed / slower * g.x, speed / slower * g.y};
  out.world.dt *= slower;
  out.world.linear_damping /= slower;
  out.world.restitution_threshold *= speed;
  for (BodyDesc& b : out.bodies) {
    const Vec2 at = place(b.position), v = direction(b.velocity);
    b.position = {at.x + shift.x, at.y + shift.y};
    b.shape = turned_box(mapped(b.shape, mirror, scale, place), quarters);
    b.velocity = {speed * v.x + boost.x, speed * v.y + boost.y};
    b.angle *= flip;
    b.angular_velocity *= flip / slower;
    b.material.density *= heavier / (scale * scale);
    b.mass *= heavier;
    if ((boost.x != 0 || boost.y != 0) && b.type == BodyType::static_body) b.type = BodyType::kinematic_body;
    if (b.type == BodyType::static_body) b.velocity = {};
  }
  for (SceneJoint& j : out.joints) change_joint(j.joint, *this);
  for (SceneFluid& f : out.fluids) change_fluid(f, *this);
  return out;
}

BodyState Change::back(const BodyState& state, double time) const {
  BodyState out = state;
  const double speed = scale / slower, flip = mirror ? -1 : 1;
  Vec2 at{(state.x - shift.x - boost.x * time) / scale, (state.y - shift.y - boost.y * time) / scale};
  Vec2 v{(state.vx - boost.x) / speed, (state.vy - boost.y) / speed};
  for (Vec2* of : {&at, &v}) {
    for (int k = 0; k < quarters % 4; ++k) *of = {of->y, -of->x};
    of->x *= flip;
  }
  out.x = at.x, out.y = at.y, out.vx = v.x, out.vy = v.y;
  out.angle = flip * state.angle;
  out.omega = flip * state.omega * slower;
  out.radius = state.radius / scale;
  return out;
}

namespace {

void relist(Shape& shape, Draw& draw) {
  if (auto* s = std::get_if<SegmentShape>(&shape)) std::swap(s->p1, s->p2);
  if (auto* s = std::get_if<CapsuleShape>(&shape)) std::swap(s->p1, s->p2);
  if (auto* s = std::get_if<ChainShape>(&shape)) {
    if (s->loop) std::rotate(s->vertices.begin(), s->vertices.begin() + draw.below(2), s->vertices.end());
    std::reverse(s->vertices.begin(), s->vertices.end());
  }
  if (auto* s = std::get_if<PolygonShape>(&shape)) {
    const int by = draw.from(1, static_cast<int>(s->vertices.size()) - 1);
    std::rotate(s->vertices.begin(), s->vertices.begin() + by, s->vertices.end());
  }
  if (auto* s = std::get_if<CompoundShape>(&shape)) {
    each_part(*s, [&draw](Shape& of, ShapePart&) { relist(of, draw); });
    s->parts = std::vector<ShapePart>(s->parts.rbegin(), s->parts.rend());
  }
}

}  // namespace

Scene relisted(const Scene& scene, Draw& draw) {
  Scene out = scene;
  for (BodyDesc& b : out.bodies) relist(b.shape, draw);
  return out;
}

Scene cut_finer(const Scene& scene, Draw& draw) {
  Scene out = scene;
  for (BodyDesc& b : out.bodies) {
    if (b.type == BodyType::dynamic_body) continue;
    ChainShape chain;
    if (const auto* s = std::get_if<SegmentShape>(&b.shape)) chain.vertices = {s->p1, s->p2};
    if (const auto* s = std::get_if<ChainShape>(&b.shape)) chain = *s;
    if (chain.vertices.empty()) continue;
    const std::size_t n = chain.vertices.size(), edges = chain.loop ? n : n - 1;
    ChainShape finer;
    finer.loop = chain.loop;
    for (std::size_t k = 0; k < edges; ++k) {
      const Vec2 p = chain.vertices[k], q = chain.vertices[(k + 1) % n];
      const int parts = draw.from(1, 5);
      for (int i = 0; i < parts; ++i) {
        const double at = static_cast<double>(i) / parts;
        finer.vertices.push_back({p.x + at * (q.x - p.x), p.y + at * (q.y - p.y)});
      }
    }
    if (!chain.loop) finer.vertices.push_back(chain.vertices.back());
    b.shape = finer;
  }
  return out;
}

Scene apart(const Scene& scene) {
  Scene out = scene;
  for (std::size_t id = 0; id < scene.bodies.size(); ++id) {
    const auto* chain = std::get_if<ChainShape>(&scene.bodies[id].shape);
    if (chain == nullptr) continue;
    const std::size_t n = chain->vertices.size(), edges = chain->loop ? n : n - 1;
    for (std::size_t k = 0; k < edges; ++k) {
      BodyDesc segment = scene.bodies[id];
      segment.shape = SegmentShape{chain->vertices[k], chain->vertices[(k + 1) % n]};
      if (k == 0) {
        out.bodies[id] = segment;
      } else {
        out.bodies.push_back(segment);
        out.body_names.resize(out.bodies.size());
      }
    }
  }
  return out;
}

Scene kinematic(const Scene& scene) {
  Scene out = scene;
  for (BodyDesc& b : out.bodies) {
    if (b.type == BodyType::static_body) b.type = BodyType::kinematic_body;
  }
  return out;
}

}  // namespace psim::laws
