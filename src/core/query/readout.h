// What is read out of a world as a whole: its hash, its sums, its bodies as columns, and their places for a renderer.
// All go by id, so that neither slots nor threads show. O(ids).
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <vector>

#include "psim/world.h"
#include "query/observed.h"

namespace psim {

std::uint64_t state_hash(const Observed& world);

/// Energy, momentum and angular momentum of all dynamic bodies.
Diagnostics sum_motion(const Observed& world);

/// The memory behind World::published.
class PublishedColumns {
 public:
  PublishedState fill(const Observed& world);
  std::size_t bytes() const { return id_.capacity() * (4 + 1 + 7 * 8); }

 private:
  std::vector<std::uint32_t> id_;
  std::vector<double> x_, y_, angle_, vx_, vy_, omega_, radius_;
  std::vector<BodyType> type_;
};

/// Publishes the places of all bodies for a renderer on another thread: by id, with the frame before for interpolation.
/// Three buffers change hands without locks, so that a reader never waits and never sees a half-written frame.
class Publisher {
 public:
  /// Notes where every body stands before a step. Needed if the host added or moved bodies since the last step, so that
  /// x_prev is where the step found them.
  void look(const Observed& world);
  /// Writes the next frame. Frozen bodies keep their last row.
  void publish(const Observed& world, std::uint64_t frame);
  /// Gives back all memory but the frame that the reader has. Runs on the thread that publishes.
  void release();
  /// The newest complete frame, or nullptr. There is one reader.
  const Snapshot* latest();
  std::size_t bytes() const;

 private:
  static constexpr unsigned kFresh = 4;  // set in middle_: a frame the reader has not taken
  // The buffer in the middle changes hands by an exchange with acquire and release on both sides: release, so that the
  // other thread sees the frame that was written, or has been read to its end; acquire, to see the same of the buffer
  // that comes back. back_ belongs to the writer, front_ to the reader. The reader's first look is relaxed, because
  // nothing but the exchange that follows gives it a buffer.
  std::array<Snapshot, 3> frames_;
  unsigned back_ = 0;
  std::atomic<unsigned> middle_{1};
  unsigned front_ = 2;
  struct Row {
    float x = 0, y = 0, angle = 0, speed = 0;  // m from the lattice centre, radians, m/s
  };
  static Row row_of(std::uint32_t id, const Observed& world);
  std::vector<Row> last_;  // by id: the frame before
};

}  // namespace psim
