// A sorting machine: belts run, one of them carries red parcels alone, sensors count, and a switch turns a belt round.
// Exits with 1 if a parcel is lost or in the wrong bin.
#include <psim/psim.h>

#include <cstdio>
#include <string>
#include <vector>

namespace {

constexpr std::uint32_t kBuilding = 1, kRed = 2, kBlue = 4;  // categories of bodies

psim::BodyId add_belt(psim::World& world, psim::Vec2 middle, double length, double speed, std::uint32_t carries) {
  psim::BodyDesc belt;
  belt.type = psim::BodyType::static_body;
  belt.shape = psim::BoxShape{length, 0.2};
  belt.position = middle;
  belt.material = {.friction = 0.8, .tangent_speed = speed};  // m/s, positive: to the right
  belt.filter = {.category = kBuilding, .mask = carries};     // others fall through
  std::string error;
  return world.add_body(belt, error);
}

struct Bin {
  const char* name;
  psim::Vec2 middle;
  psim::BodyId sensor = {};
  int red = 0, blue = 0;
};

}  // namespace

int main() {
  std::string error;
  const auto world = psim::World::create({}, {}, error);
  if (!world) return std::fprintf(stderr, "%s\n", error.c_str()), 1;

  add_belt(*world, {-2, 6}, 8, 1, kRed | kBlue);  // the feed
  add_belt(*world, {3, 4}, 6, -2, kRed);
  const psim::BodyId blue_belt = add_belt(*world, {3.5, 2}, 5, 1.5, kBlue);
  Bin bins[] = {{"red", {-1.7, 0.5}}, {"blue, left", {0.3, 0.5}}, {"blue, right", {7, 0.5}}};
  psim::BodyDesc desc;
  desc.type = psim::BodyType::static_body;
  desc.sensor = true;
  desc.shape = psim::BoxShape{1.6, 1};
  for (Bin& bin : bins) {
    desc.position = bin.middle;
    bin.sensor = world->add_body(desc, error);
  }
  world->set_event_options({.sensors = true});

  desc = {.shape = psim::BoxShape{0.4, 0.4}, .position = {-5.5, 6.3}, .material = {.friction = 0.8}};  // parcels
  for (int frame = 0; frame < 60 * 60; ++frame) {
    if (frame % 60 == 0 && frame < 60 * 45) {  // one a second, every third is red
      desc.filter.category = frame % 180 == 0 ? kRed : kBlue;
      world->add_body(desc, error);
    }
    if (frame == 60 * 25) {  // the switch
      psim::BodyTraits traits = *world->traits(blue_belt);
      traits.tangent_speed = -traits.tangent_speed;
      world->set_traits(blue_belt, traits);
    }
    world->step();
    std::vector<psim::BodyId> shipped;
    for (const psim::TouchEvent& touch : world->events().sensor_begin) {  // a is the sensor, b the parcel
      for (Bin& bin : bins) {
        if (bin.sensor == touch.a) ++(world->traits(touch.b)->filter.category == kRed ? bin.red : bin.blue);
      }
      shipped.push_back(touch.b);
    }
    world->remove_bodies(shipped);
  }

  for (const Bin& bin : bins) std::printf("bin %s: %d red, %d blue\n", bin.name, bin.red, bin.blue);
  std::printf("%zu parcels are left\n", world->dynamic_count());
  const bool sorted = bins[0].red == 15 && bins[0].blue == 0 && bins[1].red == 0 && bins[2].red == 0;
  return sorted && bins[1].blue > 0 && bins[2].blue > 0 && world->dynamic_count() == 0 ? 0 : 1;
}
