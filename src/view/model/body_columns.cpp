#include "model/body_columns.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace psim::view {
namespace {

constexpr float kLeastSpeed = 0.05f;   // m/s: a pile at rest looks at rest
constexpr float kLeastSpin = 0.002f;   // rad a frame
constexpr float kLeastForce = 1e-30f;  // N: what carries anything is seen, however light
constexpr float kFollow = 0.1f;

float percentile(std::vector<float>& values) {
  constexpr double kShare = 0.98;
  if (values.empty()) return 0;
  const auto at = static_cast<std::ptrdiff_t>(kShare * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  const float value = values[static_cast<std::size_t>(at)];
  return std::isfinite(value) ? value : 0;
}

void follow(float& bright, float now, float least) {
  now = std::max(now, least);
  bright = bright > 0 ? bright + kFollow * (now - bright) : now;
}

}  // namespace

void BodyColumns::set(const Snapshot& snapshot, std::shared_ptr<const Catalogue> catalogue) {
  snapshot_ = &snapshot;
  catalogue_ = std::move(catalogue);
  const std::size_t n = snapshot.id.size();
  looks_.resize(n);
  for (std::size_t row = 0; row < n; ++row) looks_[row] = catalogue_->look(snapshot.id[row]);
  hidden_ = static_cast<std::size_t>(
      std::ranges::count_if(looks_, [this](std::uint32_t look) { return catalogue_->hidden(look); }));
  line_rows_.clear();
  if (catalogue_->has_lines()) {
    for (std::size_t row = 0; row < n; ++row) {
      if (catalogue_->kinds()[looks_[row] & kKindMask].line) {
        line_rows_.push_back(static_cast<std::uint32_t>(row));
      }
    }
  }
  forces_.clear();
  groups_.clear();
  follow_brightness();
}

void BodyColumns::set_forces(const std::vector<float>& by_id) {
  forces_.assign(size(), 0.0f);
  for (std::size_t row = 0; row < size(); ++row) {
    const std::uint32_t id = snapshot_->id[row];
    if (id < by_id.size()) forces_[row] = by_id[id];
  }
  follow(bright_force_, sample([&](std::size_t row) { return forces_[row]; }), kLeastForce);
}

void BodyColumns::set_groups(const std::vector<float>& by_id) {
  groups_.assign(size(), kNoGroup);
  for (std::size_t row = 0; row < size(); ++row) {
    const std::uint32_t id = snapshot_->id[row];
    if (id < by_id.size()) groups_[row] = by_id[id];
  }
}

template <class Value>
float BodyColumns::sample(const Value& value) {
  constexpr std::size_t kSample = 1000;
  const std::size_t n = size(), stride = std::max<std::size_t>(n / kSample, 1);
  sample_.clear();
  for (std::size_t row = 0; row < n; row += stride) {
    if ((looks_[row] & kStaticBit) == 0) sample_.push_back(value(row));
  }
  return percentile(sample_);
}

void BodyColumns::follow_brightness() {
  follow(bright_speed_, sample([&](std::size_t row) { return snapshot_->speed[row]; }), kLeastSpeed);
  follow(bright_spin_,
         sample([&](std::size_t row) { return std::fabs(snapshot_->angle[row] - snapshot_->angle_prev[row]); }),
         kLeastSpin);
}

std::size_t BodyColumns::row_of(std::uint32_t id) const {
  const std::size_t n = size();
  if (id < n && snapshot_->id[id] == id) return id;  // nobody was ever removed
  if (n == 0) return n;
  const auto at = std::ranges::lower_bound(snapshot_->id, id);
  return at != snapshot_->id.end() && *at == id ? static_cast<std::size_t>(at - snapshot_->id.begin()) : n;
}

Vec2 BodyColumns::place(std::size_t row, float alpha) const {
  const Snapshot& s = *snapshot_;
  const float x = s.x_prev[row] + alpha * (s.x[row] - s.x_prev[row]);
  const float y = s.y_prev[row] + alpha * (s.y[row] - s.y_prev[row]);
  return {s.origin.x + static_cast<double>(x), s.origin.y + static_cast<double>(y)};
}

double BodyColumns::angle(std::size_t row, float alpha) const {
  const Snapshot& s = *snapshot_;
  return static_cast<double>(s.angle_prev[row] + alpha * (s.angle[row] - s.angle_prev[row]));
}

float BodyColumns::bright(Colouring colouring) const {
  if (colouring == Colouring::force) return std::max(bright_force_, kLeastForce);
  return std::max(colouring == Colouring::spin ? bright_spin_ : bright_speed_, kLeastSpin);
}

}  // namespace psim::view
