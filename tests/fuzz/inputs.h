// What the fuzzers of tests/fuzz and the tests of their corpus feed with bytes. Each function plays one
// input and returns what is wrong in one line, or nothing: refusing the input is right, crashing is not.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace psim::fuzz {

using Bytes = std::span<const std::uint8_t>;

/// A scene file: read, written and read again, checked, built, stepped a few times. The message about a
/// bad one must be one line FILE:LINE:COL: path: what.
std::string scene_input(Bytes text);

/// The same for files of R.U.B.E.: a corpus and a dictionary of their own.
std::string rube_input(Bytes text);

/// A state or trajectory as CSV, read frame by frame and compared with itself; or two of them with a line
/// "=" between, compared with each other.
std::string state_input(Bytes text);

/// A governor's log; what is read is replayed.
std::string details_input(Bytes text);

/// A packed state, as it comes from a file or a wire: refused in one line, and a world that it was offered to is as
/// before, or a world goes on from it. Then the same with checksums put right.
std::string saved_input(Bytes packed);

/// A recording: refused in one line, or replayed. Then the same with checksums put right.
std::string recording_input(Bytes recording);

/// Calls of the public interface, legal and illegal, on one world or on two that run by different
/// options and must agree. After each step all that the headers promise is looked at.
std::string world_input(Bytes calls);

/// Nothing if `error` is one line FILE:LINE:COL: path: what about `file`, else what it is not.
std::string refusal_fault(const std::string& error, const std::string& file);

}  // namespace psim::fuzz
