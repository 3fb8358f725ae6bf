// A growable array of plain values, aligned to a cache line and readable a little past its end, as
// the kernels want it. Growth is counted: a warm step makes none.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <new>
#include <type_traits>
#include <utility>

#include "base/os.h"
#include "block_layout.h"

namespace psim {

/// Counts the bytes that the columns of a world hold, and how often one had to grow. Each world has one. A column that
/// would grow beyond `most` throws std::bad_alloc instead.
struct MemoryMeter {
  std::size_t bytes = 0;
  std::uint64_t growths = 0;
  std::size_t most = SIZE_MAX;
  bool touches = false;  ///< the system is to give memory when room is made, and not when it is first used
};

/// While it lives, columns of 2 MiB and more touch all of their memory when room in them is asked for.
class TouchedRoom {
 public:
  explicit TouchedRoom(MemoryMeter& meter) : meter_(meter) { meter_.touches = true; }
  ~TouchedRoom() { meter_.touches = false; }
  TouchedRoom(const TouchedRoom&) = delete;
  TouchedRoom& operator=(const TouchedRoom&) = delete;

 private:
  MemoryMeter& meter_;
};

/// Empties lists and columns and gives their memory back.
template <class... Lists>
void give_back(Lists&... lists) {
  const auto drop = []<class List>(List& list) {
    if constexpr (requires { list.release(); }) {
      list.release();
    } else {
      list = List();
    }
  };
  (drop(lists), ...);
}

template <class T>
class Column {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  explicit Column(MemoryMeter& meter) : meter_(&meter) {}
  Column(Column&& other) noexcept : meter_(other.meter_) { swap(other); }
  Column& operator=(Column&& other) noexcept {
    swap(other);
    return *this;
  }
  ~Column() { release(); }

  /// Makes room for n values (and the readable pad). Keeps the content; new values are zero.
  void reserve(std::size_t n) {
    if (n > capacity_) grow(n);
    if (meter_->touches && bytes() >= os::kLargePage) touch();
  }

  /// The same, but with an eighth to spare when it grows: for lists whose length goes up and down.
  void reserve_loosely(std::size_t n) {
    if (n > capacity_) reserve(n + n / 8 + 1024);
  }

  /// Gives the memory back if there is no room for n values, so that growth need not copy values that are written anew.
  void release_if_short(std::size_t n) {
    if (n > capacity_) release();
  }

  /// Gives the memory back.
  void release() {
    drop();
    meter_->bytes -= bytes();
    data_ = nullptr;
    capacity_ = 0;
  }

  void swap(Column& other) {
    std::swap(data_, other.data_);
    std::swap(capacity_, other.capacity_);
  }

  T* data() { return data_; }
  const T* data() const { return data_; }
  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }
  std::size_t capacity() const { return capacity_; }
  bool empty() const { return data_ == nullptr; }
  std::size_t bytes() const { return capacity_ == 0 ? 0 : bytes_for(capacity_); }

 private:
  static constexpr std::align_val_t kAlignment{kernels::kAlign};
  void grow(std::size_t n) {
    const std::size_t wanted = kernels::round_up_block(std::max(n, capacity_ + capacity_ / 8));
    const std::size_t size = bytes_for(wanted), before = bytes();
    if (size - before > meter_->most - std::min(meter_->bytes, meter_->most)) throw std::bad_alloc();
    T* fresh = static_cast<T*>(take(size, before));
    if (before != 0) std::memcpy(static_cast<void*>(fresh), data_, before);
    drop();
    data_ = fresh;
    capacity_ = wanted;
    meter_->bytes += size - before;
    ++meter_->growths;
  }
  void touch() {
    auto* const begin = reinterpret_cast<volatile char*>(data_);
    for (std::size_t k = 0; k < bytes(); k += 4096) begin[k] = begin[k];  // no system has smaller pages
  }
  // Memory that is zero from the byte `zero_from` on.
  static void* take(std::size_t size, std::size_t zero_from) {
    if (size >= os::kLargePage) return os::take_pages(size);
    void* const begin = ::operator new(size, kAlignment);
    std::memset(static_cast<char*>(begin) + zero_from, 0, size - zero_from);
    return begin;
  }
  void drop() {
    if (bytes() >= os::kLargePage) return os::give_pages_back(data_, bytes());
    ::operator delete(data_, kAlignment);
  }
  static std::size_t bytes_for(std::size_t capacity) {
    const std::size_t size = (capacity + kernels::kReadPad) * sizeof(T);
    return (size + kernels::kAlign - 1) / kernels::kAlign * kernels::kAlign;
  }

  MemoryMeter* meter_;
  T* data_ = nullptr;
  std::size_t capacity_ = 0;
};

/// Bytes that these vectors hold: a meter does not count them.
template <class... Vectors>
std::size_t bytes_of(const Vectors&... vectors) {
  return (std::size_t{0} + ... + (vectors.capacity() * sizeof vectors[0]));
}

/// Makes room for n values in columns that are wanted; the others give their memory back.
template <class... Columns>
void keep_if(bool wanted, std::size_t n, Columns&... columns) {
  ((wanted ? columns.reserve(n) : columns.release()), ...);
}

}  // namespace psim
