// New contacts of parts that ask (BodyDesc::pre_solve) are shown to the host, who may let their sides through each other
// or change how they bounce and rub. What was decided lasts until the parts are apart.
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "manifolds/manifold_look.h"
#include "psim/limits.h"

namespace psim {
namespace {

bool is_surface(const NewContact& c) {
  return limits::kFriction.contains(c.friction) && limits::kRestitution.contains(c.restitution) &&
         (c.tangent_speed == 0 || limits::kTangentSpeed.contains(c.tangent_speed)) &&
         (c.rolling_resistance == 0 || limits::kRollingResistance.contains(c.rolling_resistance));
}

// What the host made of a contact. Numbers out of their ranges change nothing.
Decision decision_of(const ContactName& name, const NewContact& shown, const NewContact& now) {
  Decision d;
  d.name = name;
  d.through = !now.enabled;
  const auto surface = [](const NewContact& c) {
    return std::tie(c.friction, c.restitution, c.tangent_speed, c.rolling_resistance);
  };
  d.changed = is_surface(now) && surface(now) != surface(shown);
  if (d.changed) {
    d.surface = {coefficient(now.restitution), coefficient(now.friction), coefficient(now.tangent_speed),
                 coefficient(now.rolling_resistance)};
  }
  return d;
}

void apply(const Decision& d, ManifoldPair& pair) {
  pair.crossing = d.through ? ManifoldPair::kPasses : ManifoldPair::kMeets;
  pair.changed = true;
  if (!d.through) return;
  pair.manifold.count = 0;
  pair.active = pair.ahead = pair.landing = pair.rocking = pair.flying = pair.lasting = false;
  pair.roll = 0;
}

}  // namespace

const Decision* Decisions::find(const ContactName& name) const {
  const auto at = std::ranges::lower_bound(list_, name, {}, &Decision::name);
  return at != list_.end() && at->name == name ? &*at : nullptr;
}

bool Decisions::see(const ContactName& name) {
  const auto at = std::ranges::lower_bound(list_, name, {}, &Decision::name);
  if (at == list_.end() || at->name != name) return false;
  at->seen = true;
  return true;
}

void Decisions::keep_seen(const BodyStore& bodies) {
  const auto sleeps = [&](std::uint32_t id) { return id != kNoSlot && bodies.info[id].place == Place::asleep; };
  std::erase_if(list_,
                [&](Decision& d) { return !std::exchange(d.seen, false) && !sleeps(d.name.a) && !sleeps(d.name.b); });
}

void Decisions::add(std::span<const Decision> decided) {
  const auto old = static_cast<std::ptrdiff_t>(list_.size());
  list_.insert(list_.end(), decided.begin(), decided.end());
  const auto by_name = [](const Decision& x, const Decision& y) { return x.name < y.name; };
  std::inplace_merge(list_.begin(), list_.begin() + old, list_.end(), by_name);
}

void Decisions::forget(std::uint32_t id) {
  std::erase_if(list_, [id](const Decision& d) { return d.name.a == id || d.name.b == id; });
}

bool Manifolds::asks(const PairName& pair) const {
  const BodyStore& b = s_.bodies;
  if (b.asks(b.kind(pair.id_b), pair.part_b)) return true;
  if (pair.of_wall()) return false;
  return b.asks(b.kind(pair.id_a), pair.of_piece() ? s_.statics[pair.shape].part : pair.part_a);
}

// A pair as the host sees it.
NewContact Manifolds::shown(const ManifoldPair& pair, const ContactName& name) const {
  const BodyStore& b = s_.bodies;
  const Manifold& m = pair.manifold;
  const int k = m.count == 2 && pair.gap[1] < pair.gap[0] ? 1 : 0;
  const ManifoldPoint& p = m.point[k];
  const Vec2 normal{m.nx, m.ny}, arm_b{p.bx, p.by}, arm_a{p.ax, p.ay};
  const auto handle = [&](std::uint32_t id) { return id == kNoSlot ? kNoBody : BodyId{id, b.info[id].generation}; };
  const auto speed_at = [&](std::uint32_t slot, Vec2 arm) {
    return b.velocity(slot) + b.omega_of(slot) * upright(arm);
  };
  Vec2 coming = speed_at(pair.b, arm_b);
  if (!pair.of_piece()) coming = coming - speed_at(pair.a, arm_a);
  const double sign = pair.id_b == name.b ? 1 : -1;
  NewContact c;
  c.a = handle(name.a);
  c.b = handle(name.b);
  c.part_a = name.part_a;
  c.part_b = name.b == kNoSlot ? 0 : name.part_b;
  c.separation = pair.gap[k];
  // Of two moving bodies that are apart, the arms end where they will meet.
  const bool ahead = pair.ahead && !pair.fixed_a;
  c.point = s_.lattice.to_world(b.point(pair.b)) + arm_b - (ahead ? c.separation / 2 : 0) * normal;
  c.normal = sign * normal;
  c.speed = -dot(normal, coming);
  const Sides sides = sides_of(pair);
  c.friction = sides.friction(s_.mixing);
  c.restitution = sides.restitution(s_.mixing);
  c.tangent_speed = sides.belt();
  c.rolling_resistance = sides.rolling();
  return c;
}

void Manifolds::ask(const PreSolve& pre_solve) {
  if (!pre_solve && decisions_.empty()) return;
  struct Fresh {
    ContactName name;
    std::uint32_t pair;
  };
  std::vector<Fresh> fresh;
  for (std::uint32_t k = 0; k < pairs_.size(); ++k) {
    ManifoldPair& pair = pairs_[k];
    if (pair.moved || pair.crossing == ManifoldPair::kUnknown) continue;
    const ContactName name = name_of(pair, s_.statics);
    if (!asks(pair)) {  // any more: the next step looks at it anew
      if (decisions_.find(name) == nullptr) continue;
      pair.crossing = ManifoldPair::kUnknown;
      pair.margin = -1;
      continue;
    }
    const bool known = decisions_.see(name);
    if (pair.crossing == ManifoldPair::kNew && (known || pair.active)) fresh.push_back({name, k});
  }
  // Of the pieces of a part the nearest one is shown. Total order: no pair is there twice.
  const auto before = [&](const Fresh& x, const Fresh& y) {
    if (x.name != y.name) return x.name < y.name;
    const float gap_x = pairs_[x.pair].least_gap(), gap_y = pairs_[y.pair].least_gap();
    return gap_x != gap_y ? gap_x < gap_y : x.pair < y.pair;
  };
  std::sort(fresh.begin(), fresh.end(), before);  // Total order: as above.
  std::vector<NewContact> contacts;
  std::vector<ContactName> names;
  for (const Fresh& f : fresh) {
    if ((!names.empty() && names.back() == f.name) || decisions_.find(f.name) != nullptr) continue;
    names.push_back(f.name);
    contacts.push_back(shown(pairs_[f.pair], f.name));
  }
  if (pre_solve && !contacts.empty()) {
    const std::vector<NewContact> before_call = contacts;
    std::vector<Decision> decided;
    decided.reserve(contacts.size());
    decisions_.make_room(contacts.size());
    pre_solve(contacts);
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      decided.push_back(decision_of(names[k], before_call[k], contacts[k]));
      decided.back().seen = true;
    }
    decisions_.add(decided);
  }
  for (const Fresh& f : fresh) {
    if (const Decision* const d = decisions_.find(f.name)) apply(*d, pairs_[f.pair]);
  }
  decisions_.keep_seen(s_.bodies);
}

}  // namespace psim
