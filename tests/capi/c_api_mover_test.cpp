// The C API: casts of shapes, many rays at once, and characters.
#include "c_api_support.h"

namespace psim::test {
namespace {

TEST(CApi, ShapesAreCastAndManyRaysAtOnce) {
  CWorld c;
  c.add(psim_disc(0.5), {4, 0}, PSIM_BODY_STATIC);
  const psim_body_id far = c.add(psim_disc(0.5), {8, 0}, PSIM_BODY_STATIC);
  const psim_shape disc = psim_disc(0.5);
  psim_shape_cast_hit hit{};
  ASSERT_EQ(psim_world_shape_cast(c.world, &disc, {0, 0}, 0, {10, 0}, 0, nullptr, &hit), PSIM_OK) << c.last();
  EXPECT_EQ(hit.body.index, 0u);
  EXPECT_NEAR(hit.fraction, 0.3, 1e-6);
  EXPECT_NEAR(hit.point.x, 3.5, 1e-6);
  EXPECT_EQ(hit.normal.x, -1);
  EXPECT_EQ(psim_world_shape_cast(c.world, &disc, {0, 9}, 0, {10, 0}, 0, nullptr, &hit), PSIM_NOTHING);
  EXPECT_EQ(psim_world_shape_cast(c.world, nullptr, {0, 9}, 0, {10, 0}, 0, nullptr, &hit), PSIM_ERROR_ARGUMENT);
  psim_query_filter filter;
  psim_query_filter_init(&filter);
  filter.ignore = hit.body;
  ASSERT_EQ(psim_world_shape_cast(c.world, &disc, {0, 0}, 0, {10, 0}, 0, &filter, &hit), PSIM_OK);
  EXPECT_EQ(hit.body.index, far.index);
  filter.struct_size = 24;  // a caller of before there was more in it
  ASSERT_EQ(psim_world_shape_cast(c.world, &disc, {0, 0}, 0, {10, 0}, 0, &filter, &hit), PSIM_OK);
  EXPECT_EQ(hit.body.index, 0u);

  const psim_ray rays[3] = {{{0, 0}, {9, 0}}, {{0, 5}, {9, 5}}, {{9, 0}, {0, 0}}};
  psim_ray_hit hits[3];
  std::size_t met = 0;
  ASSERT_EQ(psim_world_ray_cast_batch(c.world, rays, hits, 3, nullptr, &met), PSIM_OK);
  EXPECT_EQ(met, 2u);
  EXPECT_EQ(hits[0].body.index, 0u);
  EXPECT_EQ(hits[1].body.index, 0xFFFFFFFFu);
  EXPECT_EQ(hits[2].body.index, far.index);
  EXPECT_EQ(psim_world_ray_cast_batch(c.world, nullptr, hits, 3, nullptr, nullptr), PSIM_ERROR_ARGUMENT);

  psim_near_hit near[2];
  std::size_t count = 0;
  ASSERT_EQ(psim_world_nearby(c.world, &disc, {5.5, 0}, 0, 5, nullptr, near, 1, &count), PSIM_OK);
  EXPECT_EQ(count, 2u);
  EXPECT_EQ(near[0].body.index, 0u);
  EXPECT_NEAR(near[0].distance, 0.5, 1e-6);
  EXPECT_EQ(near[0].one_way, 0);
}

TEST(CApi, AMoverWalks) {
  CWorld c;
  const psim_body_id ground = c.add(psim_box(40, 1), {0, -0.5}, PSIM_BODY_STATIC);
  const psim_body_id crate = c.add(psim_box(1, 1), {3, 0.5});
  psim_mover_desc desc;
  psim_mover_desc_init(&desc);
  EXPECT_EQ(desc.struct_size, sizeof desc);
  EXPECT_EQ(desc.step_height, MoverDesc{}.step_height);
  desc.push_force = 1e3;
  psim_mover* mover = nullptr;
  psim_mover* copy = nullptr;
  char error[256];
  ASSERT_EQ(psim_mover_create(&desc, {0, 0.95}, &mover, error, sizeof error), PSIM_OK) << error;
  ASSERT_EQ(psim_mover_create(&desc, {5, 5}, &copy, error, sizeof error), PSIM_OK) << error;
  ASSERT_EQ(psim_world_record(c.world, 10), PSIM_OK);
  psim_mover_state state;
  psim_mover_state_init(&state);
  for (int k = 0; k < 60; ++k) {
    ASSERT_EQ(psim_world_step(c.world, nullptr), PSIM_OK);
    ASSERT_EQ(psim_mover_move(mover, c.world, {3, -0.1}, 1.0 / 60), PSIM_OK) << c.last();
  }
  ASSERT_EQ(psim_mover_get_state(mover, &state), PSIM_OK);
  EXPECT_TRUE(state.on_ground);
  EXPECT_EQ(state.ground.index, ground.index);
  EXPECT_GT(state.position.x, 1.5);
  psim_body_state body;
  ASSERT_EQ(psim_world_body(c.world, crate, &body), PSIM_OK);
  EXPECT_GT(body.x, 3.1);  // it was pushed
  psim_mover_touch touches[16];
  std::size_t count = 0;
  ASSERT_EQ(psim_mover_touches(mover, touches, 16, &count), PSIM_OK);
  EXPECT_GE(count, 1u);
  // The pushes are in the recording.
  const void* bytes = nullptr;
  std::size_t size = 0;
  ASSERT_EQ(psim_world_recording(c.world, &bytes, &size), PSIM_OK);
  std::string wrong;
  const auto replay = Replay::open({static_cast<const std::byte*>(bytes), size}, {}, wrong);
  ASSERT_NE(replay, nullptr) << wrong;
  while (replay->next()) {
  }
  EXPECT_EQ(replay->differs_at(), 0u);
  EXPECT_EQ(replay->world().body({crate.index, crate.generation})->x, body.x);

  ASSERT_EQ(psim_mover_copy(mover, copy), PSIM_OK);
  psim_mover_state other;
  psim_mover_state_init(&other);
  ASSERT_EQ(psim_mover_get_state(copy, &other), PSIM_OK);
  EXPECT_EQ(other.position.x, state.position.x);
  EXPECT_EQ(psim_mover_move(mover, c.world, {kNaN, 0}, 1.0 / 60), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_mover_move(nullptr, c.world, {0, 0}, 1.0 / 60), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_mover_set_position(mover, {kNaN, 0}), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_mover_set_position(mover, {0, 9}), PSIM_OK);
  desc.radius = -1;
  EXPECT_EQ(psim_mover_set_desc(mover, &desc), PSIM_ERROR_ARGUMENT);
  desc.radius = 0.2;
  EXPECT_EQ(psim_mover_set_desc(mover, &desc), PSIM_OK);
  psim_mover_destroy(copy);
  EXPECT_EQ(psim_mover_create(&desc, {kNaN, 0}, &copy, error, sizeof error), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(copy, nullptr);
  psim_mover_destroy(mover);
  psim_mover_destroy(nullptr);
}

}  // namespace
}  // namespace psim::test
