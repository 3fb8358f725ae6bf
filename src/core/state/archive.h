// The bytes of a saved state: a header with a checksum, then numbers one after the other, little-endian.
//
// A part of the world describes its state once, in a function describe(archive, ...). A Saver writes what is described;
// a Loader reads it in the same order and checks every number against the bound that the description names. Whatever a
// description calls an index therefore cannot come back out of range, whoever made the bytes. A Loader stops at the
// first fault: from there on it reads zeros, and ok() is false.
//
//   values             everything that is given, in turn: numbers, structs with fields() (describe.h), optionals,
//                      vectors, variants; enums and bools are checked, and sizes refuse NaN (refuse_nan)
//   index              numbers that count something: below a bound
//   list               a vector of things, with its length
//   plain              many values without padding, copied as they are
//   packed             many numbers that are often alike or near each other, in as few bytes as each run of them needs
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
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
constexpr std::uint64_t last_of(Enum<bool>) { return 1; }

/// 64-bit hash of bytes: finds damage, no defence against forgery.
std::uint64_t hash_of(std::span<const std::byte> bytes);

/// A file of ours begins with a header of this kind, whose seal(rest) fills it in for what follows.
struct FileHeader {
  std::uint64_t magic = 0, format = 0;
  std::uint64_t size = 0;  ///< bytes
  std::uint64_t hash = 0;
};

/// Of a saved state.
struct ArchiveHeader : FileHeader {
  static constexpr std::uint64_t kMagic = 0x31305653'6D697370u;  // "psimSV01"
  static constexpr std::uint64_t kFormat = 33;
  void seal(std::span<const std::byte> rest) {
    static_cast<FileHeader&>(*this) = {kMagic, kFormat, sizeof *this + rest.size(), hash_of(rest)};
  }
};

/// What is wrong with the header of `what`, a file whose right header is another, or an empty string.
std::string fault_of(const FileHeader& header, const FileHeader& right, const std::string& what);

/// Reads the header of a file. Returns what is wrong with the file, or an empty string.
template <class Header>
std::string read_header(std::span<const std::byte> bytes, const char* what, Header& header) {
  if (bytes.size() < sizeof header) return "it is cut short";
  std::memcpy(&header, bytes.data(), sizeof header);
  Header right = header;
  right.seal(bytes.subspan(sizeof header));
  return fault_of(header, right, what);
}

/// A file: its header, and what follows.
template <class Header>
std::vector<std::byte> sealed(Header header, std::initializer_list<std::span<const std::byte>> parts) {
  std::size_t size = sizeof header;
  for (const std::span<const std::byte> part : parts) size += part.size();
  std::vector<std::byte> file(size);
  auto at = file.begin() + sizeof header;
  for (const std::span<const std::byte> part : parts) at = std::copy(part.begin(), part.end(), at);
  header.seal(std::span(file).subspan(sizeof header));
  std::memcpy(file.data(), &header, sizeof header);
  return file;
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

/// Goes through a description, and writes (Saver) or reads (Loader) what is described.
class Archive {
 public:
  bool loading() const { return loading_; }
  /// What was read is sound so far. Else error() is a line that says what is wrong.
  bool ok() const { return error_.empty(); }
  const std::string& error() const { return error_; }
  /// Bytes that are still to be read.
  std::size_t left() const { return end_ - at_; }
  void require(bool sound) {
    if (!sound && loading_) fail("it is damaged");
  }
  /// From now on. What contacts and events tell of a body whose host gave it NaN may be NaN; sizes may not.
  void refuse_nan(bool on, bool infinite_too = false) {
    refuses_nan_ = on;
    refuses_infinite_ = infinite_too;
  }
  /// Whether so many things can be in the bytes: the memory that forged bytes ask for stays in proportion to them.
  bool fits(std::uint64_t n) {
    require(n <= kThingsAByte * bytes_.size());
    return ok();
  }

  template <Number T>
  void value(T& v) {
    if constexpr (kIsSize<T>) return size(v);
    auto bits = std::bit_cast<BitsOf<sizeof(T)>>(v);
    transfer(&bits, sizeof bits);
    if (!loading_) return;
    v = number<T>(bits);
    if constexpr (std::is_floating_point_v<T>)
      keep_if(v, !(refuses_nan_ && std::isnan(v)) && !(refuses_infinite_ && std::isinf(v)));
  }
  /// Numbers below a bound. 0 if one that is read is not.
  template <class... T>
  void index(std::uint64_t bound, T&... v) {
    ((value(v), keep_if(v, static_cast<std::uint64_t>(v) < bound)), ...);
  }
  template <class T, class Each>
  void list(std::vector<T>& v, const Each& each) {
    if (loading_) v.clear();  // elements keep nothing of those before
    length(v, 1);
    for (T& element : v) {
      each(element);
      if (!ok()) break;
    }
  }
  template <class T>
  void plain(T* data, std::size_t n) {
    static_assert(std::is_trivially_copyable_v<T> && !kIsSize<T>);
    if (n != 0) transfer(data, n * sizeof(T));
  }
  template <class T>
  void plain(std::vector<T>& v) {
    length(v, sizeof(T));
    plain(v.data(), v.size());
  }
  /// The first n values of a column.
  template <class T>
  void plain(Column<T>& column, std::size_t n) {
    if (loading_ && fits(n)) column.reserve(n);
    if (ok()) plain(column.data(), n);
  }
  /// n numbers; at(k) is the k-th, by reference.
  template <class At>
  void packed(std::size_t n, const At& at) {
    using T = std::remove_cvref_t<decltype(at(std::size_t{0}))>;
    static_assert(!kIsSize<T>);
    using Bits = BitsOf<sizeof(T)>;
    Bits run[kPackedRun];
    for (std::size_t begin = 0; begin < n && ok(); begin += kPackedRun) {
      const std::size_t count = std::min(kPackedRun, n - begin);
      if (!loading_) {
        for (std::size_t k = 0; k < count; ++k) run[k] = std::bit_cast<Bits>(at(begin + k));
      }
      packed_run(run, count);
      if (!loading_) continue;
      for (std::size_t k = 0; k < count; ++k) at(begin + k) = number<T>(run[k]);
    }
  }
  /// The first n numbers of a column, which has room for them.
  template <Number T>
  void packed(Column<T>& column, std::size_t n) {
    packed(n, [&](std::size_t k) -> T& { return column[k]; });
  }
  /// A list of numbers below `bound`.
  template <Number T>
  void packed(std::vector<T>& v, std::uint64_t bound = kAnyNumber) {
    length(v, 0);
    packed(v.size(), [&](std::size_t k) -> T& { return v[k]; });
    if constexpr (std::is_integral_v<T>) {
      if (!loading_ || bound == kAnyNumber) return;
      for (const T x : v) require(static_cast<std::uint64_t>(x) < bound);
    }
  }

 protected:
  static constexpr std::size_t kHeader = sizeof(ArchiveHeader);

  explicit Archive(std::vector<std::byte> memory);             // saves
  Archive(std::span<const std::byte> bytes, std::size_t from)  // loads
      : loading_(true), bytes_(bytes), at_(from), end_(bytes.size()) {}

  /// Nothing is read any more.
  void fail(const std::string& error) {
    if (error_.empty()) error_ = error;
    at_ = end_;
  }

  bool make_room(std::size_t n);

 private:
  static constexpr std::uint64_t kThingsAByte = 16;

  // Writes n bytes, or reads them: zeros if there are not as many.
  void transfer(void* data, std::size_t n) {
    if (n > left() && !make_room(n)) {
      std::memset(data, 0, n);
      return;
    }
    if (loading_) {
      std::memcpy(data, bytes_.data() + at_, n);
    } else {
      std::memcpy(memory_.data() + at_, data, n);
    }
    at_ += n;
  }
  // A std::size_t takes 8 bytes in every state, also where it has 4: states go from machine to machine.
  template <class T>
  static constexpr bool kIsSize = std::is_same_v<T, std::size_t> && sizeof(T) < sizeof(std::uint64_t);
  void size(std::size_t& v) {
    std::uint64_t wide = v;
    value(wide);
    require(wide <= std::numeric_limits<std::size_t>::max());
    if (loading_) v = ok() ? static_cast<std::size_t>(wide) : 0;
  }
  // Makes room for a list whose elements take at least so many bytes each; 0: packed.
  template <class T>
  void length(std::vector<T>& v, std::size_t bytes) {
    std::uint64_t n = v.size();
    value(n);
    if (!loading_) return;
    require(bytes == 0 ? fits(n) : n <= left() / bytes);
    v.resize(ok() ? static_cast<std::size_t>(n) : 0);
  }
  // The number that has these bits; 0 if there is none.
  template <Number T>
  T number(BitsOf<sizeof(T)> bits) {
    if constexpr (std::is_enum_v<T> || std::is_same_v<T, bool>) {
      keep_if(bits, bits <= last_of(Enum<T>()));
      return static_cast<T>(bits);
    } else {
      return std::bit_cast<T>(bits);
    }
  }
  // A number that is read and is not sound is 0.
  template <class T>
  void keep_if(T& v, bool sound) {
    if (sound || !loading_) return;
    v = 0;
    require(false);
  }
  // Calls go with a width in bytes as a constant, so that loops over numbers of it are unrolled.
  template <class Bits, class Go>
  static void with_width(std::uint8_t width, const Go& go) {
    [&]<std::size_t... k>(std::index_sequence<k...>) {
      ((width == k ? go(std::integral_constant<std::size_t, k>()) : void()), ...);
    }
    (std::make_index_sequence<sizeof(Bits) + 1>());
  }
  template <class Bits>
  void packed_run(Bits* numbers, std::size_t count) {
    std::uint8_t width = 0;
    Bits least = 0;
    std::byte above[kPackedRun * sizeof(Bits)];
    if (!loading_) {
      Bits most = 0;
      least = std::numeric_limits<Bits>::max();
      for (std::size_t k = 0; k < count; ++k) {
        least = std::min(least, numbers[k]);
        most = std::max(most, numbers[k]);
      }
      width = static_cast<std::uint8_t>((std::bit_width(static_cast<Bits>(most - least)) + 7) / 8);
      with_width<Bits>(width, [&](auto bytes) {
        for (std::size_t k = 0; k < count; ++k) {
          const auto number = static_cast<Bits>(numbers[k] - least);
          std::memcpy(above + k * bytes, &number, bytes);
        }
      });
    }
    value(width);
    value(least);
    require(width <= sizeof(Bits));
    if (!ok()) width = 0;
    transfer(above, count * width);
    if (!loading_) return;
    with_width<Bits>(width, [&](auto bytes) {
      for (std::size_t k = 0; k < count; ++k) {
        Bits number = 0;
        std::memcpy(&number, above + k * bytes, bytes);
        numbers[k] = static_cast<Bits>(least + number);
      }
    });
  }

 protected:
  bool loading_ = false;
  bool refuses_nan_ = false, refuses_infinite_ = false;
  std::vector<std::byte> memory_;     // of a saver
  std::span<const std::byte> bytes_;  // of a loader
  std::size_t at_ = kHeader, end_ = 0;
  std::string error_;
};

class Saver : public Archive {
 public:
  /// Into memory that may be there already.
  explicit Saver(std::vector<std::byte> memory = {}) : Archive(std::move(memory)) {}
  /// What was written, without a header.
  std::span<const std::byte> bytes() const { return {memory_.data() + kHeader, at_ - kHeader}; }
  /// Makes room for so many bytes more, which then need no memory.
  void room_for(std::size_t bytes) {
    if (bytes > left()) make_room(bytes);
  }
  /// Goes back to where bytes() had this size.
  void cut(std::size_t size) { at_ = kHeader + size; }
  /// The same behind a header. The saver is of no use then.
  std::vector<std::byte> finish();
};

class Loader : public Archive {
 public:
  /// Looks at the header and the checksum.
  explicit Loader(std::span<const std::byte> bytes);
  /// Of numbers alone, without a header: Saver::bytes.
  static Loader of_numbers(std::span<const std::byte> bytes) { return Loader(bytes, 0); }
  std::byte peek() const { return bytes_[at_]; }

 private:
  using Archive::Archive;
};

/// Whatever is given, in turn: one_value() finds out what it is made of.
template <class... T>
void values(Archive& a, T&... v) {
  (one_value(a, v), ...);
}

/// A number; the elements of an array; or the members of a struct, as fields() ties them.
template <class T>
void one_value(Archive& a, T& v) {
  const auto each = [&a](auto&... member) { values(a, member...); };
  if constexpr (Number<T>) {
    a.value(v);
  } else if constexpr (requires { v[0]; }) {
    for (auto& element : v) one_value(a, element);
  } else if constexpr (requires { v.fields(); }) {
    std::apply(each, v.fields());
  } else {
    std::apply(each, fields(v));
  }
}
template <class T>
void one_value(Archive& a, std::vector<T>& v) {
  a.list(v, [&a](T& element) { one_value(a, element); });
}
template <class T>
void one_value(Archive& a, std::optional<T>& v) {
  bool any = v.has_value();
  a.value(any);
  if (a.loading()) v = any ? std::optional<T>(T{}) : std::nullopt;
  if (any) one_value(a, *v);
}
/// A variant, by the number of its alternative.
template <class... T>
void one_value(Archive& a, std::variant<T...>& v) {
  auto which = static_cast<std::uint8_t>(v.index());
  a.index(sizeof...(T), which);
  if (a.loading()) {
    std::uint8_t k = 0;
    ((which == k++ ? static_cast<void>(v.template emplace<T>()) : void()), ...);
  }
  std::visit([&a](auto& alternative) { one_value(a, alternative); }, v);
}

}  // namespace psim
