// Bullet 2 in single precision, as Debian's libbullet has it, in the plane: motion along x and y,
// turns about z, its shapes and algorithms for boxes and polygons in 2D. Set alike: no restitution
// threshold, mixing rules are psim's. All else is its own default: warm start, split impulses.
#include <BulletCollision/CollisionDispatch/btBox2dBox2dCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btConvex2dConvex2dAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletCollision/CollisionShapes/btBox2dShape.h>
#include <BulletCollision/CollisionShapes/btConvex2dShape.h>
#include <BulletCollision/NarrowPhaseCollision/btMinkowskiPenetrationDepthSolver.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "engines.h"
#include "engines/peer_bodies.h"

namespace psim::peers {
namespace {

using namespace accuracy;

constexpr btScalar kHalfDepth = 0.5f;  // m, of boxes along z
constexpr double kWallThickness = 10;  // m

btScalar scalar(double v) { return static_cast<btScalar>(v); }
btVector3 vector(Vec2 v) { return {scalar(v.x), scalar(v.y), 0}; }

btTransform pose(Vec2 position, double angle) {
  return btTransform(btQuaternion(btVector3(0, 0, 1), scalar(angle)), vector(position));
}

Vec2 turned(Vec2 v, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * v.x - s * v.y, s * v.x + c * v.y};
}

btScalar greater_restitution(const btCollisionObject* a, const btCollisionObject* b) {
  return std::max(a->getRestitution(), b->getRestitution());
}
btScalar mean_friction(const btCollisionObject* a, const btCollisionObject* b) {
  return std::sqrt(a->getFriction() * b->getFriction());
}

/// Turns and moves a kinematic body, which Bullet asks for its place.
class Driven : public btMotionState {
 public:
  Driven(const BodyDesc& desc, Vec2 centre)
      : place_(desc.position), angle_(desc.angle), desc_(&desc), centre_(centre) {}
  void advance(double h) {
    place_.x += h * desc_->velocity.x;
    place_.y += h * desc_->velocity.y;
    angle_ += h * desc_->angular_velocity;
  }
  void getWorldTransform(btTransform& at) const override {
    const Vec2 c = turned(centre_, angle_);
    at = pose({place_.x + c.x, place_.y + c.y}, angle_);
  }
  void setWorldTransform(const btTransform&) override {}
  Vec2 place() const { return place_; }

 private:
  Vec2 place_;
  double angle_;
  const BodyDesc* desc_;
  Vec2 centre_;  // of the shape, in the body's frame
};

struct CollideByFilters : btOverlapFilterCallback {
  const Model* model = nullptr;

  bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override {
    const int i = id(a), j = id(b);
    const auto of = [&](int k) { return model->bodies[static_cast<std::size_t>(k)]; };
    if (i < 0 && j < 0) return false;
    const auto type = [&](int k) { return k < 0 ? BodyType::static_body : of(k).type; };
    if (type(i) != BodyType::dynamic_body && type(j) != BodyType::dynamic_body) return false;
    return i < 0 || j < 0 || accuracy::collide(of(i).filter, of(j).filter);
  }
  static int id(const btBroadphaseProxy* p) {
    return static_cast<const btCollisionObject*>(p->m_clientObject)->getUserIndex();
  }
};

class BulletSimulation : public Simulation {
 public:
  BulletSimulation(const Model& model, const Setting& setting)
      : model_(&model),
        setting_(setting),
        config_(pools(model)),
        dispatcher_(&config_),
        world_(&dispatcher_, &broad_phase_, &solver_, &config_) {
    gCalculateCombinedRestitutionCallback = greater_restitution;
    gCalculateCombinedFrictionCallback = mean_friction;
    for (const int a : {BOX_2D_SHAPE_PROXYTYPE, CONVEX_2D_SHAPE_PROXYTYPE}) {
      for (const int b : {BOX_2D_SHAPE_PROXYTYPE, CONVEX_2D_SHAPE_PROXYTYPE}) {
        const bool boxes = a == BOX_2D_SHAPE_PROXYTYPE && b == BOX_2D_SHAPE_PROXYTYPE;
        btCollisionAlgorithmCreateFunc* made = &meet_polygons_;
        if (boxes) made = &meet_boxes_;
        dispatcher_.registerCollisionCreateFunc(a, b, made);
      }
    }
    filters_.model = &model;
    if (has_filters()) world_.getPairCache()->setOverlapFilterCallback(&filters_);
    const WorldDesc& world = model.scene.world;
    world_.setGravity(vector(world.gravity));
    world_.getSolverInfo().m_numIterations = setting.iterations;
    world_.getSolverInfo().m_restitutionVelocityThreshold = scalar(world.restitution_threshold);
    if (world.boundary == Boundary::walls) add_walls();
    for (const BodyDesc& body : model.bodies) add(body);
    for (const SceneJoint& joint : model.scene.joints) add(joint);
  }

  ~BulletSimulation() override {
    for (const auto& joint : joints_) world_.removeConstraint(joint.get());
    for (const auto& body : bodies_) world_.removeRigidBody(body.get());
    for (const auto& wall : walls_) world_.removeRigidBody(wall.get());
  }
  BulletSimulation(const BulletSimulation&) = delete;
  BulletSimulation& operator=(const BulletSimulation&) = delete;

  void advance() override {
    for (int k = 0; k < setting_.steps; ++k) {
      for (const auto& driven : driven_) driven->advance(setting_.h());
      world_.stepSimulation(scalar(setting_.h()), 0);
    }
  }

  // Angles from -pi to pi: it keeps a direction.
  void read(std::vector<BodyState>& bodies) override {
    bodies.clear();
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
      const btRigidBody& b = *bodies_[k];
      const btMatrix3x3& turn = b.getWorldTransform().getBasis();
      const double angle = std::atan2(turn[1][0], turn[0][0]);
      const Vec2 c = turned(centres_[k], angle);
      const btVector3 &x = b.getWorldTransform().getOrigin(), &v = b.getLinearVelocity();
      bodies.push_back({{static_cast<std::uint32_t>(k), 0},
                        static_cast<double>(x.x()) - c.x,
                        static_cast<double>(x.y()) - c.y,
                        angle,
                        v.x(),
                        v.y(),
                        b.getAngularVelocity().z(),
                        radius_of(model_->bodies[k]),
                        model_->bodies[k].type});
    }
  }

  void set_velocity(std::size_t body, Vec2 velocity, double omega) override {
    bodies_[body]->setLinearVelocity(vector(velocity));
    bodies_[body]->setAngularVelocity({0, 0, scalar(omega)});
  }

  // Warm start and iterations.
  double row_visits() const override {
    int points = 0;
    for (int k = 0; k < dispatcher_.getNumManifolds(); ++k) {
      points += const_cast<btCollisionDispatcher&>(dispatcher_).getManifoldByIndexInternal(k)->getNumContacts();
    }
    return static_cast<double>(points + joint_rows(*model_)) * setting_.steps * (1 + setting_.iterations);
  }

 private:
  static btDefaultCollisionConstructionInfo pools(const Model& model) {
    btDefaultCollisionConstructionInfo info;
    const int manifolds = static_cast<int>(std::min<std::size_t>(4 * model.bodies.size(), 1 << 20));
    info.m_defaultMaxPersistentManifoldPoolSize = std::max(info.m_defaultMaxPersistentManifoldPoolSize, manifolds);
    info.m_defaultMaxCollisionAlgorithmPoolSize = std::max(info.m_defaultMaxCollisionAlgorithmPoolSize, manifolds);
    return info;
  }

  bool has_filters() const {
    return std::ranges::any_of(model_->bodies, [](const BodyDesc& b) { return !(b.filter == Filter{}); });
  }

  /// The shape about its own centre.
  btCollisionShape* shape_of(const BodyDesc& desc, Vec2 centre) {
    if (const auto* box = std::get_if<BoxShape>(&desc.shape)) {
      return box_shape(box->width, box->height);
    }
    const auto* polygon = std::get_if<PolygonShape>(&desc.shape);
    if (!polygon) {
      return keep(std::make_unique<btSphereShape>(scalar(radius_of(desc))));
    }
    if (const auto sides = rectangle_of(*polygon)) return box_shape(sides->width, sides->height);
    auto hull = std::make_unique<btConvexHullShape>();
    for (const Vec2 v : polygon->vertices) {
      hull->addPoint(vector({v.x - centre.x, v.y - centre.y}), false);
    }
    hull->recalcLocalAabb();
    hull->setMargin(0);
    auto flat = std::make_unique<btConvex2dShape>(hull.get());
    shapes_.push_back(std::move(hull));
    return keep(std::move(flat));
  }

  btCollisionShape* box_shape(double width, double height) {
    return keep(std::make_unique<btBox2dShape>(btVector3(scalar(width / 2), scalar(height / 2), kHalfDepth)));
  }

  btCollisionShape* keep(std::unique_ptr<btCollisionShape> shape) {
    shapes_.push_back(std::move(shape));
    return shapes_.back().get();
  }

  void add_walls() {
    const WorldDesc& world = model_->scene.world;
    const Bounds& b = world.bounds;
    const double t = kWallThickness, w = b.xmax - b.xmin, h = b.ymax - b.ymin;
    const double x = (b.xmin + b.xmax) / 2, y = (b.ymin + b.ymax) / 2;
    const std::array<std::pair<Vec2, Vec2>, 4> sides = {{{{x, b.ymin - t / 2}, {w + 2 * t, t}},
                                                         {{x, b.ymax + t / 2}, {w + 2 * t, t}},
                                                         {{b.xmin - t / 2, y}, {t, h + 2 * t}},
                                                         {{b.xmax + t / 2, y}, {t, h + 2 * t}}}};
    for (const auto& [at, size] : sides) {
      btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, box_shape(size.x, size.y));
      info.m_startWorldTransform = pose(at, 0);
      info.m_restitution = scalar(world.wall.restitution);
      info.m_friction = scalar(world.wall.friction);
      walls_.push_back(std::make_unique<btRigidBody>(info));
      walls_.back()->setUserIndex(-1);
      world_.addRigidBody(walls_.back().get());
    }
  }

  static Vec2 shape_centre(const BodyDesc& desc) {
    const auto* polygon = std::get_if<PolygonShape>(&desc.shape);
    if (!polygon) return {};
    if (const auto sides = rectangle_of(*polygon)) return sides->centre;
    return centre_of(desc);
  }

  void add(const BodyDesc& desc) {
    const Vec2 centre = shape_centre(desc), way = turned(centre, desc.angle);
    const bool moves = desc.type == BodyType::dynamic_body;
    btRigidBody::btRigidBodyConstructionInfo info(moves ? scalar(mass_of(desc)) : 0, nullptr, shape_of(desc, centre));
    info.m_startWorldTransform = pose({desc.position.x + way.x, desc.position.y + way.y}, desc.angle);
    if (moves) info.m_localInertia = {0, 0, scalar(inertia_of(desc))};
    info.m_restitution = scalar(desc.material.restitution);
    info.m_friction = scalar(desc.material.friction);
    info.m_linearDamping = scalar(1 - std::exp(-linear_damping(model_->scene.world)));
    if (desc.type == BodyType::kinematic_body) {
      driven_.push_back(std::make_unique<Driven>(desc, centre));
      info.m_motionState = driven_.back().get();
    }
    auto body = std::make_unique<btRigidBody>(info);
    body->setUserIndex(static_cast<int>(bodies_.size()));
    body->setLinearFactor({1, 1, 0});
    body->setAngularFactor({0, 0, scalar(desc.fixed_rotation ? 0 : 1)});
    if (moves) {
      body->setLinearVelocity(vector(desc.velocity));
      body->setAngularVelocity({0, 0, scalar(desc.angular_velocity)});
    }
    if (desc.type == BodyType::kinematic_body) {
      body->setCollisionFlags(body->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    }
    const bool awake = !setting_.sleeping || desc.type == BodyType::kinematic_body;
    if (awake && desc.type != BodyType::static_body) {
      body->setActivationState(DISABLE_DEACTIVATION);
    }
    world_.addRigidBody(body.get());
    if (moves) body->setGravity(scalar(desc.gravity_scale) * world_.getGravity());
    centres_.push_back(centre);
    bodies_.push_back(std::move(body));
  }

  void add(const SceneJoint& joint) {
    const auto anchor = [&](std::uint64_t body, Vec2 at) {
      return vector({at.x - centres_[body].x, at.y - centres_[body].y});
    };
    joints_.push_back(std::make_unique<btPoint2PointConstraint>(*bodies_[joint.a], *bodies_[joint.b],
                                                                anchor(joint.a, joint.joint.anchor_a),
                                                                anchor(joint.b, joint.joint.anchor_b)));
    world_.addConstraint(joints_.back().get(), !joint.joint.collide);
  }

  const Model* model_;
  Setting setting_;
  btDefaultCollisionConfiguration config_;
  btCollisionDispatcher dispatcher_;
  btVoronoiSimplexSolver simplex_;
  btMinkowskiPenetrationDepthSolver penetration_;
  btConvex2dConvex2dAlgorithm::CreateFunc meet_polygons_{&simplex_, &penetration_};
  btBox2dBox2dCollisionAlgorithm::CreateFunc meet_boxes_;
  CollideByFilters filters_;
  btDbvtBroadphase broad_phase_;
  btSequentialImpulseConstraintSolver solver_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<Driven>> driven_;
  std::vector<std::unique_ptr<btRigidBody>> walls_, bodies_;
  std::vector<std::unique_ptr<btTypedConstraint>> joints_;
  std::vector<Vec2> centres_;
  btDiscreteDynamicsWorld world_;  // ends first
};

}  // namespace

Engine bullet_engine() {
  const int version = btGetVersion();
  Engine engine;
  engine.name = "bullet";
  engine.version = std::to_string(version / 100) + '.' + std::to_string(version % 100);
  engine.refuses = [](const Model& model) {
    return refusal(model, {.rectangles = true,
                           .polygons = true,
                           .gravity_scale = true,
                           .restitution_threshold = true,
                           .always_groups = true});
  };
  engine.make = [](const Model& model, const Setting& setting) {
    return std::make_unique<BulletSimulation>(model, setting);
  };
  return engine;
}

}  // namespace psim::peers
