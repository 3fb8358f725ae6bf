// The bodies that a fluid meets: which shapes lie at which tile, how much of each cell they take (Batty, Bertails &
// Bridson 2007), and what pressure and they do to each other.
//
// A body takes part in the equations of pressure by rows: how much it presses into each cell as it moves. So pressure
// and the body's velocity are found at once.
//
// The force of a step is that of the step before, and an impulse that makes up for the difference. So bodies that lie
// or float at rest are held up while they move, and contacts and joints bear what is left.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "fluid/fluid_solids.h"
#include "fluid/fluid_solver.h"

namespace psim {

class Archive;

/// A body as a fluid meets it.
struct FluidBody {
  std::uint32_t id = 0, generation = 0;
  Vec2 velocity;           ///< m/s
  double spin = 0;         ///< rad/s
  double inv_mass = 0;     ///< 1/kg; 0: static or kinematic, or it sleeps
  double inv_inertia = 0;  ///< 1/(kg m^2)
  bool moves = false;      ///< it is awake, and, if kinematic, has a velocity
  bool asleep = false;     ///< for the fluid it stands fast then
  double speed = 0;        ///< m/s: none of its points is faster
};

/// A fluid does this to a body in a step.
struct FluidForce {
  std::uint32_t id = 0, generation = 0;
  Vec2 force = {};          ///< N: mean of the last step
  double torque = 0;        ///< N m, about the centre of mass
  Vec2 impulse = {};        ///< N s: what the step did not know of
  double spin_impulse = 0;  ///< N m s
  double slow = 0;          ///< s: for how long the body has been slow
  bool asleep = false;      ///< it sleeps: nothing of this is given to it
  /// By how much more it feels, on a mean of the last steps, than when it fell asleep: N, N m.
  Vec2 stir_force = {};
  double stir_torque = 0;
  Vec2 rest_force = {};  ///< what it felt then
  double rest_torque = 0;
};

/// Particles that were stopped at a body gave this to it: momentum and angular momentum about its centre of mass; their mass,
/// and their moment of inertia, each at the arm of its push. All by the reference density and the area of a cell.
struct FluidHits {
  std::uint32_t body = 0;  ///< id
  double x = 0, y = 0, turn = 0, mass = 0, inertia = 0;
};

/// A fluid asks a finder for the bodies around it.
class SolidFinder {
 public:
  struct Found {
    std::uint32_t id = 0, order = 0;
    ConvexOutline outline;  ///< m from `corner`
    Vec2 centre;            ///< of mass of the body, likewise
  };
  virtual ~SolidFinder() = default;
  virtual bool any() const = 0;
  /// Appends the shapes near a box: what is seen from `corner` between `low` and `high`. Many threads may call it.
  virtual void find(Vec2 corner, Vec2 low, Vec2 high, std::vector<Found>& out) const = 0;
  virtual FluidBody body(std::uint32_t id) const = 0;
};

/// The shapes at some tiles.
class TileSolids {
 public:
  /// Finds the shapes within `reach` m of tiles with these keys.
  void find(const SolidFinder& finder, std::span<const std::uint64_t> keys, const FluidSpace& space, float reach,
            WorkerPool& pool);
  void clear() {
    by_tile_.clear();
    any_ = false;
  }
  bool any() const { return any_; }
  std::span<FluidSolid> at(std::size_t tile) {
    return tile < by_tile_.size() ? std::span(by_tile_[tile]) : std::span<FluidSolid>();
  }
  std::size_t size() const { return by_tile_.size(); }

 private:
  std::vector<std::vector<FluidSolid>> by_tile_;
  bool any_ = false;
};

class FluidBodies : public SolverRows {
 public:
  explicit FluidBodies(FluidSolver& solver) : solver_(solver) {}
  /// A step of dt seconds begins. `finder` may be null. `density`: kg/m^2 of what pressure is counted in.
  void begin(const SolidFinder* finder, double density, double dt);
  /// A part of it begins. Bodies lie where they are at the end of the step: the first part sees them move there.
  void begin_part();
  bool there() const { return finder_ != nullptr; }
  /// Finds the shapes around tiles that particles leave, for ways of up to `reach` m.
  void look_around(std::span<const std::uint64_t> keys, const FluidSpace& space, float reach, WorkerPool& pool);
  /// Finds the shapes at the tiles of this part of a step, of `part` seconds. `known`: the share of the last force that
  /// counts as known.
  void look(const FluidGrid& grid, const FluidSpace& space, double part, double known, WorkerPool& pool);
  bool any() const { return solids_.any(); }
  std::span<FluidSolid> around(std::size_t k) { return around_.at(k); }
  std::span<FluidSolid> at(std::size_t tile) { return solids_.at(tile); }
  const FluidBody& body(std::size_t k) const { return bodies_[k]; }
  std::size_t count() const { return bodies_.size(); }
  /// The k-th body bears this by viscosity in this part of a step: N s, and N m s about its centre of mass.
  void drag(std::uint32_t k, Vec2 impulse, double spin_impulse);
  /// Velocity of a point of a body, seen as the solid sees it.
  Place2 speed_at(const FluidSolid& solid, Place2 at) const;
  /// Keeps a particle out of shapes: `at` is where it went from `from`, m, in dt seconds; `speed` its velocity; `mass` as in
  /// FluidMotion. Returns whether it changed anything. `hits` takes down what the shapes bear.
  bool keep_out(std::span<const FluidSolid> solids, Place2 from, float dt, float cell, Place2& at, Place2& speed,
                float mass, std::vector<FluidHits>& hits) const;
  /// Lets a particle out that is caught between a shape that moves and one that stands, or the world's wall: it goes along the
  /// face that presses it, away from the middle of the body, by 1.5 cells at most.
  void slip_out(std::span<const FluidSolid> solids, float cell, Place2& at) const;
  /// Bodies bear this in this part of a step. `cell`: area of a cell, m^2. Lists come in an order that depends on nothing
  /// but the particles.
  void take_hits(const std::vector<FluidHits>& hits, double cell);

  /// Draws the bodies into a tile: kOpenU, kOpenV, kSeen, kSolidU, kSolidV, and kFine. Makes the rows of its cells.
  void draw(FluidGrid& grid, std::size_t tile, const FluidSpace& space);
  /// Where there is no surface the equations leave the mean of the pressure open: takes it out of what bodies feel, so that
  /// their rows add up to nothing. After draw(), before add_motion().
  void close_surfaces(const FluidGrid& grid);
  /// Takes the bodies' motion into the right sides of pressure of a tile; returns the largest of them.
  float add_motion(FluidGrid& grid, std::size_t tile) const;

  /// Calls visit(k, node, x, y, turn) for each cell of a tile that the k-th body meets: how much its velocity and its spin
  /// press into the cell. The vector from (x, y) is that of the body's surface in the cell, and leads into the body.
  template <class Visit>
  void each_row(std::size_t tile, const Visit& visit) const {
    for (const Run& run : tiles_[tile].runs) {
      for (std::uint32_t k = run.first; k < run.end; ++k) {
        const Row& row = tiles_[tile].rows[k];
        visit(run.body, std::size_t{row.node}, row.x, row.y, row.turn);
      }
    }
  }
  /// Besides pressure the k-th body feels this in this part of a step, in units of the solution for pressure times area.
  /// After draw(), before add_motion().
  void pull(std::uint32_t k, double x, double y, double turn) {
    FluidBody& b = bodies_[k];
    b.velocity = b.velocity + density_ * b.inv_mass * Vec2{x, y};
    b.spin += density_ * b.inv_inertia * turn;
    pulls_[k].x += x;
    pulls_[k].y += y;
    pulls_[k].turn += turn;
  }

  /// change += what moving bodies give if x is pressure; returns x times that.
  double apply(FluidGrid& grid, std::size_t x, std::size_t change) override;
  /// Whether some body moves with pressure.
  bool any_moving() const { return moving_; }
  /// Takes down what the pressure that was found gives to bodies in a part of `part` seconds. After look().
  void bear(FluidGrid& grid, std::size_t pressure, double part);
  /// Sums up the parts of a step.
  void finish();
  /// Finds the shapes at these tiles again, while the fluid lies still.
  void look_again(const SolidFinder* finder, std::span<const std::uint64_t> keys, const FluidSpace& space,
                  WorkerPool& pool);
  /// Returns a number that stays the same while all shapes that were found last stay as they are; nothing if one of their
  /// bodies moves.
  std::optional<std::uint64_t> surroundings();
  /// Bodies were given what they were to be given once.
  void forget_impulses();
  const std::vector<FluidForce>& forces() const { return forces_; }
  /// A body fell asleep after the step.
  void lay_down(std::uint32_t id);

  void clear();
  void describe(Archive& a);
  std::size_t bytes() const;

 private:
  /// How much a unit of a body's velocity presses into a cell.
  struct Row {
    std::uint32_t node;
    float x, y, turn;
  };
  struct Run {
    std::uint32_t body = 0, first = 0, end = 0;
    double x = 0, y = 0, turn = 0;  // sums
  };
  struct Tile {
    std::vector<Row> rows;
    std::vector<Run> runs;
  };
  struct Sum {
    double x = 0, y = 0, turn = 0;
    bool met = false;
  };
  friend class FluidCut;
  void number(TileSolids& of);
  void find(std::span<const std::uint64_t> keys, const FluidSpace& space, WorkerPool& pool);
  void sum_rows(FluidGrid& grid, std::size_t x);
  void bear_hits();
  FluidHits borne_by(std::uint32_t id) const;
  bool stopped_by_fixed(std::span<const FluidSolid> solids, Place2 from, Place2 to, float cell) const;
  FluidForce so_far(std::uint32_t id, std::uint32_t generation) const;

  FluidSolver& solver_;
  const SolidFinder* finder_ = nullptr;
  TileSolids around_, solids_;
  std::vector<FluidBody> bodies_;           // by id; with their velocity before pressure
  std::vector<FluidForce> forces_, known_;  // of this step and of the one before, by id
  // What the parts of this step gave, by id: impulses, and the force in the last of them.
  std::vector<FluidForce> given_, next_;
  std::vector<Tile> tiles_;
  std::vector<Sum> sums_, gains_, pulls_;  // by body
  std::vector<FluidHits> hits_;            // of this part of a step, in kg m/s
  std::vector<FluidHits> borne_;           // what bodies bear of those of this step, by id
  double density_ = 1, share_ = 0, dt_ = 0;
  bool moving_ = false;
};

}  // namespace psim
