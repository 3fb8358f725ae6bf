// Publishes the places of all bodies for a renderer on another thread: by id, with the frame before for
// interpolation. Three buffers change hands without locks, so that a reader never waits and never sees a
// half-written frame.
#pragma once

#include <array>
#include <atomic>

#include "base/lattice.h"
#include "base/worker_pool.h"
#include "bodies/body_store.h"
#include "bodies/static_shapes.h"
#include "psim/world.h"
#include "sleep/sleepers.h"

namespace psim {

class Publisher {
 public:
  /// Notes where every body stands before a step. Needed if the host added or moved bodies since the last step, so that
  /// x_prev is where the step found them.
  void look(const BodyStore& bodies, const std::vector<FixedBody>& fixed, const std::vector<BodyState>& frozen,
            const std::vector<Sleeper>& sleepers, const Lattice& lattice);
  /// Writes the next frame. Frozen bodies keep their last row.
  void publish(const BodyStore& bodies, const std::vector<FixedBody>& fixed, const std::vector<BodyState>& frozen,
               const std::vector<Sleeper>& sleepers, const Lattice& lattice, std::uint64_t frame, WorkerPool& pool);
  /// Gives back all memory but the frame that the reader has. Runs on the thread that publishes.
  void release();
  /// The newest complete frame, or nullptr. There is one reader.
  const Snapshot* latest();
  std::size_t bytes() const;

 private:
  static constexpr unsigned kFresh = 4;  // set in middle_: a frame the reader has not taken
  std::array<Snapshot, 3> frames_;
  unsigned back_ = 0;
  std::atomic<unsigned> middle_{1};
  unsigned front_ = 2;
  bool any_ = false;
  std::vector<float> last_x_, last_y_, last_angle_;  // by id: the rows of the frame before
};

}  // namespace psim
