#include "event_driven.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace reference {

EventDriven::EventDriven(Box box, double restitution, std::vector<Disc> discs)
    : box_(box), restitution_(restitution), discs_(std::move(discs)), next_(discs_.size()) {
  if (box_.periodic && box_.gravity != 0) throw std::invalid_argument("periodic with gravity");
}

double EventDriven::energy() const {
  double sum = 0;
  for (const Disc& d : discs_) {
    sum += d.mass * (0.5 * dot(d.v, d.v) + box_.gravity * d.x.y);
  }
  return sum;
}

Vec EventDriven::momentum() const {
  Vec sum;
  for (const Disc& d : discs_) sum = sum + d.mass * d.v;
  return sum;
}

void EventDriven::reverse() {
  for (Disc& d : discs_) d.v = -1 * d.v;
}

void EventDriven::advance(double duration) {
  const double end = now_ + duration;
  predict_all();
  for (;;) {
    const Event event = earliest();
    if (event.time > end && horizon_ > end) break;
    if (horizon_ < event.time) {  // the images looked at are no longer enough
      drift(horizon_ - now_);
      predict_all();
      continue;
    }
    drift(event.time - now_);
    resolve(event);
  }
  drift(end - now_);
}

void EventDriven::drift(double t) {
  for (Disc& d : discs_) {
    d.x.x += d.v.x * t;
    d.x.y += d.v.y * t - 0.5 * box_.gravity * t * t;
    d.v.y -= box_.gravity * t;
    if (box_.periodic) {
      d.x.x -= box_.width * std::floor(d.x.x / box_.width);
      d.x.y -= box_.height * std::floor(d.x.y / box_.height);
    }
  }
  now_ += t;
}

Vec EventDriven::nearest(Vec d) const {
  if (!box_.periodic) return d;
  return {std::remainder(d.x, box_.width), std::remainder(d.y, box_.height)};
}

double EventDriven::time_to_meet(Vec d, Vec u, double reach) {
  const double closing = dot(d, u);
  if (closing >= 0) return kNever;
  const double excess = dot(d, d) - reach * reach;
  if (excess <= 0) return 0;
  const double discriminant = closing * closing - dot(u, u) * excess;
  if (discriminant < 0) return kNever;
  return excess / (-closing + std::sqrt(discriminant));
}

double EventDriven::time_to_pair(const Disc& a, const Disc& b) const {
  const Vec d = nearest(b.x - a.x);
  const Vec u = b.v - a.v;
  const double reach = a.radius + b.radius;
  if (!box_.periodic) return time_to_meet(d, u, reach);
  double best = kNever;
  for (int i = -1; i <= 1; ++i) {
    for (int j = -1; j <= 1; ++j) {
      const Vec image{d.x + i * box_.width, d.y + j * box_.height};
      best = std::min(best, time_to_meet(image, u, reach));
    }
  }
  return best;
}

double EventDriven::time_to_close(double gap, double v, double a) {
  if (gap <= 0) {
    if (v < 0) return 0;
    if (a >= 0) return kNever;
    return v > 0 ? -2 * v / a : kNever;  // resting exactly on the wall: not an event
  }
  if (a == 0) return v < 0 ? -gap / v : kNever;
  const double discriminant = v * v - 2 * a * gap;
  if (discriminant < 0) return kNever;
  const double root = std::sqrt(discriminant);
  if (a < 0) return v <= 0 ? 2 * gap / (root - v) : (v + root) / -a;
  return v < 0 ? 2 * gap / (root - v) : kNever;
}

EventDriven::Event EventDriven::predict(std::size_t i) const {
  const Disc& d = discs_[i];
  Event best;
  best.disc = i;
  const auto offer = [&](double in, int partner) {
    if (now_ + in < best.time) {
      best.time = now_ + in;
      best.partner = partner;
    }
  };
  if (!box_.periodic) {
    offer(time_to_close(d.x.x - d.radius, d.v.x, 0), left);
    offer(time_to_close(box_.width - d.radius - d.x.x, -d.v.x, 0), right);
    offer(time_to_close(d.x.y - d.radius, d.v.y, -box_.gravity), bottom);
    offer(time_to_close(box_.height - d.radius - d.x.y, -d.v.y, box_.gravity), top);
  }
  for (std::size_t j = 0; j < discs_.size(); ++j) {
    if (j != i) offer(time_to_pair(d, discs_[j]), static_cast<int>(j));
  }
  return best;
}

void EventDriven::predict_all() {
  for (std::size_t i = 0; i < discs_.size(); ++i) next_[i] = predict(i);
  horizon_ = kNever;
  if (!box_.periodic || discs_.empty()) return;
  // No disc can be faster than if it had all the energy; until two such have come a quarter of
  // the box closer, the nearest nine images are all that can meet.
  double lightest = discs_[0].mass;
  for (const Disc& d : discs_) lightest = std::min(lightest, d.mass);
  const double fastest = std::sqrt(2 * energy() / lightest);
  if (fastest > 0) horizon_ = now_ + 0.25 * std::min(box_.width, box_.height) / (2 * fastest);
}

EventDriven::Event EventDriven::earliest() const {
  Event best;
  for (const Event& e : next_) {
    if (e.time < best.time) best = e;
  }
  return best;
}

void EventDriven::resolve(const Event& event) {
  if (++events_ > 50'000'000) throw std::runtime_error("event-driven run does not end");
  Disc& a = discs_[event.disc];
  const double bounce = -restitution_;
  if (event.partner < kNobody) {
    const bool sideways = event.partner == left || event.partner == right;
    (sideways ? a.v.x : a.v.y) *= bounce;
    ++wall_collisions_;
  } else {
    Disc& b = discs_[static_cast<std::size_t>(event.partner)];
    const Vec d = nearest(b.x - a.x);
    const double distance = length(d);
    const Vec n = (1 / distance) * d;
    const double j = -(1 + restitution_) * dot(b.v - a.v, n) / (1 / a.mass + 1 / b.mass);
    a.v = a.v - (j / a.mass) * n;
    b.v = b.v + (j / b.mass) * n;
    virial_ += j * distance;
    ++pair_collisions_;
  }
  // The two plan again, and whoever had planned with one of them. That another disc now meets
  // them sooner stands in their own new plan.
  const int first = static_cast<int>(event.disc);
  const int second = event.partner;
  for (std::size_t i = 0; i < discs_.size(); ++i) {
    const int self = static_cast<int>(i);
    const int partner = next_[i].partner;
    if (self == first || self == second || partner == first || (second >= 0 && partner == second)) {
      next_[i] = predict(i);
    }
  }
}

}  // namespace reference
