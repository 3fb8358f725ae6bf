#include "model/fluid_drawing.h"

#include <algorithm>
#include <cmath>

namespace psim::view {
namespace {

using cli::FluidColouring;
using cli::FluidStyle;

constexpr float kOwnColour = -1;  // the share of a disc that has the fluid's colour

// So much has a particle of what colours show: m/s or N/m.
float number_of(const FluidRows& rows, std::size_t row, FluidColouring colouring) {
  if (colouring == FluidColouring::pressure) return static_cast<float>(rows.pressure[row]);
  return static_cast<float>(std::hypot(rows.velocity[row].x, rows.velocity[row].y));
}

}  // namespace

void FluidDrawing::build(const FluidLook* look, const WorldDesc& world, const Camera& camera, float alpha,
                         const FluidChoice& choice) {
  count_ = 0;
  if (look == nullptr) return;
  find_values(*look, choice.colouring);
  parts_.resize(std::max(parts_.size(), look->fluids.size()));
  const Bounds& b = world.bounds;
  const bool walls = world.boundary == Boundary::walls;
  const double back = (1 - static_cast<double>(alpha)) * world.dt;
  for (std::size_t k = 0; k < look->fluids.size(); ++k) {
    const FluidRows& rows = look->fluids[k];
    places_.resize(rows.place.size());
    for (std::size_t row = 0; row < places_.size(); ++row) {
      const Vec2 at = rows.place[row], v = rows.velocity[row];
      const Vec2 then{at.x - back * v.x, at.y - back * v.y};
      places_[row] = walls ? Vec2{std::clamp(then.x, b.xmin, b.xmax), std::clamp(then.y, b.ymin, b.ymax)} : then;
    }
    Part& part = parts_[count_++];
    part.rgb = cli::fluid_rgb(static_cast<FluidId>(k));
    build_part(rows, values_[k], world, camera, choice.style, part);
  }
}

void FluidDrawing::build_part(const FluidRows& rows, const std::vector<float>& values, const WorldDesc& world,
                              const Camera& camera, FluidStyle style, Part& part) const {
  constexpr double kSameArea = 0.5641895835477563;  // radius of a disc of one spacing squared
  part.discs.clear();
  const Vec2 centre = camera.centre();
  const auto add_disc = [&](std::size_t row) {
    part.discs.push_back({static_cast<float>(places_[row].x - centre.x), static_cast<float>(places_[row].y - centre.y),
                          values.empty() ? kOwnColour : std::max(values[row], 0.0f)});
  };
  if (style == FluidStyle::particles) {
    part.field.fullness.clear();
    part.radius = static_cast<float>(rows.spacing / 2);
    for (std::size_t row = 0; row < places_.size(); ++row) add_disc(row);
    return;
  }
  part.radius = static_cast<float>(kSameArea * rows.spacing);
  cli::make_fluid_field(places_, values,
                        {rows.spacing, 1 / camera.pixels_per_metre(), camera.shown(), world.bounds, world.boundary},
                        part.field);
  for (const std::uint32_t row : part.field.lone) add_disc(row);
}

// Shares of what is nearly the most. At least a tenth of a metre per second or a newton per metre is the most, so that
// what rests looks at rest.
void FluidDrawing::find_values(const FluidLook& look, FluidColouring colouring) {
  constexpr std::size_t kSample = 1000;
  constexpr double kShare = 0.98;
  constexpr float kLeast = 0.1f, kFollow = 0.1f;
  values_.resize(look.fluids.size());
  for (std::vector<float>& values : values_) values.clear();
  if (colouring == FluidColouring::fluid) return;
  const std::size_t stride = std::max<std::size_t>(look.particles / kSample, 1);
  sample_.clear();
  for (std::size_t k = 0; k < look.fluids.size(); ++k) {
    const FluidRows& rows = look.fluids[k];
    for (std::size_t row = 0; row < rows.place.size(); ++row) {
      values_[k].push_back(number_of(rows, row, colouring));
      if (row % stride == 0) sample_.push_back(values_[k].back());
    }
  }
  if (sample_.empty()) return;
  const auto at = sample_.begin() + static_cast<std::ptrdiff_t>(kShare * static_cast<double>(sample_.size() - 1));
  std::nth_element(sample_.begin(), at, sample_.end());
  const float now = std::isfinite(*at) ? std::max(*at, kLeast) : kLeast;
  bright_ = followed_ == colouring ? bright_ + kFollow * (now - bright_) : now;
  followed_ = colouring;
  for (std::vector<float>& values : values_) {
    for (float& value : values) value /= bright_;
  }
}

}  // namespace psim::view
