#include "forces.h"

#include <cmath>

#include "tasks.h"

namespace psim {

double linear_drag(const std::vector<Field>& fields) {
  double k = 0;
  for (const Field& f : fields) {
    if (const auto* drag = std::get_if<DragField>(&f)) k += drag->linear;
  }
  return k;
}

bool needs_forces(const std::vector<Field>& fields) {
  for (const Field& f : fields) {
    if (std::holds_alternative<WellField>(f)) return true;
    if (std::get<DragField>(f).quadratic != 0) return true;
  }
  return false;
}

// Whole powers by squaring, the fraction bit by bit through square roots (to 2^-30).
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

Forces::Forces(std::vector<Field> fields, Vec2 gravity, const Lattice& lattice)
    : gravity_(gravity), lattice_(&lattice) {
  for (const Field& f : fields) {
    if (const auto* well = std::get_if<WellField>(&f)) wells_.push_back(*well);
    if (const auto* drag = std::get_if<DragField>(&f)) quadratic_ += drag->quadratic;
  }
}

// Drag is split off as Strang does, half a kick, drag, half a kick; the drag alone is exact,
//   dv/dt = -q |v| v:  v(h) = v(0) / (1 + q |v(0)| h),
// and so stable however strong it is.
void Forces::accelerations(BodyStore& b, double h, WorkerPool& pool) const {
  const std::uint32_t blocks = b.blocks();
  const Vec2 centre = lattice_->centre();
  pool.run(stream_tasks(blocks), [&](std::size_t t) {
    const BlockRange r = stream_range(t, blocks);
    const std::uint32_t end = std::min(b.count, r.end * kernels::kBlock);
    for (std::uint32_t i = r.begin * kernels::kBlock; i < end; ++i) {
      const Surface& info = b.surface(b.id[i] == kNoSlot ? 0 : b.id[i]);
      double ax = 0, ay = 0;
      if (b.id[i] != kNoSlot && info.inv_mass > 0) {
        const double scale = static_cast<double>(info.gravity_scale);
        ax = gravity_.x * scale;
        ay = gravity_.y * scale;
        const double vx = static_cast<double>(b.vel[2 * i]);
        const double vy = static_cast<double>(b.vel[2 * i + 1]);
        const double x = b.pos[2 * i] * lattice_->pitch_x() + static_cast<double>(b.disp[2 * i]);
        const double y =
            b.pos[2 * i + 1] * lattice_->pitch_y() + static_cast<double>(b.disp[2 * i + 1]);
        for (const WellField& w : wells_) {
          const double dx = (w.position.x - centre.x) - (x + h / 2 * vx);
          const double dy = (w.position.y - centre.y) - (y + h / 2 * vy);
          const double d2 = dx * dx + dy * dy;
          if (w.range > 0 && d2 > w.range * w.range) continue;
          const double s = d2 + w.softening * w.softening;
          if (!(s > 0)) continue;
          const double f = w.strength * scale / deterministic_power(s, (w.exponent + 1) / 2);
          ax += f * dx;
          ay += f * dy;
        }
        if (quadratic_ != 0) {
          const double ux = vx + h / 2 * ax, uy = vy + h / 2 * ay;
          const double rate = quadratic_ * std::sqrt(ux * ux + uy * uy);
          const double lost = rate / (1 + rate * h);  // (u(0) - u(h)) / (h u(0))
          ax -= lost * ux;
          ay -= lost * uy;
        }
      }
      b.acc[2 * i] = static_cast<float>(ax);
      b.acc[2 * i + 1] = static_cast<float>(ay);
    }
  });
}

// a = k d / (d^2 + e^2)^((n+1)/2):  U = -k (d^2 + e^2)^((1-n)/2) / (n - 1), or k ln(s)/2 for n = 1.
double Forces::potential(Vec2 p) const {
  double sum = 0;
  for (const WellField& w : wells_) {
    const double dx = w.position.x - p.x, dy = w.position.y - p.y;
    const auto at = [&](double d2) {
      const double s = d2 + w.softening * w.softening;
      if (!(s > 0)) return 0.0;
      if (w.exponent == 1) return w.strength * std::log(s) / 2;
      const double half = (w.exponent - 1) / 2;
      const double power = half >= 0 ? 1 / deterministic_power(s, half)
                                     : deterministic_power(s, -half);
      return -w.strength * power / (w.exponent - 1);
    };
    const double d2 = dx * dx + dy * dy;
    if (w.range > 0) {
      if (d2 < w.range * w.range) sum += at(d2) - at(w.range * w.range);
    } else {
      sum += at(d2);
    }
  }
  return sum;
}

}  // namespace psim
