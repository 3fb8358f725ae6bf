// Lines over and under the bodies: the world's sides, grid, segments and chains, joints, contacts,
// hits, trails. Reads what the view holds, writes two batches of lines.
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "model/body_columns.h"
#include "model/camera.h"
#include "model/history.h"
#include "model/simulation.h"
#include "window/line_batch.h"

namespace psim::view {

struct OverlayChoice {
  bool grid = false, joints = true, contacts = false, hits = false, trails = false;
};

/// 0xAABBGGRR of a strip or a colour of the solver: numbers side by side have hues far apart, as in the shaders.
std::uint32_t group_rgba(std::uint32_t group);

class Overlays {
 public:
  /// Called once for a new frame of the simulation: hits stay for a moment.
  void note(const Status& status);
  void clear() { recent_.clear(); }

  void build(const Status& status, const BodyColumns& bodies, const Camera& camera, float alpha, const History& history,
             std::size_t back, const OverlayChoice& choice, Colouring colouring);

  LineBatch below, above;

 private:
  struct Hit {
    HitEvent event;
    std::uint64_t frame = 0;
  };

  void add_world(const WorldDesc& world, const Camera& camera, bool grid);
  void add_wells(const std::vector<Vec2>& wells, const Camera& camera);
  void add_line_bodies(const BodyColumns& bodies, float alpha);
  void add_joints(const std::vector<JointLook>& joints, const WorldDesc& world, const BodyColumns& bodies, float alpha);
  void add_contacts(const std::vector<ContactLook>& contacts, const BodyColumns& bodies, const Camera& camera,
                    float alpha, bool by_colour);
  void add_hits(const BodyColumns& bodies, const Camera& camera, std::uint64_t frame);
  void add_trails(const History& history, std::size_t back, const WorldDesc& world, const BodyColumns& bodies);

  std::deque<Hit> recent_;
};

}  // namespace psim::view
