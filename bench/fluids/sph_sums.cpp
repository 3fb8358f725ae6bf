// Compiled for AVX2 with fast floats (cmake/PsimFluids.cmake), so that the compiler makes lanes of the inner loops. They
// run over whole groups of eight, which may read beyond a run: see sph_grid.h.
#include "sph_sums.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace psim::fluids {
namespace {

struct Run {
  std::size_t begin, end;
};

Run run_of(const SphGrid& grid, std::uint32_t cell, int row) {
  const std::uint32_t middle = cell + static_cast<std::uint32_t>(row) * grid.across;
  const std::size_t begin = grid.start[middle - 1], end = grid.start[middle + 2];
  return {begin, begin + (end - begin + kLanes - 1) / kLanes * kLanes};
}

// t of the kernel, 0 beyond its reach.
inline float falloff(float dx, float dy, float half_over_h) {
  const float t = 1 - std::sqrt(dx * dx + dy * dy) * half_over_h;
  return t > 0 ? t : 0;
}

}  // namespace

SphKernel::SphKernel(double reach) {
  const double h = reach / 2;
  half_over_h = static_cast<float>(1 / reach);
  w = static_cast<float>(7 / (4 * std::numbers::pi * h * h));
  f = static_cast<float>(35 / (4 * std::numbers::pi * h * h * h * h));
}

void sum_strain_rates(const SphGrid& grid, const SphConstants& k, std::vector<float>& rates) {
  const SphColumns& c = grid.columns;
  const float *x = c.x.data(), *y = c.y.data(), *vx = c.vx.data(), *vy = c.vy.data(), *strain = c.strain.data(),
              *volume = c.volume.data(), *fluid = c.fluid.data();
  const float half = k.kernel.half_over_h;
  const float rest_x = k.gravity_x / (k.sound * k.sound), rest_y = k.gravity_y / (k.sound * k.sound);
  for (std::size_t p = 0; p < grid.slot.size(); ++p) {
    const std::uint32_t i = grid.slot[p];
    const float xi = x[i], yi = y[i], vxi = vx[i], vyi = vy[i], si = strain[i];
    float outflow = 0, spread = 0;
    for (int row = -1; row <= 1; ++row) {
      const Run run = run_of(grid, grid.cell[p], row);
#pragma omp simd reduction(+ : outflow, spread)
      for (std::size_t j = run.begin; j < run.end; ++j) {
        const float dx = xi - x[j], dy = yi - y[j], t = falloff(dx, dy, half);
        const float share = volume[j] * t * t * t;
        outflow += share * ((vxi - vx[j]) * dx + (vyi - vy[j]) * dy);
        spread += share * fluid[j] * (strain[j] - si + rest_x * dx + rest_y * dy);
      }
    }
    // div v = F sum V t^3 (v_i - v_j) . (r_i - r_j).
    rates[p] = k.kernel.f * (2 * k.diffusion * spread - (1 + si) * outflow);
  }
}

void sum_strains(const SphGrid& grid, const SphConstants& k, std::vector<float>& strains) {
  const float *x = grid.columns.x.data(), *y = grid.columns.y.data();
  const float half = k.kernel.half_over_h, scale = k.mass / static_cast<float>(kDensity) * k.kernel.w;
  for (std::size_t p = 0; p < grid.slot.size(); ++p) {
    const std::uint32_t i = grid.slot[p];
    const float xi = x[i], yi = y[i];
    float sum = 0;
    for (int row = -1; row <= 1; ++row) {
      const Run run = run_of(grid, grid.cell[p], row);
#pragma omp simd reduction(+ : sum)
      for (std::size_t j = run.begin; j < run.end; ++j) {
        const float t = falloff(xi - x[j], yi - y[j], half);
        sum += t * t * t * t * (5 - 4 * t);  // 2 q + 1 = 5 - 4 t
      }
    }
    strains[p] = scale * sum - 1;
  }
}

void sum_wall_pressures(SphGrid& grid, const SphConstants& k) {
  SphColumns& c = grid.columns;
  const float *x = c.x.data(), *y = c.y.data(), *strain = c.strain.data(), *pressure = c.pressure.data(),
              *fluid = c.fluid.data();
  const float half = k.kernel.half_over_h, density = static_cast<float>(kDensity);
  for (std::size_t p = 0; p < grid.wall_slot.size(); ++p) {
    const std::uint32_t i = grid.wall_slot[p];
    const float xi = x[i], yi = y[i];
    float shares = 1e-6f, sum = 0;
    for (int row = -1; row <= 1; ++row) {
      const Run run = run_of(grid, grid.wall_cell[p], row);
#pragma omp simd reduction(+ : shares, sum)
      for (std::size_t j = run.begin; j < run.end; ++j) {
        const float dx = xi - x[j], dy = yi - y[j], t = falloff(dx, dy, half);
        const float share = fluid[j] * t * t * t * t * (5 - 4 * t);
        shares += share;
        sum += share * (pressure[j] + density * (1 + strain[j]) * (k.gravity_x * dx + k.gravity_y * dy));
      }
    }
    c.pressure[i] = std::max(sum / shares, 0.0f);
  }
}

void sum_forces(const SphGrid& grid, const SphConstants& k, std::vector<SphParticle>& particles) {
  const SphColumns& c = grid.columns;
  const float *x = c.x.data(), *y = c.y.data(), *vx = c.vx.data(), *vy = c.vy.data(), *volume = c.volume.data(),
              *pressure = c.pressure.data(), *fluid = c.fluid.data();
  const float half = k.kernel.half_over_h, tiny = 1e-4f / (half * half);
  const float density = static_cast<float>(kDensity), inner = 2 * k.viscosity * density;
  const float artificial = k.artificial * density;
  for (std::size_t p = 0; p < grid.slot.size(); ++p) {
    const std::uint32_t i = grid.slot[p];
    const float xi = x[i], yi = y[i], vxi = vx[i], vyi = vy[i], pi = pressure[i];
    float ax = 0, ay = 0;
    for (int row = -1; row <= 1; ++row) {
      const Run run = run_of(grid, grid.cell[p], row);
#pragma omp simd reduction(+ : ax, ay)
      for (std::size_t j = run.begin; j < run.end; ++j) {
        const float dx = xi - x[j], dy = yi - y[j], t = falloff(dx, dy, half);
        const float share = volume[j] * t * t * t, wet = share * fluid[j];
        const float ux = vxi - vx[j], uy = vyi - vy[j];
        const float along =
            share * (pi + pressure[j]) - wet * artificial * (ux * dx + uy * dy) / (dx * dx + dy * dy + tiny);
        ax += along * dx - wet * inner * ux;
        ay += along * dy - wet * inner * uy;
      }
    }
    const float scale = k.kernel.f * volume[i] / k.mass;  // 1 / density_i
    particles[p].ax = static_cast<double>(scale * ax + k.gravity_x);
    particles[p].ay = static_cast<double>(scale * ay + k.gravity_y);
  }
}

void sum_transport_forces(const SphGrid& grid, const SphConstants& k, std::vector<SphParticle>& particles) {
  const SphColumns& c = grid.columns;
  const float *x = c.x.data(), *y = c.y.data(), *vx = c.vx.data(), *vy = c.vy.data(), *volume = c.volume.data(),
              *pressure = c.pressure.data(), *drift_x = c.drift_x.data(), *drift_y = c.drift_y.data();
  const float half = k.kernel.half_over_h, mass = k.mass;
  const float viscous = k.viscosity * static_cast<float>(kDensity);
  for (std::size_t p = 0; p < grid.slot.size(); ++p) {
    const std::uint32_t i = grid.slot[p];
    const float xi = x[i], yi = y[i], vxi = vx[i], vyi = vy[i], pi = pressure[i], volume_i = volume[i];
    const float ui = drift_x[i], wi = drift_y[i], half_density = 0.5f * mass / volume_i;
    float ax = 0, ay = 0, bx = 0, by = 0;
    for (int row = -1; row <= 1; ++row) {
      const Run run = run_of(grid, grid.cell[p], row);
#pragma omp simd reduction(+ : ax, ay, bx, by)
      for (std::size_t j = run.begin; j < run.end; ++j) {
        const float dx = xi - x[j], dy = yi - y[j], t = falloff(dx, dy, half);
        const float areas = t * t * t * (volume_i * volume_i + volume[j] * volume[j]);
        // (rho_j p_i + rho_i p_j) / (rho_i + rho_j), with rho = m / V.
        const float both = (volume_i * pi + volume[j] * pressure[j]) / (volume_i + volume[j] + 1e-30f);
        // Half of (A_i + A_j) . (r_i - r_j), where A = rho v (drift).
        const float mine = half_density * (ui * dx + wi * dy);
        const float yours = 0.5f * mass / (volume[j] + 1e-30f) * (drift_x[j] * dx + drift_y[j] * dy);
        ax += areas * (both * dx - mine * vxi - yours * vx[j] - viscous * (vxi - vx[j]));
        ay += areas * (both * dy - mine * vyi - yours * vy[j] - viscous * (vyi - vy[j]));
        bx += areas * dx;
        by += areas * dy;
      }
    }
    const float scale = k.kernel.f / mass;
    SphParticle& own = particles[p];
    own.ax = static_cast<double>(scale * ax + k.gravity_x), own.ay = static_cast<double>(scale * ay + k.gravity_y);
    own.shift_x = static_cast<double>(scale * k.background * bx);
    own.shift_y = static_cast<double>(scale * k.background * by);
  }
}

}  // namespace psim::fluids
