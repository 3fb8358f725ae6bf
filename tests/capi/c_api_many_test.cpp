// Many bodies in one call of the C API.
#include <vector>

#include "c_api_support.h"

namespace psim::test {
namespace {

struct ManyDiscs : CWorld {
  std::vector<psim_body_id> ids;
  ManyDiscs() {
    for (int k = 0; k < 6; ++k) ids.push_back(add(psim_disc(0.5), {3.0 * k, 10}));
    ids.push_back(add(psim_disc(0.5), {0, -30}, PSIM_BODY_STATIC));
    EXPECT_EQ(psim_world_remove_body(world, ids[4]), PSIM_OK);
  }
  std::vector<psim_body_state> states() const {
    std::vector<psim_body_state> all(ids.size());
    std::size_t known = 0;
    EXPECT_EQ(psim_world_states_of(world, ids.data(), ids.size(), all.data(), &known), PSIM_OK) << last();
    EXPECT_EQ(known, 6u);
    return all;
  }
};

// One body is gone and one is static: five can be moved.
TEST(CApiMany, ChangesThoseThatCanBeChanged) {
  ManyDiscs c;
  const std::size_t n = c.ids.size();
  const std::vector<psim_vec2> places(n, psim_vec2{1, 2}), pushes(n, psim_vec2{3, 4});
  const std::vector<double> turns(n, 0.5);
  std::size_t changed = 99;
  ASSERT_EQ(psim_world_set_velocities(c.world, c.ids.data(), n, pushes.data(), turns.data(), &changed), PSIM_OK);
  EXPECT_EQ(changed, 5u);
  EXPECT_EQ(c.states()[0].vx, 3);
  EXPECT_EQ(c.states()[5].omega, 0.5);
  EXPECT_EQ(c.states()[4].id.index, 0xFFFFFFFFu);
  ASSERT_EQ(psim_world_apply_impulses(c.world, c.ids.data(), n, pushes.data(), nullptr), PSIM_OK);
  EXPECT_GT(c.states()[0].vy, 4);
  ASSERT_EQ(psim_world_set_transforms(c.world, c.ids.data(), n, places.data(), turns.data(), &changed), PSIM_OK);
  EXPECT_EQ(changed, 5u);
  EXPECT_NEAR(c.states()[2].x, 1, 1e-6);
  EXPECT_EQ(c.states()[2].angle, 0.5);
  ASSERT_EQ(psim_world_apply_forces(c.world, c.ids.data(), n, pushes.data(), &changed), PSIM_OK);
  EXPECT_EQ(changed, 5u);
  ASSERT_EQ(psim_world_set_enabled_of(c.world, c.ids.data(), n, 0, &changed), PSIM_OK);
  EXPECT_EQ(changed, 6u);
  EXPECT_EQ(psim_world_dynamic_count(c.world), 0u);
  ASSERT_EQ(psim_world_set_enabled_of(c.world, c.ids.data(), n, 1, &changed), PSIM_OK);
  EXPECT_EQ(psim_world_dynamic_count(c.world), 5u);
  ASSERT_EQ(psim_world_remove_bodies(c.world, c.ids.data(), n, &changed), PSIM_OK);
  EXPECT_EQ(changed, 6u);
  EXPECT_EQ(psim_world_body_count(c.world), 0u);
}

TEST(CApiMany, TraitsLieAStrideApart) {
  ManyDiscs c;
  std::vector<psim_body_traits> traits(c.ids.size());
  for (std::size_t k = 0; k < traits.size(); ++k) {
    psim_body_traits_init(&traits[k]);
    EXPECT_EQ(psim_world_traits(c.world, c.ids[k], &traits[k]), k == 4 ? PSIM_ERROR_STALE_ID : PSIM_OK);
    traits[k].surface.friction = 0.1 * static_cast<double>(k);
  }
  const auto set = [&](std::size_t stride, std::size_t& changed) {
    return psim_world_set_traits_of(c.world, c.ids.data(), c.ids.size(), traits.data(), stride, &changed);
  };
  std::size_t changed = 99;
  ASSERT_EQ(set(sizeof(psim_body_traits), changed), PSIM_OK) << c.last();
  EXPECT_EQ(changed, 6u);
  psim_body_traits now;
  psim_body_traits_init(&now);
  ASSERT_EQ(psim_world_traits(c.world, c.ids[3], &now), PSIM_OK);
  EXPECT_NEAR(now.surface.friction, 0.3, 1e-7);

  EXPECT_EQ(set(7, changed), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(changed, 0u);
  traits[2].struct_size = 4;
  EXPECT_EQ(set(sizeof(psim_body_traits), changed), PSIM_ERROR_STRUCT_SIZE);
  EXPECT_NE(c.last().find("traits[2]"), std::string::npos) << c.last();
}

TEST(CApiMany, MissingArraysAreRefused) {
  ManyDiscs c;
  const std::size_t n = c.ids.size();
  const std::vector<psim_vec2> vectors(n);
  const std::vector<double> numbers(n);
  std::size_t changed = 99;
  const psim_result results[] = {
      psim_world_set_velocities(c.world, nullptr, n, vectors.data(), numbers.data(), &changed),
      psim_world_set_velocities(c.world, c.ids.data(), n, nullptr, numbers.data(), &changed),
      psim_world_set_velocities(c.world, c.ids.data(), n, vectors.data(), nullptr, &changed),
      psim_world_set_transforms(c.world, c.ids.data(), n, vectors.data(), nullptr, &changed),
      psim_world_apply_impulses(c.world, c.ids.data(), n, nullptr, &changed),
      psim_world_apply_forces(c.world, nullptr, n, vectors.data(), &changed),
      psim_world_set_enabled_of(c.world, nullptr, n, 1, &changed),
      psim_world_set_traits_of(c.world, c.ids.data(), n, nullptr, sizeof(psim_body_traits), &changed),
      psim_world_remove_bodies(c.world, nullptr, n, &changed),
      psim_world_states_of(c.world, c.ids.data(), n, nullptr, &changed)};
  for (const psim_result result : results) EXPECT_EQ(result, PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(changed, 0u);
  EXPECT_EQ(psim_world_set_velocities(c.world, nullptr, 0, nullptr, nullptr, &changed), PSIM_OK);
  EXPECT_EQ(psim_world_set_enabled_of(nullptr, c.ids.data(), n, 1, &changed), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_world_body_count(c.world), 6u);
}

}  // namespace
}  // namespace psim::test
