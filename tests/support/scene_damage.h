// Damages the text of a scene the way files are damaged: cut, edited by hand, written by a program that
// knows no limits. The seed alone says what is done.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace psim::test {

struct Damage {
  std::string what;  ///< for messages
  std::string text;
};

/// One to three damages.
Damage damaged(std::string_view scene, std::uint64_t seed);

}  // namespace psim::test
