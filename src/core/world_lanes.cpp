// How full the blocks of the kernels are, counted in every 16th step if asked for. Most is known from the lists;
// O(bodies / 8 + joints), and for a 64th of the bodies where lists were made.
#include <bit>
#include <cstring>

#include "world_impl.h"

namespace psim {
namespace {

constexpr std::array<std::string_view, 9> kLaneNames = {
    "bodies", "substeps", "pair search", "pair selection", "contacts", "fixed contacts", "manifolds", "hulls", "joints"};

}  // namespace

void World::Impl::count_lanes(const StepReport& report) {
  const auto add = [this](LaneKernels kernels_of, std::uint64_t all, std::uint64_t used) {
    lane_use[kernels_of].lanes += all;
    lane_use[kernels_of].used += used;
  };
  const std::uint32_t blocks = bodies.blocks();
  add(kBodies, std::uint64_t{blocks} * kernels::kBlock, bodies.count - bodies.dead);
  if (solved.compact()) {
    add(kSubsteps, std::uint64_t{solved.blocks()} * kernels::kBlock, solved.count());
  } else {  // blocks of which nobody is linked are passed over
    std::uint64_t some = 0, bits = 0;
    for (std::uint32_t block = 0; block < blocks; ++block) {
      std::uint64_t eight;
      std::memcpy(&eight, bodies.linked.data() + std::size_t{block} * kernels::kBlock, sizeof eight);
      some += eight != 0;
      bits += static_cast<std::uint64_t>(std::popcount(eight));
    }
    add(kSubsteps, some * kernels::kBlock, bits / 8);
  }
  const PairTable& lists = loose ? candidates : table;
  if (report.rebuilt) broad.sample_lanes(bodies, lists.large_begin, lane_use[kSearch].lanes, lane_use[kSearch].used);
  for (const Strip& s : lists.strips) {
    if (!loose) break;
    const std::uint64_t n = s.pair_end - s.pair_begin, width = kernels.width;
    add(kSelection, (n + width - 1) / width * width, n);
  }
  add(kContacts, std::uint64_t{contacts.pair_blocks()} * kernels::kBlock, contacts.pair_count());
  add(kFixed, std::uint64_t{contacts.single_blocks()} * kernels::kBlock, contacts.single_count());
  if (plan.shapes) {
    std::uint64_t active = 0;
    for (std::size_t s = 0; s < manifolds.strips(); ++s) active += manifolds.active_of(s).size();
    add(kManifolds, std::uint64_t{manifolds.blocks()} * kernels::kBlock, active);
    add(kHulls, manifolds.batches().lanes, manifolds.batches().used);
  }
  if (plan.joints) joints.count_lanes(lane_use[kJoints].lanes, lane_use[kJoints].used);
}

void World::count_lane_use() { impl_->counting_lanes = impl_->options.isa != Isa::scalar; }

std::vector<LaneUse> World::lane_use() const {
  static_assert(kLaneNames.size() == Impl::kLaneKernels);
  std::vector<LaneUse> out;
  for (std::size_t k = 0; k < kLaneNames.size(); ++k) {
    const Impl::Lanes& use = impl_->lane_use[k];
    if (use.lanes != 0) out.push_back({std::string(kLaneNames[k]), use.lanes, use.used});
  }
  return out;
}

}  // namespace psim
