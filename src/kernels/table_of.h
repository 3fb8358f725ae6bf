// The table of one translation unit: every kernel on the unit's lane type.
#pragma once

#include <cstring>

#include "collide_kernel.h"
#include "contact_kernel.h"
#include "field_kernel.h"
#include "fluid_grid_kernel.h"
#include "fluid_particle_kernel.h"
#include "impact_kernel.h"
#include "joint_line_kernel.h"
#include "joint_pin_kernel.h"
#include "joint_share_kernel.h"
#include "joint_slide_kernel.h"
#include "kernel_table.h"
#include "lasting_kernel.h"
#include "manifold_kernel.h"
#include "pair_kernel.h"
#include "static_contact_kernel.h"
#include "stream_kernel.h"

namespace psim::kernels {
namespace {

template <class L>
constexpr KernelTable table_of() {
  constexpr auto plain = Model::plain, massed = Model::massed, rough = Model::rough;
  constexpr auto none = Bounce::none, edge = Bounce::edge, inner = Bounce::inner;
  constexpr auto first = Sweep::first, later = Sweep::later, sliced = Sweep::sliced;
  return {
      .width = L::width,
      .kick_first = kick_first<L>,
      .kick_again = kick_again<L>,
      .drift = drift<L>,
      .integrate = integrate<L>,
      .list_age = list_age<L>,
      .look_ahead = look_ahead<L>,
      .reaches = reaches<L>,
      .extent = extent<L>,
      .cell_keys = cell_keys<L>,
      .accelerate = {accelerate<L, false>, accelerate<L, true>},
      .advance = {{advance<L, Method::euler, false>, advance<L, Method::euler, true>},
                  {advance<L, Method::rk4, false>, advance<L, Method::rk4, true>},
                  {advance<L, Method::symplectic4, false>, advance<L, Method::symplectic4, true>}},
      .drift_corrected = drift_corrected<L>,
      .find_pairs = find_pairs<L>,
      .find_near = find_near<L>,
      .select_pairs = select_pairs<L>,
      .prepare = prepare_contacts<L>,
      .warm = {warm_contacts<L, plain>, warm_contacts<L, massed>, warm_contacts<L, rough>},
      .solve = {{solve_contacts<L, plain, none>, solve_contacts<L, plain, edge>, solve_contacts<L, plain, inner>},
                {solve_contacts<L, massed, none>, solve_contacts<L, massed, edge>, solve_contacts<L, massed, inner>},
                {solve_contacts<L, rough, none>, solve_contacts<L, rough, edge>, solve_contacts<L, rough, inner>}},
      .relax = {{relax_contacts<L, plain, none>, relax_contacts<L, plain, edge>, relax_contacts<L, plain, inner>},
                {relax_contacts<L, massed, none>, relax_contacts<L, massed, edge>, relax_contacts<L, massed, inner>},
                {relax_contacts<L, rough, none>, relax_contacts<L, rough, edge>, relax_contacts<L, rough, inner>}},
      .spend = {spend_contacts<L, plain>, spend_contacts<L, massed>, spend_contacts<L, rough>},
      .sweep = {{sweep_contacts<L, plain, first>, sweep_contacts<L, plain, later>, sweep_contacts<L, plain, sliced>},
                {sweep_contacts<L, massed, first>, sweep_contacts<L, massed, later>, sweep_contacts<L, massed, sliced>},
                {sweep_contacts<L, rough, first>, sweep_contacts<L, rough, later>, sweep_contacts<L, rough, sliced>}},
      .warm_static = {warm_statics<L, plain>, warm_statics<L, massed>, warm_statics<L, rough>},
      .solve_static = {{solve_statics<L, plain, none>, solve_statics<L, plain, edge>, solve_statics<L, plain, inner>},
                       {solve_statics<L, massed, none>, solve_statics<L, massed, edge>,
                        solve_statics<L, massed, inner>},
                       {solve_statics<L, rough, none>, solve_statics<L, rough, edge>, solve_statics<L, rough, inner>}},
      .relax_static = {{relax_statics<L, plain, none>, relax_statics<L, plain, edge>, relax_statics<L, plain, inner>},
                       {relax_statics<L, massed, none>, relax_statics<L, massed, edge>,
                        relax_statics<L, massed, inner>},
                       {relax_statics<L, rough, none>, relax_statics<L, rough, edge>, relax_statics<L, rough, inner>}},
      .spend_static = {spend_statics<L, plain>, spend_statics<L, massed>, spend_statics<L, rough>},
      // Sweeps over contacts with fixed shapes ask every lane each time, so that `sliced` is `later`.
      .sweep_static = {{sweep_statics<L, plain, first>, sweep_statics<L, plain, later>, sweep_statics<L, plain, later>},
                       {sweep_statics<L, massed, first>, sweep_statics<L, massed, later>,
                        sweep_statics<L, massed, later>},
                       {sweep_statics<L, rough, first>, sweep_statics<L, rough, later>,
                        sweep_statics<L, rough, later>}},
      .warm_manifolds = {warm_manifolds<L, false>, warm_manifolds<L, true>},
      .solve_manifolds = {{{solve_manifolds<L, false, false, false>, solve_manifolds<L, false, false, true>},
                           {solve_manifolds<L, false, true, false>, solve_manifolds<L, false, true, true>}},
                          {{solve_manifolds<L, true, false, false>, solve_manifolds<L, true, false, true>},
                           {solve_manifolds<L, true, true, false>, solve_manifolds<L, true, true, true>}}},
      .relax_manifolds = {{{relax_manifolds<L, false, false, false>, relax_manifolds<L, false, false, true>},
                           {relax_manifolds<L, false, true, false>, relax_manifolds<L, false, true, true>}},
                          {{relax_manifolds<L, true, false, false>, relax_manifolds<L, true, false, true>},
                           {relax_manifolds<L, true, true, false>, relax_manifolds<L, true, true, true>}}},
      .spend_manifolds = {spend_manifolds<L, false>, spend_manifolds<L, true>},
      .turn_bodies = turn_bodies<L>,
      .last_manifolds = {last_manifolds<L, false>, last_manifolds<L, true>},
      .collide = {{collide_discs<L, 2>, collide_hulls<L, 2, 2>, collide_hulls<L, 2, 4>, collide_hulls<L, 2, 8>},
                  {collide_discs<L, 4>, collide_hulls<L, 4, 2>, collide_hulls<L, 4, 4>, collide_hulls<L, 4, 8>},
                  {collide_discs<L, 8>, collide_hulls<L, 8, 2>, collide_hulls<L, 8, 4>, collide_hulls<L, 8, 8>}},
      .warm_joints = {{warm_lines<L, false>, warm_lines<L, true>},
                      {warm_lines<L, false>, warm_lines<L, true>},
                      {warm_pins<L, false, PinBlock>, warm_pins<L, true, PinBlock>},
                      {warm_pins<L, false, DrivenBlock>, warm_pins<L, true, DrivenBlock>},
                      {warm_slides<L, false>, warm_slides<L, true>},
                      {warm_pins<L, false, WeldBlock>, warm_pins<L, true, WeldBlock>}},
      .solve_joints = {{solve_lines<L, false, false>, solve_lines<L, true, false>},
                       {solve_lines<L, false, true>, solve_lines<L, true, true>},
                       {solve_pins<L, false, PinBlock>, solve_pins<L, true, PinBlock>},
                       {solve_pins<L, false, DrivenBlock>, solve_pins<L, true, DrivenBlock>},
                       {solve_slides<L, false>, solve_slides<L, true>},
                       {solve_pins<L, false, WeldBlock>, solve_pins<L, true, WeldBlock>}},
      .relax_joints = {{relax_lines<L, false, false>, relax_lines<L, true, false>},
                       {relax_lines<L, false, true>, relax_lines<L, true, true>},
                       {relax_pins<L, false, PinBlock>, relax_pins<L, true, PinBlock>},
                       {relax_pins<L, false, DrivenBlock>, relax_pins<L, true, DrivenBlock>},
                       {relax_slides<L, false>, relax_slides<L, true>},
                       {relax_pins<L, false, WeldBlock>, relax_pins<L, true, WeldBlock>}},
      .push_joints = {{push_lines<L, false>, push_lines<L, true>},
                      {push_nothing<L>, push_nothing<L>},
                      {push_pins<L, false, PinBlock>, push_pins<L, true, PinBlock>},
                      {push_pins<L, false, DrivenBlock>, push_pins<L, true, DrivenBlock>},
                      {push_slides<L, false>, push_slides<L, true>},
                      {push_pins<L, false, WeldBlock>, push_pins<L, true, WeldBlock>}},
      .part_joints = part_joints<L>,
      .hold_joints = hold_joints<L>,
      .let_go_joints = let_go_joints<L>,
      .scatter_fluid = scatter_fluid<L>,
      .gather_fluid = gather_fluid<L>,
      .move_fluid = move_fluid<L>,
      .begin_fluid = begin_fluid<L>,
      .smooth_fluid = smooth_fluid<L>,
      .fluid_residual = fluid_residual<L>,
      .prolong_fluid = prolong_fluid<L>,
      .turn_fluid = turn_fluid<L>,
      .advance_fluid = advance_fluid<L>,
  };
}

}  // namespace
}  // namespace psim::kernels
