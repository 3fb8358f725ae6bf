// Many bodies at once, and bodies beyond the usual sizes: piles, ropes and nets, long chains, giants, towers of very
// unequal masses. Only rich inputs come here.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "world_descs.h"
#include "world_session.h"

namespace psim::fuzz {
namespace {

// Bodies times segments of long chains: all of them may be near each other.
constexpr std::size_t kMostNear = 100'000;
constexpr double kTurn = 6.283185307179586;  // radians of a full turn

Vec2 on_circle(double radius, double angle) { return {radius * std::cos(angle), radius * std::sin(angle)}; }

// The vertices of a long chain about the origin. Each form is a stress of its own: bumps, sharp teeth, a wall that
// curls in on itself, a closed ring.
std::vector<Vec2> long_chain(ByteSource& in, std::size_t n) {
  const std::size_t form = in.below(4);
  const double width = one_of(in, {10.0, 24.0, 200.0, 20'000.0}), height = in.number(0, 4);
  const double waves = in.uniform(0.5, 30);
  std::vector<Vec2> vertices;
  for (std::size_t k = 0; k < n; ++k) {
    const double along = static_cast<double>(k) / static_cast<double>(n);  // 0 to 1
    const double x = width * (along - 0.5);
    switch (form) {
      case 0:
        vertices.push_back({x, height * std::sin(waves * kTurn * along)});
        break;
      case 1:
        vertices.push_back({x, k % 2 == 0 ? 0 : height});
        break;
      case 2:
        vertices.push_back(on_circle(width / 2 * (1 - 0.9 * along), waves * along));
        break;
      default:
        vertices.push_back(on_circle(width / 2 + (k % 3 == 0 ? height / 8 : 0), kTurn * along));
    }
  }
  if (!in.tame && in.chance(30) && n > 0) vertices[in.below_wide(n)] = in.vec2(-kHalf, kHalf);
  return vertices;
}

Shape giant(ByteSource& in, double radius) {
  switch (in.below(4)) {
    case 0:
      return BoxShape{2 * radius, 2 * radius, 0};
    case 1:
      return CapsuleShape{{-radius, 0}, {radius, 0}, radius};
    case 2: {
      PolygonShape polygon;
      for (int k = 0; k < 6; ++k) polygon.vertices.push_back(on_circle(radius, kTurn * k / 6));
      return polygon;
    }
    default:
      return DiscShape{radius};
  }
}

}  // namespace

// A group of discs with random sizes and places by a layout; none overlap.
GroupDesc Session::group(std::size_t most) {
  GroupDesc g;
  const std::size_t room = most_bodies_ - std::min(most_bodies_, bodies_.size());
  g.layout = one_of(in_, {Layout::lattice, Layout::hex, Layout::random, Layout::ring});
  g.count = std::min({room, 1 + in_.below_wide(most), kMostNear / (1 + segments_)});
  const double half = one_of(in_, {3.0, 11.5, 28.0, 90.0});
  const Vec2 home = in_.home;
  g.region = {home.x - half, home.y - half, home.x + half, home.y + half};
  const double cell = 2 * half / std::sqrt(static_cast<double>(g.count) + 1);
  g.radius_max = cell * in_.uniform(0.05, g.layout == Layout::random ? 0.3 : 0.45);
  g.radius_min = in_.chance(128) ? g.radius_max : g.radius_max * in_.uniform(0.02, 1);
  g.jitter = in_.uniform(0, 1);
  g.velocity = in_.chance(60) ? in_.vec2(-30, 30) : Vec2{};
  g.velocity_spread = in_.chance(60) ? in_.uniform(0, 10) : 0;
  g.seed = in_.byte();
  g.body.type =
      in_.chance(230) ? BodyType::dynamic_body : one_of(in_, {BodyType::static_body, BodyType::kinematic_body});
  g.body.material = material(in_);
  if (in_.chance(30)) g.body.mass = in_.number(0, 20);
  if (in_.chance(20)) g.body.gravity_scale = in_.number(-1, 2);
  g.body.fixed_rotation = in_.chance(20);
  g.body.bullet = in_.chance(10);
  g.body.filter = filter(in_);
  return g;
}

void Session::add_pile() {
  const GroupDesc g = group(most_bodies_);
  std::string error;
  const auto placed = place_group(g, error);
  say("pile of %zu, layout %d, radius %g to %g, jitter %g: %s", static_cast<std::size_t>(g.count),
      static_cast<int>(g.layout), g.radius_min, g.radius_max, g.jitter, error.c_str());
  if (!placed) return refused(error);
  DiscBatch batch;
  batch.x = placed->x;
  batch.y = placed->y;
  batch.radius = placed->radius;
  batch.vx = placed->vx;
  batch.vy = placed->vy;
  batch.type = g.body.type;
  batch.material = g.body.material;
  batch.mass = g.body.mass;
  batch.gravity_scale = g.body.gravity_scale;
  batch.fixed_rotation = g.body.fixed_rotation;
  batch.bullet = g.body.bullet;
  batch.filter = g.body.filter;
  add(batch);
}

// A rope, a net or a cloth: rows of bodies, each joined to its neighbours. Odd rows of a hex net are shifted.
void Session::add_net() {
  const std::size_t columns = 1 + in_.below(40), rows = in_.chance(90) ? 1 : 1 + in_.below(16);
  if (bodies_.size() + rows * columns > most_bodies_) return;
  const bool hex = in_.chance(80), diagonals = in_.chance(80);
  const std::size_t pins = in_.below(4);
  const double spacing = one_of(in_, {0.3, 0.6, 1.5});
  BodyDesc body;
  body.shape = in_.chance(200) ? Shape(DiscShape{spacing * in_.uniform(0.1, 0.5)})
                               : Shape(BoxShape{spacing * 0.9, spacing * in_.uniform(0.1, 0.9), 0});
  body.material = material(in_);
  const Vec2 corner = in_.place(-kHalf, kHalf / 2);
  JointDesc joint;
  joint.type = one_of(in_, {JointType::distance, JointType::spring, JointType::rope, JointType::revolute});
  joint.stiffness = in_.number(0, 5000);
  joint.damping = in_.number(0, 50);
  joint.collide = in_.chance(60);
  if (joint.type == JointType::revolute) joint.anchor_a = {spacing / 2, 0}, joint.anchor_b = {-spacing / 2, 0};
  say("net of %zu x %zu by joints of type %d", rows, columns, static_cast<int>(joint.type));
  std::vector<BodyId> ids;
  for (std::size_t k = 0; k < rows * columns; ++k) {
    const std::size_t row = k / columns, column = k % columns;
    const double shift = hex && row % 2 == 1 ? 0.5 : 0;
    body.position = {corner.x + spacing * (static_cast<double>(column) + shift),
                     corner.y + spacing * static_cast<double>(row)};
    const bool end = column == 0 || column + 1 == columns, top = row + 1 == rows;
    const bool pinned = pins == 1 ? top && end : pins == 2 ? top : pins == 3 && column == 0;
    body.type = pinned ? BodyType::static_body : BodyType::dynamic_body;
    ids.push_back(add(body));
    if (ids.back() == kNoBody) return;
  }
  const auto tie = [&](std::size_t k, std::size_t other) {
    if (joints_.size() >= most_joints_) return;
    joint.a = ids[k];
    joint.b = ids[other];
    add(joint);
  };
  for (std::size_t k = 0; k < ids.size(); ++k) {
    const bool last_column = k % columns + 1 == columns, last_row = k + columns >= ids.size();
    if (!last_column) tie(k, k + 1);
    if (!last_row) tie(k, k + columns);
    if (!last_column && !last_row && diagonals) tie(k, k + columns + 1);
  }
}

void Session::add_terrain() {
  const std::size_t n = 2 + 4 * static_cast<std::size_t>(in_.byte());
  if (bodies_.size() >= most_bodies_ || bodies_.size() * (segments_ + n) > kMostNear) return;
  BodyDesc d;
  ChainShape chain;
  chain.vertices = long_chain(in_, n);
  chain.loop = in_.chance(100);
  say("chain of %zu", chain.vertices.size());
  segments_ += chain.vertices.size();
  d.shape = chain;
  d.type = in_.chance(160) ? BodyType::static_body : BodyType::kinematic_body;
  d.position = in_.place(-kHalf, kHalf);
  if (in_.chance(60)) d.angle = in_.number(-4, 4);
  if (d.type == BodyType::kinematic_body) d.velocity = in_.vec2(-5, 5), d.angular_velocity = in_.number(-3, 3);
  d.material = material(in_);
  d.filter = filter(in_);
  d.sensor = in_.chance(16);
  add(d);
}

// A body of 1 km to 1,000 km whose surface is near the place where all other bodies are.
void Session::add_giant() {
  if (bodies_.size() >= most_bodies_) return;
  BodyDesc d;
  const double radius = one_of(in_, {1e3, 1e4, 1e5, 1e6});
  d.shape = giant(in_, radius);
  d.type = one_of(in_, {BodyType::dynamic_body, BodyType::static_body, BodyType::kinematic_body});
  const Vec2 near = in_.place(-kHalf, kHalf), way = on_circle(radius, kTurn * in_.uniform(0, 1));
  d.position = {near.x + way.x, near.y + way.y};
  if (in_.chance(80)) d.velocity = in_.vec2(-20, 20);
  if (in_.chance(40)) d.angular_velocity = in_.number(-0.01, 0.01);
  d.material = material(in_);
  if (in_.chance(100)) d.mass = std::pow(10, in_.uniform(-3, 12));
  d.bullet = in_.chance(16);
  d.filter = filter(in_);
  add(d);
}

// A kinematic body of any shape that moves and turns.
void Session::add_kinematic() {
  if (bodies_.size() >= most_bodies_) return;
  BodyDesc d;
  d.type = BodyType::kinematic_body;
  d.shape = shape(in_);
  d.position = in_.place(-kHalf, kHalf);
  d.angle = in_.number(-4, 4);
  d.velocity = in_.vec2(-20, 20);
  d.angular_velocity = in_.number(-20, 20);
  d.material = material(in_);
  d.sensor = in_.chance(30);
  d.filter = filter(in_);
  add(d);
}

// Bodies of very unequal mass on top of each other.
void Session::add_tower() {
  const std::size_t n = 2 + in_.below(12);
  if (bodies_.size() + n > most_bodies_) return;
  const Vec2 foot = in_.place(-kHalf, kHalf / 2);
  const bool boxes = in_.chance(128);
  const double low = in_.uniform(-6, 0), high = low + in_.uniform(0, 6);
  say("tower of %zu, masses 1e%g to 1e%g", n, low, high);
  std::vector<BodyDesc> descs(n);
  for (std::size_t k = 0; k < n; ++k) {
    BodyDesc& d = descs[k];
    d.shape = boxes ? Shape(BoxShape{1, 1, 0}) : Shape(DiscShape{0.5});
    d.position = {foot.x, foot.y + static_cast<double>(k)};
    d.mass = std::pow(10, in_.chance(128) ? low : high);
    d.material.friction = 0.5;
  }
  std::vector<BodyId> ids(n);
  const auto added = change<std::size_t>("add_bodies", [&](auto& w) {
    std::string error;
    const std::size_t got = w.add_bodies(descs, ids, error);
    require((got == n) == error.empty(), "add_bodies: all or an error");
    if (got != n) refused(error);
    return got;
  });
  for (std::size_t k = 0; k < added; ++k) live(ids[k]);
}

// The same for every second, third, ... body, in one call: a velocity or an impulse, or what the digits say.
void Session::push_many() {
  const std::size_t stride = 1 + in_.below(8);
  const bool velocity = in_.chance(128);
  const Vec2 v = in_.vec2(-100, 100);
  const double turn = in_.number(-50, 50);
  const Digits digits(v);
  ByteSource own(digits);
  const std::size_t which = own.chance(64) ? own.below(4) : 4;
  say("push every %zu. body by %zu: %g %g turn %g", stride, which, v.x, v.y, turn);
  std::vector<BodyId> ids;
  std::vector<BodyTraits> traits;
  for (std::size_t k = 0; k < bodies_.size(); k += stride) {
    ids.push_back(bodies_[k]);
    traits.push_back(worlds_.front()->traits(bodies_[k]).value_or(BodyTraits{}));
    traits.back().friction = own.number(0, 1);
  }
  const std::vector<Vec2> vectors(ids.size(), v);
  const std::vector<double> turns(ids.size(), turn);
  const auto changed = change<std::size_t>("changing many bodies", [&](auto& w) {
    switch (which) {
      case 0:
        return w.set_traits_of(ids, traits);
      case 1:
        return w.set_enabled_of(ids, turn > 0);
      case 2:
        return w.apply_forces(ids, vectors);
      case 3:
        return w.set_transforms(ids, vectors, turns);
      default:
        return velocity ? w.set_velocities(ids, vectors, turns) : w.apply_impulses(ids, vectors);
    }
  });
  require(changed <= ids.size(), "more bodies changed than were named");
  std::vector<BodyState> states(ids.size());
  require(worlds_.front()->states_of(ids, states) == ids.size(), "states_of: living ones");
}

void Session::remove_many() {
  const std::size_t stride = 1 + in_.below(5), first = in_.below_wide(bodies_.size());
  say("remove every %zu. body from %zu on", stride, first);
  std::vector<BodyId> gone;
  for (std::size_t k = first; k < bodies_.size(); k += stride) gone.push_back(bodies_[k]);
  const auto removed = change<std::size_t>("remove_bodies", [&](auto& w) { return w.remove_bodies(gone); });
  require(removed == gone.size(), "remove_bodies: living ones");
  bury(gone);
}

}  // namespace psim::fuzz
