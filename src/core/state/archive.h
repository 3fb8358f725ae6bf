// The bytes of a saved state: a header with a checksum, then numbers one after the other, little-endian.
//
// A part of the world describes its state once, in a function describe(archive, ...). Saver writes what is described;
// Loader reads it in the same order and checks every number against the bound that the description names. Whatever a
// description calls an index therefore cannot come back out of range, whoever made the bytes. Loader stops at the
// first fault: from there on it reads zeros, and ok() is false.
//
//   values             everything that is given, in turn: numbers, structs with fields() (describe.h), optionals,
//                      vectors, variants; enums and bools are checked, and sizes refuse NaN (Loader::refuse_nan)
//   index              numbers that count something: below a bound
//   list               a vector of things, with its length
//   plain              many values without padding, copied as they are
//   packed             many numbers that are often alike or near each other, in as few bytes as each run of them needs
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "base/column.h"

namespace psim {

static_assert(std::endian::native == std::endian::little, "saved states are little-endian");

template <class T>
concept Number = std::is_arithmetic_v<T> || std::is_enum_v<T>;

/// Names an enum: last_of(Enum<E>()) is the last value of an enum that is saved (describe.h).
template <class E>
struct Enum {};

/// 64-bit hash of bytes: finds damage, no defence against forgery.
std::uint64_t hash_of(const std::byte* data, std::size_t size);

struct ArchiveHeader {
  static constexpr std::uint64_t kMagic = 0x31305653'6D697370u;  // "psimSV01"
  static constexpr std::uint32_t kFormat = 11;
  std::uint64_t magic = kMagic;
  std::uint32_t format = kFormat;
  std::uint32_t spare = 0;
  std::uint64_t size = 0;  ///< of all, bytes
  std::uint64_t hash = 0;  ///< of what follows the header
};

/// Reads the header of a file of ours, a saved state or a recording (`what`). Returns what is wrong with it, or an
/// empty string.
template <class Header>
std::string read_header(std::span<const std::byte> bytes, const char* what, Header& header) {
  if (bytes.size() < sizeof header) return "it is cut short";
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.magic != Header::kMagic) return std::string("it is no ") + what + " of psim";
  if (header.format == Header::kFormat) return {};
  return "its format is " + std::to_string(header.format) + ", this psim reads " + std::to_string(Header::kFormat);
}

/// The unsigned integer that holds the bits of a number.
template <std::size_t kBytes>
using BitsOf = std::conditional_t<
    kBytes == 1, std::uint8_t,
    std::conditional_t<kBytes == 2, std::uint16_t, std::conditional_t<kBytes == 4, std::uint32_t, std::uint64_t>>>;

/// Numbers of packed() that share a base and a width. A run is its width in bytes, its least number, and of each
/// number what it has above that.
inline constexpr std::size_t kPackedRun = 128;

/// A bound that all numbers keep.
inline constexpr std::uint64_t kAnyNumber = ~std::uint64_t{0};

/// What both archives do alike, in terms of their length(), one_index() and packed().
template <class Self>
class Archive {
 public:
  /// Numbers below a bound. 0 if one that is read is not.
  template <class... T>
  void index(std::uint64_t bound, T&... v) {
    (self().one_index(bound, v), ...);
  }
  template <class T, class Each>
  void list(std::vector<T>& v, const Each& each) {
    if constexpr (Self::kLoading) v.clear();  // elements keep nothing of those before
    self().length(v, 1);
    for (T& element : v) {
      each(element);
      if (!self().ok()) break;
    }
  }
  template <class T>
  void plain(std::vector<T>& v) {
    self().length(v, sizeof(T));
    self().plain(v.data(), v.size());
  }
  /// A list of numbers below `bound`.
  template <Number T>
  void packed(std::vector<T>& v, std::uint64_t bound = kAnyNumber) {
    self().length(v, 0);
    self().packed(v.size(), [&](std::size_t k) -> T& { return v[k]; });
    if constexpr (std::is_integral_v<T> && Self::kLoading) {
      for (const T x : v) self().require(bound == kAnyNumber || static_cast<std::uint64_t>(x) < bound);
    }
  }
  /// The first n numbers of a column, which has room for them.
  template <Number T>
  void packed(Column<T>& column, std::size_t n) {
    self().packed(n, [&](std::size_t k) -> T& { return column[k]; });
  }

 private:
  Self& self() { return static_cast<Self&>(*this); }
};

class Saver : public Archive<Saver> {
 public:
  static constexpr bool kLoading = false;

  Saver() : Saver(std::vector<std::byte>()) {}
  /// Into memory that is there already.
  explicit Saver(std::vector<std::byte> memory) : bytes_(std::move(memory)) { make_room(0); }
  /// What was written, without a header.
  std::span<const std::byte> bytes() const { return {bytes_.data() + kBegin, at_ - kBegin}; }
  /// The same behind a header. Then the saver is empty.
  std::vector<std::byte> finish() {
    ArchiveHeader header;
    header.size = at_;
    header.hash = hash_of(bytes_.data() + kBegin, at_ - kBegin);
    std::memcpy(bytes_.data(), &header, sizeof header);
    bytes_.resize(at_);
    at_ = kBegin;
    return std::move(bytes_);
  }

  template <Number T>
  void value(const T& v) {
    put(&v, sizeof v);
  }
  using Archive::packed, Archive::plain;
  template <class T>
  void plain(T* data, std::size_t n) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (n != 0) put(data, n * sizeof(T));
  }
  template <class T>
  void plain(Column<T>& column, std::size_t n) {
    plain(column.data(), n);
  }
  /// n numbers; at(k) is the k-th, by reference.
  template <class At>
  void packed(std::size_t n, const At& at) {
    using T = std::remove_cvref_t<decltype(at(std::size_t{0}))>;
    using Bits = BitsOf<sizeof(T)>;
    Bits run[kPackedRun];
    for (std::size_t begin = 0; begin < n; begin += kPackedRun) {
      const std::size_t count = std::min(kPackedRun, n - begin);
      Bits least = std::numeric_limits<Bits>::max(), most = 0;
      for (std::size_t k = 0; k < count; ++k) {
        run[k] = std::bit_cast<Bits>(at(begin + k));
        least = std::min(least, run[k]);
        most = std::max(most, run[k]);
      }
      const auto width = static_cast<std::uint8_t>((std::bit_width(static_cast<Bits>(most - least)) + 7) / 8);
      put(&width, 1);
      put(&least, sizeof least);
      make_room(count * width + sizeof(Bits));
      for (std::size_t k = 0; k < count; ++k, at_ += width) {  // the bytes above `width` are written over
        const auto above = static_cast<Bits>(run[k] - least);
        std::memcpy(bytes_.data() + at_, &above, sizeof above);
      }
    }
  }

  bool ok() const { return true; }
  void require(bool) {}
  void refuse_nan(bool) {}
  bool fits(std::uint64_t) const { return true; }

 private:
  friend Archive;

  template <class T>
  void length(const std::vector<T>& v, std::size_t) {
    value(static_cast<std::uint64_t>(v.size()));
  }
  template <Number T>
  void one_index(std::uint64_t, const T& v) {
    value(v);
  }
  void make_room(std::size_t more) {
    if (at_ + more > bytes_.size()) bytes_.resize(std::max(at_ + more, 2 * bytes_.size() + 1024));
  }
  void put(const void* from, std::size_t n) {
    make_room(n);
    std::memcpy(bytes_.data() + at_, from, n);
    at_ += n;
  }

  static constexpr std::size_t kBegin = sizeof(ArchiveHeader);

  std::vector<std::byte> bytes_;
  std::size_t at_ = kBegin;
};

class Loader : public Archive<Loader> {
 public:
  static constexpr bool kLoading = true;

  /// Looks at the header and the checksum; error() is a line that says what is wrong.
  explicit Loader(std::span<const std::byte> bytes) : bytes_(bytes), at_(sizeof(ArchiveHeader)) {
    fail(fault_of_header());
    if (!ok()) at_ = bytes_.size();
  }
  /// Of numbers alone, without a header: Saver::bytes.
  static Loader of_numbers(std::span<const std::byte> bytes) { return Loader(bytes, 0); }

  template <Number T>
  void value(T& v) {
    v = T{};
    if constexpr (std::is_same_v<T, bool>) {
      std::uint8_t byte = 0;
      take(&byte, 1);
      require(byte <= 1);
      v = byte == 1;
      return;
    }
    T read{};
    if (!take(&read, sizeof read)) return;
    if constexpr (std::is_floating_point_v<T>) require(!refuses_nan_ || !std::isnan(read));
    if constexpr (std::is_enum_v<T>) require(static_cast<std::uint64_t>(read) <= last_of(Enum<T>()));
    if (ok()) v = read;
  }
  using Archive::packed, Archive::plain;
  template <class T>
  void plain(T* data, std::size_t n) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (n != 0) take(data, n * sizeof(T));
  }
  template <class T>
  void plain(Column<T>& column, std::size_t n) {
    if (!fits(n)) return;
    column.reserve(n);
    plain(column.data(), n);
  }
  template <class At>
  void packed(std::size_t n, const At& at) {
    using T = std::remove_cvref_t<decltype(at(std::size_t{0}))>;
    using Bits = BitsOf<sizeof(T)>;
    for (std::size_t begin = 0; begin < n && ok(); begin += kPackedRun) {
      const std::size_t count = std::min(kPackedRun, n - begin);
      std::uint8_t width = 0;
      Bits least = 0;
      take(&width, 1);
      take(&least, sizeof least);
      require(width <= sizeof(Bits) && std::size_t{width} * count <= left());
      for (std::size_t k = 0; k < count && ok(); ++k, at_ += width) {
        Bits above = 0;
        std::memcpy(&above, bytes_.data() + at_, width);
        put_bits(at(begin + k), static_cast<Bits>(least + above));
      }
    }
  }

  bool ok() const { return error_.empty(); }
  const std::string& error() const { return error_; }
  void require(bool sound) {
    if (!sound) fail("it is damaged");
  }
  void fail(const std::string& error) {
    if (error_.empty()) error_ = error;
  }
  /// From now on. What contacts and events tell of a body whose host gave it NaN may be NaN; sizes may not.
  void refuse_nan(bool on) { refuses_nan_ = on; }
  /// Whether so many things can be in the bytes: the memory that forged bytes ask for stays in proportion to them.
  bool fits(std::uint64_t n) {
    require(n <= kThingsAByte * bytes_.size());
    return ok();
  }
  std::size_t left() const { return bytes_.size() - at_; }
  std::byte peek() const { return bytes_[at_]; }

 private:
  friend Archive;
  static constexpr std::uint64_t kThingsAByte = 16;

  Loader(std::span<const std::byte> bytes, std::size_t at) : bytes_(bytes), at_(at) {}

  std::string fault_of_header() const {
    ArchiveHeader header;
    if (std::string fault = read_header(bytes_, "saved state", header); !fault.empty()) return fault;
    if (header.size != bytes_.size()) {
      return "it has " + std::to_string(bytes_.size()) + " bytes of " + std::to_string(header.size);
    }
    return hash_of(bytes_.data() + at_, bytes_.size() - at_) == header.hash ? "" : "it is damaged";
  }
  bool take(void* to, std::size_t n) {
    require(ok() && n <= left());
    if (!ok()) return false;
    std::memcpy(to, bytes_.data() + at_, n);
    at_ += n;
    return true;
  }
  // Makes room for a list whose elements take at least so many bytes each; 0: packed.
  template <class T>
  void length(std::vector<T>& v, std::size_t bytes) {
    std::uint64_t n = 0;
    value(n);
    require(bytes == 0 ? fits(n) : n <= left() / bytes);
    v.resize(ok() ? static_cast<std::size_t>(n) : 0);
  }
  template <class T>
  void one_index(std::uint64_t bound, T& v) {
    value(v);
    if (static_cast<std::uint64_t>(v) < bound) return;
    v = 0;
    require(false);
  }
  template <class T, class Bits>
  void put_bits(T& to, Bits bits) {
    if constexpr (std::is_enum_v<T>) {
      require(bits <= last_of(Enum<T>()));
      to = ok() ? static_cast<T>(bits) : T{};
    } else if constexpr (std::is_same_v<T, bool>) {
      require(bits <= 1);
      to = bits == 1;
    } else {
      to = std::bit_cast<T>(bits);
    }
  }

  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
  std::string error_;
  bool refuses_nan_ = false;
};

/// Whatever is given, in turn: one_value() finds out what it is made of.
template <class A, class... T>
void values(A& a, T&... v) {
  (one_value(a, v), ...);
}

/// A number; or the members of a struct, as fields() ties them.
template <class A, class T>
void one_value(A& a, T& v) {
  if constexpr (Number<T>) {
    a.value(v);
  } else {
    std::apply([&a](auto&... member) { values(a, member...); }, fields(v));
  }
}
template <class A, class T, std::size_t kCount>
void one_value(A& a, T (&v)[kCount]) {
  for (T& element : v) one_value(a, element);
}
template <class A, class T, std::size_t kCount>
void one_value(A& a, std::array<T, kCount>& v) {
  for (T& element : v) one_value(a, element);
}
template <class A, class T>
void one_value(A& a, std::vector<T>& v) {
  a.list(v, [&a](T& element) { one_value(a, element); });
}
template <class A, class T>
void one_value(A& a, std::optional<T>& v) {
  bool any = v.has_value();
  a.value(any);
  if constexpr (A::kLoading) v = any ? std::optional<T>(T{}) : std::nullopt;
  if (any) one_value(a, *v);
}
/// A variant, by the number of its alternative.
template <class A, class... T>
void one_value(A& a, std::variant<T...>& v) {
  auto which = static_cast<std::uint8_t>(v.index());
  a.index(sizeof...(T), which);
  if constexpr (A::kLoading) {
    std::uint8_t k = 0;
    ((which == k++ ? static_cast<void>(v.template emplace<T>()) : void()), ...);
  }
  std::visit([&a](auto& alternative) { one_value(a, alternative); }, v);
}

}  // namespace psim
