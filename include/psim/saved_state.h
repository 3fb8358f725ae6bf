// Saved states as files, or on a wire: with a checksum over every byte, so that what was cut or damaged on the
// way is refused. The states themselves are World::save's.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "psim/api.h"

namespace psim {

/// A state with a header of 32 bytes before it: magic, format, length, checksum.
PSIM_API std::vector<std::byte> pack_state(std::span<const std::byte> state);
/// And back. False and one line in `error` if it is no packed state, of another format, cut or damaged.
PSIM_API bool unpack_state(std::span<const std::byte> packed, std::vector<std::byte>& state, std::string& error);

/// Writes a packed state to a file, as write_bytes (psim/recording.h) does: there is never half of one.
/// False and one line in `error` if that fails; what was there before is still there then.
PSIM_API bool write_state(const std::string& path, std::span<const std::byte> state, std::string& error);
/// Reads one, from a file or a pipe.
PSIM_API bool read_state(const std::string& path, std::vector<std::byte>& state, std::string& error);

}  // namespace psim
