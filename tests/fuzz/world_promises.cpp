#include "world_promises.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <tuple>

namespace psim::fuzz {
namespace {

bool finite(double v) { return std::isfinite(v); }
double lesser_of(double a, double b) { return a < b ? a : b; }
bool finite(Vec2 v) { return finite(v.x) && finite(v.y); }

std::string text(double value) {
  char buffer[40];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
}

std::string text(const RayHit& hit) {
  return std::to_string(hit.body.index) + " at " + text(hit.fraction) + " " + text(hit.point.x) + " " +
         text(hit.point.y) + " normal " + text(hit.normal.x) + " " + text(hit.normal.y) + ";";
}

std::string state_fault(World& world) {
  const PublishedState s = world.published();
  const std::size_t n = s.id.size();
  if (n != world.body_count()) return "published: as many rows as bodies";
  if (s.x.size() != n || s.y.size() != n || s.angle.size() != n || s.vx.size() != n || s.vy.size() != n ||
      s.omega.size() != n || s.radius.size() != n || s.type.size() != n) {
    return "published: columns of one length";
  }
  for (std::size_t k = 0; k < n; ++k) {
    const auto body = [&](const char* what) { return "body " + std::to_string(s.id[k]) + ": " + what; };
    if (k > 0 && s.id[k] <= s.id[k - 1]) return "published: ids ascend";
    if (!finite(s.x[k]) || !finite(s.y[k])) return body("its place is not finite");
    if (!finite(s.angle[k])) return body("its angle is not finite");
    if (!finite(s.vx[k]) || !finite(s.vy[k]) || !finite(s.omega[k])) {
      return body("its velocity is not finite");
    }
    if (!finite(s.radius[k]) || s.radius[k] < 0) return body("its radius");
    const BodyId id = world.id_of(s.id[k]);
    if (id.index != s.id[k] || !world.is_valid(id)) return body("its id");
    const auto one = world.body(id);
    if (!one || one->x != s.x[k] || one->omega != s.omega[k] || one->type != s.type[k]) {
      return body("body() and published() differ");
    }
  }
  return {};
}

template <class Event>
std::string order_fault(std::span<const Event> events, const char* what, bool by_index) {
  for (std::size_t k = 0; k < events.size(); ++k) {
    const auto& e = events[k];
    if (by_index && e.a.index >= e.b.index) return std::string(what) + ": a before b";
    if (k == 0) continue;
    const auto& before = events[k - 1];
    if (e.a.index < before.a.index || (e.a.index == before.a.index && e.b.index < before.b.index)) {
      return std::string(what) + ": ordered by a, then b";
    }
  }
  return {};
}

std::string event_fault(const World& world) {
  const Events events = world.events();
  for (const std::string& fault :
       {order_fault(events.begin, "begin", true), order_fault(events.end, "end", true),
        order_fault(events.hits, "hits", true), order_fault(events.sensor_begin, "sensor_begin", false),
        order_fault(events.sensor_end, "sensor_end", false)}) {
    if (!fault.empty()) return fault;
  }
  const auto by_place = [](const FluidEvent& e) {
    return std::tuple(e.sensor.index, e.sensor.generation, e.part, e.particle);
  };
  for (const auto& list : {events.fluid_begin, events.fluid_end}) {
    if (!std::ranges::is_sorted(list, std::ranges::less_equal{}, by_place)) {
      return "events of fluids: each once, in order";
    }
  }
  for (const HitEvent& hit : events.hits) {
    if (!finite(hit.point) || !finite(hit.normal) || !finite(hit.speed)) return "a hit is not finite";
  }
  for (const TouchEvent& touch : events.begin) {
    if (!finite(touch.point) || !finite(touch.normal)) return "where a touch begins is not finite";
  }
  for (const MoveEvent& move : events.moves) {
    if (!finite(move.position) || !finite(move.angle)) return "a move is not finite";
  }
  return {};
}

std::string snapshot_fault(World& world) {
  const Snapshot* s = world.latest_snapshot();
  if (s == nullptr) return {};
  const std::size_t n = s->id.size();
  if (s->x.size() != n || s->y.size() != n || s->x_prev.size() != n || s->y_prev.size() != n || s->angle.size() != n ||
      s->angle_prev.size() != n || s->radius.size() != n || s->speed.size() != n || s->asleep.size() != n) {
    return "snapshot: columns of one length";
  }
  for (std::size_t k = 0; k < n; ++k) {
    if (k > 0 && s->id[k] <= s->id[k - 1]) return "snapshot: ids ascend";
    // An angle set to 1e300 is infinite as a float.
    if (!std::isfinite(s->x[k]) || !std::isfinite(s->y_prev[k]) || std::isnan(s->angle[k])) {
      return "snapshot: not finite";
    }
  }
  return {};
}

std::string plan_fault(const World& world) {
  for (const PlanEntry& entry : world.plan()) {
    if (entry.stage.empty() || entry.reason.empty()) return "plan: a stage and a reason";
  }
  return {};
}

std::string contact_fault(World& world) {
  const auto there = [&](BodyId id) { return world.is_valid(id); };
  for (const Contact& c : world.contacts()) {
    if (!there(c.a) || (c.b != kNoBody && (!there(c.b) || c.a.index >= c.b.index))) return "contacts: their bodies";
    if (!finite(c.point) || !finite(c.normal) || !finite(c.separation)) return "contacts: not finite";
  }
  std::size_t in_lists = 0;
  for (const std::uint32_t strip : world.strips()) in_lists += strip != kNoStrip;
  return in_lists <= world.dynamic_count() ? "" : "strips: more than moving bodies";
}

// Asks for all that is in the world, and why each of some bodies is awake.
std::string query_fault(const World& world) {
  const Bounds& b = world.desc().bounds;
  const Vec2 middle{b.xmin / 2 + b.xmax / 2, b.ymin / 2 + b.ymax / 2};
  const auto valid = [&](BodyId id) { return world.is_valid(id); };
  for (const BodyId id : world.in_region(b)) {
    if (!valid(id)) return "in_region: a body that is not";
  }
  const BoxShape box{lesser_of(b.xmax - b.xmin, 1e6), lesser_of(b.ymax - b.ymin, 1e6), 0};
  for (const BodyId id : world.overlap(box, middle, 0.3)) {
    if (!valid(id)) return "overlap: a body that is not";
  }
  for (const RayHit& hit : world.ray_cast_all({b.xmin, b.ymin}, {b.xmax, b.ymax})) {
    if (!valid(hit.body) || !(hit.fraction >= 0 && hit.fraction <= 1)) return "ray_cast_all: a hit";
  }
  if (const auto hit = world.closest(middle, b.xmax - b.xmin); hit && !valid(hit->body)) return "closest: its body";
  for (std::uint32_t id = 0; id < 24; ++id) {
    const BodyId body = world.id_of(id);
    if (valid(body) && world.why_awake(body).find('\n') != std::string::npos) return "why_awake: one line";
  }
  return {};
}

// What is drawn has finite places, and bodies that are there.
struct Looks : DebugDraw {
  const World& world;
  std::string fault;

  explicit Looks(const World& drawn) : world(drawn) {}
  void check(bool sound) {
    if (!sound) fault = "debug_draw: what is drawn";
  }
  void circle(Vec2 centre, double radius, double angle, DrawKind kind, BodyId body) override {
    if (kind == DrawKind::particle) return check(finite(centre) && finite(radius) && angle == 0 && body == kNoBody);
    check(finite(centre) && finite(radius) && (finite(angle) || !world.is_awake(body)) && world.is_valid(body));
  }
  void polygon(std::span<const Vec2> corners, double radius, DrawKind, BodyId body) override {
    check(corners.size() >= 2 && corners.size() <= kMostPolygonVertices && finite(radius) && world.is_valid(body));
    for (const Vec2 corner : corners) check(finite(corner));
  }
  void line(Vec2, Vec2, DrawKind) override {}
  void point(Vec2 at, DrawKind) override { check(finite(at)); }
};

// Of a body: its parts, and what geometry says of them without the world.
std::string part_fault(const World& world, BodyId id, const Bounds& box) {
  const std::vector<ShapePart> parts = world.shapes_of(id);
  if (!std::isfinite(box.xmin + box.xmax + box.ymin + box.ymax)) return {};
  for (std::size_t k = 0; k < parts.size() && k < 4; ++k) {
    if (!world.bounds_of_part(id, k)) return "bounds_of_part: of a part that is told";
    const Shape shape = CompoundShape{{parts[k]}};
    const auto around = shape_bounds(shape);
    if (!around) continue;  // so thin that its floats are no polygon
    const Vec2 from{around->xmin - 1, around->ymin - 2}, to{around->xmax + 1, around->ymax + 2};
    if (!limits::kCoordinate.contains(from) || !limits::kCoordinate.contains(to)) continue;
    if (shape_holds(shape, {}, from)) return "shape_holds: a point beyond the bounds";
    const auto hit = shape_ray_cast(shape, {}, from, to);
    if (hit && !(finite(hit->point) && hit->fraction >= 0 && hit->fraction <= 1)) return "shape_ray_cast: a hit";
    const DiscShape ball{0.5};
    const auto gap = shape_distance(ball, {from, 0}, shape, {});
    if (!gap || !finite(gap->point_a) || !finite(gap->point_b) || !(gap->distance > 0)) return "shape_distance: a gap";
    const auto cast = shape_cast(ball, {{from, 0}, {to.x - from.x, to.y - from.y}}, shape, {{}, {}, 1});
    if (cast && !(finite(cast->point) && cast->fraction >= 0 && cast->fraction <= 1)) return "shape_cast: a hit";
    const Vec2 corners[] = {from, to, {to.x, from.y}, {from.x, to.y}, parts[k].position};
    if (convex_hull(corners).size() < 3) return "convex_hull: of a box";
  }
  return {};
}

std::string look_fault(World& world) {
  Looks looks(world);
  DebugDrawOptions options;
  options.contacts = options.forces = true;
  if (!world.debug_draw(looks, options)) return "debug_draw";
  const Bounds& b = world.desc().bounds;
  const RayInput rays[] = {{{b.xmin, b.ymin}, {b.xmax, b.ymax}}, {{b.xmax, b.ymin}, {b.xmin, b.ymax}}};
  RayHit hits[2];
  world.ray_cast_batch(rays, hits);
  for (std::size_t k = 0; k < 2; ++k) {
    const RayHit one = world.ray_cast(rays[k].from, rays[k].to).value_or(RayHit{});
    if (one.body != hits[k].body || one.fraction != hits[k].fraction) return "ray_cast_batch: as one ray";
  }
  for (const JointId joint : world.joints_across(rays[0].from, rays[0].to)) {
    if (!world.is_valid_joint(joint)) return "joints_across: a joint that is there";
  }
  for (std::uint32_t k = 0; k < 24; ++k) {
    const BodyId id = world.id_of(k);
    if (id == kNoBody) continue;
    const auto box = world.bounds_of(id);
    const auto centre = world.centre_of_mass(id);
    if (!box || !centre || !finite(*centre) || !world.velocity_at(id, *centre)) return "where a body is";
    if (!(box->xmin <= box->xmax) || !(box->ymin <= box->ymax)) return "bounds_of: a box";
    if (const std::string fault = part_fault(world, id, *box); !fault.empty()) return fault;
    for (const JointId joint : world.joints_of(id)) {
      const auto state = world.joint(joint);
      if (!state || (state->a != id && state->b != id)) return "joints_of: a joint of another";
    }
  }
  return looks.fault;
}

}  // namespace

bool same_events(const World& one, const World& other) {
  const auto bodies = [](const auto& e, const auto& f) { return e.a == f.a && e.b == f.b; };
  const auto hits = [&](const HitEvent& e, const HitEvent& f) {
    return bodies(e, f) && e.point.x == f.point.x && e.normal.y == f.normal.y && e.speed == f.speed;
  };
  const Events e = one.events(), f = other.events();
  const auto felt = [](const TouchEvent& x, const TouchEvent& y) {
    return x.a == y.a && x.b == y.b && x.part == y.part;
  };
  const auto moves = [](const MoveEvent& x, const MoveEvent& y) {
    return x.body == y.body && x.position.x == y.position.x && x.angle == y.angle && x.fell_asleep == y.fell_asleep;
  };
  if (!std::ranges::equal(e.fell_asleep, f.fell_asleep) || !std::ranges::equal(e.woke, f.woke) ||
      !std::ranges::equal(e.moves, f.moves, moves) || !std::ranges::equal(e.fluid_begin, f.fluid_begin) ||
      !std::ranges::equal(e.fluid_end, f.fluid_end)) {
    return false;
  }
  return std::ranges::equal(e.begin, f.begin, bodies) && std::ranges::equal(e.end, f.end, bodies) &&
         std::ranges::equal(e.hits, f.hits, hits) && std::ranges::equal(e.sensor_begin, f.sensor_begin, felt) &&
         std::ranges::equal(e.sensor_end, f.sensor_end, felt);
}

std::string broken_promise(World& world, bool questions) {
  for (const std::string& fault : {state_fault(world), event_fault(world), snapshot_fault(world), contact_fault(world),
                                   questions ? plan_fault(world) + query_fault(world) + look_fault(world) : ""}) {
    if (!fault.empty()) return fault;
  }
  if (world.dynamic_count() + world.static_count() > world.body_count()) return "counts by type";
  if (world.state_hash() != world.state_hash()) return "two hashes of one state";
  // Bodies as heavy and fast as may be have more energy than a double holds; that is no fault.
  if (std::isnan(world.diagnostics().max_penetration)) return "diagnostics: max_penetration";
  if (world.memory_bytes() > std::size_t{1} << 30) return "memory_bytes: over 1 GiB";
  return {};
}

std::string events_answer(const World& world) {
  std::string answer;
  const auto add = [&](const auto& events) {
    for (const auto& e : events) answer += std::to_string(e.a.index) + "-" + std::to_string(e.b.index) + ";";
    answer += "|";
  };
  const Events events = world.events();
  add(events.begin);
  add(events.end);
  add(events.hits);
  for (const HitEvent& hit : events.hits)
    answer += text(hit.point.x) + " " + text(hit.normal.y) + " " + text(hit.speed) + ";";
  add(events.sensor_begin);
  add(events.sensor_end);
  return answer;
}

std::string report_answer(const StepReport& r) {
  const StepDetail& d = r.detail;
  std::string answer;
  for (const std::uint64_t n :
       {r.pairs, r.contacts, std::uint64_t{r.colours}, r.awake, r.asleep, std::uint64_t{r.fast},
        std::uint64_t{r.stopped}, std::uint64_t{r.escaped}, std::uint64_t{r.quarantined}, std::uint64_t{d.substeps},
        std::uint64_t{d.solves}, std::uint64_t{d.frames}, std::uint64_t{d.horizon}, std::uint64_t{d.pieces},
        std::uint64_t{d.wakes}, std::uint64_t{d.sweeps}}) {
    answer += std::to_string(n) + " ";
  }
  return answer + text(r.predicted_ms) + " " + text(r.virial);
}

std::string ray_answer(const World& world, Vec2 from, Vec2 to, const QueryFilter& filter) {
  const auto first = world.ray_cast(from, to, filter);
  const auto all = world.ray_cast_all(from, to, filter);
  if (first.has_value() != !all.empty()) return "fault: one way finds a body, the other none";
  if (first && text(*first) != text(all.front())) {
    return "fault: ray_cast " + text(*first) + " ray_cast_all " + text(all.front());
  }
  std::string answer;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const RayHit& hit = all[k];
    if (!world.is_valid(hit.body)) return "fault: a ray hits a body that is not there";
    if (!finite(hit.point) || !finite(hit.normal)) return "fault: a ray's hit is not finite";
    if (!(hit.fraction >= 0 && hit.fraction <= 1)) return "fault: fraction " + text(hit.fraction);
    if (k > 0 && hit.fraction < all[k - 1].fraction) return "fault: rays: nearest first";
    answer += text(hit);
  }
  return answer;
}

std::string cast_answer(const World& world, const Shape& shape, Vec2 from, double angle, Vec2 way, double rotation,
                        const QueryFilter& filter) {
  const auto hit = world.shape_cast(shape, from, angle, way, rotation, filter);
  if (!hit) return {};
  if (!world.is_valid(hit->body)) return "fault: a cast meets a body that is not there";
  if (!finite(hit->point) || !finite(hit->normal)) return "fault: what a cast meets is not finite";
  if (!(hit->fraction >= 0 && hit->fraction <= 1)) return "fault: fraction of a cast " + text(hit->fraction);
  return std::to_string(hit->body.index) + " at " + text(hit->fraction) + " " + text(hit->point.x) + " " +
         text(hit->normal.y);
}

std::string near_answer(const World& world, const Shape& shape, Vec2 at, double reach, const QueryFilter& filter) {
  std::vector<NearHit> near(4);
  const std::size_t count = world.nearby(shape, at, 0.3, reach, near, filter);
  std::string answer = std::to_string(count);
  for (std::size_t k = 0; k < std::min(count, near.size()); ++k) {
    const NearHit& hit = near[k];
    if (!world.is_valid(hit.body)) return "fault: a body nearby is not there";
    if (!finite(hit.point) || !finite(hit.normal) || !(hit.distance <= reach)) return "fault: nearby beyond reach";
    if (k > 0 && hit.distance < near[k - 1].distance) return "fault: nearby: nearest first";
    answer += ' ';
    answer += std::to_string(hit.body.index) + ":" + text(hit.distance) + " " + text(hit.normal.x);
  }
  return answer;
}

std::string mover_answer(World& world, Vec2 at, Vec2 velocity, const QueryFilter& filter) {
  MoverDesc desc;
  desc.filter = filter;
  Mover mover(desc, at);
  std::string answer;
  for (int k = 0; k < 5; ++k) {
    if (!mover.move(world, velocity, 0.05)) return answer + "refused";
    if (!finite(mover.position()) || !finite(mover.velocity())) return "fault: a mover is not finite";
    if (mover.ground() && !world.is_valid(mover.ground()->body)) return "fault: a mover stands on nothing";
    answer += text(mover.position().x) + " " + text(mover.position().y) + (mover.on_ground() ? "on " : "off ");
    velocity.y = mover.velocity().y - 1;
  }
  return answer;
}

std::string bodies_answer(const World& world, const std::vector<BodyId>& bodies) {
  std::string answer;
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    if (!world.is_valid(bodies[k])) return "fault: a question finds a body that is not there";
    if (k > 0 && bodies[k].index <= bodies[k - 1].index) return "fault: bodies by id, each once";
    answer += std::to_string(bodies[k].index) + ";";
  }
  return answer;
}

std::string closest_answer(const World& world, Vec2 point, double reach, const QueryFilter& filter) {
  const auto hit = world.closest(point, reach, filter);
  if (!hit) return {};
  if (!world.is_valid(hit->body)) return "fault: the nearest body is not there";
  if (!finite(hit->point) || !(hit->distance >= 0 && hit->distance <= reach)) {
    return "fault: the nearest body is beyond reach";
  }
  return std::to_string(hit->body.index) + " at " + text(hit->distance) + " " + text(hit->point.x) + " " +
         text(hit->point.y);
}

}  // namespace psim::fuzz
