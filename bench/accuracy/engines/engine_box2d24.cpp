// Box2D 2.4. Set alike: no sleeping, no restitution threshold; mixing rules are psim's own already.
// Continuous collision stays on, as it is by default.
#include <box2d/box2d.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "engines/engine.h"
#include "engines/peer_bodies.h"

namespace psim::accuracy {
namespace {

b2Vec2 to_box2d(Vec2 v) { return {static_cast<float>(v.x), static_cast<float>(v.y)}; }

class Box2dSimulation : public Simulation {
 public:
  Box2dSimulation(const Model& model, const Setting& setting)
      : model_(&model), setting_(setting), world_(to_box2d(model.scene.world.gravity)) {
    world_.SetAllowSleeping(setting.sleeping);
    world_.SetContinuousPhysics(setting.continuous);
    if (model.scene.world.boundary == Boundary::walls) add_walls();
    for (const BodyDesc& body : model.bodies) bodies_.push_back(add(body));
    for (const SceneJoint& joint : model.scene.joints) add(joint);
  }

  void advance() override {
    for (int k = 0; k < setting_.steps; ++k) {
      if (!model_->scene.world.fields.empty()) apply_fields();
      world_.Step(static_cast<float>(setting_.h()), setting_.iterations, setting_.position_iterations);
      if (watched_) virial_ += step_virial();
    }
  }

  void read(std::vector<BodyState>& bodies) override {
    bodies.clear();
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
      const b2Body& b = *bodies_[k];
      const b2Vec2 x = b.GetPosition(), v = b.GetLinearVelocity();
      bodies.push_back({{static_cast<std::uint32_t>(k), 0},
                        x.x,
                        x.y,
                        b.GetAngle(),
                        v.x,
                        v.y,
                        b.GetAngularVelocity(),
                        radius_of(model_->bodies[k]),
                        model_->bodies[k].type});
    }
  }

  void set_velocity(std::size_t body, Vec2 velocity, double omega) override {
    bodies_[body]->SetLinearVelocity(to_box2d(velocity));
    bodies_[body]->SetAngularVelocity(static_cast<float>(omega));
  }

  // Warm start, velocity and position iterations.
  double row_visits() const override {
    int points = 0;
    for (const b2Contact* c = world_.GetContactList(); c; c = c->GetNext()) {
      if (c->IsTouching()) points += c->GetManifold()->pointCount;
    }
    return static_cast<double>(points + joint_rows(*model_)) * setting_.steps *
           (1 + setting_.iterations + setting_.position_iterations);
  }

  void watch_impulses() override { watched_ = true; }
  double virial() const override { return virial_; }

  std::vector<Load> loads() override {
    std::vector<Load> loads;
    for (b2Contact* c = world_.GetContactList(); c; c = c->GetNext()) {
      if (!c->IsTouching()) continue;
      const std::size_t a = id_of(*c->GetFixtureA()), b = id_of(*c->GetFixtureB());
      if (a >= bodies_.size() || b >= bodies_.size()) continue;
      double sum = 0;
      const b2Manifold& m = *c->GetManifold();
      for (int k = 0; k < m.pointCount; ++k) sum += static_cast<double>(m.points[k].normalImpulse);
      loads.push_back({std::min(a, b), std::max(a, b), sum / setting_.h()});
    }
    return loads;
  }

 private:
  static std::size_t id_of(const b2Fixture& fixture) {
    return static_cast<std::size_t>(const_cast<b2Fixture&>(fixture).GetBody()->GetUserData().pointer) - 1;
  }

  b2FixtureDef fixture(const b2Shape& shape, const Material& material, const Filter& filter = {}) const {
    b2FixtureDef def;
    def.filter.categoryBits = static_cast<uint16>(filter.category);
    def.filter.maskBits = static_cast<uint16>(filter.mask);
    def.filter.groupIndex = static_cast<int16>(filter.group);
    def.shape = &shape;
    def.density = static_cast<float>(material.density);
    def.restitution = static_cast<float>(material.restitution);
    def.friction = static_cast<float>(material.friction);
    def.restitutionThreshold = static_cast<float>(model_->scene.world.restitution_threshold);
    return def;
  }

  void add_walls() {
    const Bounds& b = model_->scene.world.bounds;
    const std::array<b2Vec2, 4> corners = {to_box2d({b.xmin, b.ymin}), to_box2d({b.xmax, b.ymin}),
                                           to_box2d({b.xmax, b.ymax}), to_box2d({b.xmin, b.ymax})};
    b2BodyDef def;
    b2Body* frame = world_.CreateBody(&def);
    for (std::size_t k = 0; k < 4; ++k) {
      b2EdgeShape edge;
      edge.SetTwoSided(corners[k], corners[(k + 1) % 4]);
      const b2FixtureDef side = fixture(edge, model_->scene.world.wall);
      frame->CreateFixture(&side);
    }
  }

  b2Body* add(const BodyDesc& desc) {
    constexpr std::array<b2BodyType, 3> kTypes = {b2_dynamicBody, b2_staticBody, b2_kinematicBody};
    b2BodyDef def;
    def.type = kTypes[static_cast<std::size_t>(desc.type)];
    def.position = to_box2d(desc.position);
    def.angle = static_cast<float>(desc.angle);
    def.linearVelocity = to_box2d(desc.velocity);
    def.angularVelocity = static_cast<float>(desc.angular_velocity);
    def.linearDamping = static_cast<float>(linear_damping(model_->scene.world));
    def.gravityScale = static_cast<float>(desc.gravity_scale);
    def.fixedRotation = desc.fixed_rotation;
    def.bullet = desc.bullet;
    def.userData.pointer = bodies_.size() + 1;
    b2Body* body = world_.CreateBody(&def);
    if (const auto* line = std::get_if<SegmentShape>(&desc.shape)) {
      b2EdgeShape edge;
      edge.SetTwoSided(to_box2d(line->p1), to_box2d(line->p2));
      const b2FixtureDef f = fixture(edge, desc.material, desc.filter);
      body->CreateFixture(&f);
    } else if (const auto* chain = std::get_if<ChainShape>(&desc.shape)) {
      add_chain(*chain, desc, *body);
    } else if (const auto* shape = std::get_if<PolygonShape>(&desc.shape)) {
      b2PolygonShape polygon;
      const auto corners = inset(*shape, skin());
      polygon.Set(corners.data(), static_cast<int32>(corners.size()));
      add_polygon(polygon, desc, *body);
    } else if (const auto* sides = std::get_if<BoxShape>(&desc.shape)) {
      b2PolygonShape polygon;
      polygon.SetAsBox(0.5f * static_cast<float>(sides->width) - skin(),
                       0.5f * static_cast<float>(sides->height) - skin());
      add_polygon(polygon, desc, *body);
    } else {
      const double r = radius_of(desc);
      b2CircleShape circle;
      circle.m_radius = static_cast<float>(r);
      b2FixtureDef f = fixture(circle, desc.material, desc.filter);
      f.density = static_cast<float>(mass_of(desc) / (std::numbers::pi * r * r));
      body->CreateFixture(&f);
    }
    return body;
  }

  // A polygon has a skin of 1 cm around it: what is seen, skin included, is the scene's shape.
  float skin() const { return setting_.bare ? 0 : b2_polygonRadius; }

  static std::vector<b2Vec2> inset(const PolygonShape& polygon, double skin) {
    std::vector<b2Vec2> corners;
    const auto& v = polygon.vertices;
    const auto direction = [](Vec2 p, Vec2 q) {
      const double length = std::hypot(q.x - p.x, q.y - p.y);
      return Vec2{(q.x - p.x) / length, (q.y - p.y) / length};
    };
    for (std::size_t k = 0; k < v.size(); ++k) {
      const Vec2 in = direction(v[(k + v.size() - 1) % v.size()], v[k]);
      const Vec2 out = direction(v[k], v[(k + 1) % v.size()]);
      const double reach = skin / (in.x * out.y - in.y * out.x);
      corners.push_back(to_box2d({v[k].x + reach * (out.x - in.x), v[k].y + reach * (out.y - in.y)}));
    }
    return corners;
  }

  // It is solid from one side: once each way, from both.
  void add_chain(const ChainShape& chain, const BodyDesc& desc, b2Body& body) const {
    std::vector<b2Vec2> points;
    for (const Vec2 v : with_neighbours(chain)) points.push_back(to_box2d(v));
    for (int way = 0; way < 2; ++way) {
      b2ChainShape shape;
      shape.CreateChain(&points[1], static_cast<int32>(points.size() - 2), points.front(), points.back());
      const b2FixtureDef f = fixture(shape, desc.material, desc.filter);
      body.CreateFixture(&f);
      std::ranges::reverse(points);
    }
  }

  void add_polygon(b2PolygonShape& polygon, const BodyDesc& desc, b2Body& body) const {
    polygon.m_radius = skin();
    const b2FixtureDef f = fixture(polygon, desc.material, desc.filter);
    body.CreateFixture(&f);
    b2MassData mass;
    mass.mass = static_cast<float>(mass_of(desc));
    mass.center = to_box2d(centre_of(desc));
    mass.I = static_cast<float>(inertia_of(desc)) + mass.mass * b2Dot(mass.center, mass.center);
    body.SetMassData(&mass);
  }

  template <class Def>
  void create(Def& def, const SceneJoint& scene_joint) {
    def.bodyA = bodies_[scene_joint.a];
    def.bodyB = bodies_[scene_joint.b];
    def.localAnchorA = to_box2d(scene_joint.joint.anchor_a);
    def.localAnchorB = to_box2d(scene_joint.joint.anchor_b);
    def.referenceAngle = static_cast<float>(reference_of(*model_, scene_joint));
    def.collideConnected = scene_joint.joint.collide;
    world_.CreateJoint(&def);
  }

  void add(const SceneJoint& scene_joint) {
    const JointDesc& joint = scene_joint.joint;
    b2Body *a = bodies_[scene_joint.a], *b = bodies_[scene_joint.b];
    if (joint.type == JointType::revolute) {
      b2RevoluteJointDef pin;
      pin.bodyA = a;
      pin.bodyB = b;
      pin.localAnchorA = to_box2d(joint.anchor_a);
      pin.localAnchorB = to_box2d(joint.anchor_b);
      pin.collideConnected = joint.collide;
      pin.enableMotor = joint.motor_limit != 0;
      pin.maxMotorTorque = static_cast<float>(joint.motor_limit);
      pin.motorSpeed = static_cast<float>(joint.motor_speed);
      world_.CreateJoint(&pin);
      return;
    }
    if (joint.type == JointType::weld) {
      b2WeldJointDef weld;
      weld.stiffness = static_cast<float>(joint.stiffness);
      weld.damping = static_cast<float>(joint.damping);
      return create(weld, scene_joint);
    }
    if (joint.type == JointType::prismatic) {
      b2PrismaticJointDef slide;
      slide.localAxisA = to_box2d(joint.axis);
      return create(slide, scene_joint);
    }
    b2DistanceJointDef rod;
    rod.bodyA = a;
    rod.bodyB = b;
    rod.localAnchorA = to_box2d(joint.anchor_a);
    rod.localAnchorB = to_box2d(joint.anchor_b);
    rod.collideConnected = joint.collide;
    rod.length = static_cast<float>(length_of(*model_, scene_joint));
    if (joint.type == JointType::rope) {
      rod.minLength = 0;
      rod.maxLength = rod.length;
    } else if (joint.type == JointType::spring) {
      rod.stiffness = static_cast<float>(joint.stiffness);
      rod.damping = static_cast<float>(joint.damping);
    } else {
      rod.minLength = rod.maxLength = rod.length;
    }
    world_.CreateJoint(&rod);
  }

  void apply_fields() {
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
      b2Body& b = *bodies_[k];
      if (b.GetType() != b2_dynamicBody) continue;
      const b2Vec2 x = b.GetPosition(), v = b.GetLinearVelocity();
      const Vec2 a = field_acceleration(model_->scene.world, {x.x, x.y}, {v.x, v.y});
      b.ApplyForceToCenter(b.GetMass() * to_box2d(a), true);
    }
  }

  double step_virial() const {
    double sum = 0;
    for (const b2Contact* c = world_.GetContactList(); c; c = c->GetNext()) {
      const bool discs =
          c->GetFixtureA()->GetType() == b2Shape::e_circle && c->GetFixtureB()->GetType() == b2Shape::e_circle;
      if (!discs || c->GetManifold()->pointCount == 0) continue;
      const b2Vec2 between = c->GetFixtureB()->GetBody()->GetPosition() - c->GetFixtureA()->GetBody()->GetPosition();
      sum += static_cast<double>(c->GetManifold()->points[0].normalImpulse * between.Length());
    }
    return sum;
  }

  const Model* model_;
  Setting setting_;
  b2World world_;
  std::vector<b2Body*> bodies_;  // owned by the world
  bool watched_ = false;
  double virial_ = 0;
};

// Nothing is left of them inside of the skin.
bool is_thin(const BodyDesc& body) {
  const auto* sides = std::get_if<BoxShape>(&body.shape);
  return sides && std::min(sides->width, sides->height) < 2.5 * b2_polygonRadius;
}

Setting setting_of(int velocity_iterations, int steps) {
  Setting s;
  s.steps = steps;
  s.iterations = velocity_iterations;
  s.position_iterations = std::max(1, (3 * velocity_iterations + 4) / 8);
  s.curve = "positions-" + std::to_string(s.position_iterations);
  s.is_default = velocity_iterations == 8 && steps == 1;
  return s;
}

std::vector<Setting> box2d_settings(Effort effort, Scale scale) {
  std::vector<Setting> settings;
  if (effort == Effort::quick) return {setting_of(8, 1), setting_of(8, 4)};
  for (const int steps : {1, 4, 16}) {
    Setting s = setting_of(8, steps);
    s.bare = true;
    s.curve += " bare";
    s.is_default = false;
    settings.push_back(s);
  }
  for (const int iterations : {1, 2, 4, 8, 16}) {
    for (const int steps : {1, 2, 4, 8, 16, 32, 64}) {
      const bool sparse = steps > 16 || (iterations != 8 && steps != 1 && steps != 4);
      if (scale == Scale::small || !sparse) settings.push_back(setting_of(iterations, steps));
    }
  }
  return settings;
}

}  // namespace

Engine box2d24_engine() {
  Engine engine;
  engine.name = "box2d";
  engine.version = std::to_string(b2_version.major) + '.' + std::to_string(b2_version.minor) + '.' +
                   std::to_string(b2_version.revision);
  engine.refuses = [](const Model& model) {
    if (std::ranges::any_of(model.bodies, is_thin)) return std::string("box thinner than its skin");
    return refusal(model, {.fields = true,
                           .segments = true,
                           .polygons = true,
                           .chains = true,
                           .gravity_scale = true,
                           .bullets = true,
                           .restitution_threshold = true,
                           .always_groups = true,
                           .categories = 0xFFFF,
                           .rods = true,
                           .springs = true,
                           .ropes = true,
                           .welds = true,
                           .slides = true,
                           .motors = true});
  };
  engine.make = [](const Model& model, const Setting& setting) {
    return std::make_unique<Box2dSimulation>(model, setting);
  };
  engine.settings = box2d_settings;
  return engine;
}

}  // namespace psim::accuracy
