#include "report/csv.h"

#include "report/phases.h"

namespace psim::cli {
namespace {

void write_field(AtomicFile& file, auto value) {
  file.write(",");
  file.write_number(value);
}

void write_body(AtomicFile& file, const PublishedState& state, std::size_t row) {
  file.write_number(state.id[row]);
  write_field(file, state.x[row]);
  write_field(file, state.y[row]);
  write_field(file, state.angle[row]);
  write_field(file, state.vx[row]);
  write_field(file, state.vy[row]);
  write_field(file, state.omega[row]);
  file.write("\n");
}

}  // namespace

void write_state(AtomicFile& file, const PublishedState& state) {
  file.write(kStateHeader);
  file.write("\n");
  for (std::size_t row = 0; row < state.id.size(); ++row) write_body(file, state, row);
}

void write_particles(AtomicFile& file, const std::vector<FluidParticleState>& particles) {
  file.write(kParticleHeader);
  file.write("\n");
  for (const FluidParticleState& p : particles) {
    file.write_number(p.id);
    for (const double value : {p.position.x, p.position.y, p.velocity.x, p.velocity.y, p.density, p.pressure}) {
      write_field(file, value);
    }
    file.write("\n");
  }
}

void write_metrics_header(AtomicFile& file) {
  file.write("frame,total_ms");
  for (const Phase& phase : kPhases) {
    file.write(",");
    file.write(phase.key);
    file.write("_ms");
  }
  file.write(",pairs,contacts,awake,kinetic,potential,max_penetration,");
  file.write("asleep,pairs_reused,rebuilt,substeps,waited,predicted_ms,substeps_saved,fast,stopped");
  for (const std::string_view name : kSkipNames) {
    file.write(",skipped_");
    for (const char c : name) file.write(std::string_view(c == '.' ? "_" : &c, 1));
  }
  file.write(",most_sweeps,renewed,page_faults");
  file.write("\n");
}

void write_metrics_row(AtomicFile& file, std::uint64_t frame, double total_ms, const StepReport& report,
                       std::uint64_t substeps_saved, std::uint64_t page_faults, const Diagnostics& diagnostics) {
  file.write_number(frame);
  write_field(file, total_ms);
  for (const double ms : phase_ms(report)) write_field(file, ms);
  write_field(file, report.pairs);
  write_field(file, report.contacts);
  write_field(file, report.awake);
  write_field(file, diagnostics.kinetic);
  write_field(file, diagnostics.potential);
  write_field(file, diagnostics.max_penetration);
  write_field(file, report.asleep);
  write_field(file, report.pairs_reused);
  write_field(file, static_cast<std::uint64_t>(report.rebuilt));
  write_field(file, static_cast<std::uint64_t>(report.detail.substeps));
  write_field(file, static_cast<std::uint64_t>(report.detail.waits()));
  write_field(file, report.predicted_ms);
  write_field(file, substeps_saved);
  write_field(file, static_cast<std::uint64_t>(report.fast));
  write_field(file, static_cast<std::uint64_t>(report.stopped));
  for (std::size_t k = 0; k < kSkipNames.size(); ++k) {
    write_field(file, static_cast<std::uint64_t>(report.skipped >> k & 1));
  }
  write_field(file, static_cast<std::uint64_t>(report.detail.sweeps));
  write_field(file, static_cast<std::uint64_t>(report.renewed));
  write_field(file, page_faults);
  file.write("\n");
}

void write_trajectory_header(AtomicFile& file) {
  file.write(kTrajectoryHeader);
  file.write("\n");
}

void write_trajectory_rows(AtomicFile& file, std::uint64_t frame, const PublishedState& state) {
  for (std::size_t row = 0; row < state.id.size(); ++row) {
    file.write_number(frame);
    file.write(",");
    write_body(file, state, row);
  }
}

}  // namespace psim::cli
