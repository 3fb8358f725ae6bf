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

#include "views.h"

namespace psim::kernels {
namespace {

/// True if any body of the block takes substeps.
template <class L>
[[gnu::always_inline]] inline bool any_linked(const std::uint8_t* linked, std::uint32_t block) {
  std::uint64_t eight;
  std::memcpy(&eight, linked + static_cast<std::size_t>(block) * kBlock, sizeof eight);
  return eight != 0;
}

enum class Kick { uniform, own, field };

template <class L, Kick kKick>
void kick_first_as(const BodyView& b, const StreamParams& p, std::uint32_t begin,
                   std::uint32_t end) {
  const auto damp = L::set_rec(p.damp, p.damp);
  const auto uniform = L::set_rec(p.kick_x, p.kick_y);
  const auto coast = L::set_rec(p.coast, p.coast);
  const auto damp_rest = L::set_rec(p.damp_rest, p.damp_rest);
  for (std::uint32_t block = begin; block < end; ++block) {
    if (!any_linked<L>(b.linked, block)) continue;
    for (std::uint32_t r = 0; r < kBlock; r += L::records) {
      const std::size_t body = static_cast<std::size_t>(block) * kBlock + r;
      const auto mine = L::mask_rec(b.linked + body);
      const auto old = L::load_rec(b.vel + 2 * body);
      const auto v0 = L::mul(old, damp);
      auto dv = uniform;
      if constexpr (kKick != Kick::uniform) dv = L::mul(L::load_rec(b.acc + 2 * body), coast);
      if constexpr (kKick == Kick::field) {
        const auto rest = L::add(L::mul(damp_rest, old), L::load_rec(b.vel_rest + 2 * body));
        dv = L::add(dv, rest);
      }
      const auto v = L::add(v0, dv);
      if constexpr (kKick == Kick::field) {
        L::store_rec(b.vel_rest + 2 * body, L::sub(dv, L::sub(v, v0)));
      }
      L::store_rec(b.vel0 + 2 * body, v0);
      L::store_rec(b.vel + 2 * body, L::select(mine, v, old));
    }
  }
}

/// First kick of a frame, or every kick in a field. Damping comes first, then v0 is taken, then the
/// acceleration. In a field the part of a kick that does not fit into the velocity is kept for the
/// next one (compensated summation; Kahan 1965), or orbits would gain energy from rounding.
template <class L>
void kick_first(const BodyView& b, const StreamParams& p, std::uint32_t begin, std::uint32_t end) {
  if (b.acc == nullptr) return kick_first_as<L, Kick::uniform>(b, p, begin, end);
  if (b.vel_rest == nullptr) return kick_first_as<L, Kick::own>(b, p, begin, end);
  kick_first_as<L, Kick::field>(b, p, begin, end);
}

/// Later kicks: gravity and the impulses of the last substep together are v - v0, so adding that
/// again is kick and warm start in one stream, without touching a contact.
template <class L>
void kick_again(const BodyView& b, const StreamParams& p, std::uint32_t begin, std::uint32_t end) {
  const auto damp = L::set_rec(p.damp, p.damp);
  for (std::uint32_t block = begin; block < end; ++block) {
    if (!any_linked<L>(b.linked, block)) continue;
    for (std::uint32_t r = 0; r < kBlock; r += L::records) {
      const std::size_t body = static_cast<std::size_t>(block) * kBlock + r;
      const auto mine = L::mask_rec(b.linked + body);
      const auto old = L::load_rec(b.vel + 2 * body);
      const auto dv = L::sub(old, L::load_rec(b.vel0 + 2 * body));
      const auto v0 = L::mul(old, damp);
      L::store_rec(b.vel0 + 2 * body, v0);
      L::store_rec(b.vel + 2 * body, L::select(mine, L::add(v0, dv), old));
    }
  }
}

/// x += h (mean or new velocity), see above. The smooth limit is squared, (2 h |a|)^2.
template <class L>
void drift(const BodyView& b, const StreamParams& p, std::uint32_t begin, std::uint32_t end) {
  const auto h = L::set_rec(p.h, p.h);
  const auto half = L::set_rec(0.5f, 0.5f);
  const auto limit = L::set_rec(p.smooth_limit2, p.smooth_limit2);
  const auto four_h2 = L::set_rec(4 * p.h * p.h, 4 * p.h * p.h);
  const auto zero = L::set_rec(0, 0);
  for (std::uint32_t block = begin; block < end; ++block) {
    if (!any_linked<L>(b.linked, block)) continue;
    for (std::uint32_t r = 0; r < kBlock; r += L::records) {
      const std::size_t body = static_cast<std::size_t>(block) * kBlock + r;
      const auto mine = L::mask_rec(b.linked + body);
      const auto v = L::load_rec(b.vel + 2 * body);
      const auto dv = L::sub(v, L::load_rec(b.vel0 + 2 * body));
      const auto bound =
          b.acc ? L::add(limit, L::mul(four_h2, L::norm2(L::load_rec(b.acc + 2 * body)))) : limit;
      const auto smooth = L::less_equal(L::norm2(dv), bound);
      const auto mean = L::sub(v, L::select(smooth, L::mul(half, dv), zero));
      const auto d = L::load_rec(b.disp + 2 * body);
      L::store_rec(b.disp + 2 * body, L::select(mine, L::add(d, L::mul(h, mean)), d));
    }
  }
}

template <class L, bool kOwn>
bool integrate_as(const BodyView& b, const StreamParams& p, std::uint32_t begin,
                  std::uint32_t end) {
  const auto damp = L::set_rec(p.damp, p.damp);
  const auto kick = L::set_rec(p.kick_x, p.kick_y);
  const auto coast = L::set_rec(p.coast, p.coast);
  const auto fall = L::set_rec(p.fall_x, p.fall_y);
  const auto drop = L::set_rec(p.drop, p.drop);
  const auto far = L::set_rec(p.far_x, p.far_y);
  const auto near = L::set_rec(-p.far_x, -p.far_y);
  const auto pitch = L::set_rec(p.pitch_x, p.pitch_y);
  const auto inv_pitch = L::set_rec(p.inv_pitch_x, p.inv_pitch_y);
  const auto limit = L::set_rec(p.speed_limit2, p.speed_limit2);
  auto fine = L::less_equal(limit, limit);
  for (std::uint32_t block = begin; block < end; ++block) {
    for (std::uint32_t r = 0; r < kBlock; r += L::records) {
      const std::size_t body = static_cast<std::size_t>(block) * kBlock + r;
      const auto linked = L::mask_rec(b.linked + body);
      const auto v = L::load_rec(b.vel + 2 * body);
      const auto d0 = L::load_rec(b.disp + 2 * body);
      auto my_kick = kick, my_fall = fall;
      if constexpr (kOwn) {
        const auto a = L::load_rec(b.acc + 2 * body);
        my_kick = L::mul(a, coast);
        my_fall = L::mul(a, drop);
      }
      const auto free_v = L::add(L::mul(v, damp), my_kick);
      const auto free_d = L::add(L::add(d0, L::mul(coast, v)), my_fall);
      const auto new_v = L::select(linked, v, free_v);
      const auto gone = L::select(linked, d0, free_d);
      const auto d = L::min(far, L::max(near, gone));  // a NaN stays one
      fine = L::both(fine, L::less_equal(L::norm2(new_v), limit));
      const auto k = L::nearest(L::mul(d, inv_pitch));
      L::store_rec(b.vel + 2 * body, new_v);
      L::store_rec_int(b.pos + 2 * body, L::add(L::load_rec_int(b.pos + 2 * body), k));
      L::store_rec(b.disp + 2 * body, L::sub(d, L::mul(L::to_float(k), pitch)));
    }
  }
  return L::all(fine);
}

/// End of a frame. Free bodies: v' = damp v + kick, d += coast v + fall (exact for uniform gravity
/// and linear damping). All bodies: whole lattice steps move from the offset into the position,
///   k = nearest(d / pitch), X += k, d -= k pitch,
/// exactly, so nothing is lost over any number of frames. Offsets are cut to `far`. Returns false if any body is faster than
/// the limit or not a number (the caller finds it and deals with it).
template <class L>
bool integrate(const BodyView& b, const StreamParams& p, std::uint32_t begin, std::uint32_t end) {
  return b.acc == nullptr ? integrate_as<L, false>(b, p, begin, end)
                          : integrate_as<L, true>(b, p, begin, end);
}

/// Age of the neighbour lists: the largest |x - x_built| + |v| reach_time - (reach - radius) over the
/// bodies, m. The lists serve another frame while it is not positive.
template <class L>
float list_age(const BodyView& b, const std::int32_t* built, const float* radius,
               const float* reach, const StreamParams& p, float reach_time, std::uint32_t begin,
               std::uint32_t end) {
  const auto pitch = L::set_rec(p.pitch_x, p.pitch_y);
  const auto time = L::set_rec(reach_time, reach_time);
  auto worst = L::set_rec(-1e30f, -1e30f);
  for (std::uint32_t block = begin; block < end; ++block) {
    for (std::uint32_t r = 0; r < kBlock; r += L::records) {
      const std::size_t body = static_cast<std::size_t>(block) * kBlock + r;
      const auto moved = L::mul(L::to_float(L::sub(L::load_rec_int(b.pos + 2 * body),
                                                   L::load_rec_int(built + 2 * body))),
                                pitch);
      const auto far = L::sqrt(L::norm2(moved));
      const auto next = L::mul(L::sqrt(L::norm2(L::load_rec(b.vel + 2 * body))), time);
      const auto margin = L::sub(L::spread(reach + body), L::spread(radius + body));
      worst = L::max(L::sub(L::add(far, next), margin), worst);  // a NaN is passed over
    }
  }
  return L::largest(worst);
}

/// Where bodies will be in `ahead` seconds at their present velocity: X + nearest(v ahead / pitch).
template <class L>
void look_ahead(const BodyView& b, const StreamParams& p, float ahead, std::int32_t* place,
                std::uint32_t begin, std::uint32_t end) {
  const auto time = L::set_rec(ahead, ahead);
  const auto steps = L::set_rec(p.inv_pitch_x, p.inv_pitch_y);
  for (std::size_t i = static_cast<std::size_t>(begin) * kBlock;
       i < static_cast<std::size_t>(end) * kBlock; i += L::records) {
    const auto way = L::mul(L::mul(L::load_rec(b.vel + 2 * i), time), steps);
    L::store_rec_int(place + 2 * i, L::add(L::load_rec_int(b.pos + 2 * i), L::nearest(way)));
  }
}

/// reach = radius + skin + |v - common| time: how far a body can touch before the lists are made
/// again. Returns the largest.
template <class L>
float reaches(const BodyView& b, const float* radius, const ReachParams& p, float* reach,
              std::uint32_t begin, std::uint32_t end) {
  const auto base = L::set1(p.skin);
  const auto t = L::set1(p.time);
  const auto common_x = L::set1(p.common_x), common_y = L::set1(p.common_y);
  auto most = L::set1(0);
  for (std::uint32_t block = begin; block < end; ++block) {
    for (std::uint32_t r = 0; r < kBlock; r += L::width) {
      const std::size_t body = static_cast<std::size_t>(block) * kBlock + r;
      std::uint32_t slots[L::width];
      for (std::uint32_t l = 0; l < L::width; ++l) slots[l] = static_cast<std::uint32_t>(body + l);
      typename L::F x, y;
      L::template gather<1>(b.vel, slots, x, y);
      x = L::sub(x, common_x);
      y = L::sub(y, common_y);
      const auto speed = L::sqrt(L::add(L::mul(x, x), L::mul(y, y)));
      const auto m = L::add(base, L::mul(speed, t));
      const auto total = L::add(L::load(radius + body), m);
      L::store(reach + body, total);
      most = L::max(total, most);
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
void extent(const std::int32_t* pos, std::int32_t low_high[4], std::uint32_t begin,
            std::uint32_t end) {
  auto low = L::set_rec_int(low_high[0], low_high[1]);
  auto high = L::set_rec_int(low_high[2], low_high[3]);
  for (std::size_t i = static_cast<std::size_t>(begin) * kBlock;
       i < static_cast<std::size_t>(end) * kBlock; i += L::records) {
    const auto p = L::load_rec_int(pos + 2 * i);
    low = L::min(low, p);
    high = L::max(high, p);
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
void cell_keys(const std::int32_t* pos, const GridView& g, std::uint32_t* key,
               std::uint32_t begin, std::uint32_t end) {
  const auto mid = L::set_rec_int(g.mid_x, g.mid_y);
  const auto scale = L::set_rec(g.scale_x, g.scale_y);
  const auto offset = L::set_rec(g.offset_x, g.offset_y);
  const auto zero = L::set_rec(0, 0);
  const auto top = L::set_rec(static_cast<float>(g.cols - 1), static_cast<float>(g.rows - 1));
  for (std::uint32_t block = begin; block < end; ++block) {
    for (std::uint32_t r = 0; r < kBlock; r += L::records) {
      const std::size_t body = static_cast<std::size_t>(block) * kBlock + r;
      const auto x = L::to_float(L::sub(L::load_rec_int(pos + 2 * body), mid));
      const auto c = L::add(L::mul(x, scale), offset);
      L::store_keys(key + body, L::truncate(L::min(L::max(c, zero), top)), g.stride);
    }
  }
}

}  // namespace
}  // namespace psim::kernels
