// Descriptions of bodies as the host gives them: what is refused, and the properties that a body gets.
#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "bodies/body_properties.h"
#include "bodies/hull.h"
#include "bodies/static_shapes.h"
#include "psim/desc.h"

namespace psim {

inline bool finite(double v) { return std::isfinite(v); }
inline bool finite(Vec2 v) { return finite(v.x) && finite(v.y); }

/// One line that says what is wrong with a description, or nothing. Shapes other than discs are checked when their
/// hulls are made (make_hulls).
std::string check(const BodyDesc& desc, const Bounds& bounds);
std::string check(const BodyTraits& traits, BodyType type);
std::string check(const PartTraits& traits);
std::string check(const DiscBatch& batch, const Bounds& bounds);

/// Adds bodies to a World or a Recorder in their order, until one is refused. Returns how many.
template <class Adder>
std::size_t add_in_order(Adder& to, std::span<const BodyDesc> descs, std::span<BodyId> ids, std::string& error) {
  error.clear();
  if (ids.size() != descs.size()) {
    error = "there must be as much room for handles as there are descriptions";
    return 0;
  }
  std::size_t added = 0;
  for (; added < descs.size(); ++added) {
    ids[added] = to.add_body(descs[added], error);
    if (ids[added] == kNoBody) break;
  }
  return added;
}

/// One disc of a batch.
BodyDesc disc_of(const DiscBatch& batch, std::size_t i);

/// What a part has that is made of this.
PartProperties properties_of_part(const Material& material, const Filter& filter, bool sensor, Vec2 one_way,
                                  bool pre_solve);
/// Returns what a part of a compound has: its own, and what the body has where it has none.
PartProperties part_properties(const ShapePart& part, const BodyDesc& body);

/// A body on its way into the tables. `own`: what its parts have, if they differ; the hulls come last.
struct NewBody {
  BodyProperties properties;
  BodyKind kind;
  std::vector<Hull> hulls;
  std::vector<PartProperties> own;
};

/// Gives a body the filter, sensor flag and surface that its parts share. If they differ, or have what only the PartTable
/// keeps, `own` becomes what each has, and the body gets the largest restitution and friction of all.
void share_properties(std::vector<PartProperties> parts, NewBody& body);

/// Turns the directions of sides that are solid. Those of static bodies are kept in world axes.
void turn_one_way(std::span<PartProperties> parts, double angle);

/// Fills in a moving body. Of one that is no disc it makes the hulls, about its centre of mass. A kinematic body turns
/// about its place, but the engine also finds and meets it by its centre, which goes round (Population::go_round). False,
/// with a line in `error`, if the shape is refused.
bool make_moving(const BodyDesc& desc, NewBody& body, std::string& error);
/// Fills in a static body, and makes its pieces.
bool make_static(const BodyDesc& desc, const Lattice& lattice, NewBody& body, std::vector<Piece>& pieces,
                 std::string& error);

}  // namespace psim
