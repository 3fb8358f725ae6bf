// The contacts' memory: room, what was before and what is now, and the views that kernels have.
#include <algorithm>

#include "contact_store.h"

namespace psim {

using kernels::Model;

void ContactStore::make_room(std::size_t pair_lanes, std::size_t single_lanes) {
  body.reserve_loosely(2 * pair_lanes);
  for (Column<float>* c : {&nx, &ny, &gap, &rsum, &impulse, &old_impulse_})
    c->reserve_loosely(pair_lanes);
  s_body.reserve_loosely(single_lanes);
  s_shape.reserve_loosely(single_lanes);
  for (Column<float>* c : {&s_nx, &s_ny, &s_gap, &s_base_x, &s_base_y, &s_rsum, &s_refresh,
                           &s_impulse, &old_s_impulse_, &old_s_nx_, &old_s_ny_}) {
    c->reserve_loosely(single_lanes);
  }
  if (model_.bounce) {
    for (Column<float>* c : {&e, &impact, &start}) c->reserve_loosely(pair_lanes);
    for (Column<float>* c : {&s_e, &s_impact, &s_start}) c->reserve_loosely(single_lanes);
  }
  if (model_.model == Model::plain) return;
  for (Column<float>* c : {&mass, &wa, &wb}) c->reserve_loosely(pair_lanes);
  for (Column<float>* c : {&s_mass, &s_wb}) c->reserve_loosely(single_lanes);
  if (model_.model == Model::massed) return;
  for (Column<float>* c : {&mu, &friction, &old_friction_, &tmass, &qa, &qb})
    c->reserve_loosely(pair_lanes);
  for (Column<float>* c : {&s_mu, &s_friction, &old_s_friction_, &s_tmass, &s_qb}) {
    c->reserve_loosely(single_lanes);
  }
}

std::size_t ContactStore::friction_bytes() const {
  std::size_t sum = 0;
  for (const Column<float>* c : {&mu, &friction, &old_friction_, &tmass, &qa, &qb, &s_mu, &s_friction, &old_s_friction_,
                                 &s_tmass, &s_qb}) {
    sum += c->bytes();
  }
  return sum;
}

void ContactStore::swap_impulses() {
  old_impulse_.swap(impulse);
  old_friction_.swap(friction);
  swap_singles();
}

void ContactStore::swap_singles() {
  old_s_impulse_.swap(s_impulse);
  old_s_nx_.swap(s_nx);
  old_s_ny_.swap(s_ny);
  old_s_friction_.swap(s_friction);
}

void ContactStore::spare(std::size_t pairs, std::size_t singles) {
  colour_.reserve(pairs);
  make_room(pairs, singles);
  swap_impulses();
  make_room(pairs, singles);
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

kernels::SingleView ContactStore::singles() {
  kernels::SingleView v;
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
