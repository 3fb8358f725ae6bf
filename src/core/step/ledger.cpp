#include "step/ledger.h"

namespace psim {
namespace {

constexpr std::uint32_t bit(Skip what) { return 1u << static_cast<unsigned>(what); }

}  // namespace

void Ledger::begin_step(const MemoryMeter& memory) {
  skipped_ = 0;
  growths_before_ = memory.growths;
}

void Ledger::skip_all(bool but_publish, bool but_events) {
  skipped_ = (1u << kSkipNames.size()) - 1;
  if (but_publish) skipped_ &= ~bit(Skip::publish);
  if (but_events) skipped_ &= ~bit(Skip::events);
}

void Ledger::end_step(const MemoryMeter& memory, StepReport& report) {
  if (report.rebuilt) skipped_ &= ~(bit(Skip::broad_phase) | bit(Skip::colouring));
  for (std::size_t k = 0; k < skipped_steps_.size(); ++k) skipped_steps_[k] += (skipped_ >> k) & 1;
  report.skipped = skipped_;
  report.arena_growths = memory.growths - growths_before_;
}

std::vector<LaneUse> Ledger::lane_use() const {
  std::vector<LaneUse> out;
  for (std::size_t k = 0; k < use_.size(); ++k) {
    if (use_[k].all != 0) out.push_back({std::string(kLaneUserNames[k]), use_[k].all, use_[k].used});
  }
  return out;
}

}  // namespace psim
