// Outlines.
#include "psim/outline.h"

#include "convert.h"
#include "handle.h"

using namespace psim::capi;

static_assert(PSIM_MOST_OUTLINE_VERTICES == psim::kMostOutlineVertices);
static_assert(PSIM_MOST_POLYGON_VERTICES == psim::kMostPolygonVertices);

psim_result psim_cut_outline(const psim_vec2* vertices, size_t vertex_count, double radius, psim_shape_part* parts,
                             psim_vec2* corners, size_t capacity, size_t* count, char* error, size_t error_capacity) {
  return alone(__func__, error, error_capacity, [&](const Call& call) -> psim_result {
    if (count == nullptr || (vertices == nullptr && vertex_count != 0) || (parts != nullptr && corners == nullptr)) {
      return call.fail(PSIM_ERROR_ARGUMENT, "only parts, with corners, and error may be NULL");
    }
    *count = 0;
    if (vertex_count > psim::kMostOutlineVertices) {  // they are not even read
      return call.fail(PSIM_ERROR_ARGUMENT, "an outline has 3 to " + std::to_string(psim::kMostOutlineVertices) +
                                                " vertices, this one has " + std::to_string(vertex_count));
    }
    std::vector<psim::Vec2> outline;
    for (std::size_t k = 0; k < vertex_count; ++k) outline.push_back(to_cpp(vertices[k]));
    std::string wrong;
    const std::vector<psim::ShapePart> cut = psim::cut_outline(outline, radius, wrong);
    if (!wrong.empty()) return call.fail(PSIM_ERROR_ARGUMENT, wrong);
    *count = cut.size();
    if (parts == nullptr) return PSIM_OK;
    if (capacity < cut.size()) {
      return call.fail(PSIM_ERROR_ARGUMENT,
                       "there is room for " + std::to_string(capacity) + " parts of " + std::to_string(cut.size()));
    }
    for (std::size_t k = 0; k < cut.size(); ++k) parts[k] = to_c(cut[k], corners + k * PSIM_MOST_POLYGON_VERTICES);
    return PSIM_OK;
  });
}
