// The C API: the same results as the C++ one.
#include <cmath>
#include <cstring>
#include <thread>

#include "c_api_support.h"

namespace psim::test {
namespace {

TEST(CApi, TheSameWorldHasTheSameBitsAsInCpp) {
  WorldDesc desc;
  desc.gravity = {0.5, -9};
  desc.fields = {WellField{{1, 2}, 30, 0.5, 2, 0}, DragField{0.1, 0.02}};
  desc.linear_damping = 0.05;
  desc.substeps = 3;
  desc.wall.friction = 0.3;
  desc.mixing.friction = Mixing::mean;
  std::string error;
  const auto cpp = World::create(desc, {}, error);
  ASSERT_NE(cpp, nullptr) << error;

  psim_world_desc c_desc = CWorld::defaults();
  c_desc.gravity = {0.5, -9};
  const psim_field fields[] = {psim_well({1, 2}, 30, 0.5), psim_drag(0.1, 0.02)};
  c_desc.fields = fields;
  c_desc.field_count = 2;
  c_desc.linear_damping = 0.05;
  c_desc.substeps = 3;
  c_desc.wall.friction = 0.3;
  c_desc.friction_mixing = PSIM_MIXING_MEAN;
  CWorld c(c_desc);
  ASSERT_EQ(c.result, PSIM_OK) << c.error;

  const Vec2 vertices[] = {{0, 0}, {1, 0}, {0.5, 1}};
  const psim_vec2 c_vertices[] = {{0, 0}, {1, 0}, {0.5, 1}};
  const Vec2 ground[] = {{-20, -3}, {0, -4}, {20, -3}};
  const psim_vec2 c_ground[] = {{-20, -3}, {0, -4}, {20, -3}};
  const CompoundShape cross{
      {{BoxShape{1, 0.2}, {}, 0, {}, {}, 0.9}, {DiscShape{0.3}, {0.6, 0}, 0.5, 4, 0.7, {}, Filter{2, 1, 0}}}};
  psim_shape_part c_cross[2] = {};
  c_cross[0].shape = psim_box(1, 0.2);
  c_cross[0].friction = 0.9, c_cross[0].has_friction = 1;
  c_cross[1].shape = psim_disc(0.3);
  c_cross[1].position = {0.6, 0}, c_cross[1].angle = 0.5;
  c_cross[1].density = 4, c_cross[1].has_density = 1;
  c_cross[1].restitution = 0.7, c_cross[1].has_restitution = 1;
  c_cross[1].filter = {2, 1, 0}, c_cross[1].has_filter = 1;
  const std::pair<Shape, psim_shape> shapes[] = {
      {cross, {}},
      {DiscShape{0.4}, psim_disc(0.4)},
      {BoxShape{1, 0.5, 0}, psim_box(1, 0.5)},
      {CapsuleShape{{-1, 0}, {1, 0}, 0.2}, psim_capsule({-1, 0}, {1, 0}, 0.2)},
      {PolygonShape{{std::begin(vertices), std::end(vertices)}, 0}, psim_polygon(c_vertices, 3)},
      {SegmentShape{{-1, 0}, {1, 0.5}}, psim_segment({-1, 0}, {1, 0.5})},
      {ChainShape{{std::begin(ground), std::end(ground)}, false}, psim_chain(c_ground, 3, 0)}};
  std::vector<BodyId> ids;
  for (std::size_t k = 0; k < std::size(shapes); ++k) {
    BodyDesc body;
    psim_body_desc c_body;
    psim_body_desc_init(&c_body);
    body.shape = shapes[k].first;
    c_body.shape = shapes[k].second;
    if (k == 0) c_body.parts = c_cross, c_body.part_count = 2;
    body.position = {static_cast<double>(k) * 2.5, 3};
    c_body.position = psim_xy(body.position.x, 3);
    body.type = k < 6 ? BodyType::dynamic_body : BodyType::static_body;
    c_body.type = k < 6 ? PSIM_BODY_DYNAMIC : PSIM_BODY_STATIC;
    body.material = {2, 0.3, 0.5};
    c_body.material = {2, 0.3, 0.5};
    body.angular_velocity = c_body.angular_velocity = 1;
    if (k == 2) {
      body.linear_damping = c_body.linear_damping = 0.5;
      body.angular_damping = c_body.angular_damping = 0.2;
      body.locks.x = true, c_body.lock_x = 1;
    }
    ids.push_back(cpp->add_body(body, error));
    psim_body_id id{};
    ASSERT_EQ(psim_world_add_body(c.world, &c_body, &id), PSIM_OK) << c.last();
    EXPECT_EQ(id.index, ids.back().index);
  }
  JointDesc joint;
  joint.type = JointType::spring;
  joint.a = ids[0];
  joint.b = ids[1];
  joint.stiffness = 40;
  joint.length = 2;
  cpp->add_joint(joint, error);
  psim_joint_desc c_joint;
  psim_joint_desc_init(&c_joint);
  c_joint.type = PSIM_JOINT_SPRING;
  c_joint.a = {ids[0].index, ids[0].generation};
  c_joint.b = {ids[1].index, ids[1].generation};
  c_joint.stiffness = 40;
  c_joint.has_length = 1;
  c_joint.length = 2;
  ASSERT_EQ(psim_world_add_joint(c.world, &c_joint, nullptr), PSIM_OK) << c.last();

  for (int k = 0; k < 60; ++k) {
    const StepReport a = cpp->step();
    psim_step_report b;
    psim_step_report_init(&b);
    ASSERT_EQ(psim_world_step(c.world, &b), PSIM_OK);
    ASSERT_EQ(a.contacts, b.contacts);
    ASSERT_EQ(a.pairs, b.pairs);
  }
  EXPECT_EQ(psim_world_state_hash(c.world), cpp->state_hash());
}

TEST(CApi, BulkSpawnReadsColumnsAndStrides) {
  struct Particle {
    float unused;
    double x, y, radius;
  };
  std::vector<Particle> particles;
  for (int k = 0; k < 500; ++k) {
    particles.push_back({0, (k % 25) * 2.0, 1.0 + k / 25 * 2.0, 0.3 + 0.001 * k});
  }
  std::vector<double> x, y, r;
  for (const Particle& p : particles) {
    x.push_back(p.x);
    y.push_back(p.y);
    r.push_back(p.radius);
  }
  CWorld strided, plain;
  psim_disc_batch batch;
  psim_disc_batch_init(&batch);
  batch.count = particles.size();
  batch.x = {&particles[0].x, sizeof(Particle)};
  batch.y = {&particles[0].y, sizeof(Particle)};
  batch.radius = {&particles[0].radius, sizeof(Particle)};
  std::uint32_t first = 7;
  ASSERT_EQ(psim_world_add_discs(strided.world, &batch, &first), PSIM_OK) << strided.last();
  EXPECT_EQ(first, 0u);
  batch.x = {x.data(), 0};
  batch.y = {y.data(), sizeof(double)};
  batch.radius = {r.data(), 0};
  ASSERT_EQ(psim_world_add_discs(plain.world, &batch, nullptr), PSIM_OK);
  for (CWorld* w : {&strided, &plain}) {
    for (int k = 0; k < 20; ++k) psim_world_step(w->world, nullptr);
  }
  EXPECT_EQ(psim_world_body_count(plain.world), 500u);
  EXPECT_EQ(psim_world_state_hash(strided.world), psim_world_state_hash(plain.world));

  for (const auto& [bad, what] :
       {std::pair{kNaN, "position must be from -1e9 to 1e9, not nan"},
        {1e9, "position must lie inside the world's bounds, (-500, -500) to (500, 500), not at (1e9, 1)"}}) {
    x[3] = bad;
    ASSERT_EQ(psim_world_add_discs(plain.world, &batch, nullptr), PSIM_ERROR_ARGUMENT);
    EXPECT_EQ(plain.last(), std::string("psim_world_add_discs: disc 3 of the batch: ") + what);
  }
  EXPECT_EQ(psim_world_body_count(plain.world), 500u);
}

TEST(CApi, BodiesInBulkStopAtTheFirstRefused) {
  CWorld c;
  psim_body_desc descs[3];
  for (psim_body_desc& d : descs) psim_body_desc_init(&d);
  descs[0].position = {3, 0};
  descs[1].position = {6, 0};
  descs[2].mass = -1;
  psim_body_id ids[3];
  std::size_t added = 9;
  EXPECT_EQ(psim_world_add_bodies(c.world, descs, 3, sizeof descs[0], ids, &added), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(added, 2u);
  EXPECT_EQ(psim_world_body_count(c.world), 2u);
  EXPECT_EQ(ids[1].index, 1u);
  EXPECT_EQ(c.last().rfind("psim_world_add_bodies: body 2: mass", 0), 0u) << c.last();
}

TEST(CApi, QueriesFillWhatFitsAndCountAll) {
  CWorld c;
  for (int k = 0; k < 5; ++k) c.add(psim_disc(0.5), {k * 2.0, 0});
  psim_body_id ids[2];
  std::size_t count = 0;
  ASSERT_EQ(psim_world_in_region(c.world, {-1, -1, 9, 1}, nullptr, ids, 2, &count), PSIM_OK);
  EXPECT_EQ(count, 5u);
  EXPECT_EQ(ids[1].index, 1u);
  psim_ray_hit hits[8];
  ASSERT_EQ(psim_world_ray_cast_all(c.world, {-2, 0}, {5, 0}, nullptr, hits, 8, &count), PSIM_OK);
  ASSERT_EQ(count, 3u);
  EXPECT_NEAR(hits[2].point.x, 3.5, 1e-6);
  const psim_shape box = psim_box(3, 1);
  ASSERT_EQ(psim_world_overlap(c.world, &box, {7, 0}, 0, nullptr, ids, 2, &count), PSIM_OK);
  EXPECT_EQ(count, 2u);
  psim_closest_hit near{};
  ASSERT_EQ(psim_world_closest(c.world, {4, 3}, 10, nullptr, &near), PSIM_OK);
  EXPECT_EQ(near.body.index, 2u);
  EXPECT_NEAR(near.distance, 2.5, 1e-6);
  psim_query_filter none;
  psim_query_filter_init(&none);
  none.dynamic = 0;
  EXPECT_EQ(psim_world_closest(c.world, {4, 3}, 10, &none, &near), PSIM_NOTHING);
}

TEST(CApi, StateSnapshotsAndDiagnosticsCanBeRead) {
  CWorld c;
  c.add(psim_disc(0.5), {1, 2});
  c.add(psim_box(1, 1), {5, 2}, PSIM_BODY_STATIC);
  psim_snapshot shot;
  psim_snapshot_init(&shot);
  EXPECT_EQ(psim_world_latest_snapshot(c.world, &shot), PSIM_NOTHING);
  ASSERT_EQ(psim_world_enable_snapshots(c.world, 1), PSIM_OK);
  ASSERT_EQ(psim_world_step(c.world, nullptr), PSIM_OK);
  ASSERT_EQ(psim_world_latest_snapshot(c.world, &shot), PSIM_OK);
  ASSERT_EQ(shot.count, 2u);
  EXPECT_EQ(shot.frame, 1u);
  EXPECT_LT(shot.y[0], shot.y_prev[0]);
  psim_state state;
  psim_state_init(&state);
  ASSERT_EQ(psim_world_state(c.world, &state), PSIM_OK);
  ASSERT_EQ(state.count, 2u);
  EXPECT_EQ(state.type[1], PSIM_BODY_STATIC);
  EXPECT_LT(state.vy[0], 0);
  psim_diagnostics sums;
  psim_diagnostics_init(&sums);
  ASSERT_EQ(psim_world_diagnostics(c.world, &sums), PSIM_OK);
  EXPECT_GT(sums.kinetic, 0);
  EXPECT_LT(sums.momentum_y, 0);

  const psim_plan_entry* plan = nullptr;
  std::size_t count = 0;
  ASSERT_EQ(psim_world_plan(c.world, &plan, &count), PSIM_OK);
  ASSERT_GT(count, 5u);
  EXPECT_NE(std::string(plan[0].stage), "");
  const std::size_t entries = count;
  const std::size_t* bytes = nullptr;
  ASSERT_EQ(psim_world_plan_bytes(c.world, &bytes, &count), PSIM_OK);
  ASSERT_EQ(count, entries);
  for (std::size_t k = 0; k < count; ++k) {
    const std::string stage = plan[k].stage;
    if (stage == "publish") {
      EXPECT_GT(bytes[k], 0u);
    } else if (stage == "joints") {
      EXPECT_EQ(bytes[k], 0u);
    }
  }
  EXPECT_EQ(psim_world_plan_bytes(c.world, nullptr, &count), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(std::string(psim_skip_name(0)), "forces");
  EXPECT_EQ(psim_skip_name(99), nullptr);
  const psim_skip_entry* skipped = nullptr;
  ASSERT_EQ(psim_world_skipped(c.world, &skipped, &count), PSIM_OK);
  ASSERT_GT(count, 0u);
  EXPECT_EQ(skipped[0].frames, 1u);
  const psim_trace_event* trace = nullptr;
  ASSERT_EQ(psim_world_start_trace(c.world), PSIM_OK);
  ASSERT_EQ(psim_world_step(c.world, nullptr), PSIM_OK);
  ASSERT_EQ(psim_world_stop_trace(c.world), PSIM_OK);
  ASSERT_EQ(psim_world_take_trace(c.world, &trace, &count), PSIM_OK);
  EXPECT_GT(count, 0u);
  ASSERT_EQ(psim_world_step(c.world, nullptr), PSIM_OK);
  ASSERT_EQ(psim_world_take_trace(c.world, &trace, &count), PSIM_OK);
  EXPECT_EQ(count, 0u);
  const psim_lane_use* use = nullptr;
  ASSERT_EQ(psim_world_count_lane_use(c.world), PSIM_OK);
  for (int k = 0; k < 16; ++k) ASSERT_EQ(psim_world_step(c.world, nullptr), PSIM_OK);
  ASSERT_EQ(psim_world_lane_use(c.world, &use, &count), PSIM_OK);
  const std::size_t uses = count;
  for (std::size_t k = 0; k < count; ++k) EXPECT_LE(use[k].used, use[k].lanes) << use[k].kernels;
  EXPECT_EQ(psim_world_lane_use(c.world, nullptr, &count), PSIM_ERROR_ARGUMENT);
  char why[128];
  EXPECT_GT(psim_world_why_awake(c.world, {0, 0}, why, sizeof why), 0u);
  EXPECT_EQ(std::string(why).rfind("awake", 0), 0u) << why;
  psim_lane_counts lanes{};
  EXPECT_EQ(psim_world_lane_counts(c.world, &lanes), PSIM_OK);
  EXPECT_GT(lanes.vector + lanes.scalar, 0u);
  EXPECT_EQ(uses != 0, lanes.vector != 0);
  EXPECT_GT(psim_world_memory_bytes(c.world), 1000u);
}

// A job system on threads of its own, with the same bits as without.
void on_two_threads(void* user, size_t count, psim_job_function function, void* job) {
  ++*static_cast<int*>(user);
  std::thread other([=] {
    for (std::size_t i = 1; i < count; i += 2) function(job, i);
  });
  for (std::size_t i = 0; i < count; i += 2) function(job, i);
  other.join();
}

TEST(CApi, JobsRunOnTheCallersThreads) {
  CWorld own, hosted;
  int calls = 0;
  psim_job_system jobs;
  psim_job_system_init(&jobs);
  jobs.user = &calls;
  jobs.workers = 2;
  jobs.parallel_for = on_two_threads;
  ASSERT_EQ(psim_world_set_job_system(hosted.world, &jobs), PSIM_OK);
  for (CWorld* c : {&own, &hosted}) {
    for (int k = 0; k < 60; ++k) c->add(psim_disc(0.5), {k % 8 * 0.99, k / 8 * 1.0});
    for (int k = 0; k < 10; ++k) ASSERT_EQ(psim_world_step(c->world, nullptr), PSIM_OK);
  }
  EXPECT_GT(calls, 10);
  EXPECT_EQ(psim_world_state_hash(own.world), psim_world_state_hash(hosted.world));
  ASSERT_EQ(psim_world_set_job_system(hosted.world, nullptr), PSIM_OK);
  calls = 0;
  ASSERT_EQ(psim_world_step(hosted.world, nullptr), PSIM_OK);
  EXPECT_EQ(calls, 0);
}

TEST(CApi, ContactsAreThoseOfCpp) {
  CWorld c;
  const psim_body_id floor = c.add(psim_box(20, 1), {0, -0.5}, PSIM_BODY_STATIC);
  const psim_body_id box = c.add(psim_box(2, 1), {0, 0.5});
  const psim_body_id ball = c.add(psim_disc(0.5), {5, 0.5});
  const psim_contact* contacts = nullptr;
  std::size_t count = 7;
  ASSERT_EQ(psim_world_contacts(c.world, &contacts, &count), PSIM_OK);
  EXPECT_EQ(count, 0u);
  for (int k = 0; k < 60; ++k) psim_world_step(c.world, nullptr);
  ASSERT_EQ(psim_world_contacts(c.world, &contacts, &count), PSIM_OK);
  ASSERT_EQ(count, 3u);
  double sum[2] = {};
  for (std::size_t k = 0; k < count; ++k) {
    EXPECT_EQ(contacts[k].a.index, floor.index);
    EXPECT_NEAR(contacts[k].normal.y, 1, 1e-6);
    EXPECT_NEAR(contacts[k].point.y, 0, 2e-3);
    EXPECT_EQ(contacts[k].friction, 0);
    sum[contacts[k].b.index == ball.index] += contacts[k].impulse;
  }
  EXPECT_NEAR(sum[0], 2 * kG / 60, 1e-3);
  EXPECT_NEAR(sum[1], kPi / 4 * kG / 60, 1e-3);
  EXPECT_EQ(contacts[2].b.index, ball.index);
  EXPECT_EQ(psim_world_shape_count(c.world), 1u);
  EXPECT_EQ(psim_world_shape_count(nullptr), 0u);
  EXPECT_EQ(contacts[0].b.index, box.index);
  EXPECT_EQ(psim_world_contacts(c.world, nullptr, &count), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_world_contacts(c.world, &contacts, nullptr), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_world_contacts(nullptr, &contacts, &count), PSIM_ERROR_ARGUMENT);

  const psim_contact_group* groups = nullptr;
  const std::uint32_t* strips = nullptr;
  ASSERT_EQ(psim_world_set_sleeping(c.world, 0), PSIM_OK);  // sleepers have none
  ASSERT_EQ(psim_world_step(c.world, nullptr), PSIM_OK);
  ASSERT_EQ(psim_world_contacts(c.world, &contacts, &count), PSIM_OK);
  ASSERT_EQ(psim_world_contact_groups(c.world, &groups, &count), PSIM_OK);
  ASSERT_EQ(count, 3u);
  for (std::size_t k = 0; k < count; ++k) EXPECT_EQ(groups[k].strip, 0u);
  EXPECT_EQ(groups[0].colour, groups[1].colour);  // two points of one manifold
  EXPECT_NE(groups[2].colour, PSIM_NO_GROUP);
  ASSERT_EQ(psim_world_strips(c.world, &strips, &count), PSIM_OK);
  ASSERT_EQ(count, 3u);
  EXPECT_EQ(strips[floor.index], PSIM_NO_GROUP);
  EXPECT_EQ(strips[ball.index], 0u);
  EXPECT_EQ(psim_world_contact_groups(c.world, nullptr, &count), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_world_contact_groups(nullptr, &groups, &count), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_world_strips(c.world, &strips, nullptr), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_world_strips(nullptr, &strips, &count), PSIM_ERROR_ARGUMENT);
}

TEST(CApi, JointsAreChangedAndBreak) {
  CWorld c;
  const psim_body_id load = c.add(psim_disc(0.5), {0, 0});
  psim_joint_desc desc;
  psim_joint_desc_init(&desc);
  EXPECT_EQ(desc.ratio, 1);
  EXPECT_EQ(desc.joint_a.index, 0xFFFFFFFFu);
  desc.type = PSIM_JOINT_TARGET;
  desc.b = load;
  psim_joint_id mouse{};
  EXPECT_EQ(psim_world_add_joint(c.world, &desc, &mouse), PSIM_ERROR_ARGUMENT);
  desc.frequency = 4;
  desc.damping_ratio = 1;
  desc.user_data = 5;
  ASSERT_EQ(psim_world_add_joint(c.world, &desc, &mouse), PSIM_OK) << c.last();
  ASSERT_EQ(psim_world_set_target(c.world, mouse, {2, 1}), PSIM_OK) << c.last();
  EXPECT_EQ(psim_world_set_target(c.world, mouse, {kNaN, 1}), PSIM_ERROR_ARGUMENT);
  for (int k = 0; k < 120; ++k) psim_world_step(c.world, nullptr);
  psim_joint_state state{};
  ASSERT_EQ(psim_world_joint(c.world, mouse, &state), PSIM_OK);
  EXPECT_NEAR(state.anchor_b.x, 2, 1e-3);
  EXPECT_EQ(state.a.index, PSIM_WORLD_BODY_INDEX);

  psim_joint_desc now;
  psim_joint_desc_init(&now);
  ASSERT_EQ(psim_world_joint_desc(c.world, mouse, &now), PSIM_OK) << c.last();
  EXPECT_GT(now.stiffness, 0);
  EXPECT_EQ(now.frequency, 0);
  EXPECT_EQ(now.target.x, 2);
  now.break_force = -1;
  EXPECT_EQ(psim_world_set_joint(c.world, mouse, &now), PSIM_ERROR_ARGUMENT);
  EXPECT_NE(c.last().find("break force"), std::string::npos) << c.last();
  now.break_force = 1e-3;
  ASSERT_EQ(psim_world_set_joint(c.world, mouse, &now), PSIM_OK) << c.last();
  psim_world_step(c.world, nullptr);
  psim_events events;
  psim_events_init(&events);
  ASSERT_EQ(psim_world_events(c.world, &events), PSIM_OK);
  ASSERT_EQ(events.break_count, 1u);
  EXPECT_EQ(events.breaks[0].joint.index, mouse.index);
  EXPECT_EQ(events.breaks[0].b.index, load.index);
  EXPECT_EQ(events.breaks[0].user_data, 5u);
  EXPECT_EQ(psim_world_joint_desc(c.world, mouse, &now), PSIM_ERROR_STALE_ID);
  EXPECT_EQ(psim_world_set_joint(c.world, mouse, &now), PSIM_ERROR_STALE_ID);
  EXPECT_EQ(psim_world_set_target(c.world, mouse, {0, 0}), PSIM_ERROR_STALE_ID);
}

TEST(CApi, SleepGravityAndMotorsAreReachable) {
  CWorld c;
  const psim_body_id hub = c.add(psim_disc(0.5), {0, 0}, PSIM_BODY_STATIC);
  const psim_body_id wheel = c.add(psim_disc(0.5), {0, 5});
  psim_joint_desc desc;
  psim_joint_desc_init(&desc);
  desc.type = PSIM_JOINT_REVOLUTE;
  desc.a = hub;
  desc.b = wheel;
  desc.anchor_a = {0, 5};
  psim_joint_id joint{};
  ASSERT_EQ(psim_world_add_joint(c.world, &desc, &joint), PSIM_OK) << c.last();
  EXPECT_EQ(psim_world_joint_count(c.world), 1u);
  ASSERT_EQ(psim_world_set_motor(c.world, joint, 2, 100), PSIM_OK) << c.last();
  for (int k = 0; k < 30; ++k) psim_world_step(c.world, nullptr);
  psim_joint_state state{};
  ASSERT_EQ(psim_world_joint(c.world, joint, &state), PSIM_OK);
  EXPECT_EQ(state.type, PSIM_JOINT_REVOLUTE);
  EXPECT_NEAR(state.value, 1, 0.1);
  double speed = 0;
  ASSERT_EQ(psim_world_joint_speed(c.world, joint, &speed), PSIM_OK);
  EXPECT_NEAR(speed, 2, 0.1);
  EXPECT_EQ(psim_world_joint_speed(c.world, joint, nullptr), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_world_set_motor(c.world, joint, kNaN, 1), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_world_remove_joint(c.world, joint), PSIM_OK);
  EXPECT_EQ(psim_world_is_valid_joint(c.world, joint), 0);
  EXPECT_EQ(psim_world_joint(c.world, joint, &state), PSIM_ERROR_STALE_ID);
  EXPECT_EQ(psim_world_is_awake(c.world, wheel), 1);
  EXPECT_EQ(psim_world_is_awake(c.world, hub), 0);
  EXPECT_EQ(psim_world_wake(c.world, wheel), PSIM_OK);
  EXPECT_EQ(psim_world_set_gravity(c.world, {kNaN, 0}), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_world_set_gravity(c.world, {0, -1}), PSIM_OK);
  EXPECT_EQ(psim_world_set_skin(c.world, 5), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_world_set_skin(c.world, 2), PSIM_OK);
  EXPECT_EQ(psim_world_set_sleeping(c.world, 0), PSIM_OK);
  psim_world_desc now = CWorld::defaults();
  ASSERT_EQ(psim_world_get_desc(c.world, &now), PSIM_OK);
  EXPECT_EQ(now.gravity.y, -1);
  EXPECT_EQ(now.sleeping, 0);
  EXPECT_EQ(now.skin, 2);
  EXPECT_EQ(psim_world_frame(c.world), 30u);
}

}  // namespace
}  // namespace psim::test
