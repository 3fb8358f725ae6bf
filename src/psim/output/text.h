// Small helpers for the words and figures that psim prints.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace psim::cli {

/// 1234567 -> "1,234,567".
std::string grouped(std::uint64_t n);

/// A state hash the way every report writes it: 0x and 16 hex digits.
std::string hash_text(std::uint64_t hash);

/// Bytes in the largest unit that keeps a leading digit: "812 bytes", "1.5 GiB".
std::string bytes_text(std::uint64_t bytes);

/// The text without line breaks and control characters, so that a message stays one line whatever
/// a file name or a value holds.
std::string one_line(std::string_view text);

/// The word among `known` that `word` was probably meant to be; empty if none is near.
std::string nearest(std::string_view word, std::span<const std::string> known);

/// "; did you mean X?" or nothing.
std::string did_you_mean(std::string_view word, std::span<const std::string> known);

/// Writes to stdout and throws UserError if it cannot be written (a full disk, a closed pipe).
void print_out(std::string_view text);

}  // namespace psim::cli
