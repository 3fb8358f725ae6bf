#include "step/ledger.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <iterator>

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
  skipped_ = ((1u << kSkipNames.size()) - 1) & ~bit(Skip::fluid);
  if (but_publish) skipped_ &= ~bit(Skip::publish);
  if (but_events) skipped_ &= ~bit(Skip::events);
}

void Ledger::end_step(const MemoryMeter& memory, StepReport& report) {
  if (report.rebuilt) skipped_ &= ~(bit(Skip::broad_phase) | bit(Skip::colouring));
  for (std::size_t k = 0; k < skipped_steps_.size(); ++k) skipped_steps_[k] += (skipped_ >> k) & 1;
  report.skipped = skipped_;
  report.arena_growths = memory.growths - growths_before_;
}

std::vector<std::pair<std::string, std::uint64_t>> Ledger::skipped() const {
  std::vector<std::pair<std::string, std::uint64_t>> out;
  for (std::size_t k = 0; k < skipped_steps_.size(); ++k) {
    if (skipped_steps_[k] != 0) out.emplace_back(kSkipNames[k], skipped_steps_[k]);
  }
  return out;
}

void Ledger::add_lanes(std::string_view user, std::uint64_t lanes, std::uint64_t used) {
  auto use = std::find_if(use_.begin(), use_.end(), [&](const LaneUse& of) { return of.kernels == user; });
  if (use == use_.end()) use = use_.insert(use, {std::string(user)});
  use->lanes += lanes;
  use->used += used;
}

std::vector<LaneUse> Ledger::lane_use() const {
  std::vector<LaneUse> out;
  std::copy_if(use_.begin(), use_.end(), std::back_inserter(out), [](const LaneUse& use) { return use.lanes != 0; });
  return out;
}

// Most is known from the lists; O(bodies / 8 + joints), and for a 64th of the bodies where lists were made.
void survey_lanes(StepContext& c, bool rebuilt) {
  const auto add_blocks = [&c](std::string_view user, std::uint64_t blocks, std::uint64_t used) {
    c.ledger.add_lanes(user, blocks * kernels::kBlock, used);
  };
  const BodyStore& bodies = c.bodies;
  const Contacts& contacts = c.contacts;
  const Manifolds& manifolds = contacts.manifolds;
  add_blocks("bodies", bodies.blocks(), bodies.awake());
  if (contacts.solved.compact()) {
    add_blocks("substeps", contacts.solved.blocks(), contacts.solved.count());
  } else {  // blocks of which nobody is linked are passed over
    std::uint64_t some = 0, bits = 0;
    for (std::uint32_t block = 0; block < bodies.blocks(); ++block) {
      std::uint64_t eight;
      std::memcpy(&eight, bodies.linked.data() + std::size_t{block} * kernels::kBlock, sizeof eight);
      some += eight != 0;
      bits += static_cast<std::uint64_t>(std::popcount(eight));
    }
    add_blocks("substeps", some, bits / 8);
  }
  const PairTable& lists = c.neighbours.found();
  std::uint64_t all = 0, used = 0;
  if (rebuilt) c.neighbours.broad.cells().sample_lanes(all, used);
  c.ledger.add_lanes("pair search", all, used);
  all = used = 0;
  for (const Strip& s : lists.strips) {
    if (!c.neighbours.selects()) break;
    const std::uint64_t n = s.pair_end - s.pair_begin, width = c.kernels.width;
    all += (n + width - 1) / width * width;
    used += n;
  }
  c.ledger.add_lanes("pair selection", all, used);
  add_blocks("contacts", contacts.discs.pairs.blocks, contacts.discs.pairs.count);
  add_blocks("fixed contacts", contacts.discs.fixed.blocks, contacts.discs.fixed.count);
  const Manifolds::Looks hulls = c.plan.manifolds ? manifolds.looks() : Manifolds::Looks{};
  std::uint64_t active = 0;
  for (std::size_t s = 0; s < manifolds.strip_count(); ++s) active += manifolds.strip(s).active.size();
  add_blocks("manifolds", manifolds.totals().blocks, active);
  c.ledger.add_lanes("hulls", hulls.lanes, hulls.used);
  all = used = 0;
  if (c.plan.joints) c.joints.count_lanes(all, used);
  c.ledger.add_lanes("joints", all, used);
}

}  // namespace psim
