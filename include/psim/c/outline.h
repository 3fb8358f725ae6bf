/// @file
/// C API: outlines, simple polygons that may be concave, as the parts of a body.
#pragma once

#include "psim/c/desc.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Most vertices of an outline.
#define PSIM_MOST_OUTLINE_VERTICES 10000

/// Most vertices of a polygon.
#define PSIM_MOST_POLYGON_VERTICES 8

/// Cuts a simple polygon, concave or not, into convex polygons: psim_body_desc::parts. Either way round; the last vertex
/// is joined to the first. Vertices that repeat the one before them, or lie on the line of their neighbours (to 1e-6 of
/// a radian), are left out. `radius`, metres, >= 0, rounds each part; near the cuts roundings overlap, and the body's
/// mass counts them with each part.
///
/// Puts the number of parts into `*count`. `parts` (NULL: only the number is asked for) has room for `capacity` of them,
/// and `corners` for PSIM_MOST_POLYGON_VERTICES as many vertices, to which the parts point: it must stay until the body is
/// added.
///
/// PSIM_ERROR_ARGUMENT, with one line in `error` (may be NULL), if the room does not suffice, and for fewer than 3
/// vertices or more than PSIM_MOST_OUTLINE_VERTICES, numbers out of their ranges, no area, an outline that crosses or
/// touches itself, or is so thin that a part would be no polygon of a body.
PSIM_API psim_result psim_cut_outline(const psim_vec2* vertices, size_t vertex_count, double radius,
                                      psim_shape_part* parts, psim_vec2* corners, size_t capacity, size_t* count,
                                      char* error, size_t error_capacity);

#ifdef __cplusplus
}
#endif
