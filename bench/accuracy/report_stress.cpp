#include "report_stress.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <exception>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "run.h"
#include "stress.h"

namespace psim::accuracy {
namespace {

using namespace stress;

enum class Bound { at_most, at_least };

/// One figure of one stress S1 to S14.
struct Figure {
  std::string_view stress, name, unit;
  Bound bound = Bound::at_most;
  double limit = 0;
  std::function<double(const Start&)> measure;
  bool psim_only = false;
  std::string_view meaning;

  bool holds(double value) const {  // not if it is NaN
    return bound == Bound::at_most ? value <= limit : value >= limit;
  }
};

using Figures = std::vector<Figure>;

constexpr double kNone = 1e5;  // m/s, as fast as S7 goes

/// The fastest of a ladder of speeds at which, as at all slower ones, nobody comes through.
template <class Through>
double fastest_held(Through through) {
  double held = 0;
  for (const double speed : {3.0, 10.0, 30.0, 1e2, 3e2, 1e3, 3e3, 1e4, 3e4, kNone}) {
    if (through(speed) > 0) break;
    held = speed;
  }
  return held;
}

/// The worst of a measure over places where it is taken.
template <class Places, class Measure>
double worst(const Places& places, Measure measure) {
  double most = -std::numeric_limits<double>::infinity();
  for (const double place : places) {
    const double value = measure(place);
    if (std::isnan(value)) return value;
    most = std::max(most, value);
  }
  return most;
}

constexpr std::array<double, 2> kInelasticAndElastic = {0, 1};

void append_steps(Figures& all) {
  all.push_back({"S1", "largest-stable-step", "s", Bound::at_least, 1.0 / 30,
                 [](const Start& s) { return largest_stable_step(s); }, false,
                 "225 discs land, rest (below 5 cm/s) and overlap by less than a tenth of a diameter"});
  all.push_back({"S1", "long-steps-energy-gain", "of the start's", Bound::at_most, 0.01,
                 [](const Start& s) {
                   return worst(std::array{1.0 / 15, 0.1, 1.0}, [&s](double dt) {
                     const Landing landing = land(dt, 0.3, 0.5, s);
                     return landing.whole ? landing.energy_gain : std::nan("");
                   });
                 },
                 false, "the same landing in steps of 1/15, 1/10 and 1 s"});
  all.push_back({"S1", "uneven-steps-energy-gain", "of the start's", Bound::at_most, 0.01,
                 [](const Start&) {
                   const Landing landing = land_at_random_steps(1e-4, 0.05);
                   return landing.whole ? landing.energy_gain : std::nan("");
                 },
                 true, "steps of 0.1 ms to 1/20 s by chance"});
  all.push_back({"S1", "one-other-step-speed", "m/s", Bound::at_most, 1,
                 [](const Start&) {
                   return worst(std::array{1e-6, 1e-3, 0.1}, speed_after_another_step);
                 },
                 true, "fastest of a pile at rest after one step of 1 us, 1 ms or 0.1 s"});
}

void append_masses(Figures& all) {
  all.push_back({"S2", "first-sinking-mass-ratio", "", Bound::at_least, 100,
                 [](const Start& s) { return first_sinking_ratio(0.05, s); }, false,
                 "heavy on light overlaps by more than 5 % of a radius"});
  all.push_back({"S2", "elastic-pair-error", "of the speed", Bound::at_most, 1e-5,
                 [](const Start& s) {
                   return worst(std::array{1e-6, 1e-3, 1.0, 1e3, 1e6},
                                [&s](double ratio) { return elastic_pair_error(ratio, s); });
                 },
                 false, "oblique elastic impacts, mass ratios 1e-6 to 1e6"});
  all.push_back({"S2", "gravel-speed", "m/s", Bound::at_most, 30, [](const Start& s) { return gravel_speed(s); }, false,
                 "fastest stone under a disc of 160,000 times its mass"});
}

void append_overlaps(bool quick, Figures& all) {
  all.push_back({"S3", "100-at-one-point-speed", "m/s", Bound::at_most, 300,
                 [](const Start& s) { return one_point(100, s).speed; }, false,
                 "the fastest of 100 discs at one point, after 2 s"});
  all.push_back({"S3", "100-at-one-point-momentum", "of all momenta", Bound::at_most, 1e-5,
                 [](const Start& s) { return one_point(100, s).momentum; }, false, "momentum that they gain together"});
  all.push_back({"S3", "100-at-one-point-overlap", "of a diameter", Bound::at_most, 0.01,
                 [](const Start& s) { return one_point(100, s).overlap; }, false,
                 "the deepest overlap of them, after 2 s"});
  if (!quick) {  // other engines take minutes: half a million contacts
    all.push_back({"S3", "1000-at-one-point-speed", "m/s", Bound::at_most, 1000,
                   [](const Start& s) { return one_point(1000, s).speed; }, true, "the same of 1000"});
  }
  all.push_back({"S4", "overlapping-pair-speed", "m/s", Bound::at_most, 1e-3,
                 [](const Start& s) {
                   return worst(std::array{0.1, 0.5, 0.9}, [&s](double overlap) {
                     return std::max(speed_from_overlap(overlap, 0, 1, s), speed_from_overlap(overlap, 1, 1000, s));
                   });
                 },
                 false, "two discs at rest that begin 10, 50 or 90 % in each other leave at"});
  all.push_back({"S4", "overlapping-block-speed", "m/s", Bound::at_most, 30,
                 [](const Start& s) {
                   return worst(std::array{0.1, 0.5, 0.9},
                                [&s](double overlap) { return speed_from_overlapping_block(overlap, 0, s); });
                 },
                 false, "the fastest of 12 x 12 that do"});
  all.push_back(
      {"S4", "jump-from-the-ground", "m", Bound::at_most, 0.01,
       [](const Start& s) {
         return worst(std::array{0.1, 0.5, 0.9}, [&s](double overlap) { return jump_from_the_ground(overlap, s); });
       },
       false, "of a disc that begins 10, 50 or 90 % of its radius in it"});
}

void append_extremes(Figures& all) {
  all.push_back({"S5", "denormal-slowdown", "", Bound::at_most, 1.1,
                 [](const Start& s) { return denormal_slowdown(s); }, false,
                 "time of a step at denormal velocities, of that at common ones"});
  all.push_back({"S6", "difference-at-1e6", "m or m/s", Bound::at_most, 0,
                 [](const Start& s) { return difference_at(1e6, s); }, false,
                 "100 discs landing 1000 km away against those at the origin"});
}

void append_speeds(Figures& all) {
  all.push_back({"S7", "wall-holds-one-to", "m/s", Bound::at_least, kNone,
                 [](const Start& s) {
                   return fastest_held([&s](double v) {
                     return worst(kInelasticAndElastic, [&](double e) {
                       return lone_discs_through_a_wall(v, 0, e, s) + lone_discs_through_a_wall(v, 1.5, e, s);
                     });
                   });
                 },
                 false, "a disc of 0.1 m at a thin wall, straight and grazing, e 0 and 1"});
  all.push_back({"S7", "wall-holds-200-to", "m/s", Bound::at_least, kNone,
                 [](const Start& s) {
                   return fastest_held([&s](double v) {
                     return worst(kInelasticAndElastic, [&](double e) { return discs_through_a_wall(v, e, s); });
                   });
                 },
                 false, "200 of them at different speeds"});
  all.push_back({"S7", "bullets-meet-to", "m/s", Bound::at_least, kNone,
                 [](const Start& s) {
                   return fastest_held([&s](double v) {
                     return worst(kInelasticAndElastic, [&](double e) { return bullets_through_each_other(v, e, s); });
                   });
                 },
                 false, "two discs of 0.1 m shot at each other"});
  all.push_back(
      {"S7", "inelastic-pair-energy", "of before", Bound::at_most, 1,
       [](const Start& s) {
         return worst(std::array{1.0, 4.0, 16.0}, [&s](double reach) { return energy_of_inelastic_pair(reach, s); });
       },
       false,
       "oblique impacts with e = 0, approaching 1 to 16 diameters in 1/240 s; 1: they "
       "passed through each other"});
  all.push_back({"S7", "miss-deflection", "of the speed", Bound::at_most, 1e-5,
                 [](const Start& s) {
                   return worst(std::array{1.0, 4.0, 16.0}, [&s](double reach) {
                     return std::max(deflection_at_a_miss(reach, 1.05, s), deflection_at_a_miss(reach, 2, s));
                   });
                 },
                 false, "of two that pass each other by a twentieth or a whole diameter"});
}

void append_inputs(Figures& all) {
  all.push_back({"S8", "bad-scenes-taken", "of 24", Bound::at_most, 0, [](const Start&) { return bad_scenes_taken(); },
                 true, "zero, negative, huge, non-finite values in a scene file"});
  all.push_back({"S9", "bodies-changed-by-nan", "of 200", Bound::at_most, 0,
                 [](const Start&) { return bodies_changed_by_nan(); }, true,
                 "others that differ in a bit after one body got NaN"});
}

void append_crowds(bool quick, Figures& all) {
  all.push_back({"S10", "ring-overlap", "m", Bound::at_most, 0.01,
                 [](const Start& s) { return ring_on_a_big_disc(s).overlap; }, false,
                 "600 discs of 0.1 m drawn to a free one of 20 m"});
  if (quick) return;
  all.push_back({"S10", "plate-overlap", "m", Bound::at_most, 0.2,
                 [](const Start& s) { return discs_on_a_plate(s).overlap; }, false,
                 "10,000 discs of 0.5 m on one segment, after 20 s"});
}

void append_long_runs(bool quick, Figures& all) {
  const int frames = quick ? 25'000 : 250'000;
  const std::string_view orbit = quick ? "25,000 frames, e = 0.5" : "250,000 frames, e = 0.5",
                         bounce = quick ? "25,000 frames, e = 1" : "250,000 frames, e = 1",
                         gas = quick ? "64 elastic discs, 25,000 frames" : "64 elastic discs, 250,000 frames",
                         column = quick ? "top of ten discs, 25,000 frames" : "top of ten discs, 250,000 frames";
  const auto drift = [](const Drift& d) { return std::abs(d.change); };
  all.push_back({"S11", "orbit-energy-error", "relative", Bound::at_most, 6e-5,
                 [frames](const Start& s) { return kepler_energy(frames, s).largest; }, false, orbit});
  all.push_back({"S11", "orbit-energy-drift", "relative", Bound::at_most, 2e-5,
                 [frames, drift](const Start& s) { return drift(kepler_energy(frames, s)); }, false, orbit});
  all.push_back({"S11", "bounce-energy-error", "relative", Bound::at_most, 1e-3,
                 [frames](const Start& s) { return bounce_energy(frames, s).largest; }, false, bounce});
  all.push_back({"S11", "gas-energy-error", "relative", Bound::at_most, 1e-3,
                 [frames](const Start& s) { return gas_energy(frames, s).largest; }, false, gas});
  all.push_back({"S11", "column-creep", "m", Bound::at_most, 1e-6,
                 [frames](const Start& s) { return stack_place(0.5, frames, s).largest; }, false, column});
}

void append_rest(Figures& all) {
  all.push_back({"S12", "variants-that-differ", "", Bound::at_most, 0,
                 [](const Start&) { return variants_that_differ(); }, true,
                 "instruction sets x 1, 2, 4 threads, 1,000 rough discs"});
  const auto ways = std::array{0.0, 0.5};
  all.push_back({"S13", "joints-bump", "m", Bound::at_most, 1e-4,
                 [ways](const Start& s) { return worst(ways, [&s](double mu) { return glide(20, mu, s).bump; }); },
                 false, "over 1000 segments in a line at 20 m/s, sliding and rolling"});
  all.push_back({"S13", "joints-speed-lost", "relative", Bound::at_most, 1e-6,
                 [ways](const Start& s) {
                   return worst(ways, [&s](double mu) { return std::abs(glide(20, mu, s).speed_lost); });
                 },
                 false, "on the same way"});
  all.push_back({"S14", "orbit-return", "m", Bound::at_most, 1e-2, [](const Start& s) { return orbit_return(3770, s); },
                 false, "ten orbits of 10 m and, velocities reversed, ten back"});
  all.push_back({"S14", "bounce-return", "m", Bound::at_most, 1e-4,
                 [](const Start& s) { return bounce_return(600, s); }, false, "10 s of elastic bouncing and back"});
  all.push_back({"S14", "gas-return", "m", Bound::at_most, 1e-3, [](const Start& s) { return gas_return(120, s); },
                 false, "100 elastic discs, 2 s and back"});
}

Figures all_figures(bool quick) {
  Figures all;
  append_steps(all);
  append_masses(all);
  append_overlaps(quick, all);
  append_extremes(all);
  append_speeds(all);
  append_inputs(all);
  append_crowds(quick, all);
  append_long_runs(quick, all);
  append_rest(all);
  return all;
}

// ---- engines ----------------------------------------------------------------------------------

/// The engine cannot hold the scene.
struct Unfit : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Keeps the model while the simulation looks at it.
class Kept : public Simulation {
 public:
  Kept(const Engine& engine, const Model& model, const Setting& setting)
      : model_(model), simulation_(engine.make(model_, setting)) {}
  void advance() override { simulation_->advance(); }
  void read(std::vector<BodyState>& bodies) override { simulation_->read(bodies); }
  void set_velocity(std::size_t body, Vec2 velocity, double omega) override {
    simulation_->set_velocity(body, velocity, omega);
  }
  double row_visits() const override { return 0; }

 private:
  Model model_;
  std::unique_ptr<Simulation> simulation_;
};

/// The default, but the least slop that goes with it: Chipmunk's default of 0.1 m is meant for
/// pixels.
Setting usual_setting(const Engine& engine) {
  const std::vector<Setting> settings = engine.settings(Effort::quick, Scale::small);
  const auto usual = std::ranges::find_if(settings, &Setting::is_default);
  if (usual == settings.end()) throw std::logic_error(engine.name + " has no default setting");
  Setting best = *usual;
  for (const Setting& s : settings) {
    const bool alike = s.divisions() == usual->divisions() && s.iterations == usual->iterations;
    if (alike && s.slop < best.slop) best = s;
  }
  return best;
}

Start start_of(const Engine& engine) {
  return [&engine, setting = usual_setting(engine)](const Model& model) -> std::unique_ptr<Simulation> {
    const std::string why = engine.refuses(model);
    if (!why.empty()) throw Unfit(why);
    Setting at = setting;
    at.frame = model.scene.world.dt;
    return std::make_unique<Kept>(engine, model, at);
  };
}

/// Nothing if the engine cannot hold the scene, NaN if it does not get through.
std::optional<double> value_of(const Figure& figure, const Engine& engine) {
  if (figure.psim_only && engine.name != "psim") return std::nullopt;
  try {
    return figure.measure(start_of(engine));
  } catch (const Unfit&) {
    return std::nullopt;
  } catch (const Failed&) {
    return std::nan("");
  }
}

// ---- text and CSV -----------------------------------------------------------------------------

std::string number(double value, int digits) {
  if (std::isnan(value)) return "fails";
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, digits).ptr;
  return {text.data(), end};
}

std::string limit_text(const Figure& figure) {
  return (figure.bound == Bound::at_most ? "<= " : ">= ") + number(figure.limit, 3);
}

std::string padded(std::string_view text, std::size_t width) {
  std::string out(text);
  out.resize(std::max(width, out.size() + 1), ' ');
  return out;
}

std::string_view grade(const Figure& figure, double value) { return figure.holds(value) ? "holds" : "misses"; }

constexpr std::size_t kEngineWidth = 18;

std::string heading(const std::vector<Engine>& engines) {
  std::string line = padded("", 5) + padded("figure", 28) + padded("unit", 16) + padded("limit", 12);
  for (const Engine& engine : engines) line += padded(engine.name + ' ' + engine.version, kEngineWidth);
  return line + "what\n";
}

std::string cell(const Figure& figure, const std::optional<double>& value) {
  if (!value) return "-";
  return padded(number(*value, 3), 10) + std::string(grade(figure, *value));
}

std::string quoted(std::string_view text) {
  if (text.find(',') == text.npos) return std::string(text);
  return '"' + std::string(text) + '"';
}

void write_csv(std::ostream& csv, const Figure& figure, const Engine& engine, double value) {
  csv << figure.stress << ',' << figure.name << ',' << engine.name << ',' << number(value, 6) << ','
      << quoted(figure.unit) << ',' << limit_text(figure) << ',' << grade(figure, value) << ','
      << quoted(figure.meaning) << '\n';
}

}  // namespace

int report_stress(const std::vector<Engine>& engines, Effort effort, std::ostream& table, std::ostream* csv) {
  table << heading(engines) << std::flush;
  if (csv) *csv << "stress,figure,engine,value,unit,limit,grade,what\n";
  int missed = 0;
  for (const Figure& figure : all_figures(effort == Effort::quick)) {
    table << padded(figure.stress, 5) << padded(figure.name, 28) << padded(figure.unit, 16)
          << padded(limit_text(figure), 12) << std::flush;
    for (const Engine& engine : engines) {
      const std::optional<double> value = value_of(figure, engine);
      table << padded(cell(figure, value), kEngineWidth) << std::flush;
      if (!value) continue;
      if (csv) write_csv(*csv, figure, engine, *value);
      missed += engine.name == "psim" && !figure.holds(*value) ? 1 : 0;
    }
    table << figure.meaning << '\n' << std::flush;
  }
  table << "Every engine with its default setting, Chipmunk with a slop of 5 mm. holds, misses: "
           "the limit; fails: bodies lost or "
           "not finite; -: it has no such scene.\n";
  return missed;
}

}  // namespace psim::accuracy
