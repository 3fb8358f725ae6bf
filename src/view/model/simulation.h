// The world that is looked at, and everything that can be done to it. One thread owns it
// (sim_thread.h); what others may see leaves it as a Status.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/body_columns.h"
#include "model/catalogue.h"
#include "model/fluid_look.h"
#include "psim/scene.h"

namespace psim::view {

/// What the sliders set. Gravity and skin change at once; the rest takes a new world, which goes on from
/// the present state.
struct Settings {
  Vec2 gravity;
  double skin = 1;
  int substeps = 4;
  std::optional<double> restitution, friction;  ///< of every body and wall; none: the scene's own
  Isa isa = Isa::scalar;
  int threads = 1;
};

/// A joint as a picture needs it.
struct JointLook {
  std::uint32_t a = 0, b = 0;  ///< ids
  Vec2 anchor_a, anchor_b;     ///< metres, body frames
  JointType type = JointType::distance;
  std::uint32_t number = 0;  ///< the index of its id
};

/// What is collected for overlays and colours. All of it costs time of the simulation.
struct Collect {
  bool contacts = false, forces = false, strips = false, colours = false, hits = false, hash = true;
  friend bool operator==(const Collect&, const Collect&) = default;
};

/// A contact as a picture needs it.
struct ContactLook {
  std::uint32_t a = 0, b = 0;  ///< ids; b may be a wall
  Vec2 point;                  ///< metres
  float nx = 0, ny = 0;        ///< of length 1, from a to b
  float force = 0;             ///< N, along the normal
  std::uint32_t colour = 0;    ///< Contact::colour
};

struct TouchLists {
  std::vector<ContactLook> contacts;
  std::vector<float> forces;   ///< N, by id: sum of what a body's contacts press it with
  std::vector<float> groups;   ///< by id: strip, or highest colour of the contacts; kNoGroup, also beyond
  std::vector<HitEvent> hits;  ///< of the last step
};

inline constexpr std::uint64_t kNoFrame = ~std::uint64_t{0};

/// Where the wells of a world are, metres.
using WellPlaces = std::shared_ptr<const std::vector<Vec2>>;

/// What the view knows of the simulation. Everything pointed to stays as it is.
struct Status {
  std::shared_ptr<World> world;  ///< for latest_snapshot and constants only
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const Catalogue> catalogue;
  std::shared_ptr<const std::vector<JointLook>> joints;
  WellPlaces wells;
  FluidPlaces fluids;                     ///< null without fluids
  std::shared_ptr<const Snapshot> still;  ///< if set, newer than the world's latest snapshot
  std::shared_ptr<const TouchLists> touches;
  Settings settings;
  std::uint64_t scene_serial = 0;  ///< counts scenes loaded
  std::uint64_t run_serial = 0;    ///< counts restarts, too: frames begin at 0
  std::uint64_t world_serial = 0;  ///< counts rebuilt worlds, too
  bool paused = false;
  double speed = 1;  ///< simulated seconds a second
  std::string message;
  std::uint64_t frame = 0, bodies = 0;
  std::uint64_t first_frame = 0;  ///< of the world: what its snapshots count from
  std::uint64_t hash = 0, hash_frame = kNoFrame;
  std::vector<StepReport> steps;  ///< since the status before; the last one led to `frame`
};

enum class SpawnShape : std::uint8_t { disc, box, polygon, capsule };
inline constexpr const char* kSpawnShapeNames[] = {"disc", "box", "hexagon", "capsule"};

class Simulation {
 public:
  /// Throws UserError if the world cannot be made.
  Simulation(Scene scene, Isa isa, int threads);

  void step();
  bool wants_step() const { return !paused || steps_left_ > 0; }

  // ---- what the view asks for
  void load(const std::string& name);  ///< a built-in name or a file
  void restart();                      ///< the scene as it began, with the settings of now
  void single_step();
  void set_gravity(Vec2 gravity);
  void set_skin(double factor);
  void set_settings(const Settings& settings);
  void set_collect(const Collect& collect);
  void say(std::string message) { message_ = std::move(message); }

  void grab(Vec2 at, double reach);
  void drag(Vec2 to);
  void let_go();
  void spawn(Vec2 at, SpawnShape shape, double size);
  /// `strength`: N s for each metre of a body's width, up to half of `reach`; from there it fades to nothing.
  void explode(Vec2 at, double reach, double strength);
  void add_well(Vec2 at, double strength, double range);
  void add_wall(Vec2 from, Vec2 to);
  void erase(Vec2 at, double reach);

  /// Moves what is new into `status`, all but `paused` and `speed` of its own.
  void tell(Status& status);
  double dt() const { return world_->desc().dt; }
  std::uint64_t frame() const { return frames_before_ + world_->frame(); }

  bool paused = false;
  double speed = 1;

 private:
  // Two springs from a body to an unseen kinematic one, which goes after the pointer.
  struct Grab {
    BodyId body, anchor;
    Vec2 arm;        // metres, body frame
    Vec2 target;     // metres: the pointer
    double stretch;  // metres: how far the anchor goes ahead of the body
  };
  struct Added {
    BodyId id;
    BodyDesc desc;
  };

  void make(bool keep_state);
  Scene configured() const;
  void carry_over(World& old, World& fresh, Catalogue& looks);
  void add(BodyDesc desc);
  void forget_joints_of(std::uint32_t id);
  void forget_broken_joints(std::span<const JointBreak> breaks);
  void lead();
  void note_wells();
  Vec2 way(Vec2 from, Vec2 to) const;
  Vec2 inside(Vec2 place) const;
  std::shared_ptr<const TouchLists> take_touches();
  void take_contacts(TouchLists& touches);
  std::shared_ptr<const Snapshot> take_still() const;
  double mass_of(const BodyState& state) const;

  std::shared_ptr<const Scene> scene_;
  std::shared_ptr<World> world_;
  std::shared_ptr<Catalogue> catalogue_;
  std::shared_ptr<const Catalogue> told_catalogue_;
  std::shared_ptr<const std::vector<JointLook>> joints_;
  Settings settings_;
  Collect collect_;
  WellPlaces wells_;
  FluidPlaces fluids_;        // of the frame fluids_frame_
  std::vector<Added> added_;  // bodies placed by hand
  std::optional<Grab> grab_;
  std::vector<HitEvent> hits_;
  std::vector<StepReport> reports_;
  std::string message_;
  std::uint64_t scene_serial_ = 0, run_serial_ = 0, world_serial_ = 0, steps_left_ = 0, spawned_ = 0;
  std::uint64_t frames_before_ = 0;  // of the worlds that this one goes on from
  std::uint64_t hash_ = 0, hash_frame_ = kNoFrame;
  std::uint64_t fluids_frame_ = kNoFrame;
  bool changed_ = true;  // since the last step, so that the latest snapshot is out of date
};

}  // namespace psim::view
