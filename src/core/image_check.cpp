#include "image_check.h"

namespace psim {

template <class W>
void Image::Check<W>::settings() {
  const Ahead& now = w.ahead;
  require(w.substeps >= 1 && w.substeps <= 64 && now.horizon >= 1 && now.waits < 255);
  require(w.list_span >= 0 && w.select_span >= 0 && w.list_skin > 0 && w.last_substep >= 0 && w.stiff_substep >= 0);
  require(w.first_radius >= 0 && w.least_radius >= 0);
  for (const Saved::Done& d : w.saved.done) require(d.part <= static_cast<U32>(Part::done) && d.span >= 0 && d.span <= 1e30);
}

template <class W>
void Image::Check<W>::events() {
  const EventList& e = w.events;
  constexpr std::uint64_t kNoKey = ~std::uint64_t{0};
  for (const BodyId& id : e.removed_) require(id.index < ids());
  const auto known = [&](std::uint64_t key) { return key >> 32 < ids() && static_cast<U32>(key) < ids(); };
  require(e.lane_key_.size() == e.touching_.size() * kernels::kBlock);
  for (const std::uint64_t key : e.lane_key_) require(key == kNoKey || known(key));
  for (const auto* keys : {&e.paired_, &e.toggled_, &e.rest_found_, &e.rest_, &e.slept_, &e.sensed_}) {
    require(std::all_of(keys->begin(), keys->end(), known));
  }
  for (const auto* keys : {&e.paired_, &e.rest_, &e.slept_}) require(std::is_sorted(keys->begin(), keys->end()));
}

template <class W>
void Image::check(Loader& a, W& seen, const W& now, bool lists) {
  Check<W> check{a, seen, now, lists};
  check.all();
}

template void Image::check(Loader&, World::Impl&, const World::Impl&, bool);

}  // namespace psim
