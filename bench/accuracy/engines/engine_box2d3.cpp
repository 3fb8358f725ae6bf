// Box2D 3. Set alike: no sleeping, no restitution threshold; mixing rules are psim's own already.
// Continuous collision and one worker as by default; it divides a step into substeps itself.
#include <box2d/box2d.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include "engines/engine.h"
#include "engines/peer_bodies.h"

namespace psim::accuracy {
namespace {

constexpr int kDefaultSubsteps = 4;

b2Vec2 to_box2d(Vec2 v) { return {static_cast<float>(v.x), static_cast<float>(v.y)}; }

class Box2d3Simulation : public Simulation {
 public:
  Box2d3Simulation(const Model& model, const Setting& setting) : model_(&model), setting_(setting) {
    b2WorldDef def = b2DefaultWorldDef();
    def.gravity = to_box2d(model.scene.world.gravity);
    def.restitutionThreshold = static_cast<float>(model.scene.world.restitution_threshold);
    def.enableSleep = setting.sleeping;
    def.enableContinuous = setting.continuous;
    world_ = b2CreateWorld(&def);
    if (model.scene.world.boundary == Boundary::walls) add_walls();
    for (const BodyDesc& body : model.bodies) add(body);
    for (const SceneJoint& joint : model.scene.joints) add(joint);
  }
  ~Box2d3Simulation() override { b2DestroyWorld(world_); }
  Box2d3Simulation(const Box2d3Simulation&) = delete;
  Box2d3Simulation& operator=(const Box2d3Simulation&) = delete;

  void advance() override {
    for (int k = 0; k < setting_.steps; ++k) {
      if (!model_->scene.world.fields.empty()) apply_fields();
      b2World_Step(world_, static_cast<float>(setting_.frame / setting_.steps), setting_.substeps);
      if (turns_) follow_angles();
      if (watched_) virial_ += contacts().virial;
    }
  }

  void read(std::vector<BodyState>& bodies) override {
    bodies.clear();
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
      const b2Vec2 x = b2Body_GetPosition(bodies_[k]), v = b2Body_GetLinearVelocity(bodies_[k]);
      bodies.push_back({{static_cast<std::uint32_t>(k), 0},
                        x.x,
                        x.y,
                        turns_ ? angles_[k] : angle_of(k),
                        v.x,
                        v.y,
                        b2Body_GetAngularVelocity(bodies_[k]),
                        radius_of(model_->bodies[k]),
                        model_->bodies[k].type});
    }
  }

  void set_velocity(std::size_t body, Vec2 velocity, double omega) override {
    b2Body_SetLinearVelocity(bodies_[body], to_box2d(velocity));
    b2Body_SetAngularVelocity(bodies_[body], static_cast<float>(omega));
  }

  // Warm start, solve and relax every substep, restitution once a step.
  double row_visits() const override {
    return (contacts().points * (3 * setting_.substeps + 1) + joint_rows(*model_) * 3 * setting_.substeps) *
           setting_.steps;
  }

  void watch_impulses() override { watched_ = true; }
  double virial() const override { return virial_; }

  // The impulse of the last substep stands for all: load that lasts.
  std::vector<Load> loads() override {
    std::vector<Load> loads;
    std::vector<b2ContactData> touching;
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
      if (b2Body_GetType(bodies_[k]) != b2_dynamicBody) continue;
      touching.resize(static_cast<std::size_t>(b2Body_GetContactCapacity(bodies_[k])));
      const int n = b2Body_GetContactData(bodies_[k], touching.data(), static_cast<int>(touching.size()));
      for (int i = 0; i < n; ++i) append_load(k, touching[static_cast<std::size_t>(i)], loads);
    }
    return loads;
  }

 private:
  std::size_t id_of(b2ShapeId shape) const {
    return static_cast<std::size_t>(reinterpret_cast<std::uintptr_t>(b2Body_GetUserData(b2Shape_GetBody(shape)))) - 1;
  }

  /// Of two dynamic bodies the one with the lower id reports.
  void append_load(std::size_t from, const b2ContactData& contact, std::vector<Load>& loads) const {
    const std::size_t p = id_of(contact.shapeIdA), q = id_of(contact.shapeIdB);
    if (p >= bodies_.size() || q >= bodies_.size()) return;
    const std::size_t a = std::min(p, q), b = std::max(p, q);
    if (from == b && b2Body_GetType(bodies_[a]) == b2_dynamicBody) return;
    double sum = 0;
    const b2Manifold& m = contact.manifold;
    for (int k = 0; k < m.pointCount; ++k) sum += static_cast<double>(m.points[k].normalImpulse);
    loads.push_back({a, b, sum / setting_.h()});
  }

  struct Contacts {
    double points = 0;
    double virial = 0;
  };

  // Asked of each dynamic body: what it shares with another dynamic one comes twice.
  Contacts contacts() const {
    Contacts sum;
    std::vector<b2ContactData> touching;
    for (const b2BodyId body : bodies_) {
      if (b2Body_GetType(body) != b2_dynamicBody) continue;
      touching.resize(static_cast<std::size_t>(b2Body_GetContactCapacity(body)));
      const int n = b2Body_GetContactData(body, touching.data(), static_cast<int>(touching.size()));
      for (int k = 0; k < n; ++k) add_contact(touching[static_cast<std::size_t>(k)], sum);
    }
    return sum;
  }

  // The impulse of the last substep stands for all: load that lasts.
  void add_contact(const b2ContactData& contact, Contacts& sum) const {
    const b2BodyId a = b2Shape_GetBody(contact.shapeIdA), b = b2Shape_GetBody(contact.shapeIdB);
    const bool both = b2Body_GetType(a) == b2_dynamicBody && b2Body_GetType(b) == b2_dynamicBody;
    const double share = both ? 0.5 : 1;
    sum.points += share * contact.manifold.pointCount;
    const bool discs =
        b2Shape_GetType(contact.shapeIdA) == b2_circleShape && b2Shape_GetType(contact.shapeIdB) == b2_circleShape;
    if (!discs || contact.manifold.pointCount == 0) return;
    const double distance = b2Distance(b2Body_GetPosition(a), b2Body_GetPosition(b));
    sum.virial += share * setting_.substeps * distance * contact.manifold.points[0].normalImpulse;
  }

  static b2ShapeDef shape(const Material& material) {
    b2ShapeDef def = b2DefaultShapeDef();
    def.density = static_cast<float>(material.density);
    def.material.restitution = static_cast<float>(material.restitution);
    def.material.friction = static_cast<float>(material.friction);
    return def;
  }

  void add_walls() {
    const Bounds& b = model_->scene.world.bounds;
    const std::array<b2Vec2, 4> corners = {to_box2d({b.xmin, b.ymin}), to_box2d({b.xmax, b.ymin}),
                                           to_box2d({b.xmax, b.ymax}), to_box2d({b.xmin, b.ymax})};
    const b2BodyDef def = b2DefaultBodyDef();
    const b2BodyId frame = b2CreateBody(world_, &def);
    const b2ShapeDef side = shape(model_->scene.world.wall);
    for (std::size_t k = 0; k < 4; ++k) {
      const b2Segment edge{corners[k], corners[(k + 1) % 4]};
      b2CreateSegmentShape(frame, &side, &edge);
    }
  }

  void add(const BodyDesc& desc) {
    constexpr std::array<b2BodyType, 3> kTypes = {b2_dynamicBody, b2_staticBody, b2_kinematicBody};
    b2BodyDef def = b2DefaultBodyDef();
    def.type = kTypes[static_cast<std::size_t>(desc.type)];
    def.position = to_box2d(desc.position);
    def.rotation = {static_cast<float>(std::cos(desc.angle)), static_cast<float>(std::sin(desc.angle))};
    def.linearVelocity = to_box2d(desc.velocity);
    def.angularVelocity = static_cast<float>(desc.angular_velocity);
    def.linearDamping = static_cast<float>(linear_damping(model_->scene.world));
    def.gravityScale = static_cast<float>(desc.gravity_scale);
    def.fixedRotation = desc.fixed_rotation;
    def.isBullet = desc.bullet;
    def.allowFastRotation = true;
    def.userData = reinterpret_cast<void*>(static_cast<std::uintptr_t>(bodies_.size() + 1));
    const b2BodyId body = b2CreateBody(world_, &def);
    bodies_.push_back(body);
    angles_.push_back(desc.angle);
    turns_ = turns_ || desc.angular_velocity != 0 || !model_->scene.joints.empty();
    b2ShapeDef surface = shape(desc.material);
    surface.filter.categoryBits = desc.filter.category;
    surface.filter.maskBits = desc.filter.mask;
    surface.filter.groupIndex = desc.filter.group;
    if (const auto* line = std::get_if<SegmentShape>(&desc.shape)) {
      const b2Segment edge{to_box2d(line->p1), to_box2d(line->p2)};
      b2CreateSegmentShape(body, &surface, &edge);
    } else if (const auto* chain = std::get_if<ChainShape>(&desc.shape)) {
      add_chain(*chain, surface, body);
    } else if (const auto* outline = std::get_if<PolygonShape>(&desc.shape)) {
      surface.density = static_cast<float>(mass_of(desc) / area_of(desc));
      std::vector<b2Vec2> corners;
      for (const Vec2 v : outline->vertices) corners.push_back(to_box2d(v));
      const b2Hull hull = b2ComputeHull(corners.data(), static_cast<int>(corners.size()));
      const b2Polygon polygon = b2MakePolygon(&hull, 0);
      b2CreatePolygonShape(body, &surface, &polygon);
    } else if (const auto* sides = std::get_if<BoxShape>(&desc.shape)) {
      surface.density = static_cast<float>(mass_of(desc) / area_of(desc));
      const b2Polygon polygon =
          b2MakeBox(0.5f * static_cast<float>(sides->width), 0.5f * static_cast<float>(sides->height));
      b2CreatePolygonShape(body, &surface, &polygon);
    } else {
      const double r = radius_of(desc);
      surface.density = static_cast<float>(mass_of(desc) / (std::numbers::pi * r * r));
      const b2Circle circle{{0, 0}, static_cast<float>(r)};
      b2CreateCircleShape(body, &surface, &circle);
    }
  }

  // It is solid from one side: once each way, from both.
  static void add_chain(const ChainShape& chain, const b2ShapeDef& surface, b2BodyId body) {
    std::vector<b2Vec2> points;
    for (const Vec2 v : with_neighbours(chain)) points.push_back(to_box2d(v));
    for (int way = 0; way < 2; ++way) {
      b2ChainDef def = b2DefaultChainDef();
      def.points = points.data();
      def.count = static_cast<int>(points.size());
      def.materials = &surface.material;
      def.materialCount = 1;
      def.filter = surface.filter;
      b2CreateChain(body, &def);
      std::ranges::reverse(points);
    }
  }

  template <class Def>
  Def tie(Def def, const SceneJoint& scene_joint) const {
    def.bodyIdA = bodies_[scene_joint.a];
    def.bodyIdB = bodies_[scene_joint.b];
    def.localAnchorA = to_box2d(scene_joint.joint.anchor_a);
    def.localAnchorB = to_box2d(scene_joint.joint.anchor_b);
    def.referenceAngle = static_cast<float>(reference_of(*model_, scene_joint));
    def.collideConnected = scene_joint.joint.collide;
    return def;
  }

  // It wants a frequency and a damping ratio.
  void add_weld(const SceneJoint& scene_joint) {
    const JointDesc& joint = scene_joint.joint;
    b2WeldJointDef weld = tie(b2DefaultWeldJointDef(), scene_joint);
    if (joint.stiffness > 0) {
      const double reduced = 1 / (inverse_inertia(scene_joint.a) + inverse_inertia(scene_joint.b));
      const double omega = std::sqrt(joint.stiffness / reduced);
      weld.angularHertz = static_cast<float>(omega / (2 * std::numbers::pi));
      weld.angularDampingRatio = static_cast<float>(joint.damping / (2 * reduced * omega));
    }
    b2CreateWeldJoint(world_, &weld);
  }

  void add(const SceneJoint& scene_joint) {
    const JointDesc& joint = scene_joint.joint;
    const b2BodyId a = bodies_[scene_joint.a], b = bodies_[scene_joint.b];
    if (joint.type == JointType::revolute) {
      b2RevoluteJointDef pin = b2DefaultRevoluteJointDef();
      pin.bodyIdA = a;
      pin.bodyIdB = b;
      pin.localAnchorA = to_box2d(joint.anchor_a);
      pin.localAnchorB = to_box2d(joint.anchor_b);
      pin.collideConnected = joint.collide;
      pin.enableMotor = joint.motor_limit != 0;
      pin.maxMotorTorque = static_cast<float>(joint.motor_limit);
      pin.motorSpeed = static_cast<float>(joint.motor_speed);
      b2CreateRevoluteJoint(world_, &pin);
      return;
    }
    if (joint.type == JointType::weld) return add_weld(scene_joint);
    if (joint.type == JointType::prismatic) {
      b2PrismaticJointDef slide = tie(b2DefaultPrismaticJointDef(), scene_joint);
      slide.localAxisA = to_box2d(joint.axis);
      b2CreatePrismaticJoint(world_, &slide);
      return;
    }
    b2DistanceJointDef rod = b2DefaultDistanceJointDef();
    rod.bodyIdA = a;
    rod.bodyIdB = b;
    rod.localAnchorA = to_box2d(joint.anchor_a);
    rod.localAnchorB = to_box2d(joint.anchor_b);
    rod.collideConnected = joint.collide;
    rod.length = static_cast<float>(length_of(*model_, scene_joint));
    if (joint.type == JointType::rope) {
      rod.enableSpring = true;  // of no stiffness: only the limit acts
      rod.enableLimit = true;
      rod.minLength = 0;
      rod.maxLength = rod.length;
    } else if (joint.type == JointType::spring) {
      // It wants a frequency and a damping ratio; anchors are at the centres.
      const double reduced = 1 / (inverse_mass(scene_joint.a) + inverse_mass(scene_joint.b));
      const double omega = std::sqrt(joint.stiffness / reduced);
      rod.enableSpring = true;
      rod.hertz = static_cast<float>(omega / (2 * std::numbers::pi));
      rod.dampingRatio = static_cast<float>(joint.damping / (2 * reduced * omega));
    }
    b2CreateDistanceJoint(world_, &rod);
  }

  double inverse_mass(std::size_t body) const {
    const BodyDesc& desc = model_->bodies[body];
    return desc.type == BodyType::dynamic_body ? 1 / mass_of(desc) : 0;
  }

  double inverse_inertia(std::size_t body) const {
    const BodyDesc& desc = model_->bodies[body];
    return desc.type == BodyType::dynamic_body && !desc.fixed_rotation ? 1 / inertia_of(desc) : 0;
  }

  void apply_fields() {
    for (const b2BodyId body : bodies_) {
      if (b2Body_GetType(body) != b2_dynamicBody) continue;
      const b2Vec2 x = b2Body_GetPosition(body), v = b2Body_GetLinearVelocity(body);
      const Vec2 a = field_acceleration(model_->scene.world, {x.x, x.y}, {v.x, v.y});
      b2Body_ApplyForceToCenter(body, b2MulSV(b2Body_GetMass(body), to_box2d(a)), true);
    }
  }

  double angle_of(std::size_t k) const {
    const b2Rot q = b2Body_GetRotation(bodies_[k]);  // exactly: b2MakeRot and b2Rot_GetAngle approximate
    return std::atan2(static_cast<double>(q.s), static_cast<double>(q.c));
  }

  // It keeps a direction, not an angle; within a step nothing turns by half a circle.
  void follow_angles() {
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
      angles_[k] += std::remainder(angle_of(k) - angles_[k], 2 * std::numbers::pi);
    }
  }

  const Model* model_;
  Setting setting_;
  b2WorldId world_{};
  std::vector<b2BodyId> bodies_;
  std::vector<double> angles_;
  bool turns_ = false;
  bool watched_ = false;
  double virial_ = 0;
};

// Its stiffness follows from the mass that the anchors feel, which changes as bodies turn.
bool is_off_centre(const SceneJoint& scene_joint) {
  const JointDesc& joint = scene_joint.joint;
  const bool at_centres =
      joint.anchor_a.x == 0 && joint.anchor_a.y == 0 && joint.anchor_b.x == 0 && joint.anchor_b.y == 0;
  return joint.type == JointType::spring && !at_centres;
}

Setting setting_of(const char* curve, int steps, int substeps) {
  Setting s;
  s.curve = curve;
  s.steps = steps;
  s.substeps = substeps;
  s.is_default = steps == 1 && substeps == kDefaultSubsteps;
  return s;
}

// Forces from outside act once a step: where they change, steps are what counts, not substeps.
std::vector<Setting> box2d3_settings(Effort effort, Scale scale) {
  if (effort == Effort::quick) {
    return {setting_of("soft", 1, 1), setting_of("soft", 1, kDefaultSubsteps), setting_of("soft", 1, 8),
            setting_of("soft short-frames-1", 4, 1)};
  }
  const bool small = scale == Scale::small;
  std::vector<Setting> settings;
  for (const int divisions : {1, 2, 4, 8, 16, 32, 64}) {
    if (!small && divisions > 32) break;
    settings.push_back(setting_of("soft", 1, divisions));
    if (divisions > 1 && (small || divisions <= 16)) {
      settings.push_back(setting_of("soft short-frames-1", divisions, 1));
    }
  }
  for (const int steps : {2, 4, 8, 16}) {
    if (small || steps <= 4) {
      settings.push_back(setting_of("soft short-frames-4", steps, kDefaultSubsteps));
    }
  }
  return settings;
}

}  // namespace

Engine box2d3_engine() {
  const b2Version version = b2GetVersion();
  Engine engine;
  engine.name = "box2d3";
  engine.version =
      std::to_string(version.major) + '.' + std::to_string(version.minor) + '.' + std::to_string(version.revision);
  engine.refuses = [](const Model& model) {
    if (std::ranges::any_of(model.scene.joints, is_off_centre)) return std::string("spring off the centre");
    return refusal(model, {.fields = true,
                           .segments = true,
                           .polygons = true,
                           .chains = true,
                           .gravity_scale = true,
                           .bullets = true,
                           .restitution_threshold = true,
                           .always_groups = true,
                           .rods = true,
                           .springs = true,
                           .ropes = true,
                           .welds = true,
                           .slides = true,
                           .motors = true});
  };
  engine.make = [](const Model& model, const Setting& setting) {
    return std::make_unique<Box2d3Simulation>(model, setting);
  };
  engine.settings = box2d3_settings;
  return engine;
}

}  // namespace psim::accuracy
