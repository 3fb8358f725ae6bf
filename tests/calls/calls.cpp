// calls [NAME COUNT]: makes a world of COUNT bodies and changes each of them by one call, all calls in one function, so
// that tests/calls/count can tell what they cost. Without arguments: the names.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "psim/isa.h"
#include "psim/world.h"

// Named on valgrind's command line.
extern "C" [[gnu::noinline]] void counted_calls(const std::function<void()>& calls) { calls(); }

namespace psim {
namespace {

struct Crowd {
  std::unique_ptr<World> world;
  std::vector<BodyId> ids;
  std::vector<JointId> joints;
  std::string error;

  explicit Crowd(Vec2 gravity = {}) {
    WorldDesc desc;
    desc.bounds = {-10, 0, 1e5, 1000};
    desc.gravity = gravity;
    world = World::create(desc, {best_isa(), 1}, error);
  }
  BodyId add(Vec2 at, BodyType type = BodyType::dynamic_body, Shape shape = DiscShape{0.5}, bool bullet = false) {
    BodyDesc body;
    body.position = at;
    body.type = type;
    body.shape = std::move(shape);
    body.bullet = bullet;
    body.material.friction = 0.5;
    ids.push_back(world->add_body(body, error));
    return ids.back();
  }
  void join(JointType type, std::size_t a, std::size_t b) {
    JointDesc joint;
    joint.type = type;
    joint.a = ids[a];
    joint.b = ids[b];
    joints.push_back(world->add_joint(joint, error));
  }
  void rest() {
    for (int frame = 0; frame < 1000; ++frame) {
      if (world->step().asleep == ids.size()) return;
    }
    throw std::runtime_error("they do not sleep");
  }
  void remove_all() {
    counted_calls([&] {
      for (const BodyId id : ids) world->remove_body(id);
    });
  }
};

Vec2 in_row(std::size_t k, double y = 0.5) { return {2 * static_cast<double>(k), y}; }

void remove_of_type(std::size_t n, BodyType type, bool bullet) {
  Crowd crowd;
  for (std::size_t k = 0; k < n; ++k) crowd.add(in_row(k), type, DiscShape{0.5}, bullet);
  crowd.world->step();
  crowd.remove_all();
}

// Bodies at rest on the floor, in pairs with a rod, or alone.
Crowd sleepers(std::size_t n, bool joined) {
  Crowd crowd({0, -9.81});
  for (std::size_t k = 0; k < n; ++k) {
    crowd.add(in_row(k));
    if (joined && k % 2 == 1) crowd.join(JointType::distance, k - 1, k);
  }
  crowd.rest();
  return crowd;
}

// All are joined to the first one, or each to the one before.
Crowd joined(std::size_t n, bool hub, JointType type) {
  Crowd crowd;
  for (std::size_t k = 0; k < n; ++k) {
    crowd.add(in_row(k));
    if (k != 0) crowd.join(type, hub ? 0 : k - 1, k);
  }
  return crowd;
}

void remove_joints(std::size_t n, bool hub) {
  Crowd crowd = joined(n, hub, JointType::distance);
  counted_calls([&] {
    for (const JointId id : crowd.joints) crowd.world->remove_joint(id);
  });
}

const std::map<std::string, std::function<void(std::size_t)>> kCases{
    {"remove discs", [](std::size_t n) { remove_of_type(n, BodyType::dynamic_body, false); }},
    {"remove kinematic discs", [](std::size_t n) { remove_of_type(n, BodyType::kinematic_body, false); }},
    {"remove static discs", [](std::size_t n) { remove_of_type(n, BodyType::static_body, false); }},
    {"remove bullets", [](std::size_t n) { remove_of_type(n, BodyType::dynamic_body, true); }},
    {"remove different boxes",
     [](std::size_t n) {
       Crowd crowd;
       for (std::size_t k = 0; k < n; ++k) {
         crowd.add(in_row(k), BodyType::dynamic_body, BoxShape{0.5 + 1e-4 * static_cast<double>(k), 0.5, 0});
       }
       crowd.remove_all();
     }},
    {"remove sleepers", [](std::size_t n) { sleepers(n, false).remove_all(); }},
    {"set velocities of kinematic discs",
     [](std::size_t n) {
       Crowd crowd;
       for (std::size_t k = 0; k < n; ++k) crowd.add(in_row(k), BodyType::kinematic_body);
       counted_calls([&] {
         for (const BodyId id : crowd.ids) crowd.world->set_velocity(id, {1, 0}, 0);
       });
     }},
    {"disable discs",
     [](std::size_t n) {
       Crowd crowd;
       for (std::size_t k = 0; k < n; ++k) crowd.add(in_row(k));
       counted_calls([&] {
         for (const BodyId id : crowd.ids) crowd.world->set_enabled(id, false);
       });
     }},
    {"enable static boxes",
     [](std::size_t n) {
       Crowd crowd;
       for (std::size_t k = 0; k < n; ++k) crowd.add(in_row(k), BodyType::static_body, BoxShape{0.5, 0.5, 0});
       for (const BodyId id : crowd.ids) crowd.world->set_enabled(id, false);
       counted_calls([&] {
         for (const BodyId id : crowd.ids) crowd.world->set_enabled(id, true);
       });
     }},
    {"change traits",
     [](std::size_t n) {
       Crowd crowd;
       for (std::size_t k = 0; k < n; ++k) crowd.add(in_row(k));
       counted_calls([&] {
         for (const BodyId id : crowd.ids) {
           BodyTraits traits = crowd.world->traits(id).value();
           traits.linear_damping = 1;
           crowd.world->set_traits(id, traits);
           crowd.world->set_user_data(id, 1 + id.index);
         }
       });
     }},
    {"wake sleepers",
     [](std::size_t n) {
       Crowd crowd = sleepers(n, false);
       counted_calls([&] {
         for (const BodyId id : crowd.ids) crowd.world->wake(id);
       });
     }},
    {"wake joined sleepers",
     [](std::size_t n) {
       Crowd crowd = sleepers(n, true);
       counted_calls([&] {
         for (const BodyId id : crowd.ids) crowd.world->wake(id);
       });
     }},
    {"add static discs above sleepers",
     [](std::size_t n) {
       Crowd crowd = sleepers(n, false);
       counted_calls([&] {
         for (std::size_t k = 0; k < n; ++k) crowd.add(in_row(k, 10), BodyType::static_body);
       });
     }},
    {"remove joints of a row", [](std::size_t n) { remove_joints(n, false); }},
    {"remove joints of a hub", [](std::size_t n) { remove_joints(n, true); }},
    {"start motors",
     [](std::size_t n) {
       Crowd crowd = joined(n, false, JointType::revolute);
       crowd.world->step();
       counted_calls([&] {
         for (const JointId id : crowd.joints) crowd.world->set_motor(id, 1, 1);
       });
     }},
    {"change joints",
     [](std::size_t n) {
       Crowd crowd = joined(n, false, JointType::revolute);
       crowd.world->step();
       counted_calls([&] {
         for (const JointId id : crowd.joints) {
           JointDesc desc = crowd.world->joint_desc(id).value();
           desc.stiffness = 1, desc.break_force = 1e6;
           crowd.world->set_joint(id, desc, crowd.error);
         }
       });
     }},
    {"step after half were removed, with events",
     [](std::size_t n) {
       Crowd crowd({0, -9.81});
       crowd.world->set_event_options({true, true, 2, true});
       for (std::size_t k = 0; k < n; ++k) crowd.add(in_row(k / 2, k % 2 == 0 ? 0.5 : 1.5));
       for (int frame = 0; frame < 10; ++frame) crowd.world->step();
       for (std::size_t k = 0; k < n; k += 2) crowd.world->remove_body(crowd.ids[k]);
       counted_calls([&] { crowd.world->step(); });
     }},
};

}  // namespace
}  // namespace psim

int main(int count, char** arguments) {
  if (count == 1) {
    for (const auto& [name, run] : psim::kCases) std::printf("%s\n", name.c_str());
    return 0;
  }
  const auto found = psim::kCases.find(arguments[1]);
  const std::size_t bodies = count == 3 ? std::strtoull(arguments[2], nullptr, 10) : 0;
  if (found == psim::kCases.end() || bodies == 0) {
    std::fputs("calls [NAME COUNT]\n", stderr);
    return 2;
  }
  try {
    found->second(bodies);
  } catch (const std::exception& fault) {
    std::fprintf(stderr, "calls: %s\n", fault.what());
    return 1;
  }
  return 0;
}
