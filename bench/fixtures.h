// Bodies that kernels are timed on: discs of radius 0.5 m and mass 1 in columns as the engine keeps
// them. Made here rather than by the engine's stores, so that a line measures the kernel and its
// data layout (views.h) and nothing that surrounds it.
#pragma once

#include <cstdint>
#include <vector>

#include "base/column.h"
#include "base/lattice.h"
#include "psim/types.h"
#include "views.h"

namespace psim::bench {

inline constexpr double kRadius = 0.5;      // m
inline constexpr double kStep = 1.0 / 240;  // s: a sixtieth in 4 substeps

/// Where discs are and how fast, metres and m/s.
struct Placement {
  std::vector<double> x, y, vx, vy;
  Bounds bounds;

  std::uint32_t size() const { return static_cast<std::uint32_t>(x.size()); }
};

/// The discs of a built-in scene (`pile`: lattice of 1.02 m, `discs`: gas, 10 m^2 a disc).
Placement scene_placement(const char* scene, std::uint32_t n);

/// Body columns in the order of the placement, whole blocks: at least `spare` more bodies at rest
/// follow the last one.
struct Discs {
  explicit Discs(const Placement& p, std::uint32_t spare = 0);

  std::uint32_t blocks() const;  ///< of the discs, without the spare ones
  kernels::BodyView view();

  MemoryMeter meter;
  Lattice lattice;
  std::uint32_t count = 0;
  Column<std::int32_t> pos{meter}, built{meter};
  Column<float> vel{meter}, vel0{meter}, disp{meter};
  Column<float> radius{meter}, reach{meter};
  Column<float> rim_speed{meter}, rim_speed0{meter}, event_time{meter}, rim_way{meter};
  Column<std::uint8_t> linked{meter};
};

/// Constants of a substep as the solver sets them, without gravity.
kernels::ContactParams contact_params(const Lattice& lattice);
kernels::StreamParams stream_params(const Lattice& lattice);

/// Columns as they were when saved.
class Saved {
 public:
  void keep(Column<float>& column, std::size_t n);
  void restore() const;

 private:
  struct Part {
    float* column;
    std::vector<float> values;
  };
  std::vector<Part> parts_;
};

/// The same numbers on every machine (splitmix64), uniform in [low, high).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  double uniform(double low, double high);

 private:
  std::uint64_t state_;
};

}  // namespace psim::bench
