#include "structures.h"

#include <algorithm>
#include <cmath>

namespace reference {

double laguerre(int n, double x) {
  double before = 0, now = 1;
  for (int k = 0; k < n; ++k) {
    const double next = ((2 * k + 1 - x) * now - k * before) / (k + 1);
    before = now;
    now = next;
  }
  return now;
}

std::vector<double> laguerre_zeros(int n, std::size_t count) {
  // They differ by more than 1 / n.
  std::vector<double> zeros;
  const double step = 0.1 / n;
  for (double x = 0; zeros.size() < count; x += step) {
    double low = x, high = x + step;
    if (laguerre(n, low) * laguerre(n, high) > 0) continue;
    for (int k = 0; k < 60; ++k) {
      const double middle = (low + high) / 2;
      (laguerre(n, low) * laguerre(n, middle) > 0 ? low : high) = middle;
    }
    zeros.push_back(low);
  }
  return zeros;
}

double elastic_chain_sag(int links, double link, double stretch_load, double weight, double span) {
  const auto load = [=](int k) { return (0.5 * (links - 1) - k) * weight; };  // upright part of the k-th spring's
  double low = 1e-9 * weight, high = 1e6 * weight;
  for (int n = 0; n < 200; ++n) {
    const double pull = std::sqrt(low * high);
    double width = 0;
    for (int k = 0; k < links; ++k) width += link * pull * (1 / std::hypot(pull, load(k)) + 1 / stretch_load);
    (width < span ? low : high) = pull;
  }
  double sag = 0;
  for (int k = 0; k < links / 2; ++k) sag += link * load(k) * (1 / std::hypot(low, load(k)) + 1 / stretch_load);
  return sag;
}

double Cantilever::drop() const {
  // From the angle of the last link below the level the others follow inwards; the wall's must be 0.
  const auto inwards = [this](double last, double& drop) {
    double angle = last, moment = 0, beyond = tip_weight;
    drop = 0;
    for (int k = 0; k < links; ++k) {
      drop += link * std::sin(angle);
      moment += (beyond + 0.5 * link_weight) * link * std::cos(angle);
      beyond += link_weight;
      angle -= moment / stiffness;
    }
    return angle;
  };
  // Several angles may lead to a level wall; the beam that was bent from straight has the least. Up to it the wall's
  // angle rises from below 0.
  double drop = 0, high = 0;
  while (inwards(high, drop) < 0) high += 1e-3;
  double low = std::max(0.0, high - 1e-3);
  for (int n = 0; n < 80; ++n) {
    const double middle = (low + high) / 2;
    (inwards(middle, drop) < 0 ? low : high) = middle;
  }
  inwards(low, drop);
  return drop;
}

double RockingBlock::slenderness() const { return std::atan(width / height); }

double RockingBlock::amplitude(double start, int impacts) const {
  const double alpha = slenderness(), s = std::sin(alpha);
  const double kept = std::pow(1 - 1.5 * s * s, 2 * impacts);
  const double level = std::cos(alpha) + kept * (std::cos(alpha - start) - std::cos(alpha));
  return alpha - std::acos(std::min(level, 1.0));
}

namespace {

Vec nearest_on(Vec p, Vec q, Vec x) {
  const Vec along = q - p;
  return p + std::clamp(dot(x - p, along) / dot(along, along), 0.0, 1.0) * along;
}

}  // namespace

std::size_t Track::nearest_piece(Vec x) const {
  std::size_t best = 0;
  double least = INFINITY;
  for (std::size_t k = 0; k + 1 < line_.size(); ++k) {
    const double d = length(x - nearest_on(line_[k], line_[k + 1], x));
    if (d < least) best = k, least = d;
  }
  return best;
}

void Track::keep_off(std::size_t piece, State& s) const {
  const Vec away = s.x - nearest_on(line_[piece], line_[piece + 1], s.x);
  const double d = length(away);
  if (d >= radius_) return;
  const Vec n = 1 / d * away;
  s.x = s.x + (radius_ - d) * n;
  s.v = s.v - std::min(dot(s.v, n), 0.0) * n;
}

Track::State Track::after(double time, State s) const {
  constexpr double kStep = 2e-5;
  constexpr int kReach = 3, kLookEvery = 20;  // pieces to either side; steps
  const int steps = static_cast<int>(std::lround(time / kStep));
  std::size_t here = nearest_piece(s.x);
  for (int n = 0; n < steps; ++n) {
    s.v.y -= g_ * kStep;
    s.x = s.x + kStep * s.v;
    const std::size_t from = here > kReach ? here - kReach : 0, to = std::min(here + kReach + 1, line_.size() - 1);
    for (std::size_t k = from; k < to; ++k) keep_off(k, s);
    if (n % kLookEvery == 0) here = nearest_piece(s.x);
  }
  return s;
}

}  // namespace reference
