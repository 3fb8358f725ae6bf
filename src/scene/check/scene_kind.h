// What sort of scene this is, as far as errors go: `--target-error` and `--target-ms` look settings
// up by kind, and by how far the scene goes in a substep. In: a scene; out: values. O(bodies).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "psim/scene.h"

namespace psim {

enum class SceneKind : std::uint8_t { fields, gas, pile, rough_pile, mixed_masses, joints, shapes, elastic_shapes };
inline constexpr std::array<std::string_view, 8> kSceneKindNames = {
    "fields", "gas", "pile", "rough-pile", "mixed-masses", "joints", "shapes", "elastic-shapes"};

inline std::string_view scene_kind_name(SceneKind kind) { return kSceneKindNames[static_cast<std::size_t>(kind)]; }
std::optional<SceneKind> parse_scene_kind(std::string_view name);

/// Decided from the bodies as they are placed, in this order: wells or quadratic drag: fields; joints or links: joints;
/// no gravity, or restitution of 0.3 or more in bodies that cover less than half of their box: gas, or elastic_shapes
/// where a moving body is no disc; moving bodies that are no discs: shapes; masses that differ tenfold: mixed_masses; friction: rough_pile; else pile.
struct SceneTraits {
  SceneKind kind = SceneKind::pile;
  std::string because;  ///< the traits that decided
  /// 1/s, what a substep h is short or long against; errors of a kind depend on rate h alone.
  ///   fields  sqrt of the steepest sum |k| / (d^2 + e^2)^((n+1)/2) of a body, + q v of drag
  ///   joints  sqrt(a M / (D m)): what a load M, all that hangs together, opens joints of bodies of mass m and
  ///           size D by in a substep; a = g or v^2 / D
  ///   gas, elastic_shapes     collisions of a disc, by Enskog: 8 c g v / (D sqrt(2 pi)), c the share of the area
  ///           covered, g = (1 - 7c/16) / (1 - c)^2, v the r.m.s. speed, falls included
  ///   piles, shapes   sqrt(W g / (w m)): a contact of the lightest body m sags by ~ F / (m omega^2), F from
  ///           the weight W g over the width w, omega ~ 1/h (docs/solver.md)
  double rate = 0;
  std::uint64_t moving = 0;  ///< dynamic bodies
  double size = 0;           ///< m: their mean diameter; a shape counts as the disc of its area
};

SceneTraits traits_of(const Scene& scene);

}  // namespace psim
