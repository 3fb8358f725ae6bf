#include "psim/saved_state.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "base/os.h"
#include "base/output_file.h"
#include "psim/recording.h"
#include "state/archive.h"

namespace psim {
namespace {

struct PackHeader : FileHeader {
  static constexpr std::uint64_t kMagic = 0x31304B50'6D697370u;  // "psimPK01"
  void seal(std::span<const std::byte> state) {
    static_cast<FileHeader&>(*this) = {kMagic, ArchiveHeader::kFormat, state.size(), hash_of(state)};
  }
};

std::string because() { return std::strerror(errno); }

}  // namespace

std::uint64_t hash_of(std::span<const std::byte> bytes) {
  std::uint64_t hash = 0x9E3779B97F4A7C15u ^ bytes.size();
  const auto mix = [](std::uint64_t& to, std::uint64_t v) {
    to = (to ^ v) * 0xD6E8FEB86659FD93u;
    to ^= to >> 32;
  };
  const auto take = [&](std::size_t n = 8) {
    std::uint64_t v = 0;
    std::memcpy(&v, bytes.data(), n);
    bytes = bytes.subspan(n);
    return v;
  };
  if (bytes.size() >= 32) {  // four that do not wait for each other
    std::uint64_t lane[4] = {hash, hash + 1, hash + 2, hash + 3};
    while (bytes.size() >= 32) {
      for (std::uint64_t& l : lane) mix(l, take());
    }
    for (const std::uint64_t l : lane) mix(hash, l);
  }
  while (bytes.size() >= 8) mix(hash, take());
  mix(hash, bytes.empty() ? 0 : take(bytes.size()));
  return hash ^ (hash >> 29);
}

std::string fault_of(const FileHeader& header, const FileHeader& right, const std::string& what) {
  const auto differ = [](const char* mine, std::uint64_t a, const char* other, std::uint64_t b) {
    return mine + std::to_string(a) + other + std::to_string(b);
  };
  if (header.magic != right.magic) return "it is no " + what + " of psim";
  if (header.format != right.format) return differ("its format is ", header.format, ", this psim reads ", right.format);
  if (header.size != right.size) return differ("it has ", right.size, " bytes of ", header.size);
  return header.hash == right.hash ? "" : "it is damaged";
}

Archive::Archive(std::vector<std::byte> memory) : memory_(std::move(memory)) {
  memory_.resize(std::max(memory_.size(), kHeader));
  end_ = memory_.size();
}

bool Archive::make_room(std::size_t n) {
  require(false);
  if (loading_) return false;
  memory_.resize(std::max(at_ + n, 2 * memory_.size() + 1024));
  end_ = memory_.size();
  return true;
}

std::vector<std::byte> Saver::finish() {
  ArchiveHeader header;
  header.seal(bytes());
  std::memcpy(memory_.data(), &header, sizeof header);
  memory_.resize(at_);
  return std::move(memory_);
}

Loader::Loader(std::span<const std::byte> bytes) : Archive(bytes, kHeader) {
  ArchiveHeader header;
  if (const std::string fault = read_header(bytes, "saved state", header); !fault.empty()) fail(fault);
}

std::vector<std::byte> pack_state(std::span<const std::byte> state) { return sealed(PackHeader(), {state}); }

bool unpack_state(std::span<const std::byte> packed, std::vector<std::byte>& state, std::string& error) {
  PackHeader header;
  error = read_header(packed, "saved state", header);
  if (!error.empty()) return false;
  state.assign(packed.begin() + sizeof header, packed.end());
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
  std::error_code failed;
  const auto place = os::path_of(path);
  const std::filesystem::file_type type =
      status(place, failed).type();  // before it is opened: a device may notice that
  const bool is_pipe = type == std::filesystem::file_type::fifo;
  if (failed) return refuse(failed.message());
  if (type == std::filesystem::file_type::directory) return refuse(std::strerror(EISDIR));
  if (type != std::filesystem::file_type::regular && !is_pipe) return refuse("is a device; a file or a pipe is read");
  const os::FileToRead file = os::open_to_read(path);
  if (!file) return refuse(because());
  std::setvbuf(file.get(), nullptr, _IONBF, 0);  // the pieces are large
  if (!is_pipe) bytes.reserve(static_cast<std::size_t>(file_size(place, failed)) + 1);
  std::size_t size = 0;
  while (std::feof(file.get()) == 0) {
    if (size == bytes.size()) bytes.resize(std::max(bytes.capacity(), size + kPiece));
    size += std::fread(bytes.data() + size, 1, bytes.size() - size, file.get());
    if (std::ferror(file.get()) != 0) {
      if (errno != EINTR) return refuse(because());
      std::clearerr(file.get());
    }
    if (is_pipe && size > kMostOfAPipe) return refuse("more than 4 GiB through a pipe");
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
