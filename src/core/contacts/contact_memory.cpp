// The memory of contacts: room for lanes, the impulses of the last layout and of the present one, and the views of the
// kernels.
#include <algorithm>

#include "contacts/contact_store.h"

namespace psim {

using kernels::Model;

ContactStore::ContactStore(MemoryMeter& m)
    : body(m),
      nx(m),
      ny(m),
      gap(m),
      rsum(m),
      impulse(m),
      mass(m),
      wa(m),
      wb(m),
      mu(m),
      friction(m),
      tmass(m),
      qa(m),
      qb(m),
      e(m),
      impact(m),
      start(m),
      s_body(m),
      s_shape(m),
      s_nx(m),
      s_ny(m),
      s_gap(m),
      s_base_x(m),
      s_base_y(m),
      s_rsum(m),
      s_refresh(m),
      s_impulse(m),
      s_mass(m),
      s_wb(m),
      s_mu(m),
      s_friction(m),
      s_tmass(m),
      s_qb(m),
      s_e(m),
      s_impact(m),
      s_start(m),
      used_(m),
      colour_(m),
      old_impulse_(m),
      old_friction_(m),
      old_s_impulse_(m),
      old_s_friction_(m),
      old_s_nx_(m),
      old_s_ny_(m) {}

void ContactStore::forget() {
  if (!impulse.empty()) std::fill_n(impulse.data(), impulse.capacity(), 0.0f);
  if (!friction.empty()) std::fill_n(friction.data(), friction.capacity(), 0.0f);
  if (!s_impulse.empty()) std::fill_n(s_impulse.data(), s_impulse.capacity(), 0.0f);
  if (!s_friction.empty()) std::fill_n(s_friction.data(), s_friction.capacity(), 0.0f);
}

void ContactStore::make_room(std::size_t pair_lanes, std::size_t static_lanes) {
  body.reserve_loosely(2 * pair_lanes);
  for (Column<float>* c : {&nx, &ny, &gap, &rsum, &impulse, &old_impulse_}) c->reserve_loosely(pair_lanes);
  s_body.reserve_loosely(static_lanes);
  s_shape.reserve_loosely(static_lanes);
  for (Column<float>* c : {&s_nx, &s_ny, &s_gap, &s_base_x, &s_base_y, &s_rsum, &s_refresh, &s_impulse, &old_s_impulse_,
                           &old_s_nx_, &old_s_ny_}) {
    c->reserve_loosely(static_lanes);
  }
  if (model_.bounce) {
    for (Column<float>* c : {&e, &impact, &start}) c->reserve_loosely(pair_lanes);
    for (Column<float>* c : {&s_e, &s_impact, &s_start}) c->reserve_loosely(static_lanes);
  }
  if (model_.model == Model::plain) return;
  for (Column<float>* c : {&mass, &wa, &wb}) c->reserve_loosely(pair_lanes);
  for (Column<float>* c : {&s_mass, &s_wb}) c->reserve_loosely(static_lanes);
  if (model_.model == Model::massed) return;
  for (Column<float>* c : {&mu, &friction, &old_friction_, &tmass, &qa, &qb}) c->reserve_loosely(pair_lanes);
  for (Column<float>* c : {&s_mu, &s_friction, &old_s_friction_, &s_tmass, &s_qb}) {
    c->reserve_loosely(static_lanes);
  }
}

std::size_t ContactStore::friction_bytes() const {
  std::size_t sum = 0;
  for (const Column<float>* c :
       {&mu, &friction, &old_friction_, &tmass, &qa, &qb, &s_mu, &s_friction, &old_s_friction_, &s_tmass, &s_qb}) {
    sum += c->bytes();
  }
  return sum;
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
  swap_impulses();
  make_room(pairs, static_contacts);
  swap_impulses();
}

void ContactStore::turn_back() {
  if (laying_) swap_impulses();
}

void ContactStore::accept() {
  if (laying_) ++builds_;
  laying_ = false;
}

kernels::ContactView ContactStore::pairs() {
  kernels::ContactView v;
  v.body = body.data();
  v.nx = nx.data();
  v.ny = ny.data();
  v.gap = gap.data();
  v.impulse = impulse.data();
  v.rsum = rsum.data();
  v.mass = mass.data();
  v.wa = wa.data();
  v.wb = wb.data();
  v.mu = mu.data();
  v.friction = friction.data();
  v.tmass = tmass.data();
  v.qa = qa.data();
  v.qb = qb.data();
  v.e = e.data();
  v.impact = impact.data();
  v.start = start.data();
  return v;
}

kernels::StaticContactView ContactStore::static_contacts() {
  kernels::StaticContactView v;
  v.body = s_body.data();
  v.nx = s_nx.data();
  v.ny = s_ny.data();
  v.gap = s_gap.data();
  v.impulse = s_impulse.data();
  v.base_x = s_base_x.data();
  v.base_y = s_base_y.data();
  v.rsum = s_rsum.data();
  v.refresh = s_refresh.data();
  v.mass = s_mass.data();
  v.wb = s_wb.data();
  v.mu = s_mu.data();
  v.friction = s_friction.data();
  v.tmass = s_tmass.data();
  v.qb = s_qb.data();
  v.e = s_e.data();
  v.impact = s_impact.data();
  v.start = s_start.data();
  return v;
}

}  // namespace psim
