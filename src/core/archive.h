// Bytes that hold a world's state: numbers one after the other, in the order that both sides visit them, then
// the long columns. Little-endian, no struct is written whole unless it is made of 4-byte numbers alone.
//
//   header    magic, format, length, length of the first part, hash of the first part
//   first     single numbers and short lists
//   columns   each begins on a cache line, in the order that the first part names them
//
// The same visitor writes and reads: Saver and Loader have the same calls. Columns are copied at the end, in
// parallel, once the first part proved sound.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "archive_record.h"
#include "column.h"
#include "worker_pool.h"

namespace psim {

static_assert(std::endian::native == std::endian::little, "saved states are little-endian");

/// 64-bit hash of bytes: finds damage, no defence against forgery.
std::uint64_t hash_of(const std::byte* data, std::size_t size);

struct ArchiveHeader {
  static constexpr std::uint64_t kMagic = 0x31305653'6D697370u;  // "psimSV01"
  static constexpr std::uint32_t kFormat = 10;
  std::uint64_t magic = kMagic;
  std::uint32_t format = kFormat;
  std::uint32_t spare = 0;
  std::uint64_t size = 0;   ///< of all, bytes
  std::uint64_t first = 0;  ///< bytes of the first part
  std::uint64_t hash = 0;   ///< of the first part
};

class ArchiveCopies {
 public:
  void add(void* to, const void* from, std::size_t bytes) {
    constexpr std::size_t kPiece = 1 << 17;
    for (std::size_t at = 0; at < bytes; at += kPiece) {
      list_.push_back({static_cast<std::byte*>(to) + at, static_cast<const std::byte*>(from) + at,
                       std::min(kPiece, bytes - at)});
    }
  }
  /// And as many jobs more, job(0) ... on whatever thread comes to them.
  template <class Job>
  void run(WorkerPool& pool, std::size_t jobs, const Job& job) {
    pool.run(jobs + list_.size(), [&](std::size_t k) {
      if (k < jobs) return job(k);
      const Copy& copy = list_[k - jobs];
      std::memcpy(copy.to, copy.from, copy.bytes);
    });
    list_.clear();
  }
  void run(WorkerPool& pool) {
    run(pool, 0, [](std::size_t) {});
  }
  /// On this thread.
  void run() {
    for (const Copy& copy : list_) std::memcpy(copy.to, copy.from, copy.bytes);
    list_.clear();
  }

 private:
  struct Copy {
    std::byte* to = nullptr;
    const std::byte* from = nullptr;
    std::size_t bytes = 0;
  };
  std::vector<Copy> list_;
};

inline constexpr std::size_t kArchiveAlign = 64;

/// A column that is written where it lies in the bytes, and read there.
template <class T>
struct InPlace {
  static_assert(std::is_trivially_copyable_v<T>);
  std::size_t count = 0;
  std::byte* to = nullptr;          ///< while they are written: aligned to a cache line of them
  const std::byte* from = nullptr;  ///< while they are read: not aligned

  T* room(std::size_t i) const { return reinterpret_cast<T*>(to) + i; }
  T operator[](std::size_t i) const {
    T value;
    std::memcpy(&value, from + i * sizeof(T), sizeof value);
    return value;
  }
  std::size_t bytes() const { return count * sizeof(T); }
};

class Saver {
 public:
  static constexpr bool kLoading = false;

  template <Number T>
  void value(T& v) {
    if constexpr (std::is_same_v<T, bool>) {
      put(static_cast<std::uint8_t>(v));
    } else {
      put(v);
    }
  }
  /// n values of something made of numbers of one size, without gaps.
  template <class T>
  void column(Column<T>& c, std::size_t n) {
    if (c.empty()) n = 0;
    long_run(c.data(), n);
  }
  template <class List>
  void vector(List& v) {
    long_run(v.data(), v.size());
  }
  /// Whoever has it writes it in a job of finish().
  template <class T>
  void in_place(InPlace<T>& c) {
    put(static_cast<std::uint64_t>(c.count));
    if (c.count != 0) runs_.push_back({nullptr, c.bytes(), &c.to});
  }
  std::size_t count(std::size_t n) {
    put(static_cast<std::uint64_t>(n));
    return n;
  }
  /// n things of at most so many bytes.
  template <class T, class Each>
  void records(T* things, std::size_t n, std::size_t most, const Each& each) {
    std::size_t at = first_.size();
    for (std::size_t k = 0; k < n;) {
      const std::size_t end = std::min(n, k + kRecords);
      first_.resize(at + (end - k) * most);
      RecordWriter to{first_.data() + at};
      for (; k < end; ++k) each(to, things[k]);
      at = static_cast<std::size_t>(to.at - first_.data());
    }
    first_.resize(at);
  }
  /// Numbers of one kind.
  template <Number T>
  void values(std::vector<T>& v) {
    put(static_cast<std::uint64_t>(v.size()));
    const std::size_t at = first_.size();
    first_.resize(at + v.size() * sizeof(T));
    if (!v.empty()) std::memcpy(first_.data() + at, v.data(), v.size() * sizeof(T));
  }
  /// A part that is read once: Loader::part.
  template <class Visit, class Take>
  void part(const Visit& visit, const Take&) {
    visit();
  }
  bool ok() const { return true; }
  static constexpr bool dry() { return false; }
  void require(bool) {}
  void refuse_nan(bool) {}
  bool fits(std::uint64_t) const { return true; }

  /// job(0) ... job(jobs - 1) write what lies in place.
  template <class Job>
  void finish(std::vector<std::byte>& out, WorkerPool& pool, std::size_t jobs, const Job& job) {
    ArchiveHeader header;
    header.first = first_.size();
    header.hash = hash_of(first_.data(), first_.size());
    std::size_t at = round_up(sizeof header + first_.size());
    for (const Run& run : runs_) at = round_up(at + run.bytes);
    header.size = at;
    out.resize(at);
    std::memcpy(out.data(), &header, sizeof header);
    std::memcpy(out.data() + sizeof header, first_.data(), first_.size());
    at = sizeof header + first_.size();
    const auto pad = [&] {
      std::fill(out.begin() + static_cast<std::ptrdiff_t>(at), out.begin() + static_cast<std::ptrdiff_t>(round_up(at)), std::byte{0});
      at = round_up(at);
    };
    pad();
    for (const Run& run : runs_) {
      if (run.place != nullptr) {
        *run.place = out.data() + at;
      } else {
        copies_.add(out.data() + at, run.from, run.bytes);
      }
      at += run.bytes;
      pad();
    }
    copies_.run(pool, jobs, job);
  }
  /// What was written but for columns.
  std::span<const std::byte> first() const { return first_; }
  void clear() {
    first_.clear();
    runs_.clear();
  }

  static std::size_t round_up(std::size_t n) { return (n + kArchiveAlign - 1) / kArchiveAlign * kArchiveAlign; }

 private:
  struct Run {
    const void* from = nullptr;
    std::size_t bytes = 0;
    std::byte** place = nullptr;  // of what is written there
  };
  template <class T>
  void put(T v) {
    const std::size_t at = first_.size();
    first_.resize(at + sizeof v);
    std::memcpy(first_.data() + at, &v, sizeof v);
  }
  template <class T>
  void long_run(const T* from, std::size_t n) {
    static_assert(std::is_trivially_copyable_v<T>);
    put(static_cast<std::uint64_t>(n));
    if (n != 0) runs_.push_back({from, n * sizeof(T), nullptr});
  }

  static constexpr std::size_t kRecords = 64;  // that there is room for at a time

  std::vector<std::byte> first_;
  std::vector<Run> runs_;
  ArchiveCopies copies_;
};

class Loader {
 public:
  static constexpr bool kLoading = true;

  /// Looks at the header; what is wrong comes back as a line. `dry`: columns stay where they are, to be looked at.
  explicit Loader(std::span<const std::byte> bytes, bool dry = false) : bytes_(bytes), dry_(dry) {
    if (bytes.size() < sizeof header_) {
      fail("it is cut short");
      return;
    }
    std::memcpy(&header_, bytes.data(), sizeof header_);
    if (header_.magic != ArchiveHeader::kMagic) {
      fail("it is no saved state of psim");
    } else if (header_.format != ArchiveHeader::kFormat) {
      fail("its format is " + std::to_string(header_.format) + ", this psim reads " +
           std::to_string(ArchiveHeader::kFormat));
    } else if (header_.size != bytes.size() || header_.first > bytes.size() - sizeof header_) {
      fail("it has " + std::to_string(bytes.size()) + " bytes of " + std::to_string(header_.size));
    } else if (hash_of(bytes.data() + sizeof header_, header_.first) != header_.hash) {
      fail("it is damaged");
    }
    end_ = sizeof header_ + (error_.empty() ? header_.first : 0);
    begin();
  }
  /// Once more from the first number on, no longer dry.
  void begin_again() {
    dry_ = false;
    part_ = 0;
    begin();
  }
  bool dry() const { return dry_; }
  std::size_t first_bytes() const { return header_.first; }

  /// Of numbers alone, without a header: Saver::first.
  static Loader of_numbers(std::span<const std::byte> bytes) { return Loader(bytes, bytes.size()); }

  template <Number T>
  void value(T& v) {
    if constexpr (std::is_same_v<T, bool>) {
      v = get<std::uint8_t>() != 0;
    } else {
      v = get<T>();
      if constexpr (std::is_floating_point_v<T>) require(!refuses_nan_ || !std::isnan(v));
      if constexpr (std::is_enum_v<T>) {
        if constexpr (kLastOf<T> != ~std::uint64_t{0}) require(static_cast<std::uint64_t>(v) <= kLastOf<T>);
      }
    }
  }
  template <class T>
  void column(Column<T>& c, std::size_t wanted) {
    const std::size_t n = length(sizeof(T));
    require(n == wanted);
    if (n == 0 || !ok()) return;
    if (dry_) {
      seen_.push_back({&c, bytes_.data() + run_});
      run_ = Saver::round_up(run_ + n * sizeof(T));
      return;
    }
    c.reserve(n);
    take(c.data(), n * sizeof(T));
  }
  /// A column that was seen in a dry run.
  template <class T>
  InPlace<T> seen(const Column<T>& c, std::size_t n) const {
    for (const Seen& s : seen_) {
      if (s.column == &c) return {n, nullptr, s.from};
    }
    return {};
  }
  template <class List>
  void vector(List& v) {
    using T = typename List::value_type;
    const std::size_t n = length(sizeof(T));
    v.resize(n);
    if (n == 0) return;
    take(v.data(), n * sizeof(T));
    if (dry_) copies_.run();
  }
  /// Where it lies in the bytes, for as long as they are there.
  template <class T>
  void in_place(InPlace<T>& c) {
    c.count = length(sizeof(T));
    c.from = c.count != 0 ? bytes_.data() + run_ : nullptr;
    run_ = Saver::round_up(run_ + c.bytes());
  }
  /// Whether they are those of a list. Found out once.
  template <class List>
  bool same(const InPlace<std::byte>& c, const List& list) {
    if (c.count != list.size()) return false;
    if (c.count == 0) return true;
    for (const Compared& known : compared_) {
      if (known.from == c.from && known.with == list.data()) return known.same;
    }
    compared_.push_back({c.from, list.data(), std::memcmp(c.from, list.data(), c.count) == 0});
    return compared_.back().same;
  }
  /// Of a list whose elements take at least a byte each.
  std::size_t count(std::size_t) {
    const auto n = get<std::uint64_t>();
    if (n <= end_ - at_) return static_cast<std::size_t>(n);
    fail("it is damaged");
    return 0;
  }
  bool at_end() const { return at_ == end_; }
  std::byte peek() const { return bytes_[at_]; }
  bool ok() const { return error_.empty(); }
  const std::string& error() const { return error_; }
  void require(bool sound) {
    if (!sound) fail("it is damaged");
  }
  /// n things of at most so many bytes.
  template <class T, class Each>
  void records(T* things, std::size_t n, std::size_t most, const Each& each) {
    refuses_nan_ ? read_records<true>(things, n, most, each) : read_records<false>(things, n, most, each);
  }
  /// Numbers of one kind, of which none is refused.
  template <Number T>
  void values(std::vector<T>& v) {
    static_assert(std::is_integral_v<T> && !std::is_same_v<T, bool>);
    const auto n = get<std::uint64_t>();
    require(n <= (end_ - at_) / sizeof(T));
    v.resize(ok() ? static_cast<std::size_t>(n) : 0);
    if (v.empty()) return;
    std::memcpy(v.data(), bytes_.data() + at_, v.size() * sizeof(T));
    at_ += v.size() * sizeof(T);
  }
  /// A part that a dry run reads for good: visit(). The second time it is passed over, and take() has it from there.
  template <class Visit, class Take>
  void part(const Visit& visit, const Take& take) {
    if (dry_) {
      visit();
      parts_.push_back({at_, run_});
      return;
    }
    at_ = parts_[part_].at;
    run_ = parts_[part_++].run;
    take();
  }
  /// From now on. What contacts and events tell of a body whose host gave it NaN may be NaN; sizes may not.
  void refuse_nan(bool on) { refuses_nan_ = on; }
  /// Whether so many things of a byte or more can be in the bytes at all.
  bool fits(std::uint64_t n) {
    require(n <= bytes_.size());
    return ok();
  }
  /// All was read.
  void end() { require(at_ == end_ && run_ == bytes_.size()); }
  void fail(const std::string& error) {
    if (error_.empty()) error_ = error;
  }
  /// Copies wait for finish().
  ArchiveCopies& copies() { return copies_; }
  template <class Job>
  void finish(WorkerPool& pool, std::size_t jobs, const Job& job) {
    copies_.run(pool, jobs, job);
  }
  void finish(WorkerPool& pool) { copies_.run(pool); }

 private:
  struct Seen {
    const void* column = nullptr;
    const std::byte* from = nullptr;
  };
  struct PartEnd {
    std::size_t at = 0, run = 0;
  };
  struct Compared {
    const std::byte *from = nullptr, *with = nullptr;
    bool same = false;
  };

  Loader(std::span<const std::byte> bytes, std::size_t end) : bytes_(bytes), end_(end), run_(end) {}

  void begin() {
    at_ = sizeof header_;
    run_ = Saver::round_up(end_);
  }
  template <bool kRefusesNan, class T, class Each>
  void read_records(T* things, std::size_t n, std::size_t most, const Each& each) {
    for (std::size_t k = 0; k < n && ok(); ++k) {
      if (end_ - at_ < most) {
        each(*this, things[k]);
        continue;
      }
      RecordReader<kRefusesNan> from{bytes_.data() + at_};
      each(from, things[k]);
      at_ = static_cast<std::size_t>(from.at - bytes_.data());
      require(from.sound);
    }
  }
  template <class T>
  T get() {
    T v{};
    if (end_ - at_ < sizeof v) {
      fail("it is damaged");
      return v;
    }
    std::memcpy(&v, bytes_.data() + at_, sizeof v);
    at_ += sizeof v;
    return v;
  }
  std::size_t length(std::size_t each) {
    const auto n = get<std::uint64_t>();
    if (run_ <= bytes_.size() && n <= (bytes_.size() - run_) / each) return static_cast<std::size_t>(n);
    fail("it is damaged");
    return 0;
  }
  void take(void* to, std::size_t bytes) {
    copies_.add(to, bytes_.data() + run_, bytes);
    run_ = Saver::round_up(run_ + bytes);
  }

  std::span<const std::byte> bytes_;
  ArchiveHeader header_;
  std::size_t at_ = 0, end_ = 0, run_ = 0;
  std::string error_;
  ArchiveCopies copies_;
  std::vector<Seen> seen_;
  std::vector<Compared> compared_;
  std::vector<PartEnd> parts_;
  std::size_t part_ = 0;
  bool refuses_nan_ = false;
  bool dry_ = false;
};

/// Every number in turn.
template <class A, class... T>
void numbers(A& a, T&... v) {
  (a.value(v), ...);
}

/// A list of things: each(element).
template <class A, class T, class Each>
void list(A& a, std::vector<T>& v, const Each& each) {
  const std::size_t n = a.count(v.size());
  if constexpr (A::kLoading) {
    v.clear();
    v.resize(n);
  }
  for (T& element : v) {
    if (!a.ok()) return;
    each(element);
  }
}

/// The same of things that are numbers alone: each(archive, element).
template <class A, class T, class Each>
void records(A& a, std::vector<T>& v, const Each& each) {
  RecordSize most;
  T any{};
  each(most, any);
  const std::size_t n = a.count(v.size());
  if constexpr (A::kLoading) v.resize(n);
  a.records(v.data(), n, most.bytes, each);
}

}  // namespace psim
