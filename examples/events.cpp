// What happened in a step: who touched whom, how hard they hit, who entered the goal.
#include <psim/psim.h>

#include <cstdio>
#include <string>

int main() {
  std::string error;
  const auto world = psim::World::create({}, {}, error);
  if (!world) return std::fprintf(stderr, "%s\n", error.c_str()), 1;

  psim::BodyDesc floor;
  floor.type = psim::BodyType::static_body;
  floor.shape = psim::BoxShape{40, 1, 0};
  const psim::BodyId floor_id = world->add_body(floor, error);

  psim::BodyDesc goal;
  goal.type = psim::BodyType::static_body;
  goal.shape = psim::BoxShape{2, 2, 0};
  goal.position = {6, 1.5};
  goal.sensor = true;  // touches nothing, tells who overlaps it
  const psim::BodyId goal_id = world->add_body(goal, error);

  psim::BodyDesc ball;
  ball.position = {0, 5};
  ball.velocity = {4, 0};
  ball.material = {.density = 1, .restitution = 0.6, .friction = 0.2};
  const psim::BodyId ball_id = world->add_body(ball, error);
  if (ball_id == psim::kNoBody) return std::fprintf(stderr, "%s\n", error.c_str()), 1;

  psim::EventOptions options;  // nothing is collected unless asked for
  options.contacts = true;
  options.hits = true;
  options.hit_speed = 2;  // m/s: quieter ones are not told
  options.sensors = true;
  world->set_event_options(options);

  for (int frame = 0; frame < 180; ++frame) {
    world->step();
    const psim::Events events = world->events();  // valid until the world changes
    const double t = static_cast<double>(world->frame()) / 60;
    for (const psim::HitEvent& hit : events.hits) {
      if (hit.a != floor_id) continue;
      std::printf("%.2f s: the floor was hit at x = %.1f with %.1f m/s\n", t, hit.point.x, hit.speed);
    }
    for (const psim::TouchEvent& touch : events.sensor_begin) {
      if (touch.a == goal_id && touch.b == ball_id) std::printf("%.2f s: goal!\n", t);
    }
    for (const psim::TouchEvent& touch : events.sensor_end) {
      if (touch.a == goal_id) std::printf("%.2f s: out of the goal\n", t);
    }
  }
}
