#include "solver/flight.h"

#include <algorithm>
#include <cmath>

#include "base/elementary.h"
#include "least.h"

namespace psim {
namespace {

constexpr int kMostImpacts = 96;   // in a step; then the body stays where it met the last one
constexpr int kMostIdle = 3;       // impacts one after another that neither bring the body on nor change its way
constexpr double kUnseen = 1e-4;   // share of the inner radius: a change of the way that is none
constexpr double kAlike = 0.9999;  // normals with a larger cosine between them count as equal
constexpr double kDeeper = 0.1;    // share of the inner radius by which hulls would overlap in an impact

}  // namespace

float way_against(const Surroundings& s, std::size_t i, std::size_t k) {
  const BodyStore& b = s.bodies;
  const float x = b.disp[2 * i] - b.disp[2 * k], y = b.disp[2 * i + 1] - b.disp[2 * k + 1];
  if (b.angle_change.empty()) return std::sqrt(x * x + y * y);
  const float turn = b.angle_change[k], swing = b.kind(b.id[i]).hull_count == 0 ? 0.0f : b.angle_change[i] - turn;
  const Vec2 apart = s.lattice.steps({b.pos[2 * k], b.pos[2 * k + 1]}, {b.pos[2 * i], b.pos[2 * i + 1]});
  const float middle_x = static_cast<float>(apart.x) + x / 2, middle_y = static_cast<float>(apart.y) + y / 2;
  const float ux = x + turn * middle_y, uy = y - turn * middle_x;
  return std::sqrt(ux * ux + uy * uy) + std::fabs(swing) * b.radius[i];
}

Flight::Flight(const Airspace& space, std::uint32_t slot, bool pressed)
    : space_(space),
      slot_(slot),
      pressed_(pressed),
      kind_(b_.kind(b_.id[slot])),
      properties_(b_.properties(b_.id[slot])) {
  const bool shape = kind_.hull_count != 0;
  hulls_ = {shape ? &b_.hulls[kind_.first_hull] : &disc_.emplace(disc_hull(b_.radius[slot])),
            std::max<std::size_t>(1, kind_.hull_count)};
  inner_ = shape ? kind_.inner : b_.radius[slot];
  velocity_ = {b_.velocity(slot), b_.omega_of(slot)};
  fall_ = space.dt * (b_.acc.empty() ? space.gravity : Vec2{b_.acc[2 * slot], b_.acc[2 * slot + 1]});
  const double turned = b_.angle_change.empty() ? velocity_.turn * space.dt : double{b_.angle_change[slot]};
  way_ = {{b_.disp[2 * slot], b_.disp[2 * slot + 1]}, turned};
  angle_ = b_.angle_of(slot) - turned;
}

bool Flight::may_collide_with(std::uint32_t id) const {
  if (space_.filters && !b_.may_collide(kind_, b_.kind(id))) return false;
  return space_.joints == nullptr || !space_.joints->joined(b_.id[slot_], id);
}

// Whether a hull of this body collides with a part of another one, or with a wall (kNoSlot): see Manifolds::Sorter.
bool Flight::collide(const Hull& mine, std::uint32_t id, std::uint32_t part) const {
  if (!space_.filters) return true;
  if (id == kNoSlot) return kind_.first_part == 0 || kind_.sensor || !b_.is_sensor(kind_, number_of(mine));
  return b_.collide(kind_, number_of(mine), b_.kind(id), part);
}

// What is left of a course in this step.
Course Flight::rest_of(const Course& c) const {
  return {c.place(1 - left_), left_ * c.way, c.facing(1 - left_), left_ * c.turn, c.arm};
}

Course Flight::leg() const { return {at_, left_ * way_.along, angle_, left_ * way_.turn}; }

int Flight::run(std::vector<std::uint32_t>& near, std::span<const std::uint32_t> partners) {
  int impacts = 0, idle = 0;
  for (; impacts < kMostImpacts; ++impacts) {
    find(near, partners);
    const Rates before = way_;
    const double share = lesser(first_.share, 1);
    at_ = at_ + share * left_ * way_.along;
    angle_ += share * left_ * way_.turn;
    // From the mean velocity of this part of the way to that of its end: gravity bends it a little.
    way_.along = way_.along + (share - 0.5) * left_ * space_.dt * fall_;
    left_ *= 1 - share;
    if (first_.share > 1) break;
    const bool held = !bounce(near) && share == 0;  // by something else
    idle = share == 0 && is_alike(before) ? idle + 1 : 0;
    if (held || idle == kMostIdle) {
      ++impacts;
      break;
    }
    if (first_.other.slot != kNoSlot) partners = {};
  }
  if (first_.share <= 1) ride();
  if (impacts != 0) store();
  return impacts;
}

// Whether an impact changed the way by less than can be seen. What is pressed and cannot get out is struck again and
// again, and its way comes nearer to its end by a share of what is left.
bool Flight::is_alike(const Rates& before) const {
  const double turned = std::fabs(way_.turn - before.turn) * double{b_.radius[slot_]};
  return length_of(way_.along - before.along) + turned <= kUnseen * double{inner_};
}

// The last impact leads to no way on: for the rest of the step, the body moves with what it met.
void Flight::ride() {
  const Course theirs = rest_of(first_.other.course);
  at_ = theirs.place(1) + turned(sine_cosine(theirs.turn), at_ - theirs.at);
  angle_ += theirs.turn;
}

// Finds the first impact on what is left of the way. An impact ends the leg: other parts of the body that would have
// come out again by the end of the whole one may be deep in something there.
void Flight::find(std::vector<std::uint32_t>& near, std::span<const std::uint32_t> partners) {
  cut_count_ = 1;
  find_all(near, partners);
  while (hulls_.size() > 1 && cut_count_ < kMostCuts && first_.share < cuts_[cut_count_ - 1]) {
    cuts_[cut_count_++] = first_.share;
    find_all(near, partners);
  }
}

void Flight::find_all(std::vector<std::uint32_t>& near, std::span<const std::uint32_t> partners) {
  sunk_ = 0;
  for (double before = -1; before < sunk_;) {  // once more, if the body turned out to lie in something
    before = sunk_;
    first_.share = Approach::kNever;
    if (s_.statics.any()) find_fixed(near);
    if (space_.walls != nullptr) find_walls();
    for (const std::uint32_t slot : space_.kinematics) find_moving(slot, false);
    for (const std::uint32_t slot : partners) find_moving(slot, true);
    if (first_.share > 1) return;
  }
}

// A fixed piece, or what of it is near where the body is and goes.
Hull Flight::seen(std::uint32_t piece, double way) const {
  const LatticePoint start{b_.pos[2 * slot_], b_.pos[2 * slot_ + 1], 0, 0};
  return s_.statics.seen_from(piece, start, 4 * (double{b_.radius[slot_]} + length_of(at_) + way));
}

void Flight::find_fixed(std::vector<std::uint32_t>& near) {
  const std::int32_t x = b_.pos[2 * slot_], y = b_.pos[2 * slot_ + 1];
  const Vec2 way = left_ * way_.along;
  near.clear();
  s_.statics.near_way({x, y, 0, 0}, at_, way, b_.radius[slot_], near);
  looks_ += static_cast<std::uint32_t>(near.size());
  for (const std::uint32_t k : near) {
    const StaticShape& s = s_.statics[k];
    if (disc_ ? s.whole : s.face) continue;
    if (!may_collide_with(s.owner)) continue;
    const Hull piece = seen(k, length_of(way));
    if (s.face) {  // a disc whose centre is inside of a polygon, or about at its face, may leave it
      const Vec2 p = piece.vertex(0), u = piece.vertex(1) - p;
      if (cross(u, at_ - p) > -0.05 * double{b_.radius[slot_]} * length_of(u)) continue;
    }
    Other other;
    other.id = s.owner;
    other.part = s.part;
    other.has = {s.restitution, s.friction, 0, 0};
    if (s.special) other.has = b_.surface_of(s.owner, s.part);
    if (s.special) other.one_way = b_.one_way_of(b_.kind(s.owner), s.part);
    other.fixed = true;
    other.piece = k;
    meet_hull(piece, other);
  }
}

// Looks at the walls of the world, as long segments beside the way.
void Flight::find_walls() {
  const double size = b_.radius[slot_] + length_of(at_) + left_ * length_of(way_.along);
  const LatticePoint here{b_.pos[2 * slot_], b_.pos[2 * slot_ + 1], 0, 0};
  for (const std::uint32_t wall : {kWallLeft, kWallRight, kWallBottom, kWallTop}) {
    const Walls::Face face = space_.walls->face(wall, here, s_.lattice);
    if (face.height > size) continue;
    const Vec2 n{face.nx, face.ny}, foot = -face.height * n, along = 4 * size * upright(n);
    Hull hull;
    hull.count = 2;
    hull.set_vertex(0, foot - along);
    hull.set_vertex(1, foot + along);
    finish_hull(hull);
    Other other;
    other.part = wall;
    other.has = psim::surface_of(s_.wall);
    other.fixed = true;
    meet_hull(hull, other);
  }
}

// The course of another body in the step. It may turn about a point that is not its centre, if the host moves it.
Course Flight::course_of(std::uint32_t slot, bool held) const {
  const BodyKind& kind = b_.kind(b_.id[slot]);
  const double turn = b_.angle_change.empty() ? 0.0 : double{b_.angle_change[slot]}, angle = b_.angle_of(slot) - turn;
  const LatticePoint here{b_.pos[2 * slot_], b_.pos[2 * slot_ + 1]}, there{b_.pos[2 * slot], b_.pos[2 * slot + 1]};
  const Vec2 centre = s_.lattice.steps(here, there), way{b_.disp[2 * slot], b_.disp[2 * slot + 1]};
  if (!held || (kind.centre_x == 0 && kind.centre_y == 0)) return {centre, way, angle, turn};
  const Vec2 before = arm_of(kind, angle), after = arm_of(kind, angle + turn);
  return {centre - before, way - (after - before), angle, turn, {kind.centre_x, kind.centre_y}};
}

// Looks at another body that moves.
void Flight::find_moving(std::uint32_t slot, bool yields) {
  const std::uint32_t id = b_.id[slot];
  if (id == kNoSlot || !may_collide_with(id)) return;
  const BodyKind& kind = b_.kind(id);
  const LatticePoint here{b_.pos[2 * slot_], b_.pos[2 * slot_ + 1]}, there{b_.pos[2 * slot], b_.pos[2 * slot + 1]};
  const Vec2 centre = s_.lattice.steps(here, there), way{b_.disp[2 * slot], b_.disp[2 * slot + 1]};
  const double apart = length_of(centre - at_) - b_.radius[slot_] - b_.radius[slot];
  if (apart > length_of(left_ * way_.along) + length_of(way)) return;
  if (!yields && !pressed_ && left_ == 1 && way_against(s_, slot_, slot) <= kFast * inner_) return;
  Other other;
  other.id = id;
  other.course = course_of(slot, !yields);
  other.velocity = {b_.velocity(slot), b_.omega_of(slot)};
  other.way = {other.course.way, other.course.turn};
  if (!yields) other.velocity = {(1 / space_.dt) * other.way.along, other.way.turn / space_.dt};
  const bool shape = kind.hull_count != 0;
  if (yields) {
    other.slot = slot;
    other.inner = shape ? kind.inner : b_.radius[slot];
  }
  if (!shape) {
    other.has = b_.surface_of(id, 0);
    return meet_hull(disc_hull(b_.radius[slot]), other);
  }
  if (!yields) other.held = slot;
  other.fixed = !yields && other.course.turn == 0;
  meet_hulls(id, other);
}

// Looks at the hulls of a body to whose boxes the circle around this one may come, as seen from that body.
void Flight::meet_hulls(std::uint32_t id, Other other) {
  const BodyKind& kind = b_.kind(id);
  const Course mine = leg(), theirs = rest_of(other.course);
  const auto seen = [&](double share) {
    const SineCosine q = sine_cosine(theirs.facing(share));
    return turned({-q.sine, q.cosine}, mine.place(share) - theirs.place(share)) - theirs.arm;
  };
  const Vec2 from = seen(0), to = seen(1);
  // The way between is an arc. It leaves the chord by no more than `bulge`.
  const double spin = std::fabs(theirs.turn), span = length_of(mine.way - theirs.way);
  const double bulge = spin * (2 * span + spin * (length_of(from + theirs.arm) + span)) / 8;
  const double r = double{b_.radius[slot_]} + bulge;
  const Bounds way{lesser(from.x, to.x) - r, lesser(from.y, to.y) - r, greater(from.x, to.x) + r,
                   greater(from.y, to.y) + r};
  for (std::uint32_t k = 0; k < kind.hull_count; ++k) {
    const Hull& hull = b_.hulls[kind.first_hull + k];
    Bounds box{1e300, 1e300, -1e300, -1e300};
    for (int n = 0; n < hull.count; ++n) {
      const double x = hull.x[n], y = hull.y[n], round = hull.radius;
      box = {lesser(x - round, box.xmin), lesser(y - round, box.ymin), greater(x + round, box.xmax),
             greater(y + round, box.ymax)};
    }
    if (!overlap(box, way)) continue;
    other.part = k;
    other.has = b_.surface_of(id, k);
    if (space_.surfaces) other.one_way = one_way_of(id, k, other.course.angle);
    meet_hull(hull, other);
  }
}

// How a part of this body bounces and rubs.
Surface Flight::surface_of(const Hull& mine) const { return b_.surface_of(properties_, number_of(mine)); }

ContactName Flight::name_with(const Other& other, const Hull& mine) const {
  return ContactName::of(other.id, other.part, b_.id[slot_], number_of(mine));
}

// How the two of an impact bounce and rub together.
Sides Flight::sides_with(const Other& other, const Hull& mine) const {
  const Decisions& decisions = space_.contacts.manifolds.decisions();
  return {other.has, surface_of(mine), decisions.empty() ? nullptr : decisions.surface_of(name_with(other, mine))};
}

// Whether the host lets the two through each other.
bool Flight::is_let_through(const Other& other, const Hull& mine) const {
  const Decisions& decisions = space_.contacts.manifolds.decisions();
  const Decision* const d = decisions.empty() ? nullptr : decisions.find(name_with(other, mine));
  return d != nullptr && d->through;
}

// Takes an impact with a hull, if it is the first one so far.
void Flight::meet_hull(const Hull& hull, const Other& other) {
  const Course mine = leg(), theirs = rest_of(other.course);
  const bool slow =
      !disc_ && other.fixed && length_of(way_.along - other.way.along) <= double{kMostSizes} * b_.radius[slot_];
  for (const Hull& part : hulls_) {
    if (!collide(part, other.id, other.part) || is_let_through(other, part)) continue;
    const Approach pair(hull, theirs, part, mine);
    bool pressed = false;
    Vec2 normal;
    const bool bounced = slow && sides_with(other, part).restitution(s_.mixing) > 0;
    if (bounced && !passes(pair)) continue;
    const double share = strikes(pair, part, lesser(inner_, other.inner), pressed, normal);
    if (!(share < first_.share)) continue;
    if (space_.surfaces && !(!pressed && is_solid(pair, other, part, share))) continue;
    first_ = {share, pressed, normal, other, hull, &part};
  }
}

// Whether a body that bounced in the sweeps of the substeps passed through a hull, or ends deep in it. Between, the
// straight way does not show where the body was and how it turned.
bool Flight::passes(const Approach& pair) const {
  const auto is_through = [&](double share) {
    const Vec2 n = pair.entry(share);
    return n.x != 0 || n.y != 0 || pair.stand(share, 0).distance < -kDeep * inner_;
  };
  return std::any_of(cuts_, cuts_ + cut_count_, is_through);
}

// The share of the leg at which a hull strikes another one, or kNever. It strikes where it first touches, if it would come
// deeper than it lies in something already: a body that slides over tiles meets the sides of the next ones as deep as it
// sank into the last one. A body that touches all the way strikes if it would come deep.
double Flight::strikes(const Approach& pair, const Hull& mine, float inner, bool& pressed, Vec2& normal) {
  const double size = inner, deep = -kDeep * size;
  const double tolerance = kTolerance * size + 1e-6 * (double{mine.reach} + length_of(at_));
  const Approach::Stand start = pair.stand(0, 0);
  sunk_ = greater(lesser(-start.distance, kDeep * size), sunk_);
  const double struck = -kDeeper * size - sunk_;
  const auto strikes_from = [&](double from) {
    const double share = pair.falls_to(0, tolerance, from);
    return share > 1 || pair.falls_to(struck, tolerance, share) > 1 ? Approach::kNever : share;
  };
  if (start.distance > tolerance) return start.advance < 1 ? strikes_from(start.advance) : Approach::kNever;
  // Its middle stays on its side: of a thin shape, the axis of least overlap may point to the other one.
  normal = pair.entry();
  pressed = start.distance <= deep + tolerance || normal.x != 0 || normal.y != 0;
  if (pressed) {  // it comes no deeper
    const bool through = normal.x != 0 || normal.y != 0;
    const double later = pair.falls_to(start.distance - 2 * tolerance, tolerance / 2, 0);
    return later < 1 || through ? 0 : Approach::kNever;
  }
  const double limit = greater(lesser(start.distance, 0) - kDeeper * size, deep);
  const double share = pair.falls_to(limit, tolerance, 0);
  if (share > 1) return Approach::kNever;
  const double from = parts(pair, mine, tolerance);
  if (from < 1) return strikes_from(from);
  return pair.falls_to(deep, tolerance, share) > 1 ? Approach::kNever : share;
}

// The share at which hulls that touch have parted, if they do so at once; else kNever.
double Flight::parts(const Approach& pair, const Hull& mine, double tolerance) const {
  const double way = left_ * (length_of(way_.along) + std::fabs(way_.turn) * mine.reach);  // m, at most
  for (double moved = tolerance; moved < 300 * tolerance && moved < way; moved *= 4) {
    if (pair.stand(moved / way, 0).distance > 2 * tolerance) return moved / way;
  }
  return Approach::kNever;
}

// Calls each(hull, course) for the other pieces of what a shape met: fixed geometry near its way, or kinematic bodies
// that move as one.
template <class Each>
void Flight::each_beside(std::span<const std::uint32_t> near, const Each& each) const {
  const Other& other = first_.other;
  if (disc_) return;
  for (const std::uint32_t slot : other.held == kNoSlot ? std::span<const std::uint32_t>{} : space_.kinematics) {
    const BodyKind& kind = b_.kind(b_.id[slot]);
    const Course course = course_of(slot, true), theirs = rest_of(course);
    const bool as_one = length_of(course.way - other.way.along) < kTolerance * double{inner_} && course.turn == 0 &&
                        other.way.turn == 0 && may_collide_with(b_.id[slot]);
    if (slot != other.held && !(as_one && length_of(theirs.at - at_) < 2 * double{b_.radius[slot_]} + b_.radius[slot]))
      continue;
    for (std::uint32_t k = 0; k < kind.hull_count; ++k) {
      if (collide(*first_.mine, b_.id[slot], k)) each(b_.hulls[kind.first_hull + k], theirs);
    }
  }
  if (other.piece == kNoSlot) return;
  for (const std::uint32_t k : near) {
    const StaticShape& s = s_.statics[k];
    if (k == other.piece || s.face || !may_collide_with(s.owner)) continue;
    if (collide(*first_.mine, s.owner, s.part)) each(seen(k, 0), Course{});
  }
}

// Returns whether the way of the body changed.
bool Flight::bounce(std::span<const std::uint32_t> near) {
  const Other& other = first_.other;
  const Course mine = leg(), theirs = rest_of(other.course);  // both begin with the impact
  const Manifold m = Approach(first_.hull, theirs, *first_.mine, mine).touch(0, 1e30);
  const double length = std::sqrt(double{m.nx} * m.nx + double{m.ny} * m.ny);
  if (m.count == 0 || !(length > 0) || !(properties_.inv_mass > 0)) return false;
  Vec2 n = smoothed({m.nx / length, m.ny / length}, near);
  Touching touching{upright(n), {}};
  const double tolerance = first_.pressed ? 0.2 * double{inner_} : 2 * kTolerance * double{inner_};
  const double most_gap = double{m.count == 2 ? std::min(m.point[0].gap, m.point[1].gap) : m.point[0].gap} + tolerance;
  touching.add(m, mine.at - theirs.at, most_gap);
  each_beside(near, [&](const Hull& hull, const Course& course) {  // a floor of several pieces
    const Manifold beside = Approach(hull, course, *first_.mine, mine).touch(0, 1e30);
    if (dot(n, {beside.nx, beside.ny}) > kAlike) touching.add(beside, mine.at - theirs.at, most_gap);
  });
  const auto inertia = [&](const BodyProperties& p) {
    return b_.rim_speed.empty() ? 0.0 : double{p.rim_gain} / (double{p.radius} * p.radius);
  };
  ImpactSurface s{0, 0, properties_.inv_mass, inertia(properties_)};
  // What presses slowly on a body that is deep already does not bounce.
  const bool slow = first_.pressed && length_of(way_.along - other.way.along) < kFast * inner_;
  const Sides sides = sides_with(other, *first_.mine);
  s.restitution = slow ? 0.0 : double{sides.restitution(s_.mixing)};
  s.friction = double{sides.friction(s_.mixing)};
  const double belt = sides.decided != nullptr ? double{sides.decided->tangent_speed}
                                               : double{sides.b.tangent_speed} + double{sides.a.tangent_speed};
  if (first_.pressed && (first_.normal.x != 0 || first_.normal.y != 0)) {  // it is held at its middle
    n = first_.normal;
    touching = {upright(n), {}};
    const Vec2 middle = first_.mine->middle_at(mine.angle);
    touching.add({mine.at + middle - theirs.at, middle});
  }
  const std::span points(touching.points, touching.count);
  const Rates before = way_;
  Rates their_way = other.way, their_velocity = other.velocity;
  if (other.slot == kNoSlot) {
    s.least = space_.restitution_threshold * space_.dt;
    s.belt = belt * space_.dt;
    collide_rates(their_way, way_, s, n, points);
    s.least = space_.restitution_threshold;
    s.belt = belt;
    const bool bent = way_.along.x != before.along.x || way_.along.y != before.along.y || way_.turn != before.turn;
    way_.along = way_.along + 0.5 * left_ * space_.dt * fall_;
    velocity_.along = velocity_.along - left_ * fall_;  // what gravity gives after the impact
    collide_rates(their_velocity, velocity_, s, n, points);
    velocity_.along = velocity_.along + left_ * fall_;
    return bent;
  }
  // Another body that moves keeps its way in this step, and this one goes along with it.
  const BodyProperties& theirs_of = b_.properties(b_.id[other.slot]);
  s.wa = theirs_of.inv_mass;
  s.ia = inertia(theirs_of);
  s.belt = belt;
  s.least = space_.restitution_threshold;
  collide_rates(their_velocity, velocity_, s, n, points);
  way_ = {other.way.along, 0};
  b_.put_velocity(other.slot, their_velocity.along);
  b_.put_rim_speed(other.slot, their_velocity.turn * b_.radius[other.slot]);
  return true;
}

void Flight::store() const {
  const std::size_t i = slot_;
  b_.clear_remainders(i);
  b_.disp[2 * i] = kernels::snapped(at_.x, kernels::kLeastOffset);
  b_.disp[2 * i + 1] = kernels::snapped(at_.y, kernels::kLeastOffset);
  b_.put_velocity(i, velocity_.along);
  if (b_.rim_speed.empty()) return;
  b_.put_rim_speed(i, velocity_.turn * b_.radius[i]);
  if (b_.angle_change.empty()) return;
  b_.angle_change[i] = static_cast<float>(angle_ - (b_.angle[i] - double{b_.angle_change[i]}));
  b_.angle[i] = angle_;
}

}  // namespace psim
