// How bodies turn in a substep.
#include <algorithm>
#include <cstring>

#include "least.h"
#include "solver/solver_run.h"

namespace psim {

// Adds to the angles what impacts of discs within the substep did to the ways of their rims. Most blocks of eight bodies had none.
void Solver::Run::turn_by_impacts(BlockRange r) {
  BodyStore& b = s_.bodies;
  for (std::uint32_t block = r.begin; block < r.end; ++block) {
    float* const way = view_.rim_way + std::size_t{block} * 8;
    std::uint64_t bits[4];
    std::memcpy(bits, way, sizeof bits);
    if ((bits[0] | bits[1] | bits[2] | bits[3]) == 0) continue;
    for (std::uint32_t n = block * 8; n < std::min(block * 8 + 8, contacts.solved.count()); ++n) {
      const std::size_t i = contacts.solved.slot(n);
      const double turn = static_cast<double>(view_.rim_way[n]) / static_cast<double>(b.radius[i]);
      b.angle[i] += turn;
      if (params_.turns) view_.angle_change[n] += static_cast<float>(turn);
    }
    std::fill(way, way + 8, 0.0f);
  }
}

// The angles, in double precision. Where there are only discs they go by the last rim speeds, else as turn_bodies() turns
// the arms.
void Solver::Run::turn_angles(BlockRange r) {
  float mean[kTurnChunk], size[kTurnChunk];
  BodyStore& b = s_.bodies;
  const double h = h_;
  const std::uint32_t end = std::min(r.end * 8, contacts.solved.count());
  for (std::uint32_t begin = r.begin * 8; begin < end; begin += kTurnChunk) {
    const std::uint32_t n = std::min(kTurnChunk, end - begin);
    if (params_.turns) {
      find_mean_rim_speeds(begin, n, mean);
    } else {
      std::copy_n(view_.rim_speed + begin, n, mean);
    }
    const float* const radius = b.radius.data() + begin;
    const std::uint8_t* const linked = view_.linked + begin;
    for (std::uint32_t l = 0; l < n; ++l) mean[l] = linked[l] != 0 ? mean[l] : 0.0f;
    if (contacts.solved.compact()) {
      for (std::uint32_t l = 0; l < n; ++l) {
        const std::size_t i = contacts.solved.slot(begin + l);
        b.angle[i] += h * double{mean[l]} / double{b.radius[i]};
      }
      continue;
    }
    double* const angle = b.angle.data() + begin;
    for (std::uint32_t l = 0; l < n; ++l) size[l] = std::max(radius[l], 1e-30f);
    for (std::uint32_t l = 0; l < n; ++l) angle[l] += h * double{mean[l]} / double{size[l]};
  }
}

// The rim speeds by which turn_bodies() turned n bodies from `begin` on.
void Solver::Run::find_mean_rim_speeds(std::uint32_t begin, std::uint32_t n, float* mean) const {
  float bound[kTurnChunk];
  const float *const last = view_.rim_speed + begin, *const first = view_.rim_speed0 + begin;
  const float* const radius = s_.bodies.radius.data() + begin;
  std::fill_n(bound, n, turn_.smooth_limit2);
  if (view_.acc != nullptr) {
    const float* const acc = view_.acc + 2 * std::size_t{begin};
    for (std::uint32_t l = 0; l < n; ++l) {
      bound[l] += 4 * turn_.h * turn_.h * (acc[2 * l] * acc[2 * l] + acc[2 * l + 1] * acc[2 * l + 1]);
    }
  }
  // One choice a loop, of constants: compilers make vectors of such.
  for (std::uint32_t l = 0; l < n; ++l) {
    const float spin = kernels::squarable(first[l]), spun = spin * spin - turn_.least_spin2 * (radius[l] * radius[l]);
    bound[l] = bound[l] < spun ? bound[l] : spun;
  }
  for (std::uint32_t l = 0; l < n; ++l) mean[l] = kernels::squarable(last[l] - first[l]);
  for (std::uint32_t l = 0; l < n; ++l) {
    const float part = mean[l] * mean[l] <= bound[l] ? 0.5f : 0.0f;
    mean[l] = last[l] - part * (last[l] - first[l]);
  }
}

}  // namespace psim
