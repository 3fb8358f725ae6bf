// Zones for a profiler of the host, live: one around each stage of a step, one around what a worker does for a stage, one
// around the wait for workers. The host names a header with the class PsimZone when it builds psim (docs/library.md);
// without one a zone is empty and compiles to nothing.
#pragma once

#ifdef PSIM_PROFILE_HEADER

#include <optional>

#include PSIM_PROFILE_HEADER

namespace psim {

/// Begins with the object and ends with it; `name` stays valid.
using ProfileZone = ::PsimZone;

/// A zone that begins within its scope, or not at all.
class LateZone {
 public:
  void begin(const char* name) {
    if (!zone_) zone_.emplace(name);
  }

 private:
  std::optional<ProfileZone> zone_;
};

}  // namespace psim

#else

namespace psim {

struct ProfileZone {
  explicit ProfileZone(const char*) {}
};

struct LateZone {
  void begin(const char*) {}
};

}  // namespace psim

#endif
