// Columns for the kernel tests: bodies, contacts and sorted grids made here, without the engine's
// stores, so that a failure is the kernel's.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "base/machine.h"
#include "kernel_table.h"
#include "support.h"
#include "views.h"

namespace psim::test {

using kernels::BodyView;
using kernels::Bounce;
using kernels::ContactParams;
using kernels::ContactView;
using kernels::kBlock;
using kernels::KernelTable;
using kernels::Model;
using kernels::StaticContactView;
using kernels::StreamParams;
using kernels::Sweep;

inline constexpr Model kAllModels[] = {Model::plain, Model::massed, Model::rough};
inline constexpr float kPitch = 0x1p-20f;  // m a lattice step
inline constexpr float kSubstep = 1.0f / 240;

inline std::size_t index_of(Model m) { return static_cast<std::size_t>(m); }

inline float uniform(Random& random, double low, double high) { return static_cast<float>(random.uniform(low, high)); }

/// What a float column can hold at worst.
inline float nasty_float(Random& random) {
  using Limits = std::numeric_limits<float>;
  const float values[] = {0.0f,
                          1.0f,
                          1e30f,
                          1e-30f,
                          3e38f,
                          1e-44f,
                          Limits::denorm_min(),
                          Limits::min(),
                          Limits::infinity(),
                          Limits::quiet_NaN()};
  const float value = values[random.below(std::size(values))];
  return random.chance(0.5) ? -value : value;
}

inline void make_nasty(Random& random, std::vector<float>& column, std::size_t n, double chance) {
  for (std::size_t i = 0; i < n; ++i) {
    if (random.chance(chance)) column[i] = nasty_float(random);
  }
}

/// Body columns: `count` bodies in a square of 4 m, two resting dummies for padding after them, and
/// room to read beyond.
struct Bodies {
  std::size_t count = 0;
  std::vector<std::int32_t> pos, built;
  std::vector<float> vel, vel0, disp, acc, vel_remainder, disp_remainder, drift_correction, pull;
  std::vector<float> rim_speed, rim_speed0, event_time, rim_way, radius, reach;
  std::vector<std::uint8_t> linked;

  Bodies() = default;
  Bodies(Random& random, std::size_t n) : count(n) {
    const std::size_t total = kernels::round_up_block(n + 2) + kernels::kReadPad;
    for (auto* c : {&pos, &built}) c->resize(2 * total);
    for (auto* c : {&vel, &vel0, &disp, &acc, &vel_remainder}) c->resize(2 * total);
    for (auto* c : {&rim_speed, &rim_speed0, &event_time, &rim_way, &radius, &reach}) c->resize(total);
    linked.resize(total);
    for (std::size_t i = 0; i < 2 * n; ++i) {
      pos[i] = static_cast<std::int32_t>(random.uniform(-2, 2) / kPitch);
      built[i] = pos[i] + static_cast<std::int32_t>(random.uniform(-1e5, 1e5));
      vel[i] = uniform(random, -30, 30);
      vel0[i] = random.chance(0.5) ? vel[i] - uniform(random, -0.05, 0.05) : uniform(random, -30, 30);
      disp[i] = uniform(random, -0.02, 0.02);
      acc[i] = uniform(random, -20, 20);
      vel_remainder[i] = uniform(random, -1e-6, 1e-6);
    }
    for (std::size_t i = 0; i < n; ++i) {
      rim_speed[i] = uniform(random, -5, 5);
      rim_speed0[i] = uniform(random, -5, 5);
      event_time[i] = random.chance(0.8) ? 0 : uniform(random, 0, kSubstep);
      radius[i] = uniform(random, 0.2, 0.6);
      reach[i] = radius[i] + uniform(random, 0, 0.1);
      linked[i] = random.chance(0.5) ? 0xFF : 0;
    }
    Random own(n);  // of what fields need
    for (auto* c : {&disp_remainder, &drift_correction}) c->resize(2 * total);
    pull.resize(total);
    for (std::size_t i = 0; i < 2 * n; ++i) {
      disp_remainder[i] = uniform(own, -1e-9, 1e-9);
      drift_correction[i] = uniform(own, -1e-5, 1e-5);
    }
    for (std::size_t i = 0; i < n; ++i) pull[i] = own.chance(0.2) ? 0 : uniform(own, -1, 2);
  }

  std::uint32_t dummy() const { return static_cast<std::uint32_t>(count); }

  void be_nasty(Random& random, double chance) {
    for (auto* c : {&vel, &vel0, &disp, &acc, &vel_remainder}) make_nasty(random, *c, 2 * count, chance);
    for (auto* c : {&rim_speed, &rim_speed0}) make_nasty(random, *c, count, chance);
    Random own(count);
    for (auto* c : {&disp_remainder, &drift_correction}) make_nasty(own, *c, 2 * count, chance);
    make_nasty(own, pull, count, chance);
    for (std::size_t i = 0; i < count; ++i) {
      if (!random.chance(chance)) continue;
      const std::int32_t extremes[] = {INT32_MIN, INT32_MAX, 0, -1, 1};
      pos[2 * i] = extremes[random.below(5)];
      pos[2 * i + 1] = extremes[random.below(5)];
    }
    for (std::size_t i = 1; i < count; ++i) {  // coincident bodies
      if (random.chance(chance)) std::copy_n(&pos[2 * i - 2], 2, &pos[2 * i]);
    }
  }

  /// Columns that only some worlds have are null unless asked for: a kernel that touches one then
  /// fails at once.
  BodyView view(bool own_acc = false, bool rotation = false, bool impacts = false) {
    BodyView v;
    v.pos = pos.data();
    v.vel = vel.data();
    v.vel0 = vel0.data();
    v.disp = disp.data();
    v.linked = linked.data();
    if (own_acc) v.acc = acc.data();
    if (rotation) {
      v.rim_speed = rim_speed.data();
      v.rim_speed0 = rim_speed0.data();
    }
    if (impacts) v.event_time = event_time.data();
    if (impacts && rotation) v.rim_way = rim_way.data();
    return v;
  }

  /// What a world with fields and an integrator has.
  BodyView field_view(bool scales) {
    BodyView v = view(true);
    v.vel_remainder = vel_remainder.data();
    v.disp_remainder = disp_remainder.data();
    v.drift_correction = drift_correction.data();
    if (scales) v.pull = pull.data();
    return v;
  }

  std::vector<std::pair<const char*, const std::vector<float>*>> floats() const {
    return {{"disp_rest", &disp_remainder},
            {"drift_correction", &drift_correction},
            {"pull", &pull},
            {"vel", &vel},
            {"vel0", &vel0},
            {"disp", &disp},
            {"acc", &acc},
            {"spin", &rim_speed},
            {"vel_rest", &vel_remainder},
            {"spin0", &rim_speed0},
            {"reach", &reach},
            {"event_time", &event_time},
            {"rim_way", &rim_way},
            {"radius", &radius}};
  }
};

/// Lanes of contacts in blocks of 8, by column. Both kinds share the struct: `step` slots a lane.
struct Contacts {
  std::size_t step = 2;
  std::vector<std::uint32_t> body;
  std::vector<float> nx, ny, gap, impulse, rsum, mass, wa, wb, mu, friction, tmass, qa, qb, e, impact, start, base_x,
      base_y, refresh;

  std::size_t lanes() const { return nx.size(); }

  /// `blocks` blocks; in each, `used` lanes are contacts of distinct bodies and the others padding.
  Contacts() = default;
  Contacts(Random& random, const Bodies& b, bool pairs, std::size_t blocks, std::size_t used) : step(pairs ? 2 : 1) {
    std::vector<std::uint32_t> slots(b.count);
    std::iota(slots.begin(), slots.end(), 0u);
    for (std::size_t block = 0; block < blocks; ++block) {
      for (std::size_t i = slots.size(); i > 1; --i) std::swap(slots[i - 1], slots[random.below(i)]);
      for (std::size_t lane = 0; lane < kBlock; ++lane) {
        if (lane < used) {
          add(random, b, &slots[step * lane]);
        } else {
          pad(b);
        }
      }
    }
  }

  void add(Random& random, const Bodies& b, const std::uint32_t* slots) {
    body.insert(body.end(), slots, slots + step);
    double far = 0;
    double angle = random.uniform(0, 2 * kPi);
    if (step == 2) {
      const auto axis = [&](std::size_t k) {
        return (double{kPitch} * b.pos[2 * std::size_t{slots[1]} + k]) -
               (double{kPitch} * b.pos[2 * std::size_t{slots[0]} + k]);
      };
      far = std::hypot(axis(0), axis(1));
      angle = std::atan2(axis(1), axis(0));
    } else {
      far = random.uniform(0.5, 1);
    }
    const double sum = far - random.uniform(-0.01, 0.05);
    nx.push_back(static_cast<float>(std::cos(angle)));
    ny.push_back(static_cast<float>(std::sin(angle)));
    base_x.push_back(static_cast<float>(far * std::cos(angle)));
    base_y.push_back(static_cast<float>(far * std::sin(angle)));
    rsum.push_back(static_cast<float>(sum));
    gap.push_back(static_cast<float>(far - sum));
    impulse.push_back(random.chance(0.3) ? (random.chance(0.5) ? 0.0f : -0.0f) : uniform(random, 0, 3));
    const float w0 = random.chance(0.1) ? 0 : uniform(random, 0.2, 3);  // 0: kinematic
    const float w1 = uniform(random, 0.2, 3);
    wa.push_back(w0);
    wb.push_back(w1);
    mass.push_back(1 / (step == 2 ? w0 + w1 : w1));
    mu.push_back(uniform(random, 0, 1));
    friction.push_back(uniform(random, -0.5, 0.5));
    qa.push_back(2 * w0);
    qb.push_back(2 * w1);
    tmass.push_back(mass.back() / 3);
    const float es[] = {uniform(random, 0, 1), 1, uniform(random, 0, 1)};
    e.push_back(es[random.below(3)]);
    impact.push_back(random.chance(0.1) ? 1.0f : random.chance(0.5) ? 0.0f : -0.0f);
    start.push_back((random.chance(0.5) ? 1.0f : -1.0f) * (random.chance(0.5) ? 0 : uniform(random, 0, 1)));
    const float flat = std::numeric_limits<float>::infinity();
    refresh.push_back(random.chance(0.5) ? flat : 0.01f);
  }

  void pad(const Bodies& b) {
    for (std::size_t k = 0; k < step; ++k) {
      body.push_back(b.dummy() + static_cast<std::uint32_t>(k));
    }
    for (auto* c : {&nx, &base_x, &base_y, &impulse, &mass, &wa, &wb, &mu, &friction, &tmass, &qa, &qb, &e, &start}) {
      c->push_back(0);
    }
    for (auto* c : {&ny, &gap, &impact, &refresh}) c->push_back(1);
    rsum.push_back(-1);
  }

  bool is_pad(std::size_t lane) const { return rsum[lane] == -1; }

  void be_nasty(Random& random, double chance) {
    for (std::size_t k = 0; k < lanes(); ++k) {
      if (is_pad(k)) continue;
      for (auto* c : {&gap, &impulse, &friction, &start}) {
        if (random.chance(chance)) (*c)[k] = nasty_float(random);
      }
    }
  }

  ContactView pairs(Model model, bool bounce) {
    ContactView v;
    fill(v, model, bounce);
    if (model != Model::plain) v.wa = wa.data();
    if (model == Model::rough) v.qa = qa.data();
    return v;
  }
  StaticContactView static_contacts(Model model, bool bounce) {
    StaticContactView v;
    fill(v, model, bounce);
    v.base_x = base_x.data();
    v.base_y = base_y.data();
    v.refresh = refresh.data();
    return v;
  }

  std::vector<std::pair<const char*, const std::vector<float>*>> floats() const {
    return {{"nx", &nx},         {"ny", &ny},         {"gap", &gap},        {"impulse", &impulse},
            {"rsum", &rsum},     {"mass", &mass},     {"wa", &wa},          {"wb", &wb},
            {"mu", &mu},         {"tmass", &tmass},   {"qa", &qa},          {"friction", &friction},
            {"qb", &qb},         {"e", &e},           {"impact", &impact},  {"start", &start},
            {"base_x", &base_x}, {"base_y", &base_y}, {"refresh", &refresh}};
  }

 private:
  template <class View>
  void fill(View& v, Model model, bool bounce) {
    v.body = body.data();
    v.nx = nx.data();
    v.ny = ny.data();
    v.gap = gap.data();
    v.impulse = impulse.data();
    v.rsum = rsum.data();
    if (model != Model::plain) {
      v.mass = mass.data();
      v.wb = wb.data();
    }
    if (model == Model::rough) {
      v.mu = mu.data();
      v.friction = friction.data();
      v.tmass = tmass.data();
      v.qb = qb.data();
    }
    if (bounce) {
      v.e = e.data();
      v.impact = impact.data();
      v.start = start.data();
    }
  }
};

inline StreamParams stream_params(Random& random) {
  StreamParams p;
  p.h = kSubstep;
  p.kick_x = uniform(random, -0.1, 0.1);
  p.kick_y = -9.81f * kSubstep;
  p.damp = uniform(random, 0.9, 1);
  p.damp_remainder = 1e-8f;
  p.smooth_limit2 = 0.01f;
  p.coast = 4 * kSubstep;
  p.drop = 8 * kSubstep * kSubstep;
  p.fall_x = uniform(random, -1e-3, 1e-3);
  p.fall_y = -1e-3f;
  p.pitch_x = p.pitch_y = kPitch;
  p.inv_pitch_x = p.inv_pitch_y = 1 / kPitch;
  p.speed_limit2 = 1e6f;
  return p;
}

/// Wells of all kinds (powers 1/2, 1, 3/2, 2.85; soft, hard, with an end, repelling) and drag.
struct FieldSet {
  std::vector<kernels::WellTerms> wells;
  kernels::FieldParams p;

  explicit FieldSet(Random& random, double linear = 0.3, double quadratic = 0.1, double h = kSubstep) {
    const double exponents[] = {0, 1, 2, 4.7};
    for (const double exponent : exponents) {
      kernels::WellTerms w;
      w.x = random.uniform(-2, 2);
      w.y = random.uniform(-2, 2);
      w.strength = random.uniform(-5, 15);
      w.softening2 = random.chance(0.5) ? 0 : random.uniform(0.01, 0.3);
      w.range2 = random.chance(0.5) ? std::numeric_limits<double>::infinity() : 4;
      const double power = (exponent + 1) / 2;
      w.whole = static_cast<std::uint32_t>(power);
      w.fraction = static_cast<std::uint32_t>((power - w.whole) * 0x1p30) << 2;
      wells.push_back(w);
    }
    p.wells = wells.data();
    p.well_count = static_cast<std::uint32_t>(wells.size());
    p.h = h;
    p.pitch_x = p.pitch_y = double{kPitch};
    p.gravity_x = 0.5;
    p.gravity_y = -9.81;
    p.linear = linear;
    p.quadratic = quadratic;
    p.fade = std::exp(-linear * h);
    p.fade_span = linear > 0 ? (1 - p.fade) / linear : h;
    p.half_fade = std::exp(-linear * h / 2);
    p.smooth = 4 * h * h;
  }
  FieldSet(const FieldSet&) = delete;
  FieldSet& operator=(const FieldSet&) = delete;
};

inline ContactParams contact_params() {
  ContactParams p;
  p.h = kSubstep;
  p.inv_h = 1 / kSubstep;
  p.pitch_x = p.pitch_y = kPitch;
  p.soft_rate = 9.5f;
  p.soft_mass = 0.95f;
  p.soft_impulse = 0.05f;
  p.push = 3;
  p.refresh = 0.005f;
  p.warm = 0.8f;
  p.gravity_y = -9.81f;
  p.bounce_floor = 0.2f;
  p.impact_floor = 0.1f;
  return p;
}

}  // namespace psim::test
