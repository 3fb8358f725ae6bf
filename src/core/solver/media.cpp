#include "solver/media.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/elementary.h"
#include "base/tasks.h"

namespace psim {
namespace {

constexpr std::size_t kImmersedBodies = 512;  // a job
constexpr double kRound = 0.98;               // cosine of the angle between two corners of a round outline
constexpr std::size_t kMostCorners = 96;      // of an outline, and of what is left of it in a box

// The outline of a part in world axes, seen from the centre of mass of its body: a polygon, counter-clockwise.
struct Corners {
  std::array<Vec2, kMostCorners> at;
  std::size_t count = 0;
  void add(Vec2 p) {
    if (count < kMostCorners) at[count++] = p;
  }
  Vec2 next(std::size_t k) const { return at[k + 1 < count ? k + 1 : 0]; }
};

// Corners around a vertex, from one normal of length 1 to another. They lie a little outside of the arc, so that the area
// is right.
void add_arc(Vec2 vertex, double radius, Vec2 from, Vec2 to, Corners& out) {
  const double c = dot(from, to);
  if (c > kRound) {
    const double s2 = 1 - c * c;
    out.add(vertex + radius * (1 + s2 / 12) * from);
    return;
  }
  const Vec2 sum = from + to;
  const double length = length_of(sum);
  const Vec2 middle = length > 1e-3 ? (1 / length) * sum : upright(from);
  add_arc(vertex, radius, from, middle, out);
  add_arc(vertex, radius, middle, to, out);
}

Corners outline_of(const Hull& hull, SineCosine turn) {
  Corners out;
  const auto vertex = [&](int k) { return turned(turn, hull.vertex(k)); };
  if (hull.count == 1) {
    for (const Vec2 from : {Vec2{1, 0}, Vec2{-1, 0}}) add_arc(vertex(0), hull.radius, from, -1.0 * from, out);
    return out;
  }
  const auto normal = [&](int k) {
    const Vec2 edge = vertex(hull.next(k)) - vertex(k);
    return (-1 / length_of(edge)) * upright(edge);
  };
  for (int k = 0; k < hull.count; ++k) {
    if (hull.radius == 0) {
      out.add(vertex(k));
      continue;
    }
    const Vec2 before = normal(k == 0 ? hull.count - 1 : k - 1), behind = normal(k);
    add_arc(vertex(k), hull.radius, before, behind, out);
    out.add(vertex(k) + double{hull.radius} * behind);
  }
  return out;
}

// What of an outline lies where at(p) <= limit.
template <class At>
Corners cut(const Corners& from, double limit, const At& at) {
  Corners out;
  for (std::size_t k = 0; k < from.count; ++k) {
    const Vec2 p = from.at[k], q = from.next(k);
    const double of_p = at(p) - limit, of_q = at(q) - limit;
    if (of_p <= 0) out.add(p);
    if ((of_p < 0 && of_q > 0) || (of_p > 0 && of_q < 0)) out.add(p + (of_p / (of_p - of_q)) * (q - p));
  }
  return out;
}

// The part of an outline in a box.
Corners cut(const Corners& from, const Bounds& box) {
  Corners out = cut(from, box.ymax, [](Vec2 p) { return p.y; });
  out = cut(out, -box.ymin, [](Vec2 p) { return -p.y; });
  out = cut(out, box.xmax, [](Vec2 p) { return p.x; });
  return cut(out, -box.xmin, [](Vec2 p) { return -p.x; });
}

struct Area {
  double area = 0;  // m^2
  Vec2 moment;      // m^3: the area times its centroid
};
Area area_of(const Corners& c) {
  Area sum;
  for (std::size_t k = 2; k < c.count; ++k) {
    const Vec2 p = c.at[0], q = c.at[k - 1], r = c.at[k];
    const double twice = cross(q - p, r - p);
    sum.area += twice / 2;
    sum.moment = sum.moment + (twice / 6) * (p + q + r);
  }
  return sum;
}

// A body at the middle of its way in the step.
class Immersed {
 public:
  Immersed(const WorldDesc& desc, const Lattice& lattice, const BodyStore& b, std::uint32_t slot, double dt)
      : desc_(desc), b_(b), of_(b.properties(b.id[slot])), kind_(b.kinds[of_.kind]), dt_(dt) {
    velocity_ = b.velocity(slot);
    omega_ = b.omega_of(slot);
    place_ = lattice.to_world(b.point(slot)) + 0.5 * dt * velocity_;
    turn_ = sine_cosine(b.angle_of(slot) + 0.5 * dt * omega_);
    push_.slot = slot;
    const double r = of_.radius;
    inv_mass_ = of_.inv_mass;
    inv_inertia_ = r > 0 ? of_.rim_gain / (r * r) : 0;
  }

  void meet(const BuoyancyField& water) {
    const double r = of_.radius;
    const Bounds around{place_.x - r, place_.y - r, place_.x + r, place_.y + r};
    if (!overlap(around, water.region)) return;
    const Bounds region = seen(water.region);
    Area whole, under;
    each_part(water.mask, [&](const Hull& hull) {
      const Corners corners = outline_of(hull, turn_);
      add(area_of(corners), whole);
      add(area_of(cut(corners, region)), under);
    });
    if (!(under.area > 0) || !(whole.area > 0)) return;
    const Vec2 centre = (1 / under.area) * under.moment;
    push(-water.density * under.area * desc_.gravity, centre);
    // dv/dt = -c (v - flow), of which exp(-c dt) is left after the step.
    const double share = lesser(under.area / whole.area, 1.0);
    const auto slowed = [&](double rate) { return exponential_less_one(-rate * share * dt_) / dt_; };
    push_.acceleration = push_.acceleration + slowed(water.linear_damping) * (velocity_ - water.flow);
    if (inv_inertia_ > 0) push_.rim_acceleration += slowed(water.angular_damping) * omega_ * of_.radius;
  }

  // Each edge that faces the wind takes of it what its width across the wind meets.
  void meet(const WindField& wind) {
    if (wind.region && !contains(*wind.region, place_)) return;
    Vec2 force;
    double torque = 0, rate = 0;
    const auto blow = [&](double width, Vec2 air, Vec2 normal, Vec2 arm) {
      const double speed = length_of(air);
      if (!(speed > 0)) return;
      const Vec2 along = (1 / speed) * air;
      const double facing = -dot(normal, along);
      if (!(facing > 0)) return;
      const double k = 0.5 * wind.density * width * facing * speed;  // N s/m
      const Vec2 lift = -1.0 * normal - facing * along;
      const Vec2 f = k * speed * (wind.drag * along + wind.lift * lift);
      force = force + f;
      torque += cross(arm, f);
      rate += k * (wind.drag + wind.lift) * (inv_mass_ + inv_inertia_ * dot(arm, arm));
    };
    each_part(wind.mask, [&](const Hull& hull) {
      if (hull.count == 1) {
        const Vec2 arm = turned(turn_, hull.vertex(0)), air = wind.velocity - velocity_ - omega_ * upright(arm);
        const double speed = length_of(air);
        if (speed > 0) blow(2 * double{hull.radius}, air, (-1 / speed) * air, arm);
        return;
      }
      const Corners corners = outline_of(hull, turn_);
      for (std::size_t k = 0; k < corners.count; ++k) {
        const Vec2 p = corners.at[k], edge = corners.next(k) - p, arm = p + 0.5 * edge;
        const double width = length_of(edge);
        if (!(width > 0)) continue;
        blow(width, wind.velocity - velocity_ - omega_ * upright(arm), (-1 / width) * upright(edge), arm);
      }
    });
    // However strong the wind, nothing gets faster than it in a step.
    const double kept = 1 / (1 + rate * dt_);
    push_.acceleration = push_.acceleration + kept * inv_mass_ * force;
    push_.rim_acceleration += kept * inv_inertia_ * torque * of_.radius;
  }

  const Push& push() const { return push_; }

 private:
  static void add(const Area& of, Area& sum) {
    sum.area += of.area;
    sum.moment = sum.moment + of.moment;
  }
  void push(Vec2 force, Vec2 arm) {
    push_.acceleration = push_.acceleration + inv_mass_ * force;
    push_.rim_acceleration += inv_inertia_ * cross(arm, force) * of_.radius;
  }
  Bounds seen(const Bounds& r) const {
    return {r.xmin - place_.x, r.ymin - place_.y, r.xmax - place_.x, r.ymax - place_.y};
  }
  // Calls each(hull) for the parts whose category is in a mask. Sensors meet nothing.
  template <class Each>
  void each_part(std::uint32_t mask, const Each& each) const {
    const auto meets = [&](std::uint32_t part) {
      return !b_.is_sensor(kind_, part) && (b_.filter_of(kind_, part).category & mask) != 0;
    };
    if (kind_.hull_count == 0 && meets(0)) each(disc_hull(of_.radius));
    for (std::uint32_t k = 0; k < kind_.hull_count; ++k) {
      if (meets(k)) each(b_.hulls[kind_.first_hull + k]);
    }
  }

  const WorldDesc& desc_;
  const BodyStore& b_;
  const BodyProperties& of_;
  const BodyKind& kind_;
  const double dt_;
  Vec2 place_, velocity_;  // m, m/s
  double omega_ = 0;       // rad/s
  SineCosine turn_;
  double inv_mass_ = 0, inv_inertia_ = 0;
  Push push_;
};

}  // namespace

bool any_medium(const std::vector<Field>& fields) {
  return std::ranges::any_of(fields, [](const Field& f) {
    return std::holds_alternative<WindField>(f) || std::holds_alternative<BuoyancyField>(f);
  });
}

void Media::find(const WorldDesc& desc, const Lattice& lattice, const BodyStore& b, WorkerPool& pool, double dt) {
  const std::size_t jobs = jobs_for(b.count, kImmersedBodies);
  if (found_.size() < jobs) found_.resize(jobs);
  clear();
  run_each(b.count, kImmersedBodies, pool, [&](std::size_t i, std::size_t job) {
    if (b.id[i] == kNoSlot || !(b.properties(b.id[i]).inv_mass > 0)) return;
    Immersed body(desc, lattice, b, static_cast<std::uint32_t>(i), dt);
    for (const Field& field : desc.fields) {
      if (const auto* wind = std::get_if<WindField>(&field)) body.meet(*wind);
      if (const auto* water = std::get_if<BuoyancyField>(&field)) body.meet(*water);
    }
    const Push& push = body.push();
    if (push.acceleration != Vec2{} || push.rim_acceleration != 0) found_[job].push_back(push);
  });
}

std::size_t Media::bytes() const {
  std::size_t sum = found_.capacity() * sizeof(found_[0]);
  for (const std::vector<Push>& some : found_) sum += some.capacity() * sizeof(Push);
  return sum;
}

}  // namespace psim
