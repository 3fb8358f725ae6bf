// Descriptions of worlds and bodies out of bytes.
#pragma once

#include <cstddef>

#include "byte_source.h"
#include "psim/psim.h"

namespace psim::fuzz {

inline constexpr double kHalf = 12;  // m: bodies are placed within, whatever the bounds

template <class T, std::size_t N>
T one_of(ByteSource& in, const T (&values)[N]) {
  return values[in.below(N)];
}

WorldDesc world(ByteSource& in);
Material material(ByteSource& in);
Shape shape(ByteSource& in);
Filter filter(ByteSource& in);
BodyDesc body(ByteSource& in);

}  // namespace psim::fuzz
