#include "step/step_table.h"

#include <algorithm>

#include "step/part_costs.h"
#include "step/step_parts.h"

namespace psim {
namespace {

namespace run = step_parts_run;
using namespace part_costs;

// ---- when a part applies
bool always(const StepContext&) { return true; }
bool lists_mended(const StepContext& c) {
  return !c.neighbours.stale && !c.neighbours.selects() && c.neighbours.renewal.any();
}
bool lists_made(const StepContext& c) { return c.neighbours.stale; }
bool pairs_selected(const StepContext& c) { return c.neighbours.selects(); }
bool laid_out(const StepContext& c) { return c.neighbours.stale || c.neighbours.selects(); }
bool loads_found(const StepContext& c) { return laid_out(c) && c.plan.loads; }
bool sorted_out(const StepContext& c) { return laid_out(c) && c.sorts_out(); }
bool shapes_move(const StepContext& c) { return c.plan.manifolds; }

// ---- how many pieces a part has
std::size_t one(const StepContext&) { return 1; }
std::size_t moves(const StepContext& c) { return c.neighbours.broad.moves(); }
std::size_t searches(const StepContext& c) { return c.neighbours.broad.searches(); }
std::size_t nears(const StepContext& c) { return c.neighbours.broad.nears(); }
std::size_t found_strips(const StepContext& c) { return c.neighbours.found().strips.size(); }
std::size_t strips(const StepContext& c) { return c.neighbours.table.strips.size(); }
std::size_t load_pieces(const StepContext& c) { return c.contacts.loads.pieces(); }
std::size_t looks(const StepContext& c) { return c.contacts.manifolds.look_pieces(); }

constexpr Stage kLists = Stage::broad_phase, kPairs = Stage::narrow_phase, kColours = Stage::colouring;

// clang-format off
constexpr StepPart kParts[] = {
    {"check", kLists, "do the lists serve?", "one",
     always, one, run::check, piece_check, whole_check},
    {"renew", kLists, "persistent lists: those of bodies that used up their margin", "one",
     lists_mended, one, run::renew, piece_renew, nothing},
    {"measure", kLists, "how new lists are made, how far bodies reach", "one",
     lists_made, one, run::measure, piece_measure, whole_measure},
    {"count", kLists, "the cells of bodies", "one",
     lists_made, one, run::count, piece_count, whole_count},
    {"move", kLists, "bodies in cell order", "4,096 bodies",
     lists_made, moves, run::move, piece_move, whole_move},
    {"search", kLists, "pairs of bodies that may meet while the lists last", "a strip, or 16 large bodies",
     lists_made, searches, run::search, piece_search, whole_search},
    {"near", kLists, "bodies near fixed shapes; which bodies take substeps", "a strip, or 32 bodies",
     lists_made, nears, run::near, piece_near, whole_near},
    {"select", kPairs, "lists with a selection: pairs that can meet in this step", "a strip",
     pairs_selected, found_strips, run::select, piece_select, whole_select},
    {"pack", kPairs, "closes up what was selected", "a strip",
     pairs_selected, found_strips, run::pack, piece_pack, whole_pack},
    {"group", kColours, "which bodies the solver has", "one",
     laid_out, one, run::group, piece_group, nothing},
    {"loads", kColours, "bodies under much heavier ones, where the plan asks", "a strip, for each pass",
     loads_found, load_pieces, run::loads, piece_loads, whole_loads},
    {"gather", kColours, "shapes, filters, joints: what is known of the manifolds of before", "one",
     sorted_out, one, run::gather, piece_gather, whole_gather},
    {"sort_out", kColours, "takes manifolds, and pairs that must not collide, out of the lists of discs", "a strip",
     sorted_out, strips, run::sort_out, piece_sort_out, whole_sort_out},
    {"keep", kColours, "gives manifolds what is known of them", "a strip",
     sorted_out, strips, run::keep, piece_keep, whole_keep},
    {"colour", kColours, "colours of contacts of discs", "a strip",
     laid_out, strips, run::colour, piece_colour, whole_colour},
    {"lay_out", kColours, "blocks of 8 lanes that share no body, with the impulses of before", "a strip",
     laid_out, strips, run::lay_out, piece_lay_out, whole_lay_out},
    {"look", kPairs, "shapes: who touches, where, how far apart", "some pairs of a strip",
     shapes_move, looks, run::look, piece_look, look_ns, true},
    {"stand", kPairs, "shapes: which bodies stand on each other one by one", "one",
     shapes_move, one, run::stand, piece_stand, whole_stand, true},
};
// clang-format on

}  // namespace

std::span<const StepPart> step_parts() { return kParts; }

std::uint8_t part_named(std::string_view name) {
  const auto* const found =
      std::find_if(std::begin(kParts), std::end(kParts), [&](const StepPart& p) { return p.name == name; });
  return static_cast<std::uint8_t>(found - std::begin(kParts));
}

std::uint8_t next_part(const StepContext& c, std::uint8_t row) {
  while (row < std::size(kParts) && !kParts[row].applies(c)) ++row;
  return row;
}

}  // namespace psim
