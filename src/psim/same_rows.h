// Rows of a picture that are each like the one above, packed: most of a picture in which little is drawn.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace psim::cli {

/// The filter (PNG specification, 9.2) by which such a row is all zeros.
inline constexpr std::uint8_t kUpFilter = 2;

/// `rows` times that filter and `bytes` zeros, as whole bytes of deflate (RFC 1951) that need nothing before them; with `last`
/// the data end. `bytes` is at least 3. A row of 1920 pixels takes 59 bits.
std::string pack_same_rows(std::size_t bytes, std::size_t rows, bool last);

/// The Adler-32 sum of what that unpacks to, after `sum`.
std::uint32_t adler_of_same_rows(std::uint32_t sum, std::size_t bytes, std::size_t rows);

}  // namespace psim::cli
