#include "step/ledger.h"

#include <bit>
#include <cstring>

#include "step/step_context.h"

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

// Most is known from the lists; O(bodies / 8 + joints), and for a 64th of the bodies where lists were made.
void survey_lanes(const StepContext& c, bool rebuilt) {
  Ledger& ledger = c.ledger;
  const BodyStore& bodies = c.bodies;
  const Contacts& contacts = c.contacts;
  const std::uint32_t blocks = bodies.blocks();
  ledger.add_lanes(LaneUser::bodies, std::uint64_t{blocks} * kernels::kBlock, bodies.awake());
  if (contacts.solved.compact()) {
    ledger.add_lanes(LaneUser::substeps, std::uint64_t{contacts.solved.blocks()} * kernels::kBlock,
                     contacts.solved.count());
  } else {  // blocks of which nobody is linked are passed over
    std::uint64_t some = 0, bits = 0;
    for (std::uint32_t block = 0; block < blocks; ++block) {
      std::uint64_t eight;
      std::memcpy(&eight, bodies.linked.data() + std::size_t{block} * kernels::kBlock, sizeof eight);
      some += eight != 0;
      bits += static_cast<std::uint64_t>(std::popcount(eight));
    }
    ledger.add_lanes(LaneUser::substeps, some * kernels::kBlock, bits / 8);
  }
  const PairTable& lists = c.neighbours.found();
  if (rebuilt) {
    Ledger::Lanes& search = ledger.lanes_of(LaneUser::search);
    c.neighbours.broad.cells().sample_lanes(search.all, search.used);
  }
  for (const Strip& s : lists.strips) {
    if (!c.neighbours.selects()) break;
    const std::uint64_t n = s.pair_end - s.pair_begin, width = c.kernels.width;
    ledger.add_lanes(LaneUser::selection, (n + width - 1) / width * width, n);
  }
  ledger.add_lanes(LaneUser::contacts, std::uint64_t{contacts.discs.pair_blocks()} * kernels::kBlock,
                   contacts.discs.pair_count());
  ledger.add_lanes(LaneUser::fixed_contacts, std::uint64_t{contacts.discs.static_blocks()} * kernels::kBlock,
                   contacts.discs.static_count());
  if (c.plan.manifolds) {
    std::uint64_t active = 0;
    for (std::size_t s = 0; s < contacts.manifolds.strips(); ++s) active += contacts.manifolds.active_of(s).size();
    ledger.add_lanes(LaneUser::manifolds, std::uint64_t{contacts.manifolds.blocks()} * kernels::kBlock, active);
    ledger.add_lanes(LaneUser::hulls, contacts.manifolds.batches().lanes, contacts.manifolds.batches().used);
  }
  if (c.plan.joints) {
    Ledger::Lanes& joined = ledger.lanes_of(LaneUser::joints);
    c.joints.count_lanes(joined.all, joined.used);
  }
}

}  // namespace psim
