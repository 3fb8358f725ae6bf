#include "sweep.h"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

namespace psim::accuracy {
namespace {

/// Of one thread its own time, which other programs on the machine do not change; of several the
/// wall's.
double seconds_now(const Setting& setting) {
  timespec now{};
  ::clock_gettime(setting.threads == 1 ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// A world's first frames sort its bodies and make its arrays.
constexpr int kWarmFrames = 5;

double timed_run(const Model& model, const Engine& engine, const Setting& setting, int frames) {
  const auto simulation = engine.make(model, setting);
  for (int k = 0; k < kWarmFrames; ++k) simulation->advance();
  const double begin = seconds_now(setting);
  for (int k = 0; k < frames; ++k) simulation->advance();
  return seconds_now(setting) - begin;
}

double median_time(const Case& of, const Model& model, const Engine& engine, const Setting& setting, Effort effort) {
  const int frames = std::max(1, static_cast<int>(of.timed_seconds * kFrameRate) - kWarmFrames);
  std::vector<double> times(effort == Effort::quick ? 3 : 7);
  for (double& t : times) t = timed_run(model, engine, setting, frames);
  const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
  std::nth_element(times.begin(), middle, times.end());
  return *middle * kFrameRate / frames;
}

const Limit* limit_of(const Row& row) {
  if (row.setting.steps != 1 || row.setting.integrator != "verlet") return nullptr;
  for (const Limit& limit : row.quantity->limits) {
    if (limit.substeps == row.setting.substeps) return &limit;
  }
  return nullptr;
}

std::string describe(const Row& row) {
  std::ostringstream text;
  text << row.quantity->name << ": psim " << row.setting.curve << ", " << row.setting.divisions() << " substeps: error "
       << row.error << " " << row.quantity->unit;
  return text.str();
}

}  // namespace

bool matters(const Setting& setting, const Case& of, const Model& model) {
  if (setting.is_machine_variant() && !of.machine_variants) return false;
  if (setting.bare && !has_boxes(model)) return false;
  return setting.integrator.empty() || setting.integrator == "verlet" || !model.scene.world.fields.empty();
}

std::vector<Row> run_setting(const Case& of, const Model& model, const Engine& engine, const Setting& setting,
                             Effort effort) {
  std::vector<Row> rows;
  for (const Quantity& q : of.quantities) {
    Row row;
    row.quantity = &q;
    row.engine = &engine;
    row.setting = setting;
    rows.push_back(row);
  }
  Run run(model, engine.make(model, setting), setting.is_default);
  try {
    const std::vector<double> errors = of.measure(run);
    for (std::size_t k = 0; k < rows.size(); ++k) rows[k].error = errors[k];
  } catch (const Failed&) {
    // The rows keep their infinite errors.
  }
  const double seconds = median_time(of, model, engine, setting, effort);
  for (Row& row : rows) {
    row.seconds_per_sim_second = seconds;
    row.row_visits = run.time() > 0 ? run.row_visits() / run.time() : 0;
    if (!std::isfinite(row.error)) row.error = std::numeric_limits<double>::infinity();
  }
  return rows;
}

std::vector<std::string> complaints(const std::vector<Row>& rows) {
  std::vector<std::string> lines;
  // Same integrator and h: the same bits, so the same error.
  std::map<std::tuple<const Quantity*, std::string, int, int>, double> first;
  for (const Row& row : rows) {
    if (row.engine->name != "psim") continue;
    const auto key = std::tuple(row.quantity, row.setting.integrator, row.setting.steps, row.setting.substeps);
    const auto [known, is_new] = first.emplace(key, row.error);
    if (!is_new && known->second != row.error) {
      std::ostringstream text;
      text << describe(row) << ", but " << known->second << " with the first variant";
      lines.push_back(text.str());
    }
    const Limit* limit = limit_of(row);
    if (is_new && limit && !(row.error <= limit->error)) {
      std::ostringstream text;
      text << describe(row) << ", limit " << limit->error;
      lines.push_back(text.str());
    }
  }
  return lines;
}

}  // namespace psim::accuracy
