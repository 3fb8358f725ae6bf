// Changes of many bodies at once. Each body is changed as the call for one does it, in the order of the span.
#include "base/room.h"
#include "bodies/body_desc.h"
#include "world/world_impl.h"

namespace psim {

std::size_t World::add_bodies(std::span<const BodyDesc> descs, std::span<BodyId> ids, std::string& error) {
  return add_in_order(*this, descs, ids, error);
}

std::size_t World::states_of(std::span<const BodyId> ids, std::span<BodyState> states) const {
  if (states.size() != ids.size()) return 0;
  const FloatSettings settings;
  const Observed seen = impl_->observed();
  std::size_t there = 0;
  for (std::size_t k = 0; k < ids.size(); ++k) {
    const bool valid = is_valid(ids[k]);
    states[k] = valid ? seen.state_of(ids[k].index) : BodyState{};
    there += valid ? 1 : 0;
  }
  return there;
}

std::size_t World::set_transforms(std::span<const BodyId> ids, std::span<const Vec2> positions,
                                  std::span<const double> angles) {
  return count_done([this](const auto&... of) { return set_transform(of...); }, ids, positions, angles);
}

std::size_t World::set_velocities(std::span<const BodyId> ids, std::span<const Vec2> velocities,
                                  std::span<const double> angular_velocities) {
  return count_done([this](const auto&... of) { return set_velocity(of...); }, ids, velocities, angular_velocities);
}

std::size_t World::apply_impulses(std::span<const BodyId> ids, std::span<const Vec2> impulses) {
  return count_done([this](const auto&... of) { return apply_impulse(of...); }, ids, impulses);
}

std::size_t World::apply_forces(std::span<const BodyId> ids, std::span<const Vec2> forces) {
  return count_done([this](const auto&... of) { return apply_force(of...); }, ids, forces);
}

std::size_t World::set_traits_of(std::span<const BodyId> ids, std::span<const BodyTraits> traits) {
  return count_done([this](const auto&... of) { return set_traits(of...); }, ids, traits);
}

std::size_t World::set_enabled_of(std::span<const BodyId> ids, bool on) {
  return count_done([&](BodyId id) { return set_enabled(id, on); }, ids);
}

}  // namespace psim
