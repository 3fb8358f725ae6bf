// The report for programs. Numbers read back to the same bits; the state hash is text because many
// JSON readers hold numbers as doubles and would lose its low bits.
#include <nlohmann/json.hpp>

#include "options/about.h"
#include "output/text.h"
#include "psim/version.h"
#include "report/run_report.h"

namespace psim::cli {
namespace {

using Json = nlohmann::ordered_json;

// What is not known is null.
Json settings_json(const TargetSettings& settings) {
  return {{"integrator", integrator_name(settings.integrator)},
          {"substeps", settings.substeps},
          {"error", settings.error},
          {"ms_per_frame", settings.ms_per_frame}};
}

Json target_json(const Target& target) {
  Json json;
  json[target.of_time ? "ms" : "error"] = target.wanted;
  json["kind"] = scene_kind_name(target.traits.kind);
  json["because"] = target.traits.because;
  json["rate"] = target.traits.rate;
  json["measure"] = target.measure;
  json["chosen"] = settings_json(target.chosen);
  json["refused"] = target.refused ? settings_json(*target.refused) : Json();
  return json;
}

// What the run left out, and of each stage how often.
Json ledger_json(const RunReport& report) {
  Json json = {{"asleep_mean", report.per_frame(report.asleep_sum)},
               {"lists_kept_frames", report.lists_kept},
               {"lists_renewed_frames", report.frames_renewed},
               {"bodies_renewed", report.renewed_sum},
               {"pairs_reused_mean", report.per_frame(report.reused_sum)},
               {"fast_frames", report.fast_frames},
               {"fast_mean", report.per_frame(report.fast_sum)},
               {"substeps_saved", report.substeps_saved}};
  Json& stages = json["stages"] = Json::object();
  for (std::size_t k = 0; k < kSkipNames.size(); ++k) {
    stages[std::string(kSkipNames[k])] = {{"run", report.frame_ms.count() - report.frames_skipped[k]},
                                          {"skipped", report.frames_skipped[k]}};
  }
  return json;
}

Json profile_json(const Profile& profile) {
  Json json = {{"threads_busy", profile.busy()}, {"imbalance", profile.imbalance()}};
  const std::vector<Profile::Row> rows = profile.rows();
  if (!rows.empty()) json["bottleneck"] = rows[0].stage;
  for (const Profile::Row& row : rows) {
    json["stages"][std::string(row.stage)] = {{"mean", row.mean_ms},
                                              {"p99", row.p99_ms},
                                              {"share", row.share},
                                              {"threads_busy", row.busy},
                                              {"recent_mean", row.recent_mean_ms},
                                              {"recent_p99", row.recent_p99_ms}};
  }
  json["recent_frames"] = Profile::kRecent;
  Json& lanes = json["lanes"] = Json::object();
  for (const LaneUse& use : profile.lanes) {
    lanes[use.kernels] = {{"lanes", use.lanes}, {"used", use.used}};
  }
  return json;
}

Json fluid_json(const FluidReport& fluid) {
  return {{"particles", fluid.particles},
          {"kinetic", fluid.kinetic},
          {"density_error_mean", fluid.density_error_mean},
          {"density_error_max", fluid.density_error_max},
          {"iterations", fluid.iterations},
          {"emitted", fluid.emitted},
          {"drained", fluid.drained},
          {"withheld", fluid.withheld}};
}

Json governor_json(const RunReport& report) {
  return {{"frames_cut", report.frames_cut},
          {"frames_waited", report.frames_waited},
          {"substeps_saved", report.substeps_saved},
          {"frames_few_sweeps", report.frames_few_sweeps},
          {"frames_few_parts", report.frames_few_parts},
          {"frames_lost", report.frames_lost}};
}

}  // namespace

std::string report_json(const RunReport& report) {
  const Samples& frame = report.frame_ms;
  Json json;
  json["version"] = PSIM_VERSION_STRING;
  json["compiler"] = compiler_name();
  json["scene"] = report.scene;
  json["isa"] = isa_name(report.isa);
  json["lanes"] = isa_lanes(report.isa);
  json["threads"] = report.threads;
  json["frames"] = frame.count();
  json["dt"] = report.dt_s;
  json["substeps"] = report.substeps;
  json["seed"] = report.seed;
  json["bodies"] = {{"total", report.bodies_total},
                    {"dynamic", report.bodies_dynamic},
                    {"static", report.bodies_static},
                    {"awake", report.bodies_awake},
                    {"asleep", report.bodies_asleep}};
  if (report.target) json["target"] = target_json(*report.target);
  json["budget_ms"] = report.budget_ms;
  json["frames_over_budget"] = report.frames_over_budget;
  json["frame_ms"] = {{"mean", frame.mean()},
                      {"p50", frame.percentile(50)},
                      {"p95", frame.percentile(95)},
                      {"p99", frame.percentile(99)},
                      {"max", frame.max()}};
  Json& phases = json["phase_ms"] = Json::object();
  for (std::size_t i = 0; i < kPhaseCount; ++i) {
    const Samples& ms = report.phase_ms[i];
    phases[std::string(kPhases[i].key)] = {{"mean", ms.mean()}, {"p99", ms.percentile(99)}, {"max", ms.max()}};
  }
  json["counts"] = {{"pairs", report.per_frame(report.pairs_sum)},
                    {"contacts", report.per_frame(report.contacts_sum)},
                    {"colours", report.per_frame(report.colours_sum)},
                    {"neighbour_rebuilds", report.neighbour_rebuilds}};
  json["simd"] = {{"lanes_vector", report.lanes.vector}, {"lanes_scalar", report.lanes.scalar}};
  json["energy"] = {{"kinetic_start", report.start.kinetic},
                    {"potential_start", report.start.potential},
                    {"kinetic", report.end.kinetic},
                    {"potential", report.end.potential}};
  json["momentum"] = {{"x", report.end.momentum_x}, {"y", report.end.momentum_y}};
  if (report.fluid) json["fluid"] = fluid_json(*report.fluid);
  json["max_penetration"] = report.end.max_penetration;
  json["virial"] = report.virial;
  json["escaped"] = report.escaped;
  Json& skipped = json["skipped"] = Json::object();
  for (const auto& [stage, frames] : report.skipped) {
    if (frames > 0) skipped[stage] = frames;
  }
  json["ledger"] = ledger_json(report);
  if (report.profile) json["profile"] = profile_json(*report.profile);
  if (report.governed) json["governor"] = governor_json(report);
  json["memory_bytes"] = report.memory_bytes;
  json["state_hash"] = hash_text(report.state_hash);
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace psim::cli
