#include "solver/continuous.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "base/elementary.h"
#include "base/tasks.h"
#include "least.h"
#include "solver/flight.h"

namespace psim {
namespace {

constexpr std::size_t kTask = 512, kBodies = 2048, kFlights = 16;  // bodies of a job
constexpr std::size_t kFastShare = 8, kFewFast = 32;  // room is made for a share of all bodies, and for so many
constexpr std::size_t kFew = 8;                       // kinematic bodies that are looked at one by one
constexpr float kFastDisc = 0.75f;  // share of its radius by which a disc moves before it could pass thin geometry
// Share of the inner radius: a body that is deeper in a kinematic one is looked at, however slow.
constexpr float kPressed = 0.25f;

// Whether the points of a body moved far for its size.
bool is_fast(const BodyStore& b, std::size_t i, float inner) {
  const float x = b.disp[2 * i], y = b.disp[2 * i + 1];
  const float swing = b.angle_change.empty() ? 0.0f : b.angle_change[i];
  const float rest = Flight::kFast * inner - std::fabs(swing) * b.radius[i], way2 = x * x + y * y;
  return (rest < 0 || way2 > rest * rest) && std::isfinite(way2 + rest);
}

// Whether a disc may have passed thin geometry, on its way or after a bounce that brought it back.
bool is_fast_disc(const BodyStore& b, std::size_t i, float dt) {
  const float x = b.disp[2 * i], y = b.disp[2 * i + 1];
  const auto way = [&](float v) { return kernels::squarable(dt * kernels::snapped(v)); };
  const float vx = way(b.vel[2 * i]), vy = way(b.vel[2 * i + 1]);
  const float limit = kFastDisc * b.radius[i], way2 = std::max(x * x + y * y, vx * vx + vy * vy);
  return way2 > limit * limit && std::isfinite(way2);
}

bool is_free(const BodyStore& b, std::size_t i) {
  if (b.id[i] == kNoSlot || b.linked[i] == 0) return false;
  return b.properties(b.id[i]).type() == BodyType::dynamic_body;
}

float inner_of(const BodyStore& b, std::size_t i) {
  const BodyKind& kind = b.kind(b.id[i]);
  return kind.hull_count != 0 ? kind.inner : b.radius[i];
}

// The squared distance of the way of a disc from a segment, if they do not cross; else 0. p: from the start of the way
// to one end, u: from there to the other.
double distance2(Vec2 way, Vec2 p, Vec2 u) {
  const Vec2 q = p + u;
  const double sp = cross(way, p), sq = cross(way, q), from = cross(u, Vec2{} - p), to = cross(u, way - p);
  if (sp * sq < 0 && from * to < 0) return 0;
  const auto off = [](Vec2 point, Vec2 start, Vec2 along) {
    const double length2 = dot(along, along);
    const double share = length2 > 0 ? std::clamp(dot(point - start, along) / length2, 0.0, 1.0) : 0.0;
    const Vec2 d = point - start - share * along;
    return dot(d, d);
  };
  return std::min({off(p, {}, way), off(q, {}, way), off({}, p, u), off(way, p, u)});
}

// Whether a disc came deeper into a fixed shape than contacts let it, on the straight way that it went in the step.
bool passes(const Surroundings& s, std::size_t i, std::uint32_t number) {
  const BodyStore& b = s.bodies;
  const StaticShape& shape = s.statics[number];
  const Vec2 way{b.disp[2 * i], b.disp[2 * i + 1]};
  const LatticePoint here{b.pos[2 * i], b.pos[2 * i + 1]};
  const double size = double{shape.radius} + (1 - Flight::kDeep) * b.radius[i];
  const Vec2 u = shape.segment ? s.lattice.way(shape.p, shape.q) : Vec2{};
  return !shape.whole && distance2(way, s.lattice.way(here, shape.p), u) < size * size;
}

// The box around the way of a body in the step, m from the centre of the lattice.
Bounds box_of(const Surroundings& s, std::size_t i) {
  const BodyStore& b = s.bodies;
  const Vec2 at = s.lattice.metres(b.pos[2 * i], b.pos[2 * i + 1]), end = at + Vec2{b.disp[2 * i], b.disp[2 * i + 1]};
  const double r = b.radius[i];
  return {lesser(at.x, end.x) - r, lesser(at.y, end.y) - r, greater(at.x, end.x) + r, greater(at.y, end.y) + r};
}

// Whether fixed geometry may lie along the way of a body.
bool near_fixed(const ContinuousInput& in, std::size_t i) {
  const Surroundings& s = in.contacts.surroundings;
  const Bounds box = box_of(s, i);
  if (in.walls != nullptr) {
    const Vec2 low = s.lattice.metres(in.walls->low.x, in.walls->low.y),
               high = s.lattice.metres(in.walls->high.x, in.walls->high.y);
    if (box.xmin < low.x || box.ymin < low.y || box.xmax > high.x || box.ymax > high.y) return true;
  }
  return s.statics.any() && !s.statics.surely_none(box);
}

// The box around a hull, in the axes of its body.
Bounds hull_box(const Hull& hull) {
  Bounds box{1e30, 1e30, -1e30, -1e30};
  for (int k = 0; k < hull.count; ++k) {
    const double x = hull.x[k], y = hull.y[k], round = hull.radius;
    box = {std::min(box.xmin, x - round), std::min(box.ymin, y - round), std::max(box.xmax, x + round),
           std::max(box.ymax, y + round)};
  }
  return box;
}

Bounds united(const Bounds& a, const Bounds& b) {
  return {std::min(a.xmin, b.xmin), std::min(a.ymin, b.ymin), std::max(a.xmax, b.xmax), std::max(a.ymax, b.ymax)};
}

}  // namespace

// Whether a body is fast, as seen from a kinematic one, and its way leads near the box around a part of that one. The way
// is no longer than the two ways and what turning adds (Flight::way_against has it exactly).
bool Continuous::comes_upon(const Surroundings& s, std::size_t i, const Kinematic& k) const {
  const BodyStore& b = s.bodies;
  const Vec2 apart = s.lattice.steps({b.pos[2 * k.slot], b.pos[2 * k.slot + 1]}, {b.pos[2 * i], b.pos[2 * i + 1]});
  const Vec2 at = turned({-k.turn.sine, k.turn.cosine}, apart);
  const double x = b.disp[2 * i] - b.disp[2 * k.slot], y = b.disp[2 * i + 1] - b.disp[2 * k.slot + 1];
  const double far = std::sqrt(x * x + y * y), around = std::fabs(k.change) * (length_of(apart) + far);
  const double reach = double{b.radius[i]} + far + around;
  const auto near = [&](const Bounds& box) {
    const Vec2 off{at.x - std::clamp(at.x, box.xmin, box.xmax), at.y - std::clamp(at.y, box.ymin, box.ymax)};
    return !(dot(off, off) > reach * reach);
  };
  if (!near(k.hull) || !(way_against(s, i, k.slot) > Flight::kFast * inner_of(b, i))) return false;
  return std::any_of(part_boxes_.begin() + k.first_part, part_boxes_.begin() + k.first_part + k.parts, near);
}

// Notes a kinematic body and the boxes of its parts; a disc is one part.
void Continuous::note_kinematic(const Surroundings& s, std::uint32_t slot) {
  const BodyStore& b = s.bodies;
  const BodyKind& kind = b.kind(b.id[slot]);
  const double change = b.angle_change.empty() ? 0 : double{b.angle_change[slot]}, r = b.radius[slot];
  const auto first = static_cast<std::ptrdiff_t>(part_boxes_.size());
  if (kind.hull_count == 0) part_boxes_.push_back({-r, -r, r, r});
  for (std::uint32_t k = 0; k < kind.hull_count; ++k) part_boxes_.push_back(hull_box(b.hulls[kind.first_hull + k]));
  const auto parts = static_cast<std::ptrdiff_t>(part_boxes_.size()) - first;
  const Bounds hull = std::accumulate(part_boxes_.begin() + first + 1, part_boxes_.end(),
                                      part_boxes_[static_cast<std::size_t>(first)], united);
  kinematics_.push_back({box_of(s, slot), slot, hull, sine_cosine(b.angle_of(slot) - change), change, first, parts});
  const Bounds& box = kinematics_.back().box;
  widest_ = greater(box.xmax - box.xmin, widest_);
}

// The kinematic bodies by the left edges of their boxes, to find those along a way.
void Continuous::sort_kinematics(const ContinuousInput& in) {
  const Surroundings& s = in.contacts.surroundings;
  kinematics_.clear();
  part_boxes_.clear();
  widest_ = 0;
  for (const auto& [id, velocity] : in.kinematics) {
    if (s.bodies.kind(id).sensor) continue;
    note_kinematic(s, s.bodies.info[id].slot);
  }
  // Total order: the left edge, then the slot.
  std::ranges::sort(kinematics_, {}, [](const Kinematic& k) { return std::pair(k.box.xmin, k.slot); });
  kinematic_slots_.clear();
  for (const Kinematic& k : kinematics_) kinematic_slots_.push_back(k.slot);
}

// Whether a body is so fast that it may have met a kinematic body that its lists do not name, since it bounced or was
// thrown, and which ones are there.
bool Continuous::may_come_upon(const Surroundings& s, std::size_t i) const {
  if (kinematics_.empty()) return false;
  const BodyStore& b = s.bodies;
  const float x = b.disp[2 * i], y = b.disp[2 * i + 1], limit = Flight::kFast * inner_of(b, i);
  if (!(x * x + y * y > limit * limit)) return false;
  const auto meets = [&](const Kinematic& k) { return comes_upon(s, i, k); };
  if (s.lattice.wraps() || kinematics_.size() <= kFew) return std::ranges::any_of(kinematics_, meets);
  const Bounds mine = box_of(s, i);
  const auto left = [](const Kinematic& k) { return k.box.xmin; };
  auto k = std::ranges::lower_bound(kinematics_, mine.xmin - widest_, {}, left);
  for (; k != kinematics_.end() && k->box.xmin <= mine.xmax; ++k) {
    if (overlap(k->box, mine) && meets(*k)) return true;
  }
  return false;
}

// Fast shapes.
void Continuous::find_shapes(const ContinuousInput& in) {
  const BodyStore& b = in.contacts.surroundings.bodies;
  const std::vector<std::uint32_t>& slots = in.contacts.manifolds.shaped();
  jobs_.resize(std::max(jobs_.size(), jobs_for(slots.size(), kTask)));
  const Surroundings& s = in.contacts.surroundings;
  const bool fixed = in.walls != nullptr || s.statics.any();
  run_each(slots.size(), kTask, s.pool, [&](std::size_t k, std::size_t n) {
    const std::uint32_t i = slots[k];
    if (b.id[i] == kNoSlot || b.linked[i] == 0) return;
    const BodyProperties& properties = b.properties(b.id[i]);
    const BodyKind& kind = b.kinds[properties.kind];
    if (!is_fast(b, i, kind.inner) || properties.type() != BodyType::dynamic_body) return;
    jobs_[n].fast = true;
    if ((fixed && near_fixed(in, i)) || may_come_upon(s, i)) jobs_[n].found.push_back(i);
  });
}

// Discs that are deep in fixed geometry by what their contacts say.
void Continuous::find_deep_discs(const ContinuousInput& in) {
  const Surroundings& s = in.contacts.surroundings;
  const BodyStore& b = s.bodies;
  const StaticLanes& lanes = in.contacts.discs.fixed;
  const auto dt = static_cast<float>(in.dt);
  jobs_.resize(std::max(jobs_.size(), in.table.strips.size()));
  s.pool.run(in.table.strips.size(), [&](std::size_t n) {
    Job& job = jobs_[n];
    for (const StaticPair& pair : in.table.static_contacts[n]) {
      const std::size_t i = pair.body, l = pair.contact;
      if (pair.shape >= kWallLeft || b.linked[i] == 0) continue;
      job.fast = job.fast || is_fast_disc(b, i, dt);
      const float end = lanes.gap[l] + (lanes.nx[l] * b.disp[2 * i] + lanes.ny[l] * b.disp[2 * i + 1]);
      if (end < -Flight::kDeep * b.radius[i] && is_free(b, i) && passes(s, i, pair.shape))
        job.found.push_back(pair.body);
    }
  });
}

// Fast discs that went through fixed geometry. Their contacts know what lay straight ahead of them, but not what they met
// after a bounce, or when others threw them.
void Continuous::find_fast_discs(const ContinuousInput& in) {
  const Surroundings& s = in.contacts.surroundings;
  const BodyStore& b = s.bodies;
  const auto dt = static_cast<float>(in.dt);
  jobs_.resize(std::max(jobs_.size(), jobs_for(b.count, kBodies)));
  run_each(b.count, kBodies, s.pool, [&](std::size_t i, std::size_t n) {
    if (b.linked[i] == 0 || !is_fast_disc(b, i, dt) || !is_free(b, i) || b.kind(b.id[i]).hull_count != 0) return;
    Job& job = jobs_[n];
    const Vec2 way{b.disp[2 * i], b.disp[2 * i + 1]};
    job.near.clear();
    if (near_fixed(in, i)) s.statics.near_way({b.pos[2 * i], b.pos[2 * i + 1]}, {}, way, b.radius[i], job.near);
    if (std::ranges::any_of(job.near, [&](std::uint32_t k) { return passes(s, i, k); }) || may_come_upon(s, i)) {
      job.found.push_back(static_cast<std::uint32_t>(i));
    }
  });
}

// Bodies that something presses deep into fixed or kinematic geometry, and those that kinematic bodies come upon.
void Continuous::find_pressed(const ContinuousInput& in) {
  const Surroundings& s = in.contacts.surroundings;
  const BodyStore& b = s.bodies;
  for (std::size_t n = 0; n < in.contacts.manifolds.strip_count(); ++n) {
    for (const std::uint32_t k : in.contacts.manifolds.strip(n).watched) {
      const ManifoldPair& pair = in.contacts.manifolds.pairs()[k];
      if (!is_free(b, pair.b)) continue;
      const float inner = inner_of(b, pair.b);
      const bool deep = pair.of_piece() || pair.flying || pair.least_gap() < -kPressed * inner;
      if (deep || way_against(s, pair.b, pair.a) > Flight::kFast * inner) pressed_.push_back(pair.b);
    }
  }
  // Pairs of a disc and a kinematic disc are among those of discs.
  const auto held = [&](std::uint32_t i) { return b.properties(b.id[i]).type() == BodyType::kinematic_body; };
  const auto is_disc = [&](std::uint32_t i) { return b.kind(b.id[i]).hull_count == 0; };
  if (std::ranges::none_of(kinematic_slots_, is_disc)) return;
  for (const Strip& strip : in.table.strips) {
    for (std::uint32_t p = strip.pair_begin; p < strip.pair_end; ++p) {
      const std::uint32_t i = in.table.owner[p], j = in.table.other[p];
      if (held(i) != held(j) && is_free(b, held(i) ? j : i)) pressed_.push_back(held(i) ? j : i);
    }
  }
}

// Fast bullets, and the bodies that they may meet.
void Continuous::find_bullets(const ContinuousInput& in) {
  const BodyStore& b = in.contacts.surroundings.bodies;
  partners_.clear();
  fast_.assign(in.bullets.empty() ? 0 : b.count, 0);
  bool any = false;
  for (const auto& [id] : in.bullets) {
    if (b.info[id].place != Place::moving) continue;  // it sleeps
    const std::uint32_t i = b.info[id].slot;
    if (is_free(b, i) && is_fast(b, i, inner_of(b, i))) fast_[i] = any = true;
  }
  if (!any) return;
  const auto meet_pair = [&](std::uint32_t i, std::uint32_t j) {
    const auto free = [&](std::uint32_t k) { return b.properties(b.id[k]).type() == BodyType::dynamic_body; };
    if (fast_[i] != 0 && free(j)) partners_.emplace_back(i, j);
    if (fast_[j] != 0 && free(i)) partners_.emplace_back(j, i);
  };
  for (const ManifoldPair& pair : in.contacts.manifolds.pairs()) {
    if (pair.a != ManifoldPair::kNone && !pair.moved) meet_pair(pair.a, pair.b);
  }
  for (const Strip& s : in.table.strips) {
    for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) meet_pair(in.table.owner[p], in.table.other[p]);
  }
  std::ranges::sort(partners_);                                                       // total order: both slots
  partners_.erase(std::unique(partners_.begin(), partners_.end()), partners_.end());  // bodies of several parts
}

// Finds all bodies to look at.
void Continuous::find(const ContinuousInput& in) {
  const Surroundings& s = in.contacts.surroundings;
  jobs_.resize(std::max<std::size_t>(jobs_.size(), 1));
  for (Job& job : jobs_) {
    job.found.clear();
    job.looks = job.bent = 0;
    job.fast = false;
  }
  pressed_.clear();
  sort_kinematics(in);
  if (s.statics.any() || !in.kinematics.empty() || in.walls != nullptr) {
    find_shapes(in);
    find_deep_discs(in);
    // Shapes and kinematic bodies, however slow, throw discs that are squeezed.
    const bool thrown = in.contacts.manifolds.any() || !in.kinematics.empty() ||
                        std::ranges::any_of(jobs_, [](const Job& job) { return job.fast; });
    const bool discs = in.contacts.manifolds.shaped().size() < s.bodies.awake();
    if (discs && thrown) find_fast_discs(in);
    find_pressed(in);
  }
  find_bullets(in);
  flying_ = pressed_;
  for (const Job& job : jobs_) flying_.insert(flying_.end(), job.found.begin(), job.found.end());
  for (const auto& [i, j] : partners_) flying_.push_back(i);
  // Total order: slots.
  std::ranges::sort(pressed_);
  std::ranges::sort(flying_);
  flying_.erase(std::unique(flying_.begin(), flying_.end()), flying_.end());
}

// Follows the ways of all bodies that were found. Bullets change the velocities of others: they come last, one by one.
void Continuous::follow(const ContinuousInput& in) {
  const Airspace space{in.contacts,     in.joints.any_exclusions() ? &in.joints : nullptr,
                       in.filters,      in.dt,
                       in.gravity,      in.restitution_threshold,
                       in.walls,        in.surfaces,
                       kinematic_slots_};
  const auto is_bullet = [&](std::uint32_t i) { return !fast_.empty() && fast_[i] != 0; };
  const auto fly = [&](std::uint32_t i, Job& job, std::span<const std::uint32_t> partners) {
    Flight flight(space, i, std::ranges::binary_search(pressed_, i));
    job.bent += flight.run(job.near, partners) != 0 ? 1 : 0;
    job.looks += flight.looks();
  };
  jobs_.resize(std::max(jobs_.size(), jobs_for(flying_.size(), kFlights)));
  run_each(flying_.size(), kFlights, in.contacts.surroundings.pool, [&](std::size_t k, std::size_t n) {
    if (!is_bullet(flying_[k])) fly(flying_[k], jobs_[n], {});
  });
  for (const std::uint32_t i : flying_) {
    if (!is_bullet(i)) continue;
    others_.clear();
    auto p = std::ranges::lower_bound(partners_, std::pair(i, 0u));
    for (; p != partners_.end() && p->first == i; ++p) others_.push_back(p->second);
    fly(i, jobs_[0], others_);
  }
}

void Continuous::make_room(const ContinuousInput& in) {
  const std::size_t bodies = in.contacts.surroundings.bodies.count, most = bodies / kFastShare + kFewFast;
  jobs_.resize(std::max({jobs_.size(), jobs_for(in.contacts.manifolds.shaped().size(), kTask),
                         jobs_for(bodies, kBodies), in.table.strips.size(), jobs_for(most, kFlights)}));
  for (Job& job : jobs_) {
    job.found.reserve(kFewFast);
    job.near.reserve(kFewFast);
  }
  for (std::vector<std::uint32_t>* of : {&pressed_, &flying_, &others_}) of->reserve(most);
  kinematics_.reserve(in.kinematics.size());
  std::size_t parts = 0;
  for (const auto& [id, velocity] : in.kinematics) {
    parts += std::max(1u, in.contacts.surroundings.bodies.kind(id).hull_count);
  }
  part_boxes_.reserve(parts);
  kinematic_slots_.reserve(in.kinematics.size());
  fast_.reserve(in.bullets.empty() ? 0 : bodies);
  partners_.reserve(in.bullets.size());
}

std::uint32_t Continuous::stop(const ContinuousInput& in) {
  find(in);
  if (!flying_.empty()) follow(in);
  fast_count_ = static_cast<std::uint32_t>(flying_.size());
  looked_ = 0;
  std::uint32_t bent = 0;
  for (const Job& job : jobs_) {
    bent += job.bent;
    looked_ += job.looks;
  }
  return bent;
}

}  // namespace psim
