// Stream kernels: one pass over body columns, no gathers. Ranges are whole blocks of 8.
//
// A substep of length h moves a body as leapfrog does: half a drift at the old velocity, kick, half
// a drift at the new one. Contacts change v between kick and drift, so the drift uses both where the
// change is smooth (gravity, resting contacts) and the new velocity where it is an impact:
//   kick   v0 = damp v,  v = v0 + h a
//   drift  x += h (v - (v - v0)/2)  if |v - v0| <= 2 h |a|,  else  x += h v
// Bodies that no contact list names take the exact closed form of the whole frame in `integrate`.
#pragma once

#include <cstring>

#include "lane_vec.h"
#include "views.h"

namespace psim::kernels {
namespace {

/// True if any body of the block takes substeps.
template <class L>
PSIM_INLINE inline bool any_linked(const std::uint8_t* linked, std::uint32_t block) {
  std::uint64_t eight;
  std::memcpy(&eight, linked + static_cast<std::size_t>(block) * kBlock, sizeof eight);
  return eight != 0;
}

/// The acceleration of a kick: the same for all bodies; a body's own; that, with remainders kept.
enum class Kick { uniform, own, field };

template <class L, Kick kKick>
void kick_first_as(const BodyView& b, const StreamParams& p, std::uint32_t begin, std::uint32_t end) {
  const auto damp = Rec<L>(p.damp, p.damp);
  const auto uniform = Rec<L>(p.kick_x, p.kick_y);
  const auto coast = Rec<L>(p.coast, p.coast);
  const auto damp_remainder = Rec<L>(p.damp_remainder, p.damp_remainder);
  const auto again = Rec<L>(p.again, p.again);
  for (std::uint32_t block = begin; block < end; ++block) {
    if (!any_linked<L>(b.linked, block)) continue;
    for (std::uint32_t r = 0; r < kBlock; r += L::records) {
      const std::size_t body = static_cast<std::size_t>(block) * kBlock + r;
      const auto mine = L::mask_rec(b.linked + body);
      const auto old = snapped<L>(L::load_rec(b.vel + 2 * body));
      const auto v0 = old * damp;
      auto dv = uniform;
      if constexpr (kKick != Kick::uniform) dv = L::load_rec(b.acc + 2 * body) * coast;
      if constexpr (kKick == Kick::field) {
        const auto rest = damp_remainder * old + L::load_rec(b.vel_remainder + 2 * body);
        dv = dv + rest;
      }
      const auto v = v0 + dv, rounded = v - v0, lost = dv - rounded;
      if constexpr (kKick == Kick::field) {
        L::store_rec(b.vel_remainder + 2 * body, lost);
        L::store_rec(b.vel0 + 2 * body, v0);
        L::store_rec(b.vel + 2 * body, select(mine, v, old));
      } else {
        const auto ahead = v + again * lost;
        L::store_rec(b.vel0 + 2 * body, ahead - rounded);
        L::store_rec(b.vel + 2 * body, select(mine, ahead, old));
      }
    }
  }
}

/// First kick of a frame, or every kick in a field. Damping comes first, then v0 is taken, then the
/// acceleration. In a field the part of a kick that does not fit into the velocity is kept for the
/// next one (compensated summation; Kahan 1965), or orbits would gain energy from rounding. Elsewhere the later kicks
/// of the frame repeat a kick as it was rounded, so the first one makes up for what they all will lose.
template <class L>
void kick_first(const BodyView& b, const StreamParams& p, std::uint32_t begin, std::uint32_t end) {
  if (b.acc == nullptr) return kick_first_as<L, Kick::uniform>(b, p, begin, end);
  if (b.vel_remainder == nullptr) return kick_first_as<L, Kick::own>(b, p, begin, end);
  kick_first_as<L, Kick::field>(b, p, begin, end);
}

/// Later kicks: gravity and the impulses of the last substep together are v - v0, so adding that
/// again is kick and warm start in one stream, without touching a contact.
template <class L>
void kick_again(const BodyView& b, const StreamParams& p, std::uint32_t begin, std::uint32_t end) {
  const auto damp = Rec<L>(p.damp, p.damp);
  for (std::uint32_t block = begin; block < end; ++block) {
    if (!any_linked<L>(b.linked, block)) continue;
    for (std::uint32_t r = 0; r < kBlock; r += L::records) {
      const std::size_t body = static_cast<std::size_t>(block) * kBlock + r;
      const auto mine = L::mask_rec(b.linked + body);
      const auto old = snapped<L>(L::load_rec(b.vel + 2 * body));
      const auto dv = old - L::load_rec(b.vel0 + 2 * body);
      const auto v0 = old * damp;
      L::store_rec(b.vel0 + 2 * body, v0);
      L::store_rec(b.vel + 2 * body, select(mine, v0 + dv, old));
    }
  }
}

/// x += h (mean or new velocity), see above. The smooth limit is squared, (2 h |a|)^2.
template <class L>
void drift(const BodyView& b, const StreamParams& p, std::uint32_t begin, std::uint32_t end) {
  const auto h = Rec<L>(p.h, p.h);
  const auto half = Rec<L>(0.5f, 0.5f);
  const auto limit = Rec<L>(p.smooth_limit2, p.smooth_limit2);
  const auto four_h2 = Rec<L>(4 * p.h * p.h, 4 * p.h * p.h);
  const auto zero = Rec<L>(0, 0);
  for (std::uint32_t block = begin; block < end; ++block) {
    if (!any_linked<L>(b.linked, block)) continue;
    for (std::uint32_t r = 0; r < kBlock; r += L::records) {
      const std::size_t body = static_cast<std::size_t>(block) * kBlock + r;
      const auto mine = L::mask_rec(b.linked + body);
      const auto v = L::load_rec(b.vel + 2 * body);
      const auto dv = v - L::load_rec(b.vel0 + 2 * body);
      const auto bound = b.acc ? limit + four_h2 * norm2(L::load_rec(b.acc + 2 * body)) : limit;
      const auto smooth = norm2(squarable<L>(dv)) <= bound;
      const auto mean = v - select(smooth, half * dv, zero);
      const auto d = L::load_rec(b.disp + 2 * body);
      L::store_rec(b.disp + 2 * body, select(mine, snapped<L>(d + h * mean, kLeastOffset), d));
    }
  }
}

template <class L, bool kOwn>
bool integrate_as(const BodyView& b, const StreamParams& p, std::uint32_t begin, std::uint32_t end) {
  const auto damp = Rec<L>(p.damp, p.damp);
  const auto kick = Rec<L>(p.kick_x, p.kick_y);
  const auto coast = Rec<L>(p.coast, p.coast);
  const auto fall = Rec<L>(p.fall_x, p.fall_y);
  const auto drop = Rec<L>(p.drop, p.drop);
  const auto far = Rec<L>(p.far_x, p.far_y);
  const auto near = Rec<L>(-p.far_x, -p.far_y);
  const auto pitch = Rec<L>(p.pitch_x, p.pitch_y);
  const auto inv_pitch = Rec<L>(p.inv_pitch_x, p.inv_pitch_y);
  const auto limit = Rec<L>(p.speed_limit2, p.speed_limit2);
  auto fine = L::every_rec();
  for (std::uint32_t block = begin; block < end; ++block) {
    for (std::uint32_t r = 0; r < kBlock; r += L::records) {
      const std::size_t body = static_cast<std::size_t>(block) * kBlock + r;
      const auto linked = L::mask_rec(b.linked + body);
      const auto v = L::load_rec(b.vel + 2 * body);
      const auto d0 = L::load_rec(b.disp + 2 * body);
      auto my_kick = kick, my_fall = fall;
      if constexpr (kOwn) {
        const auto a = L::load_rec(b.acc + 2 * body);
        my_kick = a * coast;
        my_fall = a * drop;
      }
      const auto free_v = v * damp + my_kick;
      const auto free_d = d0 + coast * v + my_fall;
      const auto new_v = snapped<L>(select(linked, v, free_v));
      const auto gone = select(linked, d0, free_d);
      const auto d = min(far, max(near, gone));  // a NaN stays one
      fine = fine & (norm2(new_v) <= limit);
      const auto k = nearest(d * inv_pitch);
      L::store_rec(b.vel + 2 * body, new_v);
      L::store_rec_int(b.pos + 2 * body, L::load_rec_int(b.pos + 2 * body) + k);
      L::store_rec(b.disp + 2 * body, snapped<L>(d - to_float(k) * pitch, kLeastOffset));
    }
  }
  return all(fine);
}

/// End of a frame. Free bodies: v' = damp v + kick, d += coast v + fall (exact for uniform gravity
/// and linear damping). All bodies: whole lattice steps move from the offset into the position,
///   k = nearest(d / pitch), X += k, d -= k pitch,
/// exactly, so nothing is lost over any number of frames. Offsets are cut to `far`. Returns false if any body is faster
/// than the limit or not a number (the caller finds it and deals with it).
template <class L>
bool integrate(const BodyView& b, const StreamParams& p, std::uint32_t begin, std::uint32_t end) {
  return b.acc == nullptr ? integrate_as<L, false>(b, p, begin, end) : integrate_as<L, true>(b, p, begin, end);
}

/// Age of the neighbour lists: the largest |x - x_built| + |v| reach_time - (reach - radius) over the
/// bodies, m. The lists serve another frame while it is not positive.
template <class L>
float list_age(const BodyView& b, const std::int32_t* built, const float* radius, const float* reach,
               const StreamParams& p, float reach_time, std::uint32_t begin, std::uint32_t end) {
  const auto pitch = Rec<L>(p.pitch_x, p.pitch_y);
  const auto time = Rec<L>(reach_time, reach_time);
  auto worst = Rec<L>(-1e30f, -1e30f);
  for (std::uint32_t block = begin; block < end; ++block) {
    for (std::uint32_t r = 0; r < kBlock; r += L::records) {
      const std::size_t body = static_cast<std::size_t>(block) * kBlock + r;
      const auto moved = to_float(L::load_rec_int(b.pos + 2 * body) - L::load_rec_int(built + 2 * body)) * pitch;
      const auto far = sqrt(norm2(moved));
      const auto next = sqrt(norm2(L::load_rec(b.vel + 2 * body))) * time;
      const auto margin = L::spread(reach + body) - L::spread(radius + body);
      worst = max(far + next - margin, worst);  // a NaN is passed over
    }
  }
  return L::largest(worst);
}

/// Where bodies will be in `ahead` seconds at their present velocity: X + nearest(v ahead / pitch).
template <class L>
void look_ahead(const BodyView& b, const StreamParams& p, float ahead, std::int32_t* place, std::uint32_t begin,
                std::uint32_t end) {
  const auto time = Rec<L>(ahead, ahead);
  const auto steps = Rec<L>(p.inv_pitch_x, p.inv_pitch_y);
  for (std::size_t i = static_cast<std::size_t>(begin) * kBlock; i < static_cast<std::size_t>(end) * kBlock;
       i += L::records) {
    const auto way = L::load_rec(b.vel + 2 * i) * time * steps;
    L::store_rec_int(place + 2 * i, L::load_rec_int(b.pos + 2 * i) + nearest(way));
  }
}

/// reach = radius + skin + |v - common| time, with the skin of small bodies by their own radius: how far a body can touch before the lists are made
/// again. Returns the largest.
template <class L>
float reaches(const BodyView& b, const float* radius, const ReachParams& p, float* reach, std::uint32_t begin,
              std::uint32_t end) {
  const F<L> skin = p.skin, share = p.of_radius;
  const bool by_radius = p.of_radius != 0;
  const F<L> t = p.time;
  const F<L> common_x = p.common_x, common_y = p.common_y;
  F<L> most = 0;
  for (std::uint32_t block = begin; block < end; ++block) {
    for (std::uint32_t r = 0; r < kBlock; r += L::width) {
      const std::size_t body = static_cast<std::size_t>(block) * kBlock + r;
      std::uint32_t slots[L::width];
      for (std::uint32_t l = 0; l < L::width; ++l) slots[l] = static_cast<std::uint32_t>(body + l);
      F<L> x, y;
      L::template gather<1>(b.vel, slots, x, y);
      x = x - common_x;
      y = y - common_y;
      const auto speed = sqrt(x * x + y * y);
      const auto size = L::load(radius + body);
      const auto m = (by_radius ? min(share * size, skin) : skin) + speed * t;
      const auto total = size + m;
      L::store(reach + body, total);
      most = max(total, most);
    }
  }
  float each[L::width];
  L::store(each, most);
  float worst = 0;
  for (const float one : each) worst = one > worst ? one : worst;
  return worst;
}

/// Smallest and largest lattice coordinates: low_high = {x low, y low, x high, y high}, widened.
template <class L>
void extent(const std::int32_t* pos, std::int32_t low_high[4], std::uint32_t begin, std::uint32_t end) {
  auto low = RecI<L>(low_high[0], low_high[1]);
  auto high = RecI<L>(low_high[2], low_high[3]);
  for (std::size_t i = static_cast<std::size_t>(begin) * kBlock; i < static_cast<std::size_t>(end) * kBlock;
       i += L::records) {
    const auto p = L::load_rec_int(pos + 2 * i);
    low = min(low, p);
    high = max(high, p);
  }
  std::int32_t lows[2 * L::records], highs[2 * L::records];
  L::store_rec_int(lows, low);
  L::store_rec_int(highs, high);
  for (std::uint32_t r = 0; r < 2 * L::records; ++r) {
    const std::uint32_t axis = r & 1u;
    if (lows[r] < low_high[axis]) low_high[axis] = lows[r];
    if (highs[r] > low_high[2 + axis]) low_high[2 + axis] = highs[r];
  }
}

/// Cell keys: column and row = truncate(float(X - mid) scale + offset), clamped to the grid.
template <class L>
void cell_keys(const std::int32_t* pos, const GridView& g, std::uint32_t* key, std::uint32_t begin, std::uint32_t end) {
  const auto mid = RecI<L>(g.mid_x, g.mid_y);
  const auto scale = Rec<L>(g.scale_x, g.scale_y);
  const auto offset = Rec<L>(g.offset_x, g.offset_y);
  const auto zero = Rec<L>(0, 0);
  const auto top = Rec<L>(static_cast<float>(g.cols - 1), static_cast<float>(g.rows - 1));
  for (std::uint32_t block = begin; block < end; ++block) {
    for (std::uint32_t r = 0; r < kBlock; r += L::records) {
      const std::size_t body = static_cast<std::size_t>(block) * kBlock + r;
      const auto x = to_float(L::load_rec_int(pos + 2 * body) - mid);
      const auto c = x * scale + offset;
      L::store_keys(key + body, truncate(min(max(c, zero), top)), g.stride);
    }
  }
}

/// rad: beside a turn that is smaller, its square is nothing to a float.
constexpr float kSmallTurn = 1e-8f;

/// Where bodies have turned to since the frame's start: d += h u / R, turn = R (cos d - 1, sin d). As the drift does, u is
/// the mean of a substep where the change is smooth: a body that pivots on a point would slide there, if it turned by
/// another velocity than it moves. A body that did not turn before is pushed out of an overlap, which it needs in full.
/// Polynomials of fdlibm's kernels on d - 2 pi nearest(d / 2 pi), halved twice for range.
template <class L>
void turn_bodies(const BodyView& b, const float* radius, const StreamParams& p, std::uint32_t begin,
                 std::uint32_t end) {
  const F<L> one = 1, two = 2, step = p.h, limit = p.smooth_limit2, four_h2 = 4 * p.h * p.h, least = p.least_spin2;
  const F<L> nearest = 12582912.0f;  // 1.5 x 2^23: adding it rounds to whole numbers
  for (std::uint32_t block = begin; block < end; ++block) {
    if (!any_linked<L>(b.linked, block)) continue;
    for (std::uint32_t r = 0; r < kBlock; r += L::width) {
      const std::size_t i = static_cast<std::size_t>(block) * kBlock + r;
      const F<L> last = L::load(b.rim_speed + i), first = L::load(b.rim_speed0 + i), none = 0;
      const F<L> before = L::load(b.angle_change + i);
      if (!any((last != none) | (first != none) | (before != none))) continue;
      const auto change = last - first, way = squarable<L>(change), spin = squarable<L>(first);
      auto bound = limit;
      if (b.acc != nullptr) {
        std::uint32_t slots[L::width];
        for (std::uint32_t l = 0; l < L::width; ++l) slots[l] = static_cast<std::uint32_t>(i + l);
        F<L> x, y;
        L::template gather<1>(b.acc, slots, x, y);
        bound = limit + four_h2 * (x * x + y * y);
      }
      const auto size = L::load(radius + i);
      const auto spun = spin * spin - least * (size * size);
      const auto rim_speed = last - keep(way * way <= min(bound, spun), 0.5f * change);
      const auto safe = select(0 < size, size, one);
      auto d = snapped<L>(before + step * (rim_speed / safe));
      L::store(b.angle_change + i, d);
      // A turn of more than 2^20 in a frame has no direction left.
      d = max(min(d, 1e6f), -1e6f);
      const auto turns = d * 0.15915494309f + nearest - nearest;
      d = d - turns * 6.28125f - turns * 1.9353071795e-3f;
      // |x| <= pi/4: sin x = x + x^3 S(x^2), cos x - 1 = -x^2/2 + x^4 C(x^2). Where x is so small that cos x - 1 is lost
      // beside sin x, their powers are 0 and no denormals.
      const auto x = d * 0.25f;
      const auto large = kSmallTurn < abs(x);
      const auto z = keep(large, x * x);
      const F<L> s3 = 8.3333310e-3f + z * -1.9839334e-4f;
      auto sine = x + x * z * (-0.16666667f + z * s3);
      const F<L> c3 = -1.3888889e-3f + z * 2.4801588e-5f;
      auto less_one = z * -0.5f + z * z * (4.1666668e-2f + z * c3);
      for (int doubling = 0; doubling < 2; ++doubling) {  // sin 2x = 2 s c, cos 2x - 1 = -2 s^2
        const auto cosine = one + less_one;
        less_one = -(two * (sine * sine));
        sine = two * (sine * cosine);
      }
      // + 0: who did not turn has +0 here, whether or not its register was skipped above.
      L::store_records(b.arm_change + 2 * i, size * keep(large, less_one) + none, size * sine + none);
    }
  }
}

}  // namespace
}  // namespace psim::kernels
