// Discs that go over edges, substep by substep. Before the contacts are solved, every loose edge gets the contact that the
// disc has in the middle of the substep. Where the disc comes to an edge that rises, it hits this edge at its time and is
// lifted off the one that bore it: neither the order of the contacts nor the length of the substep matters.
#include <algorithm>
#include <cmath>
#include <span>

#include "base/elementary.h"
#include "base/rotor.h"
#include "contacts/contact_store.h"

namespace psim {
namespace {

constexpr int kMostHits = 16;       // of a disc in a substep
constexpr double kTouching = 1e-4;  // share of the radius

class EdgeFollower {
 public:
  EdgeFollower(StaticLanes& c, ContactModel model, const kernels::BodyView& bodies, double h)
      : c_(c), model_(model), b_(bodies), h_(h) {}

  void body(std::span<const LooseEdge> edges) {
    edges_ = edges;
    i_ = c_.body[edges[0].lane];
    if (!(weight_of(edges[0].lane) > 0)) return;  // nothing stops a kinematic disc
    for (const LooseEdge& edge : edges) turn(edge);
    for (const LooseEdge& edge : edges) {
      if (c_.impulse[edge.lane] > 0 && !is_there(edge.lane)) hand_over(edge.lane);
    }
    const LooseEdge* from = find_bearer();
    if (from != nullptr) settle(from->lane);
    double time = 0;
    for (int hits = 0; hits < kMostHits; ++hits) {
      const LooseEdge* const next = hit_next(from, time);
      if (next == nullptr) break;
      if (from != nullptr) lift_off(from->lane, time / h_);
      hit(next->lane, time);
      from = next;
    }
  }

 private:
  Vec2 normal_of(std::uint32_t at) const { return {c_.nx[at], c_.ny[at]}; }
  Vec2 record(const float* column) const { return {column[2 * i_], column[2 * i_ + 1]}; }
  double weight_of(std::uint32_t at) const { return model_.massed() ? c_.wb[at] : 1.0f; }
  bool is_there(std::uint32_t at) const { return c_.gap[at] < kNoGap; }
  void push(float* column, Vec2 by) const {
    column[2 * i_] += static_cast<float>(by.x);
    column[2 * i_ + 1] += static_cast<float>(by.y);
  }

  // What an impulse along a normal and across it does to the velocity.
  static Vec2 change_of(double weight, Vec2 n, double l, double t) {
    return {weight * (l * n.x - t * n.y), weight * (l * n.y + t * n.x)};
  }
  double rubs(std::uint32_t at) const { return model_.rough() ? c_.friction[at] : 0.0f; }

  // An impulse that the velocity holds turns with the normal.
  void turn(const LooseEdge& loose) const {
    const std::uint32_t at = loose.lane;
    const Vec2 was = normal_of(at);
    put_edge(meet_edge(loose.edge, record(b_.disp), 2 * h_ * record(b_.vel), 0.25), c_, at);
    push(b_.vel, change_of(weight_of(at), normal_of(at) - was, c_.impulse[at], rubs(at)));
  }

  // The load of an edge that the disc has left goes to the one on which it is.
  void hand_over(std::uint32_t from) const {
    const Vec2 n = normal_of(from);
    const LooseEdge* best = nullptr;
    double most = 0.5;
    for (const LooseEdge& edge : edges_) {
      if (!is_there(edge.lane) || dot(n, normal_of(edge.lane)) <= most) continue;
      most = dot(n, normal_of(edge.lane));
      best = &edge;
    }
    if (best == nullptr) return;
    const std::uint32_t to = best->lane;
    push(b_.vel, change_of(weight_of(from), normal_of(to) - n, c_.impulse[from], rubs(from)));
    c_.impulse[to] = std::max(c_.impulse[to], 0.0f) + c_.impulse[from];
    c_.impulse[from] = 0;
    if (!model_.rough()) return;
    c_.friction[to] += c_.friction[from];
    c_.friction[from] = 0;
  }

  // The edge on which the disc lies when the substep begins, if there is one.
  const LooseEdge* find_bearer() const {
    const Vec2 v = record(b_.vel), v0 = record(b_.vel0), moved = record(b_.disp);
    const LooseEdge* best = nullptr;
    float most = -1;
    for (const LooseEdge& edge : edges_) {
      const Vec2 n = normal_of(edge.lane);
      const double gap = static_cast<double>(c_.gap[edge.lane]) + dot(n, moved);
      const float l = std::max(c_.impulse[edge.lane], 0.0f);
      const bool lies = gap < kTouching * edge.edge.radius && dot(n, v) < 0.5 * dot(n, v0);
      if (!is_there(edge.lane) || !(l > 0 || lies) || l <= most) continue;
      most = l;
      best = &edge;
    }
    return best;
  }

  // An edge bears what holds the disc against the kick of this substep, which repeated what it bore in the last one.
  void settle(std::uint32_t at) const {
    const Vec2 n = normal_of(at);
    const double had = std::max(c_.impulse[at], 0.0f);
    const double l = greater(had - dot(n, record(b_.vel)) / weight_of(at), 0.0);
    push(b_.vel, change_of(weight_of(at), n, l - had, 0));
    c_.impulse[at] = static_cast<float>(l);
  }

  // The next edge that the disc hits after `time` and that lifts it off the edge `from`, if there is one. An approach
  // that only the kick of this substep made is no hit.
  const LooseEdge* hit_next(const LooseEdge* from, double& time) const {
    const Vec2 v = record(b_.vel), v0 = record(b_.vel0), moved = record(b_.disp);
    const LooseEdge* next = nullptr;
    double soonest = h_;
    for (const LooseEdge& edge : edges_) {
      const std::uint32_t to = edge.lane;
      if (&edge == from || !is_there(to) || c_.impulse[to] > 0 || (model_.bounce && c_.e[to] > 0)) continue;
      const Vec2 n = normal_of(to);
      const double closing = -dot(n, v);
      if (!(closing > 0) || -dot(n, v0) < 0.5 * closing) continue;
      const double mean = 0.5 * (closing - dot(n, v0));  // the disc goes at the mean velocity
      const double when = greater((static_cast<double>(c_.gap[to]) + dot(n, moved)) / mean, time);
      if (when >= soonest || (from != nullptr && !lifts(from->lane, v, n, closing))) continue;
      soonest = when;
      next = &edge;
    }
    time = soonest;
    return next;
  }

  // Whether an impact along n lifts the disc off an edge.
  bool lifts(std::uint32_t from, Vec2 v, Vec2 n, double closing) const {
    const Vec2 mine = normal_of(from);
    const double load = weight_of(from) * greater(static_cast<double>(c_.impulse[from]), 0.0), cosine = dot(mine, n);
    return cosine > 0 && dot(mine, v) + closing * cosine >= load * (1 - cosine * cosine);
  }

  // What an edge bore up to a share of the substep is done; the rest of its load is taken back.
  void lift_off(std::uint32_t from, double share) const {
    const Vec2 change = change_of(weight_of(from), normal_of(from), c_.impulse[from], rubs(from));
    push(b_.vel, (share - 1) * change);
    push(b_.vel0, share * change);
    spin(from, (share - 1) * rubs(from), share * rubs(from));
    c_.impulse[from] = 0;
    c_.gap[from] = kNoGap;
    if (model_.rough()) c_.friction[from] = 0;
  }

  // An impact without restitution at its time, as in the sweeps (docs/solver.md). The disc goes on along the edge.
  void hit(std::uint32_t to, double time) const {
    const Vec2 v = record(b_.vel), n = normal_of(to);
    const double weight = weight_of(to), l = -dot(n, v) / weight;
    double t = 0;
    if (model_.rough()) {
      const double slip = cross(n, v) - static_cast<double>(b_.rim_speed[i_]),
                   most = static_cast<double>(c_.mu[to]) * l;
      t = lesser(greater(-slip * static_cast<double>(c_.tmass[to]), -most), most);
      spin(to, t, t);
    }
    const Vec2 change = change_of(weight, n, l, t);
    const double lasts = greater(l + dot(n, record(b_.vel0)) / weight, 0.0);  // holds it against the kick
    const Vec2 change_before = change - weight * lasts * n;
    push(b_.vel, change);
    push(b_.vel0, change_before);
    c_.impulse[to] = static_cast<float>(lasts);
    push(b_.disp, -0.5 * time * (change + change_before));
  }

  // What impulses across the normal do to the rim speeds, now and before the kick.
  void spin(std::uint32_t at, double now, double before) const {
    if (!model_.rough()) return;
    b_.rim_speed[i_] -= static_cast<float>(static_cast<double>(c_.qb[at]) * now);
    b_.rim_speed0[i_] -= static_cast<float>(static_cast<double>(c_.qb[at]) * before);
  }

  StaticLanes& c_;
  const ContactModel model_;
  const kernels::BodyView& b_;
  const double h_;
  std::span<const LooseEdge> edges_;
  std::size_t i_ = 0;
};

}  // namespace

void ContactStore::follow_edges(const kernels::BodyView& bodies, double h) {
  if (!any_loose_ || pass_blocks() == 0) return;
  s_.pool.run(edges_.size(), [&](std::size_t index) {
    EdgeFollower follower(fixed, model_, bodies, h);
    std::span<const LooseEdge> list = edges_[index].loose;
    while (!list.empty()) {
      const auto other = [&](const LooseEdge& edge) { return fixed.body[edge.lane] != fixed.body[list[0].lane]; };
      const auto of_body = static_cast<std::size_t>(std::ranges::find_if(list, other) - list.begin());
      follower.body(list.first(of_body));
      list = list.subspan(of_body);
    }
  });
}

}  // namespace psim
