#include "handle.h"

#include <algorithm>

namespace psim::capi {

std::size_t copy_text(std::string_view text, char* buffer, std::size_t capacity) noexcept {
  if (buffer != nullptr && capacity != 0) {
    buffer[text.copy(buffer, capacity - 1)] = '\0';
  }
  return text.size();
}

psim_result Call::fail(psim_result result, std::string_view what) const noexcept {
  if (psim::out_of_memory()) {  // what the engine answered comes from that
    result = PSIM_ERROR_OUT_OF_MEMORY;
    if (what.find("no room") == what.npos) what = kNothingDone;
  }
  const std::lock_guard lock(world->error_mutex);
  char* at = world->error;
  std::size_t room = psim_world::kErrorRoom;
  for (const std::string_view part : {std::string_view(name), std::string_view(": "), what}) {
    const std::size_t n = std::min(copy_text(part, at, room), room - 1);
    at += n;
    room -= n;
  }
  return result;
}

}  // namespace psim::capi
