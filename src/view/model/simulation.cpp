// The world's life: making, remaking, stepping, and what the view is told. What hands do to it is
// in simulation_tools.cpp.
#include "model/simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <string_view>
#include <utility>

#include "builtin/samples.h"
#include "options/scene_choice.h"
#include "output/text.h"
#include "output/user_error.h"
#include "place/links.h"

namespace psim::view {
namespace {

// A hash costs about 20 ns a body: in every frame of a small world, now and then in a large one.
constexpr std::uint64_t kHashEveryFrame = 20'000;
constexpr std::uint64_t kHashFrames = 30;

void override_materials(Scene& scene, std::optional<double> Settings::*which, double Material::*target,
                        const Settings& settings) {
  const std::optional<double>& value = settings.*which;
  if (!value) return;
  scene.world.wall.*target = *value;
  for (BodyDesc& body : scene.bodies) body.material.*target = *value;
  for (GroupDesc& group : scene.groups) group.body.material.*target = *value;
}

// What to look for in a scene, or what it is where nobody says.
std::string about(const Scene& scene) {
  const std::string_view line = look_for(scene.name);
  return line.empty() ? scene.description : std::string(line);
}

}  // namespace

Simulation::Simulation(Scene scene, Isa isa, int threads) : scene_(std::make_shared<const Scene>(std::move(scene))) {
  settings_.isa = isa;
  settings_.threads = threads;
  settings_.gravity = scene_->world.gravity;
  settings_.substeps = scene_->world.substeps;
  settings_.skin = scene_->world.skin;
  ++scene_serial_;
  message_ = about(*scene_);
  make(false);
}

Scene Simulation::configured() const {
  Scene scene = *scene_;
  scene.world.gravity = settings_.gravity;
  scene.world.substeps = settings_.substeps;
  scene.world.skin = settings_.skin;
  override_materials(scene, &Settings::restitution, &Material::restitution, settings_);
  override_materials(scene, &Settings::friction, &Material::friction, settings_);
  return scene;
}

void Simulation::make(bool keep_state) {
  Scene scene = configured();
  if (keep_state && world_) {
    scene.world.fields = world_->desc().fields;
    if (const FluidPlaces fluids = take_fluids(*world_, scene)) carry_fluids(*fluids, scene);
  }
  cli::check_memory(scene);
  if (world_) let_go();
  std::shared_ptr<World> fresh = cli::make_world(scene, settings_.isa, settings_.threads);
  auto looks = std::make_shared<Catalogue>(scene);
  if (keep_state && world_) {
    carry_over(*world_, *fresh, *looks);
    frames_before_ += world_->frame();
  } else {
    added_.clear();
    reports_.clear();
    frames_before_ = 0;
    ++run_serial_;
  }
  hash_frame_ = fluids_frame_ = kNoFrame;
  hits_.clear();
  world_ = std::move(fresh);
  catalogue_ = std::move(looks);
  told_catalogue_.reset();
  std::vector<JointLook> joints;
  for (const DrawnJoint& j : drawn_joints(scene)) {
    joints.push_back({static_cast<std::uint32_t>(j.a), static_cast<std::uint32_t>(j.b), j.joint.anchor_a,
                      j.joint.anchor_b, j.joint.type, j.number});
  }
  joints_ = std::make_shared<const std::vector<JointLook>>(std::move(joints));
  note_wells();
  world_->enable_snapshots(true);
  set_collect(collect_);
  world_->prepare();
  ++world_serial_;
  changed_ = true;
}

// Bodies of the scene keep their ids; those placed by hand may get others.
void Simulation::carry_over(World& old, World& fresh, Catalogue& looks) {
  std::vector<bool> by_hand(scene_->body_count());
  for (Added& one : added_) {
    const std::optional<BodyState> now = old.body(one.id);
    if (!now) continue;
    if (one.id.index < by_hand.size()) by_hand[one.id.index] = true;
    one.desc.position = {now->x, now->y};
    one.desc.angle = now->angle;
    one.desc.velocity = {now->vx, now->vy};
    one.desc.angular_velocity = now->omega;
    if (settings_.restitution) one.desc.material.restitution = *settings_.restitution;
    if (settings_.friction) one.desc.material.friction = *settings_.friction;
    std::string error;
    one.id = fresh.add_body(one.desc, error);
    if (one.id != kNoBody) looks.set(one.id.index, one.desc, one.desc.type);
  }
  std::erase_if(added_, [&](const Added& one) { return !fresh.is_valid(one.id); });

  const PublishedState state = old.published();
  std::vector<bool> alive(by_hand.size());
  for (std::size_t row = 0; row < state.id.size(); ++row) {
    const std::uint32_t id = state.id[row];
    if (id >= alive.size() || by_hand[id]) continue;
    alive[id] = true;
    if (state.type[row] == BodyType::static_body) continue;
    const BodyId body = fresh.id_of(id);
    fresh.set_transform(body, {state.x[row], state.y[row]}, state.angle[row]);
    fresh.set_velocity(body, {state.vx[row], state.vy[row]}, state.omega[row]);
  }
  for (std::uint32_t id = 0; id < alive.size(); ++id) {
    if (!alive[id]) fresh.remove_body(fresh.id_of(id));
  }
}

void Simulation::load(const std::string& name) {
  cli::Options options;
  options.scene = name;
  try {
    auto scene = std::make_shared<const Scene>(cli::choose_scene(options));
    const auto before = std::exchange(scene_, scene);
    const Settings settings = settings_;
    settings_.gravity = scene_->world.gravity;
    settings_.substeps = scene_->world.substeps;
    settings_.skin = scene_->world.skin;
    settings_.restitution.reset();
    settings_.friction.reset();
    try {
      make(false);
    } catch (...) {
      scene_ = before;
      settings_ = settings;
      throw;
    }
    ++scene_serial_;
    message_ = about(*scene_);
  } catch (const cli::UserError& error) {
    message_ = error.what();
  }
}

void Simulation::restart() {
  make(false);
  message_ = "restarted";
}

void Simulation::single_step() {
  paused = true;
  ++steps_left_;
}

void Simulation::set_gravity(Vec2 gravity) {
  if (world_->set_gravity(gravity)) settings_.gravity = gravity;
}

void Simulation::set_skin(double factor) {
  if (world_->set_skin(factor)) settings_.skin = factor;
}

void Simulation::set_settings(const Settings& settings) {
  const Settings before = std::exchange(settings_, settings);
  try {
    make(true);
    message_ = fmt::format("new world from the present state: {}, {} thread{}, {} substeps", isa_name(world_->isa()),
                           world_->threads(), world_->threads() == 1 ? "" : "s", world_->desc().substeps);
  } catch (const cli::UserError& error) {
    settings_ = before;
    message_ = error.what();
  }
}

void Simulation::set_collect(const Collect& collect) {
  collect_ = collect;
  hits_.clear();
  constexpr double kHitSpeed = 0.5;
  world_->set_event_options({.hits = collect.hits, .hit_speed = kHitSpeed});
}

void Simulation::step() {
  if (grab_) lead();
  reports_.push_back(world_->step());
  if (steps_left_ > 0) --steps_left_;
  changed_ = false;
  const Events events = world_->events();
  if (!events.breaks.empty()) forget_broken_joints(events.breaks);
  if (!collect_.hits) return;
  hits_.assign(events.hits.begin(), events.hits.end());
}

std::shared_ptr<const TouchLists> Simulation::take_touches() {
  auto touches = std::make_shared<TouchLists>();
  touches->hits = hits_;
  if (collect_.contacts || collect_.forces || collect_.colours) take_contacts(*touches);
  if (!collect_.strips) return touches;
  for (const std::uint32_t strip : world_->strips()) {
    touches->groups.push_back(strip == kNoStrip ? kNoGroup : static_cast<float>(strip));
  }
  return touches;
}

void Simulation::take_contacts(TouchLists& touches) {
  const auto at = [](std::vector<float>& by_id, BodyId id, float none) -> float& {
    if (by_id.size() <= id.index) by_id.resize(std::size_t{id.index} + 1, none);
    return by_id[id.index];
  };
  const std::span<const Contact> contacts = world_->contacts();
  if (collect_.contacts) touches.contacts.reserve(contacts.size());
  for (const Contact& c : contacts) {
    const auto force = static_cast<float>(c.impulse / world_->desc().dt);
    if (collect_.contacts) {
      touches.contacts.push_back({c.a.index, c.b.index, c.point, static_cast<float>(c.normal.x),
                                  static_cast<float>(c.normal.y), force, c.colour});
    }
    for (const BodyId id : {c.a, c.b}) {
      if (id == kNoBody) continue;
      if (collect_.forces) at(touches.forces, id, 0) += force;
      if (!collect_.colours || c.colour == kNoColour) continue;
      float& most = at(touches.groups, id, kNoGroup);
      most = std::max(most, static_cast<float>(c.colour));
    }
  }
}

std::shared_ptr<const Snapshot> Simulation::take_still() const {
  auto still = std::make_shared<Snapshot>();
  const PublishedState state = world_->published();
  const Bounds& b = world_->desc().bounds;
  still->frame = world_->frame();
  still->origin = {(b.xmin + b.xmax) / 2, (b.ymin + b.ymax) / 2};
  still->id.assign(state.id.begin(), state.id.end());
  const auto from = [](std::span<const double> column, double origin) {
    std::vector<float> floats(column.size());
    std::ranges::transform(column, floats.begin(), [origin](double v) { return static_cast<float>(v - origin); });
    return floats;
  };
  still->x_prev = still->x = from(state.x, still->origin.x);
  still->y_prev = still->y = from(state.y, still->origin.y);
  still->angle_prev = still->angle = from(state.angle, 0);
  still->radius = from(state.radius, 0);
  still->speed.resize(state.id.size());
  still->asleep.resize(state.id.size());
  for (std::size_t row = 0; row < state.id.size(); ++row) {
    still->speed[row] = static_cast<float>(std::hypot(state.vx[row], state.vy[row]));
    still->asleep[row] = state.type[row] == BodyType::dynamic_body && !world_->is_awake(world_->id_of(state.id[row]));
  }
  return still;
}

void Simulation::tell(Status& status) {
  if (!told_catalogue_) told_catalogue_ = std::make_shared<const Catalogue>(*catalogue_);
  status.world = world_;
  status.scene = scene_;
  status.catalogue = told_catalogue_;
  status.joints = joints_;
  status.wells = wells_;
  if (fluids_frame_ != frame()) fluids_ = take_fluids(*world_, *scene_);
  fluids_frame_ = frame();
  status.fluids = fluids_;
  // While it runs, the next step shows what changed.
  const bool no_snapshot = world_->frame() == 0;
  if (changed_ && (paused || no_snapshot)) {
    status.still = take_still();
  } else {
    status.still.reset();
  }
  if (collect_.contacts || collect_.forces || collect_.strips || collect_.colours || collect_.hits) {
    status.touches = take_touches();
  } else {
    status.touches.reset();
  }
  const std::uint64_t every = world_->body_count() > kHashEveryFrame && !paused ? kHashFrames : 1;
  if (collect_.hash && frame() % every == 0) {
    hash_ = world_->state_hash();
    hash_frame_ = frame();
  }
  status.settings = settings_;
  status.scene_serial = scene_serial_;
  status.run_serial = run_serial_;
  status.world_serial = world_serial_;
  status.paused = paused;
  status.speed = speed;
  status.message = message_;
  status.frame = frame();
  status.first_frame = frames_before_;
  status.bodies = world_->body_count() - (grab_ ? 1 : 0);
  status.hash = hash_;
  status.hash_frame = hash_frame_;
  status.steps.insert(status.steps.end(), reports_.begin(), reports_.end());
  reports_.clear();
}

}  // namespace psim::view
