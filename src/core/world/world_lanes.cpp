// How full the blocks of the kernels are, counted in every 16th step if asked for. Most is known from the lists;
// O(bodies / 8 + joints), and for a 64th of the bodies where lists were made.
#include <bit>
#include <cstring>

#include "world/world_impl.h"

namespace psim {

void World::Impl::survey_lanes(const StepReport& report) {
  const std::uint32_t blocks = bodies.blocks();
  ledger.add_lanes(LaneUser::bodies, std::uint64_t{blocks} * kernels::kBlock, bodies.count - bodies.dead);
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
  const PairTable& lists = neighbours.found();
  if (report.rebuilt) {
    Ledger::Lanes& search = ledger.lanes_of(LaneUser::search);
    neighbours.broad.sample_lanes(lists.large_begin, search.all, search.used);
  }
  for (const Strip& s : lists.strips) {
    if (!neighbours.selects()) break;
    const std::uint64_t n = s.pair_end - s.pair_begin, width = kernels.width;
    ledger.add_lanes(LaneUser::selection, (n + width - 1) / width * width, n);
  }
  ledger.add_lanes(LaneUser::contacts, std::uint64_t{contacts.discs.pair_blocks()} * kernels::kBlock,
                   contacts.discs.pair_count());
  ledger.add_lanes(LaneUser::fixed_contacts, std::uint64_t{contacts.discs.static_blocks()} * kernels::kBlock,
                   contacts.discs.static_count());
  if (plan.manifolds) {
    std::uint64_t active = 0;
    for (std::size_t s = 0; s < contacts.manifolds.strips(); ++s) active += contacts.manifolds.active_of(s).size();
    ledger.add_lanes(LaneUser::manifolds, std::uint64_t{contacts.manifolds.blocks()} * kernels::kBlock, active);
    ledger.add_lanes(LaneUser::hulls, contacts.manifolds.batches().lanes, contacts.manifolds.batches().used);
  }
  if (plan.joints) {
    Ledger::Lanes& joined = ledger.lanes_of(LaneUser::joints);
    joints.count_lanes(joined.all, joined.used);
  }
}

void World::count_lane_use() {
  if (impl_->options.isa != Isa::scalar) impl_->ledger.survey_lanes();
}

std::vector<LaneUse> World::lane_use() const { return impl_->ledger.lane_use(); }

}  // namespace psim
