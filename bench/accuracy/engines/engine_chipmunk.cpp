// Chipmunk 7. Set alike: it never sleeps and has no restitution threshold; its restitution and
// friction multiply, so each surface gets the square root, and where restitutions differ a callback
// takes the greater.
#include <chipmunk/chipmunk.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <utility>

#include "engines/engine.h"
#include "engines/peer_bodies.h"

namespace psim::accuracy {
namespace {

constexpr double kDefaultSlop = 0.1;
constexpr double kTightSlop = 0.005;  // Box2D's
constexpr int kDefaultIterations = 10;
constexpr double kTimeToSleep = 0.5;  // s, psim's and Box2D's; it has no default

cpVect to_chipmunk(Vec2 v) { return {v.x, v.y}; }

cpBool take_greater_restitution(cpArbiter* arbiter, cpSpace*, cpDataPointer) {
  CP_ARBITER_GET_SHAPES(arbiter, a, b)
  const double more = std::max(cpShapeGetElasticity(a), cpShapeGetElasticity(b));
  cpArbiterSetRestitution(arbiter, more * more);
  return cpTrue;
}

// Fields go into the velocity update, which comes after the one of places: with a force set before
// the step, places and velocities would both start from the old state (explicit Euler).
void update_velocity_in_fields(cpBody* body, cpVect gravity, cpFloat damping, cpFloat dt) {
  const auto& world = *static_cast<const WorldDesc*>(cpSpaceGetUserData(cpBodyGetSpace(body)));
  const cpVect x = cpBodyGetPosition(body), v = cpBodyGetVelocity(body);
  const Vec2 a = field_acceleration(world, {x.x, x.y}, {v.x, v.y});
  cpBodyUpdateVelocity(body, cpvadd(gravity, to_chipmunk(a)), damping, dt);
}

struct Visits {
  double points = 0;
  double virial = 0;
};

struct Pressed {
  std::vector<Load>* loads;
  double step;  // s
};

std::size_t id_of(const cpBody* body) {
  return static_cast<std::size_t>(reinterpret_cast<std::uintptr_t>(cpBodyGetUserData(body))) - 1;
}

// Called from each dynamic body: of two the one with the lower id reports.
void append_load(cpBody* body, cpArbiter* arbiter, void* data) {
  CP_ARBITER_GET_BODIES(arbiter, first, second)
  cpBody* other = first == body ? second : first;
  const std::size_t a = id_of(body), b = id_of(other);
  if (a > b && cpBodyGetType(other) == CP_BODY_TYPE_DYNAMIC) return;
  const auto& pressed = *static_cast<Pressed*>(data);
  const double along = cpvdot(cpArbiterTotalImpulse(arbiter), cpArbiterGetNormal(arbiter));
  pressed.loads->push_back({std::min(a, b), std::max(a, b), std::abs(along) / pressed.step});
}

// Called from each dynamic body: what it shares with another dynamic one comes twice.
void count_contact(cpBody* body, cpArbiter* arbiter, void* data) {
  CP_ARBITER_GET_BODIES(arbiter, a, b)
  const cpBody* other = a == body ? b : a;
  const double share = cpBodyGetType(const_cast<cpBody*>(other)) == CP_BODY_TYPE_DYNAMIC ? 0.5 : 1;
  auto& visits = *static_cast<Visits*>(data);
  visits.points += share * cpArbiterGetCount(arbiter);
  const double along = cpvdot(cpArbiterTotalImpulse(arbiter), cpArbiterGetNormal(arbiter));
  visits.virial += share * std::abs(along) * cpvdist(cpBodyGetPosition(a), cpBodyGetPosition(b));
}

double mean_size(const Model& model) {
  double sum = 0, count = 0;
  for (const BodyDesc& body : model.bodies) {
    if (body.type != BodyType::dynamic_body) continue;
    sum += std::sqrt(area_of(body));
    ++count;
  }
  return count > 0 ? sum / count : 1;
}

class ChipmunkSimulation : public Simulation {
 public:
  ChipmunkSimulation(const Model& model, const Setting& setting)
      : model_(&model), setting_(setting), space_(cpSpaceNew(), &cpSpaceFree) {
    const WorldDesc& world = model.scene.world;
    cpSpaceSetUserData(space_.get(), const_cast<WorldDesc*>(&world));
    cpSpaceSetGravity(space_.get(), to_chipmunk(world.gravity));
    cpSpaceSetIterations(space_.get(), setting.iterations);
    cpSpaceSetCollisionSlop(space_.get(), setting.slop);
    if (setting.sleeping) cpSpaceSetSleepTimeThreshold(space_.get(), kTimeToSleep);
    cpSpaceSetDamping(space_.get(), std::exp(-linear_damping(world)));
    if (setting.hashed) {
      // What its manual advises: cells as large as a shape, ten times as many as shapes.
      const int count = static_cast<int>(10 * model.bodies.size());
      cpSpaceUseSpatialHash(space_.get(), mean_size(model), count);
    }
    if (world.boundary == Boundary::walls) add_walls();
    for (const BodyDesc& body : model.bodies) add(body);
    for (const SceneJoint& joint : model.scene.joints) add(joint);
    if (!alike_) {
      cpSpaceAddDefaultCollisionHandler(space_.get())->preSolveFunc = take_greater_restitution;
    }
  }

  void advance() override {
    for (int k = 0; k < setting_.steps; ++k) {
      if (broken_) return;
      cpSpaceStep(space_.get(), setting_.h());
      broken_ = !joints_.empty() && std::ranges::any_of(bodies_, is_broken);
      if (watched_) virial_ += visits().virial;
    }
  }

  void read(std::vector<BodyState>& bodies) override {
    bodies.clear();
    if (broken_) return;
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
      const cpBody* b = bodies_[k].get();
      const cpVect x = cpBodyGetPosition(b), v = cpBodyGetVelocity(b);
      bodies.push_back({{static_cast<std::uint32_t>(k), 0},
                        x.x,
                        x.y,
                        cpBodyGetAngle(b),
                        v.x,
                        v.y,
                        cpBodyGetAngularVelocity(b),
                        radius_of(model_->bodies[k]),
                        model_->bodies[k].type});
    }
  }

  void set_velocity(std::size_t body, Vec2 velocity, double omega) override {
    cpBodySetVelocity(bodies_[body].get(), to_chipmunk(velocity));
    cpBodySetAngularVelocity(bodies_[body].get(), omega);
  }

  // Warm start and iterations.
  double row_visits() const override {
    return (visits().points + joint_rows(*model_)) * setting_.steps * (1 + setting_.iterations);
  }

  void watch_impulses() override { watched_ = true; }
  double virial() const override { return virial_; }

  std::vector<Load> loads() override {
    std::vector<Load> loads;
    Pressed pressed{&loads, setting_.h()};
    for (const auto& body : bodies_) {
      if (cpBodyGetType(body.get()) == CP_BODY_TYPE_DYNAMIC) cpBodyEachArbiter(body.get(), append_load, &pressed);
    }
    std::erase_if(loads, [&](const Load& load) { return load.b >= bodies_.size(); });  // walls
    return loads;
  }

 private:
  template <class T>
  using Owned = std::unique_ptr<T, void (*)(T*)>;

  // Springs are explicit, and joints under load diverge where a step does not resolve them. Debian's library aborts at a
  // speed that is not a number; such a run ends before it.
  static bool is_broken(const Owned<cpBody>& body) {
    constexpr double kMost = 1e6;  // m/s, rad/s
    return !(std::abs(cpBodyGetAngularVelocity(body.get())) < kMost) ||
           !(cpvlength(cpBodyGetVelocity(body.get())) < kMost);
  }

  Visits visits() const {
    Visits visits;
    for (const auto& body : bodies_) {
      if (cpBodyGetType(body.get()) != CP_BODY_TYPE_DYNAMIC) continue;
      cpBodyEachArbiter(body.get(), count_contact, &visits);
    }
    return visits;
  }

  void add_shape(cpShape* shape, const Material& material, const Filter& filter = {}) {
    const auto group = static_cast<cpGroup>(filter.group < 0 ? -filter.group : 0);
    cpShapeSetFilter(shape, cpShapeFilterNew(group, filter.category, filter.mask));
    cpShapeSetElasticity(shape, std::sqrt(material.restitution));
    cpShapeSetFriction(shape, std::sqrt(material.friction));
    alike_ = alike_ && (shapes_.empty() || material.restitution == restitution_);
    restitution_ = material.restitution;
    shapes_.emplace_back(cpSpaceAddShape(space_.get(), shape), &cpShapeFree);
  }

  void add_walls() {
    const Bounds& b = model_->scene.world.bounds;
    const std::array<cpVect, 4> corners = {{{b.xmin, b.ymin}, {b.xmax, b.ymin}, {b.xmax, b.ymax}, {b.xmin, b.ymax}}};
    for (std::size_t k = 0; k < 4; ++k) {
      cpBody* fixed = cpSpaceGetStaticBody(space_.get());
      add_shape(cpSegmentShapeNew(fixed, corners[k], corners[(k + 1) % 4], 0), model_->scene.world.wall);
    }
  }

  static cpBody* new_body(const BodyDesc& desc) {
    if (desc.type == BodyType::static_body) return cpBodyNewStatic();
    if (desc.type == BodyType::kinematic_body) return cpBodyNewKinematic();
    return cpBodyNew(mass_of(desc), desc.fixed_rotation ? INFINITY : inertia_of(desc));
  }

  void add(const BodyDesc& desc) {
    cpBody* body = cpSpaceAddBody(space_.get(), new_body(desc));
    bodies_.emplace_back(body, &cpBodyFree);
    cpBodySetUserData(body, reinterpret_cast<cpDataPointer>(static_cast<std::uintptr_t>(bodies_.size())));
    if (desc.type == BodyType::dynamic_body) {
      cpBodySetCenterOfGravity(body, to_chipmunk(centre_of(desc)));
    }
    cpBodySetAngle(body, desc.angle);  // about the centre of gravity, so before the place
    cpBodySetPosition(body, to_chipmunk(desc.position));
    if (desc.type != BodyType::static_body) {
      cpBodySetVelocity(body, to_chipmunk(desc.velocity));
      cpBodySetAngularVelocity(body, desc.angular_velocity);
    }
    if (desc.type == BodyType::dynamic_body && !model_->scene.world.fields.empty()) {
      cpBodySetVelocityUpdateFunc(body, update_velocity_in_fields);
    }
    if (const auto* line = std::get_if<SegmentShape>(&desc.shape)) {
      add_shape(cpSegmentShapeNew(body, to_chipmunk(line->p1), to_chipmunk(line->p2), 0), desc.material, desc.filter);
    } else if (const auto* chain = std::get_if<ChainShape>(&desc.shape)) {
      add_chain(*chain, desc, body);
    } else if (const auto* sides = std::get_if<BoxShape>(&desc.shape)) {
      add_shape(cpBoxShapeNew(body, sides->width, sides->height, 0), desc.material, desc.filter);
    } else if (const auto* polygon = std::get_if<PolygonShape>(&desc.shape)) {
      std::vector<cpVect> corners;
      for (const Vec2 v : polygon->vertices) corners.push_back(to_chipmunk(v));
      add_shape(cpPolyShapeNewRaw(body, static_cast<int>(corners.size()), corners.data(), 0), desc.material,
                desc.filter);
    } else {
      add_shape(cpCircleShapeNew(body, radius_of(desc), cpvzero), desc.material, desc.filter);
    }
  }

  void add_chain(const ChainShape& chain, const BodyDesc& desc, cpBody* body) {
    const std::vector<Vec2> v = with_neighbours(chain);
    for (std::size_t k = 1; k + 2 < v.size(); ++k) {
      cpShape* piece = cpSegmentShapeNew(body, to_chipmunk(v[k]), to_chipmunk(v[k + 1]), 0);
      cpSegmentShapeSetNeighbors(piece, to_chipmunk(v[k - 1]), to_chipmunk(v[k + 2]));
      add_shape(piece, desc.material, desc.filter);
    }
  }

  void keep(cpConstraint* made, bool collide) {
    cpConstraintSetCollideBodies(made, collide ? cpTrue : cpFalse);
    joints_.emplace_back(cpSpaceAddConstraint(space_.get(), made), &cpConstraintFree);
  }

  // It has these in parts: a pin or a groove for the places, a gear, a spring or a motor for the angle.
  bool add_parts(const SceneJoint& scene_joint) {
    constexpr double kGroove = 100;  // m, half of its length
    const JointDesc& joint = scene_joint.joint;
    cpBody *a = bodies_[scene_joint.a].get(), *b = bodies_[scene_joint.b].get();
    const cpVect at_a = to_chipmunk(joint.anchor_a), at_b = to_chipmunk(joint.anchor_b);
    const double reference = reference_of(*model_, scene_joint);
    if (joint.type == JointType::prismatic) {
      const cpVect along = cpvmult(cpvnormalize(to_chipmunk(joint.axis)), kGroove);
      keep(cpGrooveJointNew(a, b, cpvsub(at_a, along), cpvadd(at_a, along), at_b), joint.collide);
      keep(cpGearJointNew(a, b, reference, 1), joint.collide);
    } else if (joint.type == JointType::weld) {
      keep(cpPivotJointNew2(a, b, at_a, at_b), joint.collide);
      keep(joint.stiffness > 0 ? cpDampedRotarySpringNew(a, b, -reference, joint.stiffness, joint.damping)
                               : cpGearJointNew(a, b, reference, 1),
           joint.collide);
    } else if (joint.type == JointType::revolute && joint.motor_limit != 0) {
      keep(cpPivotJointNew2(a, b, at_a, at_b), joint.collide);
      cpConstraint* motor = cpSimpleMotorNew(a, b, -joint.motor_speed);
      cpConstraintSetMaxForce(motor, joint.motor_limit);
      keep(motor, joint.collide);
    } else {
      return false;
    }
    return true;
  }

  void add(const SceneJoint& scene_joint) {
    if (add_parts(scene_joint)) return;
    const JointDesc& joint = scene_joint.joint;
    cpBody *a = bodies_[scene_joint.a].get(), *b = bodies_[scene_joint.b].get();
    const cpVect at_a = to_chipmunk(joint.anchor_a), at_b = to_chipmunk(joint.anchor_b);
    cpConstraint* made = nullptr;
    if (joint.type == JointType::revolute) {
      made = cpPivotJointNew2(a, b, at_a, at_b);
    } else if (joint.type == JointType::spring) {
      made = cpDampedSpringNew(a, b, at_a, at_b, length_of(*model_, scene_joint), joint.stiffness, joint.damping);
    } else if (joint.type == JointType::rope) {
      made = cpSlideJointNew(a, b, at_a, at_b, 0, length_of(*model_, scene_joint));
    } else {
      made = cpPinJointNew(a, b, at_a, at_b);
      cpPinJointSetDist(made, length_of(*model_, scene_joint));
    }
    keep(made, joint.collide);
  }

  const Model* model_;
  Setting setting_;
  std::vector<Owned<cpBody>> bodies_;
  std::vector<Owned<cpShape>> shapes_;
  std::vector<Owned<cpConstraint>> joints_;
  Owned<cpSpace> space_;  // freed first: it looks at its bodies once more
  bool alike_ = true;
  double restitution_ = 0;
  bool broken_ = false;
  bool watched_ = false;
  double virial_ = 0;
};

Setting setting_of(double slop, int iterations, int steps) {
  Setting s;
  s.steps = steps;
  s.iterations = iterations;
  s.slop = slop;
  s.curve = slop == kDefaultSlop ? "slop-0.1" : "slop-0.005";
  s.is_default = slop == kDefaultSlop && iterations == kDefaultIterations && steps == 1;
  return s;
}

std::vector<Setting> chipmunk_settings(Effort effort, Scale scale) {
  std::vector<Setting> settings;
  if (effort == Effort::quick) {
    for (const double slop : {kDefaultSlop, kTightSlop}) {
      for (const int steps : {1, 4}) settings.push_back(setting_of(slop, kDefaultIterations, steps));
    }
    return settings;
  }
  for (const double slop : {kDefaultSlop, kTightSlop}) {
    for (const int iterations : {1, 2, 4, 8, kDefaultIterations, 16}) {
      for (const int steps : {1, 2, 4, 8, 16, 32, 64}) {
        const bool usual = iterations == kDefaultIterations;
        const bool sparse = steps > 16 || (!usual && ((steps != 1 && steps != 4) || slop == kTightSlop));
        if (scale == Scale::small || !sparse) settings.push_back(setting_of(slop, iterations, steps));
      }
    }
  }
  return settings;
}

}  // namespace

namespace {

// A library built without NDEBUG says so on stdout, which is for rows, when it makes its first
// space.
void let_it_introduce_itself() {
  std::fflush(stdout);
  const int rows = ::dup(STDOUT_FILENO);
  if (rows < 0) return;
  ::dup2(STDERR_FILENO, STDOUT_FILENO);
  cpSpaceFree(cpSpaceNew());
  std::fflush(stdout);
  ::dup2(rows, STDOUT_FILENO);
  ::close(rows);
}

}  // namespace

Engine chipmunk_engine() {
  let_it_introduce_itself();
  Engine engine;
  engine.name = "chipmunk";
  engine.version = cpVersionString;
  engine.refuses = [](const Model& model) {
    return refusal(model, {.fields = true,
                           .segments = true,
                           .polygons = true,
                           .chains = true,
                           .rods = true,
                           .springs = true,
                           .ropes = true,
                           .welds = true,
                           .slides = true,
                           .motors = true});
  };
  engine.make = [](const Model& model, const Setting& setting) {
    return std::make_unique<ChipmunkSimulation>(model, setting);
  };
  engine.settings = chipmunk_settings;
  return engine;
}

}  // namespace psim::accuracy
