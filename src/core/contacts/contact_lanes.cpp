#include "contacts/contact_lanes.h"

#include <limits>

#include "bodies/body_store.h"

namespace psim {
namespace {

// Columns that the model reads have room for all lanes; the others give their memory back.
template <class... Columns>
void fit(bool wanted, std::size_t lanes, Columns&... columns) {
  ((wanted ? columns.reserve_loosely(lanes) : columns.release()), ...);
}

template <class View>
View common_view(ContactLanes& c) {
  View v;
  v.body = c.body.data();
  v.nx = c.nx.data();
  v.ny = c.ny.data();
  v.gap = c.gap.data();
  v.impulse = c.impulse.data();
  v.rsum = c.rsum.data();
  v.mass = c.mass.data();
  v.wb = c.wb.data();
  v.mu = c.mu.data();
  v.friction = c.friction.data();
  v.tmass = c.tmass.data();
  v.qb = c.qb.data();
  v.e = c.e.data();
  v.impact = c.impact.data();
  v.start = c.start.data();
  return v;
}

}  // namespace

void ContactLanes::make_room(ContactModel model, std::size_t lanes) {
  body.reserve_loosely(sides * lanes);
  fit(true, lanes, nx, ny, gap, rsum, impulse, old_impulse);
  fit(model.massed(), lanes, mass, wb);
  fit(model.massed() && sides == 2, lanes, wa);
  fit(model.rough(), lanes, mu, friction, old_friction, tmass, qb);
  fit(model.rough() && sides == 2, lanes, qa);
  fit(model.bounce, lanes, e, impact, start);
}

void ContactLanes::swap_impulses() {
  old_impulse.swap(impulse);
  old_friction.swap(friction);
}

void ContactLanes::pad(ContactModel model, std::size_t lane, std::uint32_t dummy) {
  for (std::uint32_t side = 0; side < sides; ++side) body[sides * lane + side] = dummy + side;
  rsum[lane] = -1;
  if (model.bounce) impact[lane] = 1;
  fill(model, {}, lane, {}, {});
  put(model, lane, 0, 0);
}

void ContactLanes::fill_all(ContactModel model, const MixingRules& rules, std::size_t begin, std::size_t end,
                            const BodyProperties& both) {
  if (begin == end) return;
  fill(model, rules, begin, both, both);
  const auto copy_if = [&](bool wanted, auto&... columns) {
    if (wanted) (std::fill(columns.data() + begin + 1, columns.data() + end, columns[begin]), ...);
  };
  copy_if(model.bounce, e);
  copy_if(model.massed(), mass, wb);
  copy_if(model.massed() && sides == 2, wa);
  copy_if(model.rough(), mu, tmass, qb);
  copy_if(model.rough() && sides == 2, qa);
}

kernels::ContactView PairLanes::view() {
  auto v = common_view<kernels::ContactView>(*this);
  v.wa = wa.data();
  v.qa = qa.data();
  return v;
}

void StaticLanes::make_room(ContactModel model, std::size_t lanes) {
  ContactLanes::make_room(model, lanes);
  fit(true, lanes, shape, base_x, base_y, refresh, old_nx, old_ny);
}

void StaticLanes::swap_impulses() {
  ContactLanes::swap_impulses();
  old_nx.swap(nx);
  old_ny.swap(ny);
}

void StaticLanes::pad(ContactModel model, std::size_t lane, std::uint32_t dummy) {
  ContactLanes::pad(model, lane, dummy);
  shape[lane] = kNoSlot;
  nx[lane] = base_x[lane] = base_y[lane] = 0;
  ny[lane] = gap[lane] = 1;
  refresh[lane] = std::numeric_limits<float>::infinity();
}

kernels::StaticContactView StaticLanes::view() {
  auto v = common_view<kernels::StaticContactView>(*this);
  v.base_x = base_x.data();
  v.base_y = base_y.data();
  v.refresh = refresh.data();
  return v;
}

}  // namespace psim
