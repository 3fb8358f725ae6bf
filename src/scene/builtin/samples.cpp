// The tree of samples. BuiltinScene::description says what a scene is; here is what can be seen in it.
#include "builtin/samples.h"

#include <algorithm>

namespace psim {
namespace {

constexpr std::string_view kDiscs = "Discs", kStacks = "Stacks", kLoads = "Heavy on light",
                           kImpacts = "Impacts and gases", kJoints = "Joints", kCloth = "Ropes and cloth",
                           kMachines = "Machines", kShapes = "Shapes and compounds", kFields = "Fields",
                           kBenchmarks = "Benchmarks";

constexpr Sample kSamples[] = {
    {kDiscs, "discs", "Most discs fly freely and cost next to nothing: watch the frame time as they land."},
    {kDiscs, "pile", "Coloured by force, a disc bears more the deeper it lies."},
    {kDiscs, "rough-pile", "Compare pile: friction makes chains of force, with discs between them that bear little."},
    {kDiscs, "dam", "The column slumps and runs along the tank; friction stops it as a flat heap."},
    {kDiscs, "hourglass", "The stream stays equally strong while the filling sinks."},
    {kDiscs, "galton", "Each peg sends a disc left or right; the bins fill to a bell curve."},
    {kDiscs, "mixed-sizes", "The smallest discs trickle between large ones that are 50 times as wide."},

    {kStacks, "vertical_stack", "The stack stands, though each box lies 2 cm beside the one below."},
    {kStacks, "stack_100", "A hundred boxes stand on each other, and no swaying builds up."},
    {kStacks, "pyramid", "Nothing creeps: the boxes fall asleep where they were put."},
    {kStacks, "far_pyramid", "Compare pyramid: so far from the origin the boxes lie as still."},
    {kStacks, "card_house", "Cards of 2 mm lean on each other; friction alone holds the house up."},
    {kStacks, "arch", "The stones hold each other without joints; erase one and the arch falls."},
    {kStacks, "domino_run", "The wave of falling dominoes runs along the row at a steady speed."},

    {kLoads, "high_mass_ratio_1", "The tops land, and the light pyramids below them stand."},
    {kLoads, "high_mass_ratio_2",
     "The large box comes to rest on the small ones and does not press them into the floor."},
    {kLoads, "high_mass_ratio_3", "The large box comes to rest on the tips of two triangles."},
    {kLoads, "overlap_recovery", "The boxes push each other apart to a whole pyramid; none is thrown."},
    {kLoads, "ball_and_chain", "The chain keeps its length, though the ball weighs more than all links."},
    {kLoads, "boxes_into_discs", "The boxes plunge in; the bed of discs gives way and then bears them."},

    {kImpacts, "billiard", "Nothing slows down: the energy of the cue disc is shared and kept."},
    {kImpacts, "newtons_cradle", "One disc strikes and one swings out; those between them hardly move."},
    {kImpacts, "gas-periodic", "Who leaves on one side comes back on the other; no energy is lost."},
    {kImpacts, "smash", "The block ploughs through the wall; boxes that nothing has reached stand still."},

    {kJoints, "bridge", "The planks sag and swing as the discs land, but their pins stay closed."},
    {kJoints, "chain", "The free end whips round as the chain swings through."},
    {kJoints, "rain", "Joints with limits: no elbow and no knee bends the wrong way."},

    {kCloth, "rope", "The links keep their distance, however fast the rope swings."},
    {kCloth, "cloth",
     "The ball drops on the upper edge: a wave runs through the cloth, and its links keep their length."},
    {kCloth, "joint_grid", "The net hangs by seven discs and folds; 19,794 pins stay closed."},

    {kMachines, "tumbler", "The boxes climb with the wall and slide back, again and again."},
    {kMachines, "washer", "The paddles lift the boxes and drop them; colour by direction to see the streams."},
    {kMachines, "spinner", "The driven bar clears its way; what it throws runs round the ring."},

    {kShapes, "compounds", "The pairs of triangles hook into each other, and the heap holds steep sides."},
    {kShapes, "junkyard", "The blade pushes a wave of scrap before it and leaves the floor bare behind."},

    {kFields, "orbits", "The inner discs overtake the outer ones, as planets do."},
    {kFields, "rush", "Discs from all sides are packed into one round cluster."},

    {kBenchmarks, "million", "A million discs: compare the frame time with that of discs."},
    {kBenchmarks, "large_pyramid", "5,050 boxes: colour by force to see the load spread to the base."},
    {kBenchmarks, "many_pyramids", "400 pyramids fall asleep, and the frame time falls to almost nothing."},
};

}  // namespace

std::span<const Sample> samples() { return kSamples; }

std::string_view look_for(std::string_view scene) {
  const auto at = std::ranges::find(kSamples, scene, &Sample::scene);
  return at == std::end(kSamples) ? std::string_view() : at->look_for;
}

}  // namespace psim
