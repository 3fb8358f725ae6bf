// The table of one translation unit: every kernel on the unit's lane type.
#pragma once

#include <cstring>

#include "contact_kernel.h"
#include "field_kernel.h"
#include "impact_kernel.h"
#include "kernel_table.h"
#include "pair_kernel.h"
#include "single_kernel.h"
#include "stream_kernel.h"

namespace psim::kernels {
namespace {

template <class L>
constexpr KernelTable table_of() {
  constexpr auto plain = Model::plain, massed = Model::massed, rough = Model::rough;
  return {
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
      .drift_bent = drift_bent<L>,
      .find_pairs = find_pairs<L>,
      .find_near = find_near<L>,
      .select_pairs = select_pairs<L>,
      .prepare = prepare_contacts<L>,
      .warm = {warm_contacts<L, plain>, warm_contacts<L, massed>, warm_contacts<L, rough>},
      .solve = {{solve_contacts<L, plain, false>, solve_contacts<L, plain, true>},
                {solve_contacts<L, massed, false>, solve_contacts<L, massed, true>},
                {solve_contacts<L, rough, false>, solve_contacts<L, rough, true>}},
      .relax = {{relax_contacts<L, plain, false>, relax_contacts<L, plain, true>},
                {relax_contacts<L, massed, false>, relax_contacts<L, massed, true>},
                {relax_contacts<L, rough, false>, relax_contacts<L, rough, true>}},
      .spend = {spend_contacts<L, plain>, spend_contacts<L, massed>, spend_contacts<L, rough>},
      .sweep = {sweep_contacts<L, plain>, sweep_contacts<L, massed>, sweep_contacts<L, rough>},
      .warm_single = {warm_singles<L, plain>, warm_singles<L, massed>, warm_singles<L, rough>},
      .solve_single = {{solve_singles<L, plain, false>, solve_singles<L, plain, true>},
                       {solve_singles<L, massed, false>, solve_singles<L, massed, true>},
                       {solve_singles<L, rough, false>, solve_singles<L, rough, true>}},
      .relax_single = {{relax_singles<L, plain, false>, relax_singles<L, plain, true>},
                       {relax_singles<L, massed, false>, relax_singles<L, massed, true>},
                       {relax_singles<L, rough, false>, relax_singles<L, rough, true>}},
      .spend_single = {spend_singles<L, plain>, spend_singles<L, massed>,
                       spend_singles<L, rough>},
      .sweep_single = {sweep_singles<L, plain>, sweep_singles<L, massed>,
                       sweep_singles<L, rough>},
  };
}

}  // namespace
}  // namespace psim::kernels
