// What the built-in scenes are made from. One function a scene: (bodies, seed) -> Scene; the seed is
// set by make_builtin. Scenes of discs have exactly that many dynamic discs, 1 m across where a scene
// does not say otherwise. Scenes of rigid bodies have that many of what they are about, besides
// ground and machinery; where their table says so, they know one size only.
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
GroupDesc lattice(std::uint64_t n, const Bounds& region, double radius, double jitter, const Material& material);

/// Adds a static chain or segment.
void add_static(Scene& scene, const char* name, Vec2 position, Shape shape, const Material& material);

// ---- rigid bodies: builtin_rigid.cpp ---------------------------------------------------------------

/// Friction 0.6, no restitution, 1 kg/m^2: the defaults of Box2D 3, whose samples many scenes are.
inline constexpr Material kRigid{1, 0, 0.6};

/// An empty open world with gravity (0, -10).
Scene open_scene(const Bounds& bounds);

BodyDesc rigid(Shape shape, Vec2 position, const Material& material = kRigid);

/// Adds a body without a name and returns its id.
std::uint64_t add(Scene& scene, const BodyDesc& body);

/// Adds a static box by its centre and half its size, as Box2D's samples have their ground.
std::uint64_t add_ground(Scene& scene, Vec2 centre, double half_width, double half_height,
                         const Material& material = kRigid);

/// One of the shapes of a body.
ShapePart part_of(PartShape shape, Vec2 position = {0, 0});

/// An empty explicit group of one shape, to `put` bodies in.
GroupDesc list_of(Shape shape, const Material& material = kRigid);
void put(GroupDesc& group, double x, double y);

/// Joins a and b at a point given in both frames; returns the joint for more settings.
JointDesc& pin(Scene& scene, std::uint64_t a, std::uint64_t b, Vec2 anchor_a, Vec2 anchor_b);

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
// builtin_stacks.cpp
Scene large_pyramid(std::uint64_t n, std::uint64_t seed);
Scene many_pyramids(std::uint64_t n, std::uint64_t seed);
Scene far_pyramid(std::uint64_t n, std::uint64_t seed);
Scene pyramid(std::uint64_t n, std::uint64_t seed);
Scene stack(std::uint64_t n, std::uint64_t seed);
Scene high_mass_ratio_1(std::uint64_t n, std::uint64_t seed);
Scene high_mass_ratio_2(std::uint64_t n, std::uint64_t seed);
Scene high_mass_ratio_3(std::uint64_t n, std::uint64_t seed);
Scene overlap_recovery(std::uint64_t n, std::uint64_t seed);
Scene card_house(std::uint64_t n, std::uint64_t seed);
Scene arch(std::uint64_t n, std::uint64_t seed);
Scene domino_run(std::uint64_t n, std::uint64_t seed);
// builtin_jointed.cpp
Scene joint_grid(std::uint64_t n, std::uint64_t seed);
Scene bridge(std::uint64_t n, std::uint64_t seed);
Scene chain(std::uint64_t n, std::uint64_t seed);
Scene ball_and_chain(std::uint64_t n, std::uint64_t seed);
Scene newtons_cradle(std::uint64_t n, std::uint64_t seed);
Scene rope(std::uint64_t n, std::uint64_t seed);
Scene cloth(std::uint64_t n, std::uint64_t seed);
// builtin_ragdolls.cpp
Scene rain(std::uint64_t n, std::uint64_t seed);
// builtin_basins.cpp
Scene compounds(std::uint64_t n, std::uint64_t seed);
Scene junkyard(std::uint64_t n, std::uint64_t seed);
// builtin_machines.cpp
Scene tumbler(std::uint64_t n, std::uint64_t seed);
Scene washer(std::uint64_t n, std::uint64_t seed);
Scene spinner(std::uint64_t n, std::uint64_t seed);
Scene smash(std::uint64_t n, std::uint64_t seed);
Scene rush(std::uint64_t n, std::uint64_t seed);
Scene boxes_into_discs(std::uint64_t n, std::uint64_t seed);

}  // namespace psim::builtin
