#include "lists/body_mover.h"

#include <algorithm>

namespace psim {

// Calls each(column, its other half, values a body) for the columns that there are.
template <class Each>
void BodyMover::each_column(bool radii, const Each& each) {
  each(b_.pos, pos_, 2);
  each(b_.vel, vel_, 2);
  each(b_.disp, disp_, 2);
  each(b_.id, id_, 1);
  each(b_.reach, reach_, 1);
  if (radii) each(b_.radius, radius_, 1);
  if (b_.rim_speed.empty()) return;
  each(b_.rim_speed, rim_speed_, 1);
  each(b_.angle, angle_, 1);
}

template <bool kRadii, bool kTurns>
void BodyMover::gather(const std::uint32_t* from, std::size_t begin, std::size_t end) {
  for (std::size_t to = begin; to < end; ++to) {
    const std::size_t i = from[to];
    const auto copy2 = [&](auto* target, const auto* source) {
      target[2 * to] = source[2 * i];
      target[2 * to + 1] = source[2 * i + 1];
    };
    copy2(pos_.data(), b_.pos.data());
    copy2(vel_.data(), b_.vel.data());
    copy2(disp_.data(), b_.disp.data());
    id_[to] = b_.id[i];
    reach_[to] = b_.reach[i];
    if constexpr (kRadii) radius_[to] = b_.radius[i];
    if constexpr (kTurns) {
      rim_speed_[to] = b_.rim_speed[i];
      angle_[to] = b_.angle[i];
    }
  }
}

void BodyMover::move(const std::uint32_t* from, bool mixed_radii, std::size_t begin, std::size_t end) {
  if (begin == 0) {
    const std::size_t padded = kernels::round_up_block(b_.count);
    each_column(mixed_radii, [=](auto&, auto& other, std::size_t values) { other.reserve(values * padded); });
  }
  const bool turns = !b_.rim_speed.empty();
  const auto gather = mixed_radii ? turns ? &BodyMover::gather<true, true> : &BodyMover::gather<true, false>
                      : turns ? &BodyMover::gather<false, true>
                                  : &BodyMover::gather<false, false>;
  s_.pool.run((end - begin + kPiece - 1) / kPiece, [&](std::size_t piece) {
    const std::size_t first = begin + piece * kPiece;
    (this->*gather)(from, first, std::min(end, first + kPiece));
  });
}

void BodyMover::finish(bool mixed_radii, std::uint32_t count) {
  each_column(mixed_radii, [](auto& column, auto& other, std::size_t) { column.swap(other); });
  b_.count = b_.listed = count;
  b_.dead = 0;
  b_.slots_stale = true;
  if (b_.count != 0) b_.pad_tail();
}

}  // namespace psim
