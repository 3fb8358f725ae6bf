#include "manifolds/decisions.h"

#include <algorithm>
#include <utility>

namespace psim {

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
  std::ranges::inplace_merge(list_, list_.begin() + old, {}, &Decision::name);
}

void Decisions::forget(std::uint32_t id) {
  std::erase_if(list_, [id](const Decision& d) { return d.name.a == id || d.name.b == id; });
}

}  // namespace psim
