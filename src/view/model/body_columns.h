// What the bodies of a picture are drawn from: a snapshot, their looks by row, and the scale of the
// colours. All that the CPU does for a body in a frame is here: one look-up.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "model/catalogue.h"
#include "psim/world.h"

namespace psim::view {

inline constexpr int kColouringCount = 9;
enum class Colouring : std::uint8_t { speed, direction, sleep, spin, body, type, force, strip, solver };
inline constexpr const char* kColouringNames[] = {"speed", "direction", "sleep", "spin",  "body",
                                                  "type",  "force",     "strip", "solver"};
/// Of a body in no strip, or without contacts.
inline constexpr float kNoGroup = -1;

class BodyColumns {
 public:
  /// Reads a snapshot, which must live as long as this is drawn from. O(bodies), about 1 ns each.
  void set(const Snapshot& snapshot, std::shared_ptr<const Catalogue> catalogue);
  /// What contacts press each body with, N, by id; those beyond it touch nothing.
  void set_forces(const std::vector<float>& by_id);
  /// Strips, or colours of the solver, by id; those beyond it have none.
  void set_groups(const std::vector<float>& by_id);

  /// Rows that are not hidden.
  std::size_t seen() const { return size() - hidden_; }
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

  /// N, by row; empty where nobody asked.
  const std::vector<float>& forces() const { return forces_; }
  /// Strips or colours of the solver, by row; empty where nobody asked.
  const std::vector<float>& groups() const { return groups_; }

  /// What gets the brightest colour: nearly the most, so that one stray body does not leave the
  /// rest in the dark, m/s, radians a frame or N. Follows slowly, so that nothing flickers.
  float bright(Colouring colouring) const;

 private:
  void follow_brightness();
  template <class Value>
  float sample(const Value& value);

  const Snapshot* snapshot_ = nullptr;
  std::shared_ptr<const Catalogue> catalogue_;
  std::vector<std::uint32_t> looks_;  // by row
  std::size_t hidden_ = 0;
  std::vector<std::uint32_t> line_rows_;
  std::vector<float> sample_;
  std::vector<float> forces_, groups_;  // by row
  float bright_speed_ = 0, bright_spin_ = 0, bright_force_ = 0;
};

}  // namespace psim::view
