#include "solver/forces.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/elementary.h"
#include "base/tasks.h"

namespace psim {

using kernels::Method;

std::string_view integrator_name(Integrator integrator) {
  constexpr std::string_view kNames[] = {"verlet", "euler", "rk4", "symplectic4"};
  const auto number = static_cast<std::size_t>(integrator);
  return number < std::size(kNames) ? kNames[number] : "?";
}

std::optional<Integrator> parse_integrator(std::string_view name) {
  for (const Integrator integrator : kAllIntegrators) {
    if (name == integrator_name(integrator)) return integrator;
  }
  return std::nullopt;
}

double linear_drag(const std::vector<Field>& fields) {
  double k = 0;
  for (const Field& f : fields) {
    if (const auto* drag = std::get_if<DragField>(&f)) k += drag->linear;
  }
  return k;
}

bool needs_forces(const std::vector<Field>& fields) {
  return std::any_of(fields.begin(), fields.end(), [](const Field& f) {
    const auto* drag = std::get_if<DragField>(&f);
    return std::holds_alternative<WellField>(f) || (drag != nullptr && drag->quadratic != 0);
  });
}

// Computes whole powers by squaring, and the fraction bit by bit through square roots, to 2^-30.
double deterministic_power(double s, double p) {
  const double whole = std::floor(p);
  double result = 1, square = s;
  for (auto n = static_cast<unsigned>(whole); n != 0; n >>= 1) {
    if (n & 1u) result *= square;
    square *= square;
  }
  double fraction = p - whole, root = s;
  for (int bit = 0; bit < 30 && fraction > 0; ++bit) {
    root = std::sqrt(root);
    fraction *= 2;
    if (fraction >= 1) {
      result *= root;
      fraction -= 1;
    }
  }
  return result;
}

Forces::Forces(const WorldDesc& world, const Lattice& lattice)
    : world_(world), lattice_(lattice), linear_(world.linear_damping + linear_drag(world.fields)) {
  const Vec2 centre = lattice.centre();
  for (const Field& f : world.fields) {
    if (const auto* drag = std::get_if<DragField>(&f)) quadratic_ += drag->quadratic;
    const auto* well = std::get_if<WellField>(&f);
    if (!well) continue;
    const double power = (well->exponent + 1) / 2, whole = std::floor(power);
    kernels::WellTerms t;
    t.x = well->position.x - centre.x;
    t.y = well->position.y - centre.y;
    t.strength = well->strength;
    t.softening2 = well->softening * well->softening;
    t.range2 = well->range > 0 ? well->range * well->range : std::numeric_limits<double>::infinity();
    t.whole = static_cast<std::uint32_t>(whole);
    t.fraction = static_cast<std::uint32_t>((power - whole) * 0x1p30) << 2;
    terms_.push_back(t);
  }
}

std::optional<Method> Forces::method() const {
  constexpr std::optional<Method> kMethodOf[] = {std::nullopt, Method::euler, Method::rk4, Method::symplectic4};
  return kMethodOf[static_cast<std::size_t>(world_.integrator)];
}

kernels::FieldParams Forces::params(double h) const {
  kernels::FieldParams p;
  p.wells = terms_.data();
  p.well_count = static_cast<std::uint32_t>(terms_.size());
  if (lattice_.wraps()) {
    p.period_x = 0x1p32 * lattice_.pitch_x();
    p.period_y = 0x1p32 * lattice_.pitch_y();
  }
  p.h = h;
  p.pitch_x = lattice_.pitch_x();
  p.pitch_y = lattice_.pitch_y();
  p.gravity_x = world_.gravity.x;
  p.gravity_y = world_.gravity.y;
  p.linear = linear_;
  p.quadratic = quadratic_;
  p.fade = exponential(-linear_ * h);
  p.half_fade = exponential(-linear_ * h / 2);
  p.fade_span = linear_ > 0 ? -exponential_less_one(-linear_ * h) / linear_ : h;
  p.smooth = method() == Method::euler ? -1 : 4 * h * h;
  return p;
}

void Forces::scale_gravity(BodyStore& b, WorkerPool& pool) const {
  run_stream(b.blocks(), pool, [&](BlockRange r) {
    for (std::uint32_t i = r.begin * kernels::kBlock; i < r.end * kernels::kBlock; ++i) {
      float scale = 0;
      if (i < b.count && b.id[i] != kNoSlot) {
        const BodyProperties& properties = b.properties(b.id[i]);
        if (properties.inv_mass > 0) scale = properties.gravity_scale;
      }
      b.pull[i] = scale;
      b.acc[2 * std::size_t{i}] = kernels::snapped(world_.gravity.x * static_cast<double>(scale));
      b.acc[2 * std::size_t{i} + 1] = kernels::snapped(world_.gravity.y * static_cast<double>(scale));
    }
  });
}

void make_room_for_remainders(BodyStore& b) {
  for (const Column<float>* column : {&b.vel_remainder, &b.disp_remainder}) b.spare.reserve(column->capacity());
}

void move_remainders(BodyStore& b, const std::uint32_t* from, WorkerPool& pool) {
  for (Column<float>* column : {&b.vel_remainder, &b.disp_remainder}) {
    if (column->empty()) continue;
    b.spare.reserve(column->capacity());
    run_stream(b.blocks(), pool, [&](BlockRange r) {
      for (std::size_t i = std::size_t{r.begin} * kernels::kBlock; i < std::size_t{r.end} * kernels::kBlock; ++i) {
        for (std::size_t axis = 0; axis < 2; ++axis) {
          b.spare[2 * i + axis] = i < b.count ? (*column)[2 * std::size_t{from[i]} + axis] : 0.0f;
        }
      }
    });
    column->swap(b.spare);
  }
}

// a = k d / (d^2 + e^2)^((n+1)/2):  U = -k (d^2 + e^2)^((1-n)/2) / (n - 1), or k ln(s)/2 for n = 1.
double Forces::potential(Vec2 p) const {
  double sum = 0;
  for (const Field& f : world_.fields) {
    const auto* w = std::get_if<WellField>(&f);
    if (w == nullptr) continue;
    const auto at = [w](double d2) {
      const double s = d2 + w->softening * w->softening;
      if (!(s > 0)) return 0.0;
      if (w->exponent == 1) return w->strength * logarithm(s) / 2;
      const double half = (w->exponent - 1) / 2;
      const double power = half >= 0 ? 1 / deterministic_power(s, half) : deterministic_power(s, -half);
      return -w->strength * power / (w->exponent - 1);
    };
    Vec2 way = w->position - p;
    if (lattice_.wraps()) {  // to the nearest copy
      const Vec2 period{0x1p32 * lattice_.pitch_x(), 0x1p32 * lattice_.pitch_y()};
      way = way - Vec2{period.x * std::nearbyint(way.x / period.x), period.y * std::nearbyint(way.y / period.y)};
    }
    const double d2 = dot(way, way), range2 = w->range * w->range;
    if (!(w->range > 0)) {
      sum += at(d2);
    } else if (d2 < range2) {
      sum += at(d2) - at(range2);
    }
  }
  return sum;
}

}  // namespace psim
