#include "psim/saved_state.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

#include "archive.h"
#include "psim/recording.h"

namespace psim {
namespace {

struct PackHeader {
  static constexpr std::uint64_t kMagic = 0x31304B50'6D697370u;  // "psimPK01"
  std::uint64_t magic = kMagic;
  std::uint64_t format = ArchiveHeader::kFormat;
  std::uint64_t size = 0;  ///< of the state, bytes
  std::uint64_t hash = 0;  ///< of the state
};

struct Close {
  void operator()(std::FILE* f) const { std::fclose(f); }
};
using File = std::unique_ptr<std::FILE, Close>;

std::string because() { return std::strerror(errno); }

}  // namespace

std::vector<std::byte> pack_state(std::span<const std::byte> state) {
  PackHeader header;
  header.size = state.size();
  header.hash = hash_of(state.data(), state.size());
  std::vector<std::byte> packed(sizeof header + state.size());
  std::memcpy(packed.data(), &header, sizeof header);
  std::copy(state.begin(), state.end(), packed.begin() + sizeof header);
  return packed;
}

bool unpack_state(std::span<const std::byte> packed, std::vector<std::byte>& state, std::string& error) {
  PackHeader header;
  error.clear();
  if (packed.size() < sizeof header) {
    error = "it is cut short";
    return false;
  }
  std::memcpy(&header, packed.data(), sizeof header);
  const auto rest = packed.subspan(sizeof header);
  if (header.magic != PackHeader::kMagic) {
    error = "it is no saved state of psim";
  } else if (header.format != ArchiveHeader::kFormat) {
    error = "its format is " + std::to_string(header.format) + ", this psim reads " +
            std::to_string(ArchiveHeader::kFormat);
  } else if (rest.size() < header.size) {
    error = "it is cut short";
  } else if (rest.size() > header.size || hash_of(rest.data(), rest.size()) != header.hash) {
    error = "it is damaged";
  }
  if (!error.empty()) return false;
  state.assign(rest.begin(), rest.end());
  return true;
}

bool write_bytes(const std::string& path, std::span<const std::byte> bytes, std::string& error) {
  error.clear();
  const std::string beside = path + ".part";
  {
    File file(std::fopen(beside.c_str(), "wb"));
    if (!file) {
      error = path + ": " + because();
      return false;
    }
    if (std::fwrite(bytes.data(), 1, bytes.size(), file.get()) != bytes.size() ||
        std::fflush(file.get()) != 0 || std::fclose(file.release()) != 0) {
      error = path + ": " + because();
    }
  }
  if (error.empty() && std::rename(beside.c_str(), path.c_str()) != 0) error = path + ": " + because();
  if (!error.empty()) std::remove(beside.c_str());
  return error.empty();
}

bool read_bytes(const std::string& path, std::vector<std::byte>& bytes, std::string& error) {
  error.clear();
  bytes.clear();
  File file(std::fopen(path.c_str(), "rb"));
  if (!file) {
    error = path + ": " + because();
    return false;
  }
  std::vector<std::byte> piece(1 << 20);
  for (std::size_t n; (n = std::fread(piece.data(), 1, piece.size(), file.get())) != 0;) {
    bytes.insert(bytes.end(), piece.begin(), piece.begin() + static_cast<std::ptrdiff_t>(n));
  }
  if (std::ferror(file.get()) != 0) error = path + ": " + because();
  return error.empty();
}

bool write_state(const std::string& path, std::span<const std::byte> state, std::string& error) {
  return write_bytes(path, pack_state(state), error);
}

bool read_state(const std::string& path, std::vector<std::byte>& state, std::string& error) {
  std::vector<std::byte> packed;
  if (!read_bytes(path, packed, error)) return false;
  if (unpack_state(packed, state, error)) return true;
  error = path + ": " + error;
  return false;
}

}  // namespace psim
