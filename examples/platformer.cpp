// A character in a level: it walks up stairs and a slope, jumps through a shelf that is solid from above, and rides on a
// platform. The input is a script; exits with 1 if the character does not get to where it should.
#include <psim/mover.h>
#include <psim/psim.h>

#include <cstdio>
#include <string>
#include <vector>

namespace {

psim::BodyId add(psim::World& world, psim::BodyType type, const psim::Shape& shape, psim::Vec2 at,
                 psim::Vec2 velocity = {}, psim::Vec2 one_way = {}) {
  psim::BodyDesc body;
  body.type = type;
  body.shape = shape;
  body.position = at;
  body.velocity = velocity;
  body.one_way = one_way;
  std::string error;
  return world.add_body(body, error);
}

struct Input {  // what a player does, and on what he should stand afterwards
  const char* what;
  int frames;
  double run;   // m/s
  double jump;  // m/s, in the first frame
  psim::BodyId stands_on;
};

}  // namespace

int main() {
  using psim::BodyType;
  std::string error;
  const auto world = psim::World::create({}, {}, error);
  if (!world) return std::fprintf(stderr, "%s\n", error.c_str()), 1;

  const auto fixed = BodyType::static_body;
  const psim::BodyId floor = add(*world, fixed, psim::BoxShape{60, 1, 0}, {10, -0.5});
  psim::CompoundShape steps;
  for (int k = 0; k < 4; ++k) {  // each 0.25 m higher
    steps.parts.push_back({.shape = psim::BoxShape{2 - 0.4 * k, 0.25, 0}, .position = {0.2 * k, 0.125 + 0.25 * k}});
  }
  const psim::BodyId stairs = add(*world, fixed, steps, {3, 0});
  const psim::BodyId slope = add(*world, fixed, psim::PolygonShape{{{4, 0}, {7, 0}, {4, 1}}, 0}, {});
  const psim::BodyId shelf = add(*world, fixed, psim::BoxShape{3, 0.2, 0}, {10, 2.4}, {}, {0, 1});
  const psim::BodyId platform = add(*world, BodyType::kinematic_body, psim::BoxShape{4, 0.4, 0}, {13.6, 2.3});

  psim::Mover mover({}, {0, 0.95});  // 0.6 m wide and 1.8 m high
  const Input script[] = {{"stands", 20, 0, 0, floor},    {"climbs", 62, 3, 0, stairs},
                          {"goes down", 60, 3, 0, slope}, {"walks on", 80, 3, 0, floor},
                          {"jumps", 70, 0, 7.5, shelf},   {"steps on the platform", 60, 3, 0, platform},
                          {"rides", 120, 0, 0, platform}};
  bool all = true;
  for (const Input& input : script) {
    if (input.stands_on == platform && input.run == 0) world->set_velocity(platform, {2, 0.5}, 0);
    for (int frame = 0; frame < input.frames; ++frame) {
      world->step();
      const double dt = world->desc().dt, fall = mover.velocity().y + world->desc().gravity.y * dt;
      mover.move(*world, {input.run, frame == 0 && input.jump > 0 ? input.jump : fall}, dt);
    }
    const auto ground = mover.ground();
    const bool right = ground && ground->body == input.stands_on;
    std::printf("%s: at (%.1f, %.1f), %s\n", input.what, mover.position().x, mover.position().y,
                right ? "where it should be" : "elsewhere");
    all = all && right;
  }
  return all ? 0 : 1;
}
