/* psim from C: a wall of boxes, a ball, and a ray that finds what is left standing. */
#include <psim.h>
#include <stdio.h>
#include <stdlib.h>

/* Every call says whether it worked; the world keeps one line about the last that did not. */
static void check(const psim_world* world, psim_result result) {
  char line[256];
  if (result >= 0) return;
  psim_last_error(world, line, sizeof line);
  fprintf(stderr, "%s: %s\n", psim_result_string(result), line);
  exit(1);
}

int main(void) {
  psim_world_desc desc;
  psim_world_desc_init(&desc); /* sets the defaults and the size: always first */
  desc.bounds.xmin = -50;
  desc.bounds.ymin = 0;
  desc.bounds.xmax = 50;
  desc.bounds.ymax = 50;
  desc.wall.friction = 0.6;

  psim_world* world;
  char error[256];
  if (psim_world_create(&desc, NULL, &world, error, sizeof error) < 0) {
    fprintf(stderr, "%s\n", error);
    return 1;
  }

  psim_body_desc body;
  psim_body_desc_init(&body);
  body.shape = psim_box(1, 1);
  body.material.friction = 0.6;
  for (int k = 0; k < 8; ++k) {
    body.position = psim_xy(0, 0.5 + k);
    check(world, psim_world_add_body(world, &body, NULL));
  }

  body.shape = psim_disc(0.5);
  body.position = psim_xy(-20, 6);
  body.velocity = psim_xy(30, 2);
  body.mass = 5;
  psim_body_id ball;
  check(world, psim_world_add_body(world, &body, &ball));

  psim_step_report report;
  psim_step_report_init(&report);
  for (int frame = 0; frame < 300; ++frame) check(world, psim_world_step(world, &report));

  psim_body_state state;
  check(world, psim_world_body(world, ball, &state));
  printf("the ball is at (%.1f, %.1f)\n", state.x, state.y);

  psim_ray_hit hit;
  if (psim_world_ray_cast(world, psim_xy(0, 50), psim_xy(0, 0), NULL, &hit) == PSIM_OK) {
    printf("the wall is %.1f m high\n", hit.point.y);
  } else {
    printf("nothing is left of the wall\n");
  }
  psim_world_destroy(world);
  return 0;
}
