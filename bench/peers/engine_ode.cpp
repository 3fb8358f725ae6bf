// ODE in the plane: its contacts are reduced to those of the plane z = 0, so that nothing pushes a
// body out of it, and what rounding does about it is taken away after every step, as its manual wants
// it with the plane joint; that joint's three rows a body are spared. QuickStep. Set alike: no
// restitution threshold, mixing rules are psim's. All else is its own default; it has no warm start.
#include <ode/ode.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "engines.h"
#include "engines/peer_bodies.h"

namespace psim::peers {
namespace {

using namespace accuracy;

constexpr double kDepth = 1;           // m, of boxes along z
constexpr double kWallThickness = 10;  // m
constexpr int kMostContacts = 8;       // of two boxes

class OdeSimulation : public Simulation {
 public:
  OdeSimulation(const Model& model, const Setting& setting) : model_(&model), setting_(setting) {
    const WorldDesc& world = model.scene.world;
    dRandSetSeed(0);  // of the order of rows: the same run twice
    dWorldSetGravity(world_, world.gravity.x, world.gravity.y, 0);
    dWorldSetQuickStepNumIterations(world_, setting.iterations);
    dWorldSetAutoDisableFlag(world_, setting.sleeping ? 1 : 0);
    dWorldSetLinearDamping(world_, 1 - std::exp(-linear_damping(world) * setting.h()));
    dWorldSetLinearDampingThreshold(world_, 0);
    if (world.boundary == Boundary::walls) add_walls();
    for (const BodyDesc& body : model.bodies) add(body);
    for (const SceneJoint& joint : model.scene.joints) add(joint);
  }
  ~OdeSimulation() override {
    dJointGroupDestroy(contacts_);
    dSpaceDestroy(space_);
    dWorldDestroy(world_);
  }
  OdeSimulation(const OdeSimulation&) = delete;
  OdeSimulation& operator=(const OdeSimulation&) = delete;

  void advance() override {
    for (int k = 0; k < setting_.steps; ++k) {
      rows_ = 0;
      dSpaceCollide(space_, this,
                    [](void* self, dGeomID a, dGeomID b) { static_cast<OdeSimulation*>(self)->meet(a, b); });
      dWorldQuickStep(world_, setting_.h());
      dJointGroupEmpty(contacts_);
      for (const dBodyID body : bodies_) {
        if (body) flatten(body);
      }
    }
  }

  // Angles from -pi to pi: it keeps a direction.
  void read(std::vector<BodyState>& bodies) override {
    bodies.clear();
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
      const BodyDesc& desc = model_->bodies[k];
      BodyState s{{static_cast<std::uint32_t>(k), 0},
                  desc.position.x,
                  desc.position.y,
                  desc.angle,
                  0,
                  0,
                  0,
                  radius_of(desc),
                  desc.type};
      if (const dBodyID body = bodies_[k]) {
        const dReal *x = dBodyGetPosition(body), *q = dBodyGetQuaternion(body);
        s.angle = std::remainder(2 * std::atan2(q[3], q[0]), 2 * std::numbers::pi);
        const Vec2 c = turned(centre_of(desc), s.angle);
        s.x = x[0] - c.x;
        s.y = x[1] - c.y;
        s.vx = dBodyGetLinearVel(body)[0];
        s.vy = dBodyGetLinearVel(body)[1];
        s.omega = dBodyGetAngularVel(body)[2];
      }
      bodies.push_back(s);
    }
  }

  void set_velocity(std::size_t body, Vec2 velocity, double omega) override {
    dBodySetLinearVel(bodies_[body], velocity.x, velocity.y, 0);
    dBodySetAngularVel(bodies_[body], 0, 0, omega);
  }

  double row_visits() const override {
    return static_cast<double>(rows_ + joint_rows(*model_)) * setting_.steps * setting_.iterations;
  }

 private:
  static constexpr std::uint64_t kWall = ~std::uint64_t{0};

  static Vec2 turned(Vec2 v, double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    return {c * v.x - s * v.y, s * v.x + c * v.y};
  }

  static Vec2 minus(Vec2 a, Vec2 b) { return {a.x - b.x, a.y - b.y}; }

  static void flatten(dBodyID body) {
    const dReal *x = dBodyGetPosition(body), *v = dBodyGetLinearVel(body);
    const dReal *w = dBodyGetAngularVel(body), *q = dBodyGetQuaternion(body);
    if (x[2] == 0 && v[2] == 0 && w[0] == 0 && w[1] == 0 && q[1] == 0 && q[2] == 0) return;
    const double length = std::hypot(q[0], q[3]);
    const dQuaternion turn = {q[0] / length, 0, 0, q[3] / length};
    dBodySetPosition(body, x[0], x[1], 0);
    dBodySetQuaternion(body, turn);
    dBodySetLinearVel(body, v[0], v[1], 0);
    dBodySetAngularVel(body, 0, 0, w[2]);
  }

  static std::uint64_t id(dGeomID geom) {
    return static_cast<std::uint64_t>(reinterpret_cast<std::uintptr_t>(dGeomGetData(geom))) - 1;
  }
  static void set_id(dGeomID geom, std::uint64_t id) {
    dGeomSetData(geom, reinterpret_cast<void*>(static_cast<std::uintptr_t>(id + 1)));
  }

  const Material& material(std::uint64_t id) const {
    return id == kWall ? model_->scene.world.wall : model_->bodies[id].material;
  }
  bool may_touch(std::uint64_t a, std::uint64_t b) const {
    if (a == kWall || b == kWall) return true;
    if (!accuracy::collide(model_->bodies[a].filter, model_->bodies[b].filter)) return false;
    return !(jointed_[a] && jointed_[b] && tied_.contains({std::min(a, b), std::max(a, b)}));
  }

  void meet(dGeomID a, dGeomID b) {
    const dBodyID body_a = dGeomGetBody(a), body_b = dGeomGetBody(b);
    const bool moves_a = body_a && !dBodyIsKinematic(body_a);
    const bool moves_b = body_b && !dBodyIsKinematic(body_b);
    if ((!moves_a && !moves_b) || !may_touch(id(a), id(b))) return;
    std::array<dContact, kMostContacts> found;
    const int n = dCollide(a, b, kMostContacts, &found[0].geom, sizeof(dContact));
    const Material &m = material(id(a)), &l = material(id(b));
    const double friction = std::sqrt(m.friction * l.friction);
    const double restitution = std::max(m.restitution, l.restitution);
    for (int k = 0; k < n; ++k) {
      dContact& contact = found[static_cast<std::size_t>(k)];
      if (contact.geom.pos[2] < 0) continue;  // the far side has the same contact
      contact.geom.pos[2] = 0;
      const dReal* normal = contact.geom.normal;
      contact.surface.mode = dContactApprox1 | dContactFDir1 | dContactMu2;
      contact.surface.mu = friction;
      contact.surface.mu2 = 0;  // no row along z
      contact.fdir1[0] = -normal[1];
      contact.fdir1[1] = normal[0];
      contact.fdir1[2] = 0;
      if (restitution > 0) {
        contact.surface.mode |= dContactBounce;
        contact.surface.bounce = restitution;
        contact.surface.bounce_vel = model_->scene.world.restitution_threshold;
      }
      rows_ += friction > 0 ? 2 : 1;
      dJointAttach(dJointCreateContact(world_, contacts_, &contact), body_a, body_b);
    }
  }

  void add_walls() {
    const Bounds& b = model_->scene.world.bounds;
    const double t = kWallThickness, w = b.xmax - b.xmin, h = b.ymax - b.ymin;
    const double x = (b.xmin + b.xmax) / 2, y = (b.ymin + b.ymax) / 2;
    const std::array<std::pair<Vec2, Vec2>, 4> sides = {{{{x, b.ymin - t / 2}, {w + 2 * t, t}},
                                                         {{x, b.ymax + t / 2}, {w + 2 * t, t}},
                                                         {{b.xmin - t / 2, y}, {t, h + 2 * t}},
                                                         {{b.xmax + t / 2, y}, {t, h + 2 * t}}}};
    for (const auto& [at, size] : sides) {
      const dGeomID wall = dCreateBox(space_, size.x, size.y, kDepth);
      dGeomSetPosition(wall, at.x, at.y, 0);
      set_id(wall, kWall);
    }
  }

  /// The shape, and its centre in the body's frame.
  std::pair<dGeomID, Vec2> geom_of(const BodyDesc& desc) {
    if (const auto* box = std::get_if<BoxShape>(&desc.shape)) {
      return {dCreateBox(space_, box->width, box->height, kDepth), {}};
    }
    if (const auto* polygon = std::get_if<PolygonShape>(&desc.shape)) {
      const Rectangle sides = *rectangle_of(*polygon);
      return {dCreateBox(space_, sides.width, sides.height, kDepth), sides.centre};
    }
    return {dCreateSphere(space_, radius_of(desc)), {}};
  }

  static void place(Vec2 at, double angle, auto object, auto set_position, auto set_turn) {
    const dQuaternion turn = {std::cos(angle / 2), 0, 0, std::sin(angle / 2)};
    set_position(object, at.x, at.y, 0);
    set_turn(object, turn);
  }

  void add(const BodyDesc& desc) {
    const auto [geom, offset] = geom_of(desc);
    set_id(geom, bodies_.size());
    jointed_.push_back(false);
    const Vec2 way = turned(offset, desc.angle);
    const Vec2 middle{desc.position.x + way.x, desc.position.y + way.y};
    if (desc.type == BodyType::static_body) {
      bodies_.push_back(nullptr);
      place(middle, desc.angle, geom, dGeomSetPosition, dGeomSetQuaternion);
      return;
    }
    const dBodyID body = dBodyCreate(world_);
    bodies_.push_back(body);
    dGeomSetBody(geom, body);
    dBodySetLinearVel(body, desc.velocity.x, desc.velocity.y, 0);
    dBodySetAngularVel(body, 0, 0, desc.angular_velocity);
    dBodySetFiniteRotationMode(body, 0);
    if (desc.type == BodyType::kinematic_body) {
      dBodySetKinematic(body);
      dBodySetAutoDisableFlag(body, 0);
      place(desc.position, desc.angle, body, dBodySetPosition, dBodySetQuaternion);
      dGeomSetOffsetPosition(geom, offset.x, offset.y, 0);
      return;
    }
    place(middle, desc.angle, body, dBodySetPosition, dBodySetQuaternion);
    dMass mass;
    const double inertia = inertia_of(desc);
    dMassSetParameters(&mass, mass_of(desc), 0, 0, 0, inertia, inertia, inertia, 0, 0, 0);
    dBodySetMass(body, &mass);
    dBodySetGyroscopicMode(body, 0);
    if (desc.fixed_rotation) {
      const dJointID plane = dJointCreatePlane2D(world_, nullptr);
      dJointAttach(plane, body, nullptr);
      dJointSetPlane2DAngleParam(plane, dParamVel, 0);
      dJointSetPlane2DAngleParam(plane, dParamFMax, dInfinity);
    }
  }

  Vec2 anchor(std::uint64_t body, Vec2 at) const {
    const BodyDesc& desc = model_->bodies[body];
    const Vec2 way = turned(at, desc.angle);
    return {desc.position.x + way.x, desc.position.y + way.y};
  }

  void add(const SceneJoint& joint) {
    std::uint64_t a = joint.a, b = joint.b;
    Vec2 at_a = anchor(a, joint.joint.anchor_a), at_b = anchor(b, joint.joint.anchor_b);
    if (!bodies_[a]) {  // what is fixed comes second
      std::swap(a, b);
      std::swap(at_a, at_b);
    }
    jointed_[a] = jointed_[b] = true;
    if (!joint.joint.collide) tied_.emplace(std::min(a, b), std::max(a, b));
    if (joint.joint.type == JointType::revolute) {
      const dJointID pin = dJointCreateBall(world_, nullptr);
      dJointAttach(pin, bodies_[a], bodies_[b]);
      dJointSetBallAnchor(pin, at_a.x, at_a.y, 0);
      // The second one is asked for in the frame of its body.
      if (bodies_[b])
        at_b = minus(b == joint.b ? joint.joint.anchor_b : joint.joint.anchor_a, centre_of(model_->bodies[b]));
      dJointSetBallAnchor2(pin, at_b.x, at_b.y, 0);
      return;
    }
    const dJointID rod = dJointCreateDBall(world_, nullptr);
    dJointAttach(rod, bodies_[a], bodies_[b]);
    dJointSetDBallAnchor1(rod, at_a.x, at_a.y, 0);
    dJointSetDBallAnchor2(rod, at_b.x, at_b.y, 0);
    dJointSetDBallDistance(rod, length_of(*model_, joint));
  }

  const Model* model_;
  Setting setting_;
  dWorldID world_ = dWorldCreate();
  dSpaceID space_ = dSweepAndPruneSpaceCreate(nullptr, dSAP_AXES_XYZ);
  dJointGroupID contacts_ = dJointGroupCreate(0);
  std::vector<dBodyID> bodies_;  // owned by the world; null: a fixed one is a geometry alone
  std::vector<bool> jointed_;
  std::set<std::pair<std::uint64_t, std::uint64_t>> tied_;  // pairs whose joint lets them overlap
  int rows_ = 0;
};

}  // namespace

Engine ode_engine() {
  dInitODE2(0);
  Engine engine;
  engine.name = "ode";
  engine.version = PSIM_ODE_VERSION;
  engine.refuses = [](const Model& model) {
    return refusal(model, {.rectangles = true, .restitution_threshold = true, .always_groups = true, .rods = true});
  };
  engine.make = [](const Model& model, const Setting& setting) {
    return std::make_unique<OdeSimulation>(model, setting);
  };
  return engine;
}

}  // namespace psim::peers
