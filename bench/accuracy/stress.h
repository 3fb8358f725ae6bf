// How far psim can be driven: figures of its stability. `run_stress` measures all of them; the tests
// hold each to today's figure through the same functions. docs/stress.md is the table.
#pragma once

#include <string>
#include <vector>

namespace psim::accuracy {

struct StressRow {
  std::string name;
  double figure = 0;
  std::string unit;
  std::string meaning;
};

/// Every figure, about 12 s. `quick`: a tenth of the million steps, no large crowds; 3 s.
std::vector<StressRow> run_stress(bool quick);

namespace stress {

// ---- length of the step -----------------------------------------------------------------------

/// 225 discs fall in a bin and come to rest.
struct Landing {
  bool whole = false;      ///< everybody finite and inside
  double energy_gain = 0;  ///< largest energy on the way over that of the start, relative
  double speed = 0;        ///< m/s, root mean square at the end
  double overlap = 0;      ///< of a diameter, the largest at the end
  /// Whole, no energy gained, at rest, no overlap over a tenth.
  bool stable() const;
};

Landing land(double dt, double restitution, double friction);
/// As `land`, every step of another length between these, s.
Landing land_at_random_steps(double shortest, double longest);
/// A pile at rest, one step of this length, then a second of common ones: the fastest disc, m/s.
double speed_after_a_short_step(double short_step);
/// The largest of 1/240 … 1 s at which landings with and without friction are stable, s.
double largest_stable_step();

// ---- mass ratios ------------------------------------------------------------------------------

/// A disc `ratio` times as heavy as the one that it lies on, after 10 s.
struct Load {
  double overlap = 0;  ///< the larger of both contacts', of a radius
  double speed = 0;    ///< m/s
};

Load heavy_on_light(double ratio);
/// The first ratio, to `digits` of it, at which heavy_on_light overlaps by more than that.
double first_sinking_ratio(double overlap);
/// Largest error of an elastic oblique pair's velocities over offsets, of the speed.
double elastic_pair_error(double ratio);
/// A disc of 160,000 times their mass let down on gravel: the fastest stone ever, m/s.
double gravel_speed();

// ---- overlaps ---------------------------------------------------------------------------------

/// Two discs at rest that overlap by this part of a diameter: the speed they leave with, m/s.
double speed_from_overlap(double overlap, double restitution, double mass_ratio);
/// The same for the fastest of 12 x 12 discs.
double speed_from_overlapping_block(double overlap, double restitution);
/// How high a disc jumps that begins so deep (of its radius) in the ground, m.
double jump_from_the_ground(double overlap);

struct OnePoint {
  double speed = 0;     ///< m/s of the fastest, after 2 s
  double momentum = 0;  ///< of the sum of all momenta
  bool finite = false;
};
OnePoint one_point(int discs);

// ---- speed ------------------------------------------------------------------------------------

/// How many of 200 discs of radius 0.1 m, each alone in its world, pass a thin wall that they come
/// at this fast, `angle` from the normal.
int lone_discs_through_a_wall(double speed, double angle, double restitution);
/// How many of 200 in one world do at any time, at speeds up to this.
int discs_through_a_wall(double speed, double restitution);
/// How many of 50 pairs shot at each other pass through each other.
int bullets_through_each_other(double speed, double restitution);
/// Most kinetic energy after two discs without restitution met at offsets, of that before; 1 is
/// none gained. `reach`: way of approach within a substep, in diameters.
double energy_of_inelastic_pair(double reach);
/// The first reach at which it exceeds 1.01.
double first_gaining_reach();

// ---- far away, denormals ----------------------------------------------------------------------

/// Largest difference between a landing round (0, 0) and one round (x, 0), each in a world about
/// it: velocities in m/s, places in m beyond what a double at x can tell.
double difference_at(double x);
/// Time of a step of 3,600 touching discs whose velocities are denormal, of that at common ones.
double denormal_slowdown();

// ---- long runs --------------------------------------------------------------------------------

/// What a measure did over a run: its largest size, and the change of its mean from the first
/// tenth to the last.
struct Drift {
  double largest = 0;
  double change = 0;
};
/// Relative energy of a Kepler orbit, e = 0.5, over so many substeps.
Drift kepler_energy(int substeps_a_frame, int steps);
/// Relative energy of a disc that bounces with e = 1.
Drift bounce_energy(int frames);
/// Relative energy of 64 elastic discs.
Drift gas_energy(int frames);
/// Ten discs on top of one another: where the top one is, m from where it came to rest.
Drift stack_place(double friction, int frames);

// ---- smooth ground, time ----------------------------------------------------------------------

struct Glide {
  double bump = 0;        ///< m
  double speed_lost = 0;  ///< relative
};
/// A disc over 1000 segments in a line.
Glide glide(double speed, double friction);

/// How far from their start bodies are after a run there and back with velocities reversed, m.
double orbit_return(int substeps, int frames);
double bounce_return(int frames);
double gas_return(int frames);

// ---- crowds -----------------------------------------------------------------------------------

struct Crowd {
  bool finite = false;
  double overlap = 0;  ///< m, the largest at the end
  double speed = 0;    ///< m/s, of the fastest at the end
};
/// 600 small discs drawn to a big one that floats free.
Crowd ring_on_a_big_disc();
/// 10,000 discs on one segment, after 20 s.
Crowd discs_on_a_plate();

}  // namespace stress
}  // namespace psim::accuracy
