// What the bodies of a picture are drawn from: a snapshot, their looks by row, and the scale of the
// colours. All that the CPU does for a body in a frame is here: one look-up.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "catalogue.h"
#include "psim/world.h"

namespace psim::view {

inline constexpr int kColouringCount = 6;
enum class Colouring : std::uint8_t { speed, direction, sleep, spin, body, type };
inline constexpr const char* kColouringNames[] = {"speed", "direction", "sleep",
                                                  "spin",  "body",      "type"};

class BodyColumns {
 public:
  /// Reads a snapshot, which must live as long as this is drawn from. O(bodies), about 1 ns each.
  void set(const Snapshot& snapshot, std::shared_ptr<const Catalogue> catalogue);

  std::size_t size() const { return snapshot_ != nullptr ? snapshot_->id.size() : 0; }
  const Snapshot* snapshot() const { return snapshot_; }
  const std::shared_ptr<const Catalogue>& catalogue() const { return catalogue_; }
  const std::vector<std::uint32_t>& looks() const { return looks_; }
  /// Rows of segments and chains.
  const std::vector<std::uint32_t>& line_rows() const { return line_rows_; }

  /// The row of a body; size() if it has none.
  std::size_t row_of(std::uint32_t id) const;
  /// Where a body is drawn.
  Vec2 place(std::size_t row, float alpha) const;
  double angle(std::size_t row, float alpha) const;

  /// What gets the brightest colour: nearly the fastest, so that one stray body does not leave the
  /// rest in the dark, m/s or radians a frame. Follows slowly, so that nothing flickers.
  float bright(Colouring colouring) const;

 private:
  void follow_brightness();

  const Snapshot* snapshot_ = nullptr;
  std::shared_ptr<const Catalogue> catalogue_;
  std::vector<std::uint32_t> looks_;  // by row
  std::vector<std::uint32_t> line_rows_;
  std::vector<float> sample_;
  float bright_speed_ = 0, bright_spin_ = 0;
};

}  // namespace psim::view
