// Outlines of the C API: the same pieces as in C++, room for them, and what is said of wrong ones.
#include <vector>

#include "c_api_support.h"
#include "outline_support.h"

namespace psim::test {
namespace {

struct CCut {
  std::vector<psim_shape_part> parts;
  std::vector<psim_vec2> corners;
  size_t count = 77;
  char error[256] = "";
  psim_result result;

  CCut(const std::vector<psim_vec2>& outline, double radius, size_t capacity)
      : parts(capacity + 1), corners((capacity + 1) * PSIM_MOST_POLYGON_VERTICES) {
    result = psim_cut_outline(outline.data(), outline.size(), radius, parts.data(), corners.data(), capacity, &count,
                              error, sizeof error);
  }
};

TEST(COutline, HasThePiecesOfCpp) {
  std::mt19937 random(4);
  const Points outline = star(40, 0.5, random);
  std::vector<psim_vec2> vertices;
  for (const Vec2 v : outline) vertices.push_back({v.x, v.y});
  const std::vector<ShapePart> wanted = cut(outline, 0.1);
  size_t count = 0;
  ASSERT_EQ(psim_cut_outline(vertices.data(), vertices.size(), 0.1, nullptr, nullptr, 0, &count, nullptr, 0), PSIM_OK);
  ASSERT_EQ(count, wanted.size());
  const CCut c(vertices, 0.1, count);
  ASSERT_EQ(c.result, PSIM_OK) << c.error;
  ASSERT_EQ(c.count, count);
  for (size_t k = 0; k < count; ++k) {
    const auto& polygon = std::get<PolygonShape>(wanted[k].shape);
    const psim_shape& shape = c.parts[k].shape;
    EXPECT_EQ(shape.type, PSIM_SHAPE_POLYGON);
    EXPECT_EQ(shape.radius, 0.1);
    EXPECT_EQ(c.parts[k].position.x, wanted[k].position.x);
    ASSERT_EQ(shape.vertex_count, polygon.vertices.size());
    for (size_t v = 0; v < shape.vertex_count; ++v) EXPECT_EQ(shape.vertices[v].y, polygon.vertices[v].y);
  }
  EXPECT_EQ(c.parts[count].shape.vertices, nullptr);
  CWorld world;
  psim_body_desc body;
  psim_body_desc_init(&body);
  body.parts = c.parts.data();
  body.part_count = c.count;
  EXPECT_EQ(psim_world_add_body(world.world, &body, nullptr), PSIM_OK) << world.last();
}

TEST(COutline, RefusesWhatIsWrong) {
  const std::vector<psim_vec2> l{{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 3}, {0, 3}};
  const CCut narrow(l, 0, 1);
  EXPECT_EQ(narrow.result, PSIM_ERROR_ARGUMENT);
  EXPECT_STREQ(narrow.error, "psim_cut_outline: there is room for 1 parts of 2");
  EXPECT_EQ(narrow.count, 2u);
  const CCut crossing({{0, 0}, {1, 1}, {1, 0}, {0, 1}}, 0, 2);
  EXPECT_EQ(crossing.result, PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(crossing.count, 0u);
  EXPECT_STREQ(crossing.error,
               "psim_cut_outline: an outline must not cross or touch itself; its edges from vertex 0 to vertex 1 and "
               "from vertex 2 to vertex 3 do");
  EXPECT_STREQ(CCut(std::vector<psim_vec2>(20000), 0, 1).error,
               "psim_cut_outline: an outline has 3 to 10000 vertices, this one has 20000");
  size_t count = 0;
  psim_shape_part part;
  char error[100] = "";
  EXPECT_EQ(psim_cut_outline(nullptr, 3, 0, nullptr, nullptr, 0, &count, error, sizeof error), PSIM_ERROR_ARGUMENT);
  EXPECT_STREQ(error, "psim_cut_outline: only parts, with corners, and error may be NULL");
  EXPECT_EQ(psim_cut_outline(l.data(), l.size(), 0, &part, nullptr, 1, &count, nullptr, 0), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_cut_outline(l.data(), l.size(), 0, nullptr, nullptr, 0, nullptr, nullptr, 0), PSIM_ERROR_ARGUMENT);
}

}  // namespace
}  // namespace psim::test
