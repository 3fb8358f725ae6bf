// What the built-in scenes are made from. One function a scene: (discs, seed) -> Scene with exactly
// that many dynamic discs; the seed is set by make_builtin. Discs are 1 m across where a scene does
// not say otherwise.
#pragma once

#include <cstdint>

#include "psim/scene.h"

namespace psim::builtin {

/// Side of a lattice cell around a disc of 1 m: a gap of 2 cm.
inline constexpr double kSpacing = 1.02;

/// ceil(sqrt(n)) without rounding errors.
std::uint64_t ceil_sqrt(std::uint64_t n);

/// n cells in rows of at most `columns`, from the corner (x, y) up: a region on which a lattice of n
/// has cells no smaller than `cell`.
Bounds block(std::uint64_t n, std::uint64_t columns, double cell, double x, double y);

/// A lattice of discs with a material.
GroupDesc lattice(std::uint64_t n, const Bounds& region, double radius, double jitter,
                  const Material& material);

/// Adds a static chain or segment.
void add_static(Scene& scene, const char* name, Vec2 position, Shape shape,
                const Material& material);

// builtin_lattice.cpp
Scene discs(std::uint64_t n, std::uint64_t seed);
Scene pile(std::uint64_t n, std::uint64_t seed);
Scene rough_pile(std::uint64_t n, std::uint64_t seed);
Scene dam(std::uint64_t n, std::uint64_t seed);
Scene mixed_sizes(std::uint64_t n, std::uint64_t seed);
Scene gas_periodic(std::uint64_t n, std::uint64_t seed);
// builtin_shapes.cpp
Scene hourglass(std::uint64_t n, std::uint64_t seed);
Scene galton(std::uint64_t n, std::uint64_t seed);
// builtin_lists.cpp
Scene billiard(std::uint64_t n, std::uint64_t seed);
Scene orbits(std::uint64_t n, std::uint64_t seed);

}  // namespace psim::builtin
