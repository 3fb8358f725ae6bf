// The C API of contacts that the caller decides, of wind and water, and of single parts.
#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "c_api_support.h"

namespace psim::test {
namespace {

psim_body_id add_box(psim_world* world, double x, double y, int type, int asks) {
  psim_body_desc body;
  psim_body_desc_init(&body);
  body.type = type;
  body.shape = psim_box(type == PSIM_BODY_STATIC ? 40 : 1, 1);
  body.position = {x, y};
  body.pre_solve = asks;
  psim_body_id id;
  EXPECT_EQ(psim_world_add_body(world, &body, &id), PSIM_OK);
  return id;
}

psim_vec2 place(psim_world* world, psim_body_id id) {
  psim_body_state state;
  EXPECT_EQ(psim_world_body(world, id, &state), PSIM_OK);
  return {state.x, state.y};
}

struct Host {
  int calls = 0;
  std::vector<psim_new_contact> seen;
};

extern "C" void let_through(void* user, psim_new_contact* contacts, size_t count) {
  auto& host = *static_cast<Host*>(user);
  ++host.calls;
  for (size_t k = 0; k < count; ++k) {
    host.seen.push_back(contacts[k]);
    contacts[k].enabled = 0;
  }
}

TEST(CApiContacts, PartsAreTold) {
  CWorld c;
  psim_shape_part parts[2] = {};
  parts[0].shape = psim_box(1, 1);
  parts[1].shape = psim_disc(0.5);
  parts[1].position = {0, 1};
  psim_body_desc body;
  psim_body_desc_init(&body);
  body.parts = parts;
  body.part_count = 2;
  body.type = PSIM_BODY_STATIC;
  psim_body_id id;
  ASSERT_EQ(psim_world_add_body(c.world, &body, &id), PSIM_OK);
  uint32_t part = 7;
  psim_ray_hit ray;
  ASSERT_EQ(psim_world_ray_cast_part(c.world, {0, 5}, {0, 0}, nullptr, &ray, &part), PSIM_OK);
  EXPECT_EQ(part, 1u);
  EXPECT_EQ(psim_world_ray_cast_part(c.world, {0, 5}, {0, 0}, nullptr, &ray, nullptr), PSIM_OK);
  EXPECT_EQ(psim_world_ray_cast_part(c.world, {0, 5}, {0, 0}, nullptr, nullptr, &part), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(c.last(), "psim_world_ray_cast_part: hit must not be NULL");
  psim_closest_hit closest;
  ASSERT_EQ(psim_world_closest_part(c.world, {0, -2}, 5, nullptr, &closest, &part), PSIM_OK);
  EXPECT_EQ(part, 0u);
  const psim_shape disc = psim_disc(0.1);
  psim_shape_cast_hit cast;
  ASSERT_EQ(psim_world_shape_cast_part(c.world, &disc, {0, 5}, 0, {0, -5}, 0, nullptr, &cast, &part), PSIM_OK);
  EXPECT_EQ(part, 1u);
  psim_near_hit near[1];
  size_t count = 0;
  ASSERT_EQ(psim_world_nearby(c.world, &disc, {0, 1.7}, 0, 0.3, nullptr, near, 1, &count), PSIM_OK);
  EXPECT_EQ(near[0].part, 1u);
  psim_event_options options;
  psim_event_options_init(&options);
  options.hits = 1;
  ASSERT_EQ(psim_world_set_event_options(c.world, &options), PSIM_OK);
  add_box(c.world, 0, 2.5, PSIM_BODY_DYNAMIC, 0);
  psim_events events;
  psim_events_init(&events);
  for (int k = 0; k < 120 && events.hit_count == 0; ++k) {
    ASSERT_EQ(psim_world_step(c.world, nullptr), PSIM_OK);
    ASSERT_EQ(psim_world_events(c.world, &events), PSIM_OK);
  }
  ASSERT_EQ(events.hit_part_count, 1u);
  EXPECT_EQ(events.hit_parts[0].a, 1u);
  const psim_contact* contacts = nullptr;
  const psim_parts* touching = nullptr;
  size_t all = 0;
  ASSERT_EQ(psim_world_contacts(c.world, &contacts, &all), PSIM_OK);
  ASSERT_EQ(psim_world_contact_parts(c.world, &touching, &count), PSIM_OK);
  ASSERT_EQ(count, all);
  ASSERT_GT(count, 0u);
  EXPECT_EQ(touching[0].a, 1u);
  EXPECT_EQ(touching[0].b, 0u);
  EXPECT_EQ(psim_world_contact_parts(c.world, nullptr, &count), PSIM_ERROR_ARGUMENT);
}

TEST(CApiContacts, TheCallerDecides) {
  CWorld c;
  const psim_body_id floor = add_box(c.world, 0, -0.5, PSIM_BODY_STATIC, 1);
  const psim_body_id falls = add_box(c.world, 0, 0.5, PSIM_BODY_DYNAMIC, 0);
  Host host;
  ASSERT_EQ(psim_world_set_pre_solve(c.world, &let_through, &host), PSIM_OK);
  ASSERT_EQ(psim_world_record(c.world, 1), PSIM_OK);
  for (int k = 0; k < 60; ++k) ASSERT_EQ(psim_world_step(c.world, nullptr), PSIM_OK);
  EXPECT_EQ(host.calls, 1);
  ASSERT_EQ(host.seen.size(), 1u);
  EXPECT_EQ(host.seen[0].a.index, floor.index);
  EXPECT_EQ(host.seen[0].b.index, falls.index);
  EXPECT_NEAR(host.seen[0].normal.y, 1, 1e-6);
  EXPECT_EQ(host.seen[0].reserved, 0);
  EXPECT_LT(place(c.world, falls).y, -3);
  const void* bytes = nullptr;
  size_t size = 0;
  ASSERT_EQ(psim_world_recording(c.world, &bytes, &size), PSIM_OK);
  psim_replay* replay = nullptr;
  ASSERT_EQ(psim_replay_open(bytes, size, nullptr, &replay, nullptr, 0), PSIM_OK);
  while (psim_replay_next(replay) == PSIM_OK) {
  }
  EXPECT_EQ(psim_world_state_hash(psim_replay_world(replay)), psim_world_state_hash(c.world));
  psim_replay_close(replay);
  EXPECT_EQ(host.calls, 1);
  ASSERT_EQ(psim_world_set_pre_solve(c.world, nullptr, nullptr), PSIM_OK);
  EXPECT_EQ(psim_world_set_pre_solve(nullptr, nullptr, nullptr), PSIM_ERROR_ARGUMENT);
}

TEST(CApiContacts, WindAndWaterStandBesideTheFields) {
  CWorld c;
  const psim_body_id floats = add_box(c.world, 0, -5, PSIM_BODY_DYNAMIC, 0);
  const psim_field well = psim_well({0, 0}, 0.001, 1);
  psim_medium media[2] = {};
  media[0].type = PSIM_MEDIUM_WATER;
  media[0].region = {-50, -50, 50, 0};
  media[0].density = 2;
  media[0].linear_damping = media[0].angular_damping = 3;
  media[0].mask = 0xFFFFFFFFu;
  media[1].type = PSIM_MEDIUM_WIND;
  media[1].velocity = {3, 0};
  media[1].density = 0.5;
  media[1].drag = 1;
  media[1].mask = 0xFFFFFFFFu;
  ASSERT_EQ(psim_world_set_fields(c.world, &well, 1), PSIM_OK);
  ASSERT_EQ(psim_world_set_media(c.world, media, 2), PSIM_OK);
  psim_world_desc desc;
  psim_world_desc_init(&desc);
  ASSERT_EQ(psim_world_get_desc(c.world, &desc), PSIM_OK);
  ASSERT_EQ(desc.field_count, 1u);
  ASSERT_EQ(desc.medium_count, 2u);
  EXPECT_EQ(desc.media[0].region.ymax, 0);
  EXPECT_EQ(desc.media[1].velocity.x, 3);
  EXPECT_EQ(desc.media[1].has_region, 0);
  for (int k = 0; k < 600; ++k) ASSERT_EQ(psim_world_step(c.world, nullptr), PSIM_OK);
  EXPECT_NEAR(place(c.world, floats).y, 0, 0.01);
  EXPECT_GT(place(c.world, floats).x, 0.5);
  ASSERT_EQ(psim_world_set_fields(c.world, nullptr, 0), PSIM_OK);
  ASSERT_EQ(psim_world_get_desc(c.world, &desc), PSIM_OK);
  EXPECT_EQ(desc.field_count, 0u);
  EXPECT_EQ(desc.medium_count, 2u);
  media[0].density = -1;
  EXPECT_EQ(psim_world_set_media(c.world, media, 1), PSIM_ERROR_ARGUMENT);
  media[0].type = 7;
  EXPECT_EQ(psim_world_set_media(c.world, media, 1), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(c.last(), "psim_world_set_media: medium 0: medium type 7 is none of psim_medium_type, 0 or 1");
  EXPECT_EQ(psim_world_set_media(c.world, nullptr, 1), PSIM_ERROR_ARGUMENT);
  ASSERT_EQ(psim_world_get_desc(c.world, &desc), PSIM_OK);
  EXPECT_EQ(desc.medium_count, 2u);
}

TEST(CApiContacts, PartsOneByOne) {
  CWorld c;
  psim_shape_part parts[2] = {};
  parts[0].shape = psim_box(1, 1);
  parts[1].shape = psim_disc(1);
  parts[1].position = {2, 0};
  psim_body_desc body;
  psim_body_desc_init(&body);
  body.parts = parts;
  body.part_count = 2;
  body.sleepless = 1;
  psim_body_id id;
  ASSERT_EQ(psim_world_add_body(c.world, &body, &id), PSIM_OK);
  psim_body_traits whole;
  psim_body_traits_init(&whole);
  ASSERT_EQ(psim_world_traits(c.world, id, &whole), PSIM_OK);
  EXPECT_EQ(whole.sleepless, 1);
  EXPECT_EQ(psim_world_part_count(c.world, id), 2u);
  psim_part_traits traits;
  psim_part_traits_init(&traits);
  ASSERT_EQ(psim_world_part_traits(c.world, id, 1, &traits), PSIM_OK);
  traits.surface.friction = 0.75;
  traits.user_data = 42;
  ASSERT_EQ(psim_world_set_part_traits(c.world, id, 1, &traits), PSIM_OK);
  psim_part_traits now;
  psim_part_traits_init(&now);
  ASSERT_EQ(psim_world_part_traits(c.world, id, 1, &now), PSIM_OK);
  EXPECT_EQ(now.surface.friction, 0.75);
  EXPECT_EQ(now.user_data, 42u);
  ASSERT_EQ(psim_world_part_traits(c.world, id, 0, &now), PSIM_OK);
  EXPECT_EQ(now.surface.friction, 0);
  EXPECT_EQ(psim_world_part_traits(c.world, id, 2, &now), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(c.last(), "psim_world_part_traits: body 0 has no part 2");
  traits.surface.friction = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(psim_world_set_part_traits(c.world, id, 1, &traits), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_world_part_count(c.world, {7, 0}), 0u);
  EXPECT_EQ(psim_world_part_traits(c.world, {7, 0}, 0, &now), PSIM_ERROR_STALE_ID);
}

}  // namespace
}  // namespace psim::test
