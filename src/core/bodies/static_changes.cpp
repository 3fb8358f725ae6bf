// Static bodies that the host changes: they are disabled for a while, and get other surfaces.
#include <algorithm>

#include "bodies/static_pieces.h"
#include "bodies/static_shapes.h"

namespace psim {

std::uint32_t StaticShapes::hide(std::uint32_t first, std::uint32_t owner) {
  std::uint32_t end = first;
  for (; end < count_ && statics_[end].owner == owner && statics_[end].alive; ++end) {
    statics_[end].alive = false;
    statics_[end].hidden = true;
    --alive_;
  }
  dirty_ = true;
  return end - first;
}

void StaticShapes::show(std::uint32_t first, std::uint32_t count) {
  for (std::uint32_t k = first; k < first + count; ++k) {
    statics_[k].alive = true;
    statics_[k].hidden = false;
    ++alive_;
  }
  dirty_ = true;
}

bool StaticShapes::hides(std::uint32_t first, std::uint32_t count, std::uint32_t owner) const {
  if (first > count_ || count > count_ - first) return false;
  const auto is_his = [&](const StaticShape& s) { return s.hidden && s.owner == owner; };
  return std::all_of(statics_.data() + first, statics_.data() + first + count, is_his);
}

std::size_t StaticShapes::hidden() const {
  const auto is_hidden = [](const StaticShape& s) { return s.hidden; };
  return static_cast<std::size_t>(std::count_if(statics_.data(), statics_.data() + count_, is_hidden));
}

void StaticShapes::remove_hidden(std::uint32_t first, std::uint32_t count) {
  for (std::uint32_t k = first; k < first + count; ++k) {
    statics_[k].hidden = false;
    if (statics_[k].whole) free_hulls_.push_back(statics_[k].hull);
  }
  if (count != 0) gone_.emplace_back(first, count);
}

std::uint32_t StaticShapes::parts_from(std::uint32_t first, std::uint32_t owner) const {
  const auto is_his = [&](const StaticShape& s) { return s.owner == owner && (s.alive || s.hidden); };
  std::uint32_t parts = 1;
  for (std::uint32_t k = first; k < count_ && is_his(statics_[k]); ++k) parts = std::max(parts, statics_[k].part + 1);
  return parts;
}

void StaticShapes::set_surface(std::uint32_t first, std::uint32_t owner,
                               const std::function<PartProperties(std::uint32_t)>& of_part) {
  const auto is_his = [&](const StaticShape& s) { return s.owner == owner && (s.alive || s.hidden); };
  for (std::uint32_t k = first; k < count_ && is_his(statics_[k]); ++k) mark(statics_[k], of_part(statics_[k].part));
}

}  // namespace psim
