// A world of the C API that the tests make, and how it is told of.
#pragma once

#include <psim.h>

#include <limits>

#include "support.h"

namespace psim::test {

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

struct CWorld {
  explicit CWorld(const psim_world_desc& desc, const psim_run_options* options = nullptr) {
    result = psim_world_create(&desc, options, &world, error, sizeof error);
  }
  CWorld() : CWorld(defaults()) {}
  ~CWorld() { psim_world_destroy(world); }
  CWorld(const CWorld&) = delete;
  CWorld& operator=(const CWorld&) = delete;

  static psim_world_desc defaults() {
    psim_world_desc desc;
    psim_world_desc_init(&desc);
    return desc;
  }
  psim_body_id add(const psim_shape& shape, psim_vec2 position, std::int32_t type = PSIM_BODY_DYNAMIC) {
    psim_body_desc desc;
    psim_body_desc_init(&desc);
    desc.shape = shape;
    desc.position = position;
    desc.type = type;
    psim_body_id id{};
    EXPECT_EQ(psim_world_add_body(world, &desc, &id), PSIM_OK) << last();
    return id;
  }
  std::string last() const {
    char text[256];
    psim_last_error(world, text, sizeof text);
    return text;
  }

  psim_world* world = nullptr;
  psim_result result = PSIM_OK;
  char error[256] = "";
};

}  // namespace psim::test
