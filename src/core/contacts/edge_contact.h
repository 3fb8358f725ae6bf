// The contact of a disc with a segment, or with an edge of a polygon. The disc meets the face of the edge or one of its
// ends, and which of them may change within a step. What lies beyond an end decides about it:
//
//   nothing                      the end is round
//   an edge that falls away      the end is round between the two edges, then the other edge has the disc
//   an edge that goes straight   the other edge has the disc
//   an edge that rises           the line of the face holds on, so that a disc that comes along the other edge meets
//                                the face in time
//
// So a disc goes over a line of edges as over one smooth shape, whichever way and in whichever order they are listed.
#pragma once

#include <cstdint>

#include <vector>

#include "bodies/static_shapes.h"
#include "contacts/contact_lanes.h"
#include "psim/types.h"

namespace psim {

/// What lies beyond an end of an edge: another edge, which starts there.
struct EdgeCorner {
  float cos = 0, sin = 0;      ///< its direction against that of this edge; sin > 0: it rises on the disc's side
  float length = 0;            ///< m; 0: there is none
  bool other_has_end = false;  ///< the contact of the other edge has the round end
};

/// An edge as a disc sees it from its place at the start of the step.
struct Edge {
  Vec2 along;                 ///< unit vector, with the disc on its left
  double height = 0;          ///< m: of the centre over the line
  double begin = 0, end = 0;  ///< m: the two ends, along the line from the foot of the centre
  double radius = 0;          ///< m: of the disc, and around the edge
  EdgeCorner before, after;
};

/// What a disc meets: a face (normal and gap stay while it moves), a round end, or nothing.
struct EdgeContact {
  enum Kind : std::uint8_t { nothing, face, round };
  Kind kind = nothing;
  Vec2 normal;
  double gap = 0;  ///< m: at the start of the step, along this normal
  Vec2 base;       ///< m: from the round end to the centre at the start of the step
};

/// What a disc meets that went by `moved` since the start of the step, and goes on by `way`: the face, if it comes down on
/// it, else what there is after the share `middle` of the way.
EdgeContact meet_edge(const Edge& edge, Vec2 moved, Vec2 way, double middle);

/// Writes a contact into its lane.
void put_edge(const EdgeContact& contact, StaticLanes& c, std::uint32_t at);

/// An edge near a disc. Vectors lead from the centre of the disc.
struct NearEdge {
  std::uint32_t lane = 0;
  const StaticShape* shape = nullptr;
  Vec2 p, q;
  Edge edge;
  EdgeContact contact;
  Vec2 old_normal;
  bool loose = false;
};

/// An edge whose contact may change within the step.
struct LooseEdge {
  std::uint32_t lane = 0;
  Edge edge;
};

/// The edges of a strip, and those near one disc at a time.
struct StripEdges {
  std::vector<LooseEdge> loose;
  std::vector<NearEdge> near;
};

}  // namespace psim
