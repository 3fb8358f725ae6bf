// Makes a scene that breaks a law as small as it can be.
#pragma once

#include "law.h"

namespace psim::laws {

/// Takes bodies and joints out, and simplifies what is left, as long as the law stays broken and `tries` last.
Scene shrunk(const Law& law, Scene scene, int tries);

}  // namespace psim::laws
