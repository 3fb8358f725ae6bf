// How far an engine can be driven: the figures of its stability. report_stress.h makes the table of
// them, for psim and the engines beside it; tests/stress_*_test.cpp hold psim's. docs/stress.md has
// them all.
//
// Every measurement starts its scenes by `Start`; the default is psim with one thread. One that an
// engine does not survive ends in `Failed`.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "engines/engine.h"
#include "engines/model.h"

namespace psim::accuracy::stress {

/// Puts a scene to work. A frame is scene.world.dt, also where that is not 1/60 s.
using Start = std::function<std::unique_ptr<Simulation>(const Model&)>;

std::unique_ptr<Simulation> start_psim(const Model& model);

// ---- S1: length of the step -------------------------------------------------------------------

/// 225 discs fall in a bin and come to rest.
struct Landing {
  bool whole = false;      ///< everybody finite and inside
  double energy_gain = 0;  ///< largest energy on the way over that of the start, relative
  double speed = 0;        ///< m/s, root mean square at the end
  double overlap = 0;      ///< of a diameter, the largest at the end
  /// Whole, energy gained below 1 %, slower than 5 cm/s, no overlap over a tenth.
  bool stable() const;
};

Landing land(double dt, double restitution, double friction, const Start& start = start_psim);
/// As `land`, of psim, for twice as long and of seven starts that differ by tenths of a millimetre, since when the last
/// disc finds its place is chance: medians of speed and overlap, the worst of the others.
Landing usual_landing(double dt, double restitution, double friction);
/// The largest of 1/240 … 1 s at which landings with and without friction are stable, s.
double largest_stable_step(const Start& start = start_psim);
/// As `land`, every step of another length between these, s. psim only.
Landing land_at_random_steps(double shortest, double longest);
/// A pile at rest, one step of this length, then a second of common ones: the fastest disc, m/s.
/// psim only.
double speed_after_another_step(double dt);

// ---- S2: mass ratios --------------------------------------------------------------------------

/// A disc `ratio` times as heavy as the one that it lies on, after 10 s.
struct Load {
  double overlap = 0;  ///< the larger of both contacts', of a radius
  double speed = 0;    ///< m/s
};

Load heavy_on_light(double ratio, const Start& start = start_psim);
/// The first ratio from 1 on, in steps of a tenth, at which it overlaps by more than that.
double first_sinking_ratio(double overlap, const Start& start = start_psim);
/// Largest error of an elastic oblique pair's velocities over offsets, of the speed.
double elastic_pair_error(double ratio, const Start& start = start_psim);
/// A disc of 160,000 times their mass let down on gravel: the fastest stone ever, m/s.
double gravel_speed(const Start& start = start_psim);

// ---- S3, S4: overlaps -------------------------------------------------------------------------

struct OnePoint {
  double speed = 0;     ///< m/s of the fastest, after 2 s
  double momentum = 0;  ///< of the sum of all momenta
  double overlap = 0;   ///< of a diameter, the largest after 2 s
};
OnePoint one_point(int discs, const Start& start = start_psim);

/// Two discs at rest that overlap by this part of a diameter: the speed they leave with, m/s.
double speed_from_overlap(double overlap, double restitution, double mass_ratio, const Start& start = start_psim);
/// The same for the fastest of 12 x 12 discs.
double speed_from_overlapping_block(double overlap, double restitution, const Start& start = start_psim);
/// How high a disc jumps that begins so deep (of its radius) in the ground, m.
double jump_from_the_ground(double overlap, const Start& start = start_psim);

// ---- S5, S6: denormals, far away --------------------------------------------------------------

/// Time of a step of 3,600 touching discs whose velocities are denormal, of that at common ones.
double denormal_slowdown(const Start& start = start_psim);
/// Largest difference between a landing round (0, 0) and one round (x, 0), each in a world about
/// it: velocities in m/s, places in m beyond what a double at x can tell.
double difference_at(double x, const Start& start = start_psim);

// ---- S7: speed --------------------------------------------------------------------------------

/// How many of 200 discs of radius 0.1 m, each alone in its world, pass a thin wall that they come
/// at this fast, `angle` from the normal.
int lone_discs_through_a_wall(double speed, double angle, double restitution, const Start& start = start_psim);
/// How many of 200 in one world do at any time, at speeds up to this.
int discs_through_a_wall(double speed, double restitution, const Start& start = start_psim);
/// How many of 50 pairs shot at each other pass through each other.
int bullets_through_each_other(double speed, double restitution, const Start& start = start_psim);
/// Most kinetic energy after two discs without restitution met at offsets, of that before; 1 is
/// none gained. `reach`: way of approach within 1/240 s, in diameters.
double energy_of_inelastic_pair(double reach, const Start& start = start_psim);
/// Two of them that pass each other at this distance, in diameters: change of velocity, of the speed.
double deflection_at_a_miss(double reach, double distance, const Start& start = start_psim);

// ---- S8, S9, S12: bad input, NaN, variants. psim only ------------------------------------------

/// How many of some two dozen bad scene files are taken, or refused without a place.
int bad_scenes_taken();
/// How many others of 200 discs differ in a bit after one got NaN from after it was removed.
int bodies_changed_by_nan();
/// How many of the instruction sets x 1, 2, 4 threads do not have the first one's bits.
int variants_that_differ();

// ---- S10: crowds ------------------------------------------------------------------------------

struct Crowd {
  double overlap = 0;  ///< m, the largest at the end
  double speed = 0;    ///< m/s, of the fastest at the end
};
/// 600 small discs drawn to a big one that floats free.
Crowd ring_on_a_big_disc(const Start& start = start_psim);
/// 10,000 discs on one segment, after 20 s.
Crowd discs_on_a_plate(const Start& start = start_psim);

// ---- S11: long runs ---------------------------------------------------------------------------

/// What a measure did over a run: its largest size, and the change of its mean from the first
/// tenth to the last.
struct Drift {
  double largest = 0;
  double change = 0;
};
/// Relative energy of a Kepler orbit, e = 0.5.
Drift kepler_energy(int frames, const Start& start = start_psim);
/// Relative energy of a disc that bounces with e = 1.
Drift bounce_energy(int frames, const Start& start = start_psim);
/// Relative energy of 64 elastic discs.
Drift gas_energy(int frames, const Start& start = start_psim);
/// Ten discs on top of one another: where the top one is, m from where it came to rest.
Drift stack_place(double friction, int frames, const Start& start = start_psim);

// ---- S13, S14: smooth ground, time reversed ---------------------------------------------------

struct Glide {
  double bump = 0;        ///< m
  double speed_lost = 0;  ///< relative
};
/// A disc over 1000 segments in a line.
Glide glide(double speed, double friction, const Start& start = start_psim);

/// How far from their start bodies are after a run there and back with velocities reversed, m.
double orbit_return(int frames, const Start& start = start_psim);
double bounce_return(int frames, const Start& start = start_psim);
double gas_return(int frames, const Start& start = start_psim);

}  // namespace psim::accuracy::stress
