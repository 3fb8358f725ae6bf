// The C API: the same results as the C++ one, structs of other versions, errors, and that nothing
// thrown gets out. Layouts: tests/capi/abi_v1.c.
#include <psim.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <stdexcept>
#include <thread>

#include "support.h"

namespace psim::test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

struct CWorld {
  explicit CWorld(const psim_world_desc& desc, const psim_run_options* options = nullptr) {
    result = psim_world_create(&desc, options, &world, error, sizeof error);
  }
  CWorld() : CWorld(defaults()) {}
  ~CWorld() { psim_world_destroy(world); }
  CWorld(const CWorld&) = delete;
  CWorld& operator=(const CWorld&) = delete;

  static psim_world_desc defaults() {
    psim_world_desc desc;
    psim_world_desc_init(&desc);
    return desc;
  }
  psim_body_id add(const psim_shape& shape, psim_vec2 position,
                   std::int32_t type = PSIM_BODY_DYNAMIC) {
    psim_body_desc desc;
    psim_body_desc_init(&desc);
    desc.shape = shape;
    desc.position = position;
    desc.type = type;
    psim_body_id id{};
    EXPECT_EQ(psim_world_add_body(world, &desc, &id), PSIM_OK) << last();
    return id;
  }
  std::string last() const {
    char text[256];
    psim_last_error(world, text, sizeof text);
    return text;
  }

  psim_world* world = nullptr;
  psim_result result = PSIM_OK;
  char error[256] = "";
};

TEST(CApi, TheSameWorldHasTheSameBitsAsInCpp) {
  WorldDesc desc;
  desc.gravity = {0.5, -9};
  desc.fields = {WellField{{1, 2}, 30, 0.5, 2, 0}, DragField{0.1, 0.02}};
  desc.linear_damping = 0.05;
  desc.substeps = 3;
  desc.wall.friction = 0.3;
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
  CWorld c(c_desc);
  ASSERT_EQ(c.result, PSIM_OK) << c.error;

  const Vec2 vertices[] = {{0, 0}, {1, 0}, {0.5, 1}};
  const psim_vec2 c_vertices[] = {{0, 0}, {1, 0}, {0.5, 1}};
  const Vec2 ground[] = {{-20, -3}, {0, -4}, {20, -3}};
  const psim_vec2 c_ground[] = {{-20, -3}, {0, -4}, {20, -3}};
  const std::pair<Shape, psim_shape> shapes[] = {
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
    body.position = {static_cast<double>(k) * 2.5, 3};
    c_body.position = psim_xy(body.position.x, 3);
    body.type = k < 5 ? BodyType::dynamic_body : BodyType::static_body;
    c_body.type = k < 5 ? PSIM_BODY_DYNAMIC : PSIM_BODY_STATIC;
    body.material = {2, 0.3, 0.5};
    c_body.material = {2, 0.3, 0.5};
    body.angular_velocity = c_body.angular_velocity = 1;
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

  x[3] = kNaN;
  ASSERT_EQ(psim_world_add_discs(plain.world, &batch, nullptr), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(
      plain.last(),
      "psim_world_add_discs: disc 3 of the batch: position must lie inside the world's bounds");
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
  EXPECT_EQ(psim_world_add_bodies(c.world, descs, 3, sizeof descs[0], ids, &added),
            PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(added, 2u);
  EXPECT_EQ(psim_world_body_count(c.world), 2u);
  EXPECT_EQ(ids[1].index, 1u);
  EXPECT_EQ(c.last().rfind("psim_world_add_bodies: body 2: mass", 0), 0u) << c.last();
}

TEST(CApi, AnOlderCallersShorterStructTakesDefaults) {
  psim_world_desc desc = CWorld::defaults();
  desc.dt = 0.01;
  desc.substeps = 40;  // past the end of the shorter struct: not read
  desc.restitution_threshold = -5;
  desc.struct_size = offsetof(psim_world_desc, substeps);
  CWorld c(desc);
  ASSERT_EQ(c.result, PSIM_OK) << c.error;
  psim_world_desc now = CWorld::defaults();
  ASSERT_EQ(psim_world_get_desc(c.world, &now), PSIM_OK);
  EXPECT_EQ(now.dt, 0.01);
  EXPECT_EQ(now.substeps, WorldDesc{}.substeps);
  EXPECT_EQ(now.restitution_threshold, 0);
}

TEST(CApi, AnOlderCallersShorterReportIsNotWrittenPast) {
  CWorld c;
  c.add(psim_disc(0.5), {0, 0});
  psim_step_report report;
  std::memset(&report, 0xAB, sizeof report);
  report.struct_size = offsetof(psim_step_report, pairs);
  ASSERT_EQ(psim_world_step(c.world, &report), PSIM_OK);
  EXPECT_EQ(report.struct_size, offsetof(psim_step_report, pairs));
  EXPECT_GT(report.total_ms, 0);
  EXPECT_EQ(report.pairs, 0xABABABABABABABABu);
}

TEST(CApi, WrongStructSizesAreRefused) {
  psim_world_desc desc = CWorld::defaults();
  for (const std::uint32_t size : {0u, 4u, 12u, static_cast<std::uint32_t>(sizeof desc) + 8u}) {
    desc.struct_size = size;
    CWorld c(desc);
    EXPECT_EQ(c.result, PSIM_ERROR_STRUCT_SIZE) << size;
    EXPECT_EQ(c.world, nullptr);
  }
  EXPECT_STREQ(CWorld(desc).error,
               "psim_world_create: desc has struct_size 152, this library knows 144: it is older "
               "than the header");
}

TEST(CApi, InitFillsWhatANewerCallerHasWithZeros) {
  alignas(8) unsigned char newer[sizeof(psim_body_desc) + 16];
  std::memset(newer, 0xAB, sizeof newer);
  psim_init(newer, PSIM_STRUCT_BODY_DESC, sizeof newer);
  psim_body_desc known;
  std::memcpy(&known, newer, sizeof known);
  EXPECT_EQ(known.struct_size, sizeof newer);
  EXPECT_EQ(known.gravity_scale, 1);
  EXPECT_EQ(newer[sizeof newer - 1], 0);
}

TEST(CApi, ErrorsSayWhatAndWhere) {
  psim_world_desc desc = CWorld::defaults();
  desc.boundary = 9;
  EXPECT_STREQ(CWorld(desc).error,
               "psim_world_create: boundary 9 is none of psim_boundary, 0 to 2");
  desc = CWorld::defaults();
  desc.dt = 0;
  EXPECT_STREQ(CWorld(desc).error, "psim_world_create: dt must be above 0 and at most 10 s");
  char shorter[8];
  psim_world* world = nullptr;
  EXPECT_EQ(psim_world_create(&desc, nullptr, &world, shorter, sizeof shorter),
            PSIM_ERROR_ARGUMENT);
  EXPECT_STREQ(shorter, "psim_wo");

  CWorld c;
  const psim_body_id still = c.add(psim_box(1, 1), {0, 0}, PSIM_BODY_STATIC);
  EXPECT_EQ(c.last(), "");
  EXPECT_EQ(psim_world_set_velocity(c.world, still, {1, 0}, 0), PSIM_ERROR_NOT_MOVABLE);
  EXPECT_EQ(c.last(), "psim_world_set_velocity: body 0 is static or frozen");
  psim_body_desc body;
  psim_body_desc_init(&body);
  body.shape.type = 77;
  EXPECT_EQ(psim_world_add_body(c.world, &body, nullptr), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(c.last(), "psim_world_add_body: shape type 77 is none of psim_shape_type, 0 to 5");
  EXPECT_EQ(psim_world_add_body(c.world, nullptr, nullptr), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_world_step_by(c.world, kNaN, nullptr), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_world_step(nullptr, nullptr), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_world_body_count(nullptr), 0u);
  EXPECT_EQ(psim_last_error(nullptr, nullptr, 0), 0u);
  psim_world_destroy(nullptr);

  psim_joint_desc joint;
  psim_joint_desc_init(&joint);
  joint.a = joint.b = still;
  EXPECT_EQ(psim_world_add_joint(c.world, &joint, nullptr), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(c.last(), "psim_world_add_joint: a and b must differ");
}

TEST(CApi, EveryResultHasWords) {
  for (int code = PSIM_ERROR_BROKEN_WORLD; code <= PSIM_NOTHING; ++code) {
    EXPECT_STRNE(psim_result_string(code), "unknown result") << code;
  }
  EXPECT_STREQ(psim_result_string(PSIM_ERROR_BROKEN_WORLD - 1), "unknown result");
}

TEST(CApi, VersionsAndInstructionSets) {
  EXPECT_STREQ(psim_version(), PSIM_VERSION_STRING);
  EXPECT_EQ(psim_version_number(),
            10000u * PSIM_VERSION_MAJOR + 100u * PSIM_VERSION_MINOR + PSIM_VERSION_PATCH);
  for (const Isa isa : kAllIsas) {
    std::int32_t parsed = -7;
    EXPECT_EQ(psim_isa_name(static_cast<std::int32_t>(isa)), isa_name(isa));
    EXPECT_EQ(psim_parse_isa(isa_name(isa).data(), &parsed), PSIM_OK);
    EXPECT_EQ(parsed, static_cast<std::int32_t>(isa));
    if (!isa_available(isa)) continue;
    psim_run_options options;
    psim_run_options_init(&options);
    options.isa = static_cast<std::int32_t>(isa);
    options.threads = 2;
    CWorld c(CWorld::defaults(), &options);
    ASSERT_EQ(c.result, PSIM_OK) << c.error;
    EXPECT_EQ(psim_world_isa(c.world), options.isa);
    EXPECT_EQ(psim_world_threads(c.world), 2);
  }
  EXPECT_EQ(psim_isa_name(3), nullptr);
  EXPECT_EQ(psim_isa_available(3), 0);
  std::int32_t integrator = -7;
  EXPECT_EQ(psim_parse_integrator("rk4", &integrator), PSIM_OK);
  EXPECT_STREQ(psim_integrator_name(integrator), "rk4");
  EXPECT_EQ(psim_parse_integrator("rk5", &integrator), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_stage_name(static_cast<int>(kStageCount)), nullptr);
  EXPECT_STREQ(psim_stage_name(0), "forces");
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
  ASSERT_EQ(psim_world_take_trace(c.world, &trace, &count), PSIM_OK);
  EXPECT_GT(count, 0u);
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

TEST(CApi, AGovernedRunReplaysFromItsReports) {
  const auto fill = [](CWorld& c) {
    for (int k = 0; k < 40; ++k) c.add(psim_disc(0.5), {k % 8 * 1.0, -499 + k / 8 * 1.0});
  };
  CWorld cut, again;
  fill(cut);
  fill(again);
  psim_cost_model costs;
  psim_cost_model_init(&costs);
  costs.pass = 1e5;  // so that nothing fits
  psim_governor_desc governor;
  psim_governor_desc_init(&governor);
  governor.on = 1;
  governor.costs = &costs;
  ASSERT_EQ(psim_world_set_governor(cut.world, &governor), PSIM_OK) << cut.last();
  bool less = false;
  for (int k = 0; k < 30; ++k) {
    psim_step_report report;
    psim_step_report_init(&report);
    ASSERT_EQ(psim_world_step(cut.world, &report), PSIM_OK);
    less |= report.detail.substeps < 4;
    ASSERT_EQ(psim_world_replay(again.world, report.detail, nullptr), PSIM_OK) << again.last();
  }
  EXPECT_TRUE(less);
  EXPECT_EQ(psim_world_state_hash(cut.world), psim_world_state_hash(again.world));
  EXPECT_EQ(psim_world_replay(again.world, {4, 8, 1, 1, 0}, nullptr), PSIM_ERROR_ARGUMENT);
  psim_step_report limited;
  psim_step_report_init(&limited);
  ASSERT_EQ(psim_world_replay(again.world, {4, 3 * PSIM_STEP_SWEEP, 1, 1, 0}, &limited), PSIM_OK);
  EXPECT_EQ(limited.detail.flags, 3 * PSIM_STEP_SWEEP);
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

void throw_no_memory(void*, size_t, psim_job_function, void*) { throw std::bad_alloc(); }
void throw_number(void*, size_t, psim_job_function, void*) { throw 7; }
void leave_out_the_last(void*, size_t count, psim_job_function function, void* job) {
  for (std::size_t i = 0; i + 1 < count; ++i) function(job, i);
}

TEST(CApi, WhatIsThrownInsideBecomesAResultAndTheWorldIsDone) {
  const std::pair<decltype(psim_job_system::parallel_for), psim_result> cases[] = {
      {throw_no_memory, PSIM_ERROR_OUT_OF_MEMORY},
      {throw_number, PSIM_ERROR_INTERNAL},
      {leave_out_the_last, PSIM_ERROR_INTERNAL}};
  for (const auto& [parallel_for, expected] : cases) {
    CWorld c;
    const psim_body_id id = c.add(psim_disc(0.5), {0, 0});
    psim_job_system jobs;
    psim_job_system_init(&jobs);
    jobs.parallel_for = parallel_for;
    ASSERT_EQ(psim_world_set_job_system(c.world, &jobs), PSIM_OK);
    EXPECT_EQ(psim_world_step(c.world, nullptr), expected) << c.last();
    EXPECT_NE(c.last(), "");
    EXPECT_EQ(psim_world_step(c.world, nullptr), PSIM_ERROR_BROKEN_WORLD);
    EXPECT_EQ(psim_world_remove_body(c.world, id), PSIM_ERROR_BROKEN_WORLD);
    EXPECT_EQ(psim_world_body_count(c.world), 0u);
  }
}

TEST(CApi, ASavedWorldGoesOnWithTheSameBits) {
  psim_world_desc desc = CWorld::defaults();
  const psim_field drag = psim_drag(0.1, 0);
  desc.fields = &drag;
  desc.field_count = 1;
  CWorld c(desc);
  for (int k = 0; k < 30; ++k) c.add(psim_box(1, 1), {k % 5 * 1.1, -498 + k / 5 * 1.1});
  const auto run_on = [](psim_world* world) {
    for (int k = 0; k < 20; ++k) psim_world_step(world, nullptr);
    return psim_world_state_hash(world);
  };
  run_on(c.world);
  const void* state = nullptr;
  std::size_t size = 0;
  ASSERT_EQ(psim_world_save(c.world, &state, &size), PSIM_OK) << c.last();
  const std::uint64_t expected = run_on(c.world);
  ASSERT_EQ(psim_world_restore(c.world, state, size), PSIM_OK) << c.last();
  EXPECT_EQ(run_on(c.world), expected);

  // Through a buffer, and into a new world.
  std::size_t packed_size = 0;
  ASSERT_EQ(psim_pack_state(state, size, nullptr, 0, &packed_size), PSIM_OK);
  EXPECT_EQ(packed_size, size + 32);
  std::vector<unsigned char> packed(packed_size), unpacked(size);
  EXPECT_EQ(psim_pack_state(state, size, packed.data(), 10, &packed_size), PSIM_ERROR_ARGUMENT);
  ASSERT_EQ(psim_pack_state(state, size, packed.data(), packed.size(), &packed_size), PSIM_OK);
  char error[256];
  std::size_t unpacked_size = 0;
  ASSERT_EQ(psim_unpack_state(packed.data(), packed.size(), unpacked.data(), unpacked.size(),
                              &unpacked_size, error, sizeof error),
            PSIM_OK)
      << error;
  psim_world* again = nullptr;
  ASSERT_EQ(
      psim_world_from_state(unpacked.data(), unpacked_size, nullptr, &again, error, sizeof error),
      PSIM_OK)
      << error;
  EXPECT_EQ(run_on(again), expected);
  psim_world_desc now = CWorld::defaults();
  ASSERT_EQ(psim_world_get_desc(again, &now), PSIM_OK);
  ASSERT_EQ(now.field_count, 1u);
  EXPECT_EQ(now.fields[0].linear, 0.1);
  psim_world_destroy(again);

  packed[packed.size() / 2] ^= 1;
  EXPECT_EQ(psim_unpack_state(packed.data(), packed.size(), nullptr, 0, &unpacked_size, error,
                              sizeof error),
            PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(std::string(error).rfind("psim_unpack_state: ", 0), 0u) << error;
  CWorld other;
  EXPECT_EQ(psim_world_restore(other.world, "no state", 8), PSIM_ERROR_ARGUMENT);
  EXPECT_NE(other.last(), "");

  const std::string path = testing::TempDir() + "c_api_state";
  ASSERT_EQ(psim_write_state(path.c_str(), state, size, error, sizeof error), PSIM_OK) << error;
  ASSERT_EQ(
      psim_read_state(path.c_str(), unpacked.data(), size, &unpacked_size, error, sizeof error),
      PSIM_OK)
      << error;
  EXPECT_EQ(std::memcmp(unpacked.data(), state, size), 0);
  std::remove(path.c_str());
  EXPECT_EQ(psim_read_state(path.c_str(), nullptr, 0, &unpacked_size, error, sizeof error),
            PSIM_ERROR_ARGUMENT);
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

TEST(CApi, AReplayStepsByAnotherDt) {
  CWorld a, b;
  for (CWorld* c : {&a, &b}) {
    for (int k = 0; k < 5; ++k) c->add(psim_disc(0.5), {0.1 * k, -499.5 + k});
  }
  for (int k = 0; k < 20; ++k) {
    psim_step_report report;
    psim_step_report_init(&report);
    ASSERT_EQ(psim_world_step_by(a.world, 0.01, &report), PSIM_OK);
    ASSERT_EQ(psim_world_replay_by(b.world, report.detail, 0.01, nullptr), PSIM_OK) << b.last();
  }
  EXPECT_EQ(psim_world_state_hash(a.world), psim_world_state_hash(b.world));
  for (const double dt : {0.0, -1.0, 11.0, kNaN}) {
    EXPECT_EQ(psim_world_replay_by(b.world, {0, 0, 1, 1, 0}, dt, nullptr), PSIM_ERROR_ARGUMENT) << dt;
    EXPECT_EQ(psim_world_step_by(b.world, dt, nullptr), PSIM_ERROR_ARGUMENT) << dt;
  }
  for (const psim_step_detail wrong :
       {psim_step_detail{65, 0, 1, 1, 0}, psim_step_detail{0, 2, 1, 1, 0},
        psim_step_detail{0, 4, 1, 1, 0}, psim_step_detail{0, 0, 0, 1, 0},
        psim_step_detail{0, 0, 9, 1, 0}, psim_step_detail{0, 0, 1, 0, 0}}) {
    EXPECT_EQ(psim_world_replay(b.world, wrong, nullptr), PSIM_ERROR_ARGUMENT);
  }
  EXPECT_EQ(psim_world_frame(b.world), 20u);
}

TEST(CApi, ARecordingHoldsAllThatWasDoneAndRunsAgain) {
  CWorld c;
  std::vector<psim_body_id> ids;
  for (int k = 0; k < 12; ++k) ids.push_back(c.add(psim_box(1, 0.8), {k % 4 * 1.2, -498 + k / 4 * 1.1}));
  const void* bytes = nullptr;
  std::size_t size = 1;
  EXPECT_EQ(psim_world_recording(c.world, &bytes, &size), PSIM_NOTHING);
  EXPECT_EQ(size, 0u);
  EXPECT_EQ(psim_world_stop_recording(c.world), PSIM_NOTHING);
  EXPECT_EQ(psim_world_record(c.world, 0), PSIM_ERROR_ARGUMENT);
  for (int k = 0; k < 10; ++k) psim_world_step(c.world, nullptr);

  ASSERT_EQ(psim_world_record(c.world, 5), PSIM_OK);
  const auto steps = [&](int n) {
    for (int k = 0; k < n; ++k) ASSERT_EQ(psim_world_step(c.world, nullptr), PSIM_OK);
  };
  // All that changes a world, each with an effect.
  steps(3);
  ids.push_back(c.add(psim_disc(0.4), {2, -480}));
  const double x[] = {-3, -5}, y[] = {-490, -490};
  psim_disc_batch batch;
  psim_disc_batch_init(&batch);
  batch.count = 2;
  batch.x = {x, 0};
  batch.y = {y, 0};
  ASSERT_EQ(psim_world_add_discs(c.world, &batch, nullptr), PSIM_OK) << c.last();
  ASSERT_EQ(psim_world_set_velocity(c.world, ids[0], {1, 3}, 2), PSIM_OK);
  ASSERT_EQ(psim_world_set_transform(c.world, ids[1], {8, -490}, 0.3), PSIM_OK);
  ASSERT_EQ(psim_world_apply_impulse(c.world, ids[2], {1, 1}), PSIM_OK);
  ASSERT_EQ(psim_world_apply_impulse_at(c.world, ids[3], {1, 1}, {5, -498}), PSIM_OK);
  ASSERT_EQ(psim_world_apply_angular_impulse(c.world, ids[4], 0.5), PSIM_OK);
  steps(4);
  psim_joint_desc joint;
  psim_joint_desc_init(&joint);
  joint.type = PSIM_JOINT_REVOLUTE;
  joint.a = ids[5];
  joint.b = ids[6];
  psim_joint_id pin{}, second{};
  ASSERT_EQ(psim_world_add_joint(c.world, &joint, &pin), PSIM_OK) << c.last();
  joint.a = ids[7];
  ASSERT_EQ(psim_world_add_joint(c.world, &joint, &second), PSIM_OK) << c.last();
  ASSERT_EQ(psim_world_set_motor(c.world, pin, 1, 5), PSIM_OK);
  ASSERT_EQ(psim_world_step_by(c.world, 0.01, nullptr), PSIM_OK);
  ASSERT_EQ(psim_world_remove_joint(c.world, second), PSIM_OK);
  ASSERT_EQ(psim_world_remove_body(c.world, ids[8]), PSIM_OK);
  ASSERT_EQ(psim_world_set_gravity(c.world, {1, -9}), PSIM_OK);
  ASSERT_EQ(psim_world_set_skin(c.world, 0.5), PSIM_OK);
  ASSERT_EQ(psim_world_replay_by(c.world, {2, 0, 1, 1, 0}, 0.02, nullptr), PSIM_OK);
  ASSERT_EQ(psim_world_replay(c.world, {3, 0, 2, 2, 0}, nullptr), PSIM_OK);
  steps(90);
  ASSERT_EQ(psim_world_set_sleeping(c.world, 0), PSIM_OK);
  ASSERT_EQ(psim_world_wake(c.world, ids[9]), PSIM_OK);
  steps(5);
  const std::uint64_t hash = psim_world_state_hash(c.world), frame = psim_world_frame(c.world);
  ASSERT_EQ(psim_world_recording(c.world, &bytes, &size), PSIM_OK);
  std::vector<unsigned char> recording(static_cast<const unsigned char*>(bytes),
                                       static_cast<const unsigned char*>(bytes) + size);
  // A restore is none of what a recording can hold.
  const void* state = nullptr;
  std::size_t state_size = 0;
  ASSERT_EQ(psim_world_save(c.world, &state, &state_size), PSIM_OK);
  EXPECT_EQ(psim_world_restore(c.world, state, state_size), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_world_stop_recording(c.world), PSIM_OK);
  EXPECT_EQ(psim_world_restore(c.world, state, state_size), PSIM_OK);

  psim_run_options options;
  psim_run_options_init(&options);
  options.isa = PSIM_ISA_SCALAR;
  options.threads = 2;
  char error[256];
  psim_replay* replay = nullptr;
  ASSERT_EQ(psim_replay_open(recording.data(), recording.size(), &options, &replay, error, sizeof error), PSIM_OK) << error;
  EXPECT_EQ(psim_replay_steps_in_all(replay), frame - 10);
  psim_result result = PSIM_OK;
  while ((result = psim_replay_next(replay)) == PSIM_OK) {
  }
  EXPECT_EQ(result, PSIM_NOTHING);
  EXPECT_EQ(psim_replay_steps(replay), frame - 10);
  EXPECT_EQ(psim_replay_differs_at(replay), 0u);
  EXPECT_GE(psim_replay_hashes(replay), (frame - 10) / 5);
  EXPECT_EQ(psim_world_state_hash(psim_replay_world(replay)), hash);
  EXPECT_EQ(psim_world_threads(psim_replay_world(replay)), 2);
  psim_replay_close(replay);

  recording[recording.size() - 9] ^= 1;
  EXPECT_EQ(psim_replay_open(recording.data(), recording.size(), nullptr, &replay, error, sizeof error), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(std::string(error).rfind("psim_replay_open: ", 0), 0u) << error;
  EXPECT_EQ(replay, nullptr);
  EXPECT_EQ(psim_replay_open(nullptr, 0, nullptr, &replay, error, sizeof error), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_replay_open(recording.data(), 5, nullptr, nullptr, error, sizeof error), PSIM_ERROR_ARGUMENT);
  psim_replay_close(nullptr);
  EXPECT_EQ(psim_replay_next(nullptr), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_replay_world(nullptr), nullptr);
  EXPECT_EQ(psim_replay_steps(nullptr) + psim_replay_steps_in_all(nullptr) + psim_replay_hashes(nullptr) +
                psim_replay_differs_at(nullptr), 0u);
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
