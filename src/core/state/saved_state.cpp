#include "psim/saved_state.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "base/output_file.h"
#include "psim/recording.h"
#include "state/archive.h"

namespace psim {
namespace {

struct PackHeader {
  static constexpr std::uint64_t kMagic = 0x31304B50'6D697370u;  // "psimPK01"
  static constexpr std::uint64_t kFormat = ArchiveHeader::kFormat;
  std::uint64_t magic = kMagic;
  std::uint64_t format = kFormat;
  std::uint64_t size = 0;  ///< of the state, bytes
  std::uint64_t hash = 0;  ///< of the state
};

struct Descriptor {
  int number = -1;
  ~Descriptor() {
    if (number >= 0) ::close(number);
  }
};

std::string because() { return std::strerror(errno); }

}  // namespace

std::uint64_t hash_of(const std::byte* data, std::size_t size) {
  std::uint64_t hash = 0x9E3779B97F4A7C15u ^ size;
  const auto mix = [](std::uint64_t& to, std::uint64_t v) {
    to = (to ^ v) * 0xD6E8FEB86659FD93u;
    to ^= to >> 32;
  };
  const auto take = [&] {
    std::uint64_t v;
    std::memcpy(&v, data, 8);
    data += 8, size -= 8;
    return v;
  };
  if (size >= 32) {  // four that do not wait for each other
    std::uint64_t lane[4] = {hash, hash + 1, hash + 2, hash + 3};
    while (size >= 32) {
      for (std::uint64_t& l : lane) mix(l, take());
    }
    for (const std::uint64_t l : lane) mix(hash, l);
  }
  while (size >= 8) mix(hash, take());
  std::uint64_t last = 0;
  if (size != 0) std::memcpy(&last, data, size);
  mix(hash, last);
  return hash ^ (hash >> 29);
}

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
  error = read_header(packed, "saved state", header);
  if (!error.empty()) return false;
  const auto rest = packed.subspan(sizeof header);
  if (rest.size() < header.size) {
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
  OutputFile file(path);
  file.write(bytes.data(), bytes.size());
  if (file.commit(true)) return true;
  error = path + ": " + std::strerror(file.error());
  return false;
}

bool read_bytes(const std::string& path, std::vector<std::byte>& bytes, std::string& error) {
  constexpr std::size_t kPiece = 1 << 20, kMostOfAPipe = std::size_t{4} << 30;
  error.clear();
  bytes.clear();
  const auto refuse = [&](const std::string& why) {
    error = path + ": " + why;
    bytes.clear();
    return false;
  };
  struct stat what = {};
  if (::stat(path.c_str(), &what) != 0) return refuse(because());  // before it is opened, which a device may notice
  if (S_ISDIR(what.st_mode)) return refuse(std::strerror(EISDIR));
  if (!S_ISREG(what.st_mode) && !S_ISFIFO(what.st_mode)) return refuse("is a device; a file or a pipe is read");
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  if (file.number < 0) return refuse(because());
  std::size_t size = 0;
  if (S_ISREG(what.st_mode)) bytes.reserve(static_cast<std::size_t>(what.st_size) + 1);
  for (;;) {
    if (size == bytes.size()) bytes.resize(std::max(bytes.capacity(), size + kPiece));
    const ssize_t n = ::read(file.number, bytes.data() + size, bytes.size() - size);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return refuse(because());
    if (n == 0) break;
    size += static_cast<std::size_t>(n);
    if (S_ISFIFO(what.st_mode) && size > kMostOfAPipe) return refuse("more than 4 GiB through a pipe");
  }
  bytes.resize(size);
  return true;
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
