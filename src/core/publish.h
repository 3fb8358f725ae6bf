// Publish: a picture of the world for a renderer on another thread, by id, with the frame before it
// for interpolation. Three buffers change hands without locks; a reader never waits and never sees
// a half-written frame.
#pragma once

#include <array>
#include <atomic>

#include "body_store.h"
#include "lattice.h"
#include "psim/world.h"
#include "sleepers.h"
#include "worker_pool.h"

namespace psim {

struct FixedBody {
  double x = 0, y = 0, angle = 0;
  float radius = 0;
  std::uint32_t id = 0;
  std::uint32_t first_shape = 0;
};

class Publisher {
 public:
  /// Notes where every body stands before a step: needed when the host added or moved some since
  /// the last one, so that x_prev is where the step found them.
  void look(const BodyStore& bodies, const std::vector<FixedBody>& fixed,
            const std::vector<BodyState>& frozen, const std::vector<Sleeper>& sleepers,
            const Lattice& lattice);
  /// Writes the next frame. `frozen` bodies keep their last row.
  void publish(const BodyStore& bodies, const std::vector<FixedBody>& fixed,
               const std::vector<BodyState>& frozen, const std::vector<Sleeper>& sleepers,
               const Lattice& lattice, std::uint64_t frame,
               WorkerPool& pool);
  /// Nobody looks any more: gives back all but the frame that the reader has. On the thread that publishes.
  void release();
  /// The newest complete frame, or nullptr. One reader.
  const Snapshot* latest();
  std::size_t bytes() const;

 private:
  static constexpr unsigned kFresh = 4;  // set in middle_: a frame the reader has not taken
  std::array<Snapshot, 3> frames_;
  unsigned back_ = 0;
  std::atomic<unsigned> middle_{1};
  unsigned front_ = 2;
  bool any_ = false;
  std::vector<float> last_x_, last_y_, last_angle_;  // by id, of the frame before
};

}  // namespace psim
