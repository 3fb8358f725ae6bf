/* A C99 program on the C API: a box falls on a chain, a ray finds it, a motor turns it. Prints one
   line and returns 0, or says which line of this file did not hold. */
#include <math.h>
#include <psim/psim.h> /* the C API, from C */
#include <stdio.h>
#include <string.h>

#define CHECK(condition)                                       \
  do {                                                         \
    if (!(condition)) {                                        \
      char why[256];                                           \
      psim_last_error(world, why, sizeof why);                 \
      printf("line %d: %s (%s)\n", __LINE__, #condition, why); \
      return 1;                                                \
    }                                                          \
  } while (0)

static void one_after_the_other(void* user, size_t count, psim_job_function function, void* job) {
  size_t i;
  for (i = 0; i < count; ++i) function(job, i);
  *(size_t*)user += count;
}

int main(void) {
  psim_world* world = NULL;
  char error[256];
  size_t jobs_run = 0;

  psim_world_desc desc;
  psim_world_desc_init(&desc);
  desc.bounds.ymin = -5;
  CHECK(psim_world_create(&desc, NULL, &world, error, sizeof error) == PSIM_OK);

  const psim_vec2 ground[] = {{-20, 0}, {0, 0}, {20, 0}};
  psim_body_desc body;
  psim_body_desc_init(&body);
  body.type = PSIM_BODY_STATIC;
  body.shape = psim_chain(ground, 3, 0);
  body.material.friction = 0.6;
  psim_body_id floor_id, box_id;
  CHECK(psim_world_add_body(world, &body, &floor_id) == PSIM_OK);

  psim_body_desc_init(&body);
  body.shape = psim_box(1, 1);
  body.position = psim_xy(0.25, 2);
  body.material.friction = 0.6;
  CHECK(psim_world_add_body(world, &body, &box_id) == PSIM_OK);

  psim_job_system jobs;
  psim_job_system_init(&jobs);
  jobs.user = &jobs_run;
  jobs.parallel_for = one_after_the_other;
  CHECK(psim_world_set_job_system(world, &jobs) == PSIM_OK);

  psim_event_options options;
  psim_event_options_init(&options);
  options.contacts = 1;
  CHECK(psim_world_set_event_options(world, &options) == PSIM_OK);

  int frame, touched = 0;
  for (frame = 0; frame < 120; ++frame) {
    psim_step_report report;
    psim_step_report_init(&report);
    CHECK(psim_world_step(world, &report) == PSIM_OK);
    CHECK(report.quarantined == 0);
    psim_events events;
    psim_events_init(&events);
    CHECK(psim_world_events(world, &events) == PSIM_OK);
    if (events.begin_count == 1 && events.begin[0].a.index == floor_id.index &&
        events.begin[0].b.index == box_id.index) {
      touched = 1;
    }
  }
  CHECK(touched);
  CHECK(jobs_run > 0);

  psim_body_state state;
  CHECK(psim_world_body(world, box_id, &state) == PSIM_OK);
  CHECK(fabs(state.y - 0.5) < 0.01);

  psim_ray_hit hit;
  CHECK(psim_world_ray_cast(world, psim_xy(-10, 0.5), psim_xy(10, 0.5), NULL, &hit) == PSIM_OK);
  CHECK(hit.body.index == box_id.index && hit.normal.x < -0.99);
  CHECK(psim_world_ray_cast(world, psim_xy(0, 9), psim_xy(9, 9), NULL, &hit) == PSIM_NOTHING);

  CHECK(psim_world_remove_body(world, box_id) == PSIM_OK);
  CHECK(psim_world_remove_body(world, box_id) == PSIM_ERROR_STALE_ID);
  CHECK(psim_last_error(world, error, sizeof error) > 0);
  CHECK(strcmp(error, "psim_world_remove_body: there is no body 1 of this generation") == 0);

  psim_world_destroy(world);
  printf("psim %s from C99: the box lies at y = %.2f\n", psim_version(), state.y);
  return 0;
}
