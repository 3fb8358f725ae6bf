// How much of the cells of a tile bodies take. Shares of area are found on squares of one spacing; the shares of faces
// are those of the squares from the middle of one cell to the next.
#pragma once

#include <array>
#include <vector>

#include "fluid/fluid_bodies.h"

namespace psim {

class FluidCut {
 public:
  FluidCut(FluidGrid& grid, std::size_t tile, const FluidSpace& space, FluidBodies& bodies);
  void run();

 private:
  static constexpr std::int32_t kFirst = -3,
                                kSide = 38;  // squares of a tile and around it: kFirst to kFirst + kSide - 1
  static constexpr float kFar = 1e30f;

  struct Cover {
    std::uint32_t solid;
    std::int32_t a, b;
    float share;
  };
  struct Middle {
    float distance = kFar;  // of the middle of a cell from the nearest shape
    Place2 out, at;         // where it is, or comes out of thin shapes
    std::uint32_t solid = 0;
  };
  struct Most {
    float share = 0;
    std::uint32_t solid = 0;
  };
  struct ClosedFace {
    bool across;  // across x
    std::size_t node;
    Place2 at;
    std::uint32_t body;
    float rest;
  };
  static std::size_t square(std::int32_t a, std::int32_t b) {
    return static_cast<std::size_t>((b - kFirst) * kSide + a - kFirst);
  }
  float total(std::int32_t a, std::int32_t b) const { return total_[square(a, b)]; }
  Place2 middle_of(std::int32_t a, std::int32_t b) const {
    return {(static_cast<float>(a) + 0.5f) * side_x_, (static_cast<float>(b) + 0.5f) * side_y_};
  }
  void add_cover(const Cover& c);
  void cover(std::uint32_t k);
  void cover_tiny(std::uint32_t k, const FluidSolid& s);
  void end_at_walls();
  void find_middles();
  Place2 way_out(Place2 at, const Middle& nearest) const;
  bool closes(std::size_t n, std::size_t m, std::uint32_t& solid) const;
  bool is_shut(std::size_t n, std::size_t m, std::int32_t a, std::int32_t b, float open, std::uint32_t& solid) const;
  void open_faces();
  void see();
  void make_rows();
  void add_body(std::size_t first, std::size_t end);

  FluidGrid& grid_;
  std::size_t t_;
  const FluidTile& tile_;
  const FluidSpace& space_;
  FluidBodies& bodies_;
  std::span<FluidSolid> solids_;
  float side_x_, side_y_;                         // of a square, m
  std::array<float, kSide * kSide> total_{};      // the share of a square that is solid
  std::array<float, kSide * kSide> kernel_{};     // what a kernel of squares sees there that is solid
  std::array<Most, kSide * kSide> most_{};        // the shape that takes most of a square
  std::array<float, kernels::kTileFloats> sees_;  // what the kernel of a cell sees that is open
  std::vector<Cover> covers_;
  std::array<Middle, kernels::kTileFloats> middles_{};
  std::vector<ClosedFace> closed_;
  std::array<float, kernels::kTileFloats> share_u_{}, share_v_{};  // taken by all bodies
  std::array<float, kernels::kTileFloats> su_, sv_, mu_, mv_;      // by one body, and times the arm
};

}  // namespace psim
