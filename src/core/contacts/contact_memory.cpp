// The memory of contacts: room for lanes, the impulses of the last layout and of the present one, and the views of the
// kernels.
#include "contacts/contact_store.h"

namespace psim {

using kernels::Model;

// Columns that the model reads have room for all lanes; the others give their memory back.
void ContactStore::make_room(std::size_t pair_lanes, std::size_t static_lanes) {
  const bool massed = model_.model != Model::plain, bounce = model_.bounce;
  const auto fit = [](bool wanted, std::size_t lanes, auto&... columns) {
    ((wanted ? columns.reserve_loosely(lanes) : columns.release()), ...);
  };
  body.reserve_loosely(2 * pair_lanes);
  fit(true, pair_lanes, nx, ny, gap, rsum, impulse, old_impulse_);
  fit(massed, pair_lanes, mass, wa, wb);
  fit(rough(), pair_lanes, mu, friction, old_friction_, tmass, qa, qb);
  fit(bounce, pair_lanes, e, impact, start);
  fit(true, static_lanes, s_body, s_shape, s_nx, s_ny, s_gap, s_base_x, s_base_y, s_rsum, s_refresh);
  fit(true, static_lanes, s_impulse, old_s_impulse_, old_s_nx_, old_s_ny_);
  fit(massed, static_lanes, s_mass, s_wb);
  fit(rough(), static_lanes, s_mu, s_friction, old_s_friction_, s_tmass, s_qb);
  fit(bounce, static_lanes, s_e, s_impact, s_start);
}

std::size_t ContactStore::friction_bytes() const {
  const auto sum = [](const auto&... columns) { return (columns.bytes() + ...); };
  return sum(mu, friction, old_friction_, tmass, qa, qb, s_mu, s_friction, old_s_friction_, s_tmass, s_qb);
}

void ContactStore::swap_impulses() {
  old_impulse_.swap(impulse);
  old_friction_.swap(friction);
  swap_statics();
}

void ContactStore::swap_statics() {
  old_s_impulse_.swap(s_impulse);
  old_s_nx_.swap(s_nx);
  old_s_ny_.swap(s_ny);
  old_s_friction_.swap(s_friction);
}

void ContactStore::spare(std::size_t pairs, std::size_t static_contacts) {
  colour_.reserve(pairs);
  make_room(pairs, static_contacts);
}

kernels::ContactView ContactStore::pairs() {
  return {.body = body.data(),
          .nx = nx.data(),
          .ny = ny.data(),
          .gap = gap.data(),
          .impulse = impulse.data(),
          .rsum = rsum.data(),
          .mass = mass.data(),
          .wa = wa.data(),
          .wb = wb.data(),
          .mu = mu.data(),
          .friction = friction.data(),
          .tmass = tmass.data(),
          .qa = qa.data(),
          .qb = qb.data(),
          .e = e.data(),
          .impact = impact.data(),
          .start = start.data()};
}

kernels::StaticContactView ContactStore::static_contacts() {
  return {.body = s_body.data(),
          .nx = s_nx.data(),
          .ny = s_ny.data(),
          .gap = s_gap.data(),
          .impulse = s_impulse.data(),
          .base_x = s_base_x.data(),
          .base_y = s_base_y.data(),
          .rsum = s_rsum.data(),
          .refresh = s_refresh.data(),
          .mass = s_mass.data(),
          .wb = s_wb.data(),
          .mu = s_mu.data(),
          .friction = s_friction.data(),
          .tmass = s_tmass.data(),
          .qb = s_qb.data(),
          .e = s_e.data(),
          .impact = s_impact.data(),
          .start = s_start.data()};
}

}  // namespace psim
