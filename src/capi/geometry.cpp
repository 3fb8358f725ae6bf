// Geometry of shapes without a world.
#include "psim/geometry.h"

#include <algorithm>
#include <initializer_list>

#include "convert.h"
#include "handle.h"

using namespace psim::capi;

namespace {

// Gives ask(shapes...) to `answer`, if there is one.
template <class Out, class Ask>
psim_result ask_shapes(const char* name, std::initializer_list<const psim_shape*> given, Out* out, const Ask& ask) {
  return alone(name, nullptr, 0, [&](const Call&) -> psim_result {
    if (out == nullptr) return PSIM_ERROR_ARGUMENT;
    std::vector<psim::Shape> shapes;
    for (const psim_shape* shape : given) {
      if (shape == nullptr || !convert(*shape, shapes.emplace_back()).empty()) return PSIM_ERROR_ARGUMENT;
    }
    const auto found = ask(shapes);
    if (!found) return PSIM_NOTHING;
    *out = to_c(*found);
    return PSIM_OK;
  });
}

}  // namespace

psim_result psim_shape_bounds(const psim_shape* shape, psim_pose at, psim_bounds* bounds) {
  return ask_shapes(__func__, {shape}, bounds,
                    [&](const auto& shapes) { return psim::shape_bounds(shapes[0], to_cpp(at)); });
}

psim_result psim_shape_holds(const psim_shape* shape, psim_pose at, psim_vec2 point) {
  psim_vec2 held;
  return ask_shapes(__func__, {shape}, &held, [&](const auto& shapes) -> std::optional<psim::Vec2> {
    if (!psim::shape_holds(shapes[0], to_cpp(at), to_cpp(point))) return {};
    return to_cpp(point);
  });
}

psim_result psim_shape_ray_cast(const psim_shape* shape, psim_pose at, psim_vec2 from, psim_vec2 to,
                                psim_shape_hit* hit) {
  return ask_shapes(__func__, {shape}, hit, [&](const auto& shapes) {
    return psim::shape_ray_cast(shapes[0], to_cpp(at), to_cpp(from), to_cpp(to));
  });
}

psim_result psim_shape_distance(const psim_shape* a, psim_pose at_a, const psim_shape* b, psim_pose at_b,
                                psim_shape_gap* gap) {
  return ask_shapes(__func__, {a, b}, gap, [&](const auto& shapes) {
    return psim::shape_distance(shapes[0], to_cpp(at_a), shapes[1], to_cpp(at_b));
  });
}

psim_result psim_shape_cast(const psim_shape* a, psim_shape_move move_a, const psim_shape* b, psim_shape_move move_b,
                            psim_shape_hit* hit) {
  return ask_shapes(__func__, {a, b}, hit, [&](const auto& shapes) {
    return psim::shape_cast(shapes[0], to_cpp(move_a), shapes[1], to_cpp(move_b));
  });
}

psim_result psim_convex_hull(const psim_vec2* points, size_t count, double tolerance, psim_vec2* hull, size_t capacity,
                             size_t* hull_count) {
  return alone(__func__, nullptr, 0, [&](const Call&) -> psim_result {
    if (hull_count == nullptr || (points == nullptr && count != 0) || (hull == nullptr && capacity != 0)) {
      return PSIM_ERROR_ARGUMENT;
    }
    *hull_count = 0;
    std::vector<psim::Vec2> given(count);
    std::transform(points, points + count, given.begin(), [](psim_vec2 v) { return to_cpp(v); });
    const std::vector<psim::Vec2> found = psim::convex_hull(given, tolerance);
    for (std::size_t k = 0; k < std::min(capacity, found.size()); ++k) hull[k] = to_c(found[k]);
    *hull_count = found.size();
    return found.empty() ? PSIM_NOTHING : PSIM_OK;
  });
}
