#include "base/room.h"

#include <utility>

#include "psim/world.h"

namespace psim {

bool& ran_out_of_memory() noexcept {
  thread_local bool ran_out = false;
  return ran_out;
}

bool out_of_memory() noexcept { return std::exchange(ran_out_of_memory(), false); }

}  // namespace psim
