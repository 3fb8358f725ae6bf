// The CSV files: state, of bodies and of fluids, metrics, trajectory. Numbers in the shortest form that reads back to the
// same bits; rows by id. About 0.4 us a body row.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "output/atomic_file.h"
#include "psim/report.h"
#include "psim/world.h"

namespace psim::cli {

inline constexpr std::string_view kStateHeader = "id,x,y,angle,vx,vy,omega";
inline constexpr std::string_view kParticleHeader = "id,x,y,vx,vy,density,pressure";
inline constexpr std::string_view kTrajectoryHeader = "frame,id,x,y,angle,vx,vy,omega";

/// kStateHeader and a row a body.
void write_state(AtomicFile& file, const PublishedState& state);

/// kParticleHeader and a row a particle of a fluid.
void write_particles(AtomicFile& file, const std::vector<FluidParticleState>& particles);

/// The columns are in docs/performance.md.
void write_metrics_header(AtomicFile& file);
void write_metrics_row(AtomicFile& file, std::uint64_t frame, double total_ms, const StepReport& report,
                       std::uint64_t substeps_saved, std::uint64_t page_faults, const Diagnostics& diagnostics);

/// kTrajectoryHeader, then a row a body every frame that is written.
void write_trajectory_header(AtomicFile& file);
void write_trajectory_rows(AtomicFile& file, std::uint64_t frame, const PublishedState& state);

}  // namespace psim::cli
