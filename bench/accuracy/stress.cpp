#include "stress.h"

#include <algorithm>

namespace psim::accuracy {
namespace {

using namespace stress;

using Rows = std::vector<StressRow>;

void steps_and_masses(bool quick, Rows& rows) {
  rows.push_back({"largest-stable-step", largest_stable_step(), "s",
                  "225 discs land and rest, overlap below a tenth of a diameter"});
  rows.push_back({"landing-at-1s-gain", std::max(land(1, 0, 0).energy_gain, 0.0), "relative",
                  "energy gained by the same landing at dt = 1 s"});
  rows.push_back({"landing-at-random-steps-gain", land_at_random_steps(1e-4, 0.05).energy_gain,
                  "relative", "energy gained at steps of 0.1 ms to 1/20 s by chance"});
  rows.push_back({"landing-at-uneven-steps-overlap",
                  land_at_random_steps(0.8 / 60, 1.2 / 60).overlap, "of a diameter",
                  "at steps of 1/60 s and a fifth more or less, by chance"});
  rows.push_back(
      {"one-short-step-speed", speed_after_a_short_step(1e-6), "m/s",
       "fastest of a pile at rest after one step of a microsecond among those of 1/60 s"});
  rows.push_back({"first-sinking-mass-ratio", first_sinking_ratio(0.05), "",
                  "heavy on light overlaps by more than 5 % of a radius from here on"});
  double worst = 0;
  for (double ratio = 1e-6; ratio < 2e6; ratio *= quick ? 1e3 : 10) {
    worst = std::max(worst, elastic_pair_error(ratio));
  }
  rows.push_back({"elastic-pair-error", worst, "of the speed",
                  "worst oblique elastic impact over mass ratios 1e-6 to 1e6"});
  rows.push_back({"gravel-speed", gravel_speed(), "m/s",
                  "fastest stone under a disc of 160,000 times its mass"});
}

void overlaps(bool quick, Rows& rows) {
  for (const double overlap : {0.1, 0.25, 0.5, 0.75, 1.0}) {
    const std::string percent = std::to_string(static_cast<int>(100 * overlap));
    rows.push_back({"overlap-" + percent + "-pair-speed", speed_from_overlap(overlap, 1, 1), "m/s",
                    "two elastic discs that begin with this overlap leave each other at"});
    if (overlap == 1) continue;
    rows.push_back({"overlap-" + percent + "-block-speed", speed_from_overlapping_block(overlap, 0),
                    "m/s", "the fastest of 12 x 12 that begin with it"});
  }
  for (const int discs : {2, 10, quick ? 100 : 1000}) {
    rows.push_back({"one-point-" + std::to_string(discs) + "-speed", one_point(discs).speed, "m/s",
                    "the fastest of so many discs at one point"});
  }
}

// The first speed of the ladder at which `through` is not 0; 0 if there is none.
template <class Through>
double first_tunnelling(Through through) {
  for (const double speed : {1e2, 3e2, 1e3, 3e3, 1e4, 3e4, 1e5}) {
    if (through(speed) > 0) return speed;
  }
  return 0;
}

void speeds(Rows& rows) {
  for (const double e : {0.0, 1.0}) {
    const std::string name = e > 0 ? "-elastic" : "-inelastic";
    rows.push_back({"tunnelling-alone" + name, first_tunnelling([e](double v) {
                      return lone_discs_through_a_wall(v, 0, e) +
                             lone_discs_through_a_wall(v, 1.5, e);
                    }),
                    "m/s", "first speed up to 1e5 at which a disc passes a thin wall; 0: none"});
    rows.push_back({"tunnelling-in-company" + name,
                    first_tunnelling([e](double v) { return discs_through_a_wall(v, e); }), "m/s",
                    "the same for one of 200 at different speeds"});
    rows.push_back({"tunnelling-bullets" + name,
                    first_tunnelling([e](double v) { return bullets_through_each_other(v, e); }),
                    "m/s", "two discs shot at each other pass; 0: none"});
  }
  rows.push_back({"inelastic-gain-reach", first_gaining_reach(), "diameters a substep",
                  "pairs with e = 0 that approach faster than this gain energy"});
}

void long_runs(bool quick, Rows& rows) {
  const int steps = quick ? 100'000 : 1'000'000, frames = steps / 4;
  const auto add = [&rows](const std::string& name, const Drift& drift, const std::string& unit,
                           const std::string& meaning) {
    rows.push_back({name + "-largest", drift.largest, unit, meaning + ": largest"});
    rows.push_back({name + "-drift", drift.change, unit, meaning + ": last tenth less first"});
  };
  const std::string over = " over " + std::to_string(steps) + " substeps";
  add("kepler-energy", kepler_energy(4, steps), "relative", "orbit, e = 0.5," + over);
  add("bounce-energy", bounce_energy(frames), "relative", "elastic bouncing" + over);
  add("gas-energy", gas_energy(frames), "relative", "64 elastic discs" + over);
  add("stack-place", stack_place(0.5, frames), "m", "top of a column of ten" + over);
}

void smooth_and_reversed(Rows& rows) {
  const Glide sliding = glide(20, 0), rolling = glide(20, 0.5);
  rows.push_back({"joints-bump", std::max(sliding.bump, rolling.bump), "m",
                  "over 1000 segments in a line at 20 m/s"});
  rows.push_back({"joints-speed-lost", std::max(sliding.speed_lost, rolling.speed_lost), "relative",
                  "on the same way"});
  rows.push_back({"orbit-return", orbit_return(4, 3770), "m",
                  "ten orbits and, velocities reversed, ten back"});
  rows.push_back({"bounce-return", bounce_return(600), "m", "10 s of elastic bouncing and back"});
  rows.push_back({"gas-return", gas_return(120), "m", "100 elastic discs, 2 s and back"});
}

void crowds(Rows& rows) {
  const Crowd ring = ring_on_a_big_disc(), plate = discs_on_a_plate();
  rows.push_back({"ring-overlap", ring.overlap, "m", "600 discs of 0.1 m drawn to one of 20 m"});
  rows.push_back({"plate-overlap", plate.overlap, "m", "10,000 discs of 0.5 m on one segment"});
  rows.push_back({"plate-speed", plate.speed, "m/s", "their fastest after 20 s"});
}

}  // namespace

Rows run_stress(bool quick) {
  Rows rows;
  steps_and_masses(quick, rows);
  overlaps(quick, rows);
  speeds(rows);
  rows.push_back({"difference-at-1e6", difference_at(1e6), "m, m/s",
                  "100 discs landing 1000 km away against those at the origin"});
  rows.push_back({"denormal-slowdown", denormal_slowdown(), "",
                  "time of a step at denormal velocities, of that at common ones"});
  long_runs(quick, rows);
  smooth_and_reversed(rows);
  if (!quick) crowds(rows);
  return rows;
}

}  // namespace psim::accuracy
