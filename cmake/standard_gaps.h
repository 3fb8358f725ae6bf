// The parts of the C++20 standard library that psim uses and that an older standard library lacks: that of emscripten
// 3.1.6 is libc++ of LLVM 13. PsimWebPackages.cmake includes this file ahead of every source. Each part asks for the
// library's own feature macro and disappears where it is there.
//
// Names go into namespace std, so that the sources stay plain C++20. Only the overloads that psim calls are here.
#pragma once

#include <version>

#ifndef __cpp_lib_bit_cast
#include <bit>
namespace std {
template <class To, class From>
constexpr To bit_cast(const From& from) noexcept {
  return __builtin_bit_cast(To, from);
}
}  // namespace std
#endif

#ifndef __cpp_lib_atomic_ref
#include <atomic>
namespace std {
template <class T>
class atomic_ref {
 public:
  explicit atomic_ref(T& value) : value_(&value) {}
  void store(T value, memory_order order = memory_order_seq_cst) const {
    __atomic_store_n(value_, value, static_cast<int>(order));
  }
  T load(memory_order order = memory_order_seq_cst) const { return __atomic_load_n(value_, static_cast<int>(order)); }

 private:
  T* value_;
};
}  // namespace std
#endif

#ifndef __cpp_lib_jthread
#include <thread>
namespace std {
class jthread {
 public:
  template <class... Arguments>
  explicit jthread(Arguments&&... arguments) : thread_(std::forward<Arguments>(arguments)...) {}
  jthread(jthread&&) = default;
  ~jthread() {
    if (thread_.joinable()) thread_.join();
  }

 private:
  thread thread_;
};
}  // namespace std
#endif

#ifndef __cpp_lib_to_chars
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
namespace std {
/// Takes what from_chars takes: no space, plus sign or hexadecimal digits, and no more text than the number. The C
/// library rounds correctly, and the locale of these programs is "C".
inline from_chars_result from_chars(const char* first, const char* last, double& value) {
  const string text(first, last);
  const size_t length = min(text.find_first_not_of("0123456789.eE+-"), text.size());
  char* stop = nullptr;
  const string number = text.substr(0, length);
  const double read = number.empty() || number[0] == '+' ? 0 : strtod(number.c_str(), &stop);
  if (stop == nullptr || stop == number.c_str()) return {first, errc::invalid_argument};
  const size_t digit = number.find_first_of("123456789"), exponent = number.find_first_of("eE");
  const bool fits = read - read == 0 && (read != 0 || !(digit < exponent));
  if (fits) value = read;
  return {first + (stop - number.c_str()), fits ? errc() : errc::result_out_of_range};
}

/// The shortest digits that read back as the value, in fixed or scientific notation, whichever is shorter. `sure`
/// digits survive the way through the type; two or three more always suffice.
template <class Real>
char* shortest_text(char* first, Real value, int sure) {
  if (value - value != 0 || value == 0) {
    const char* const word = value != value ? "nan" : signbit(value) ? (value == 0 ? "-0" : "-inf") : "inf";
    return first + sprintf(first, "%s", value == 0 && !signbit(value) ? "0" : word);
  }
  char text[40];
  for (int digits = sure;; ++digits) {
    sprintf(text, "%.*e", digits - 1, static_cast<double>(value));
    const bool same = sizeof value == sizeof(float) ? strtof(text, nullptr) == value : strtod(text, nullptr) == value;
    if (same || digits == sure + 3) break;
  }
  string mantissa(text, strchr(text, 'e'));
  const int exponent = atoi(strchr(text, 'e') + 1);
  const size_t last = mantissa.find_last_not_of('0');
  mantissa.resize(mantissa[last] == '.' ? last : last + 1);
  const string scientific = mantissa + (exponent < 0 ? "e-" : "e+") + (abs(exponent) < 10 ? "0" : "") +
                            to_string(abs(exponent));
  const int digits = static_cast<int>(count_if(mantissa.begin(), mantissa.end(), [](char c) { return c >= '0'; }));
  char fixed[400];
  sprintf(fixed, "%.*f", max(digits - 1 - exponent, 0), static_cast<double>(value));
  const bool is_short = strlen(fixed) <= scientific.size();
  return first + sprintf(first, "%s", is_short ? fixed : scientific.c_str());
}
/// `last` leaves room for any number: 40 characters suffice.
inline to_chars_result to_chars(char* first, char*, double value) { return {shortest_text(first, value, 15), errc()}; }
inline to_chars_result to_chars(char* first, char*, float value) { return {shortest_text(first, value, 6), errc()}; }
}  // namespace std
#endif

#ifndef __cpp_lib_ranges
#include <algorithm>
#include <functional>
#include <iterator>
namespace std {
namespace ranges {

template <class Range, class Test, class Projection = identity>
constexpr auto find_if(Range&& range, Test test, Projection of = {}) {
  return std::find_if(begin(range), end(range), [&](auto& e) -> bool { return invoke(test, invoke(of, e)); });
}
template <class Range, class Value, class Projection = identity>
constexpr auto find(Range&& range, const Value& value, Projection of = {}) {
  return std::find_if(begin(range), end(range), [&](auto& e) -> bool { return invoke(of, e) == value; });
}
template <class Range, class Test, class Projection = identity>
constexpr bool any_of(Range&& range, Test test, Projection of = {}) {
  return ranges::find_if(range, test, of) != end(range);
}
template <class Range, class Test, class Projection = identity>
constexpr bool none_of(Range&& range, Test test, Projection of = {}) {
  return !ranges::any_of(range, test, of);
}
template <class Range, class Test, class Projection = identity>
constexpr bool all_of(Range&& range, Test test, Projection of = {}) {
  return std::all_of(begin(range), end(range), [&](auto& e) -> bool { return invoke(test, invoke(of, e)); });
}
template <class Range, class Test>
constexpr auto count_if(Range&& range, Test test) {
  return std::count_if(begin(range), end(range), test);
}
template <class Range, class Value>
constexpr auto count(Range&& range, const Value& value) {
  return std::count(begin(range), end(range), value);
}
template <class A, class B, class Same = std::equal_to<>>
constexpr bool equal(A&& a, B&& b, Same same = {}) {
  return std::equal(begin(a), end(a), begin(b), end(b), same);
}
template <class A, class B>
constexpr auto mismatch(A&& a, B&& b) {
  return std::mismatch(begin(a), end(a), begin(b), end(b));
}
template <class Range, class Less = std::less<>, class Projection = identity>
constexpr void sort(Range&& range, Less before = {}, Projection of = {}) {
  std::sort(begin(range), end(range), [&](auto& a, auto& b) { return before(invoke(of, a), invoke(of, b)); });
}
template <class Range, class Less = std::less<>, class Projection = identity>
constexpr bool is_sorted(Range&& range, Less before = {}, Projection of = {}) {
  return std::is_sorted(begin(range), end(range),
                        [&](auto& a, auto& b) { return before(invoke(of, a), invoke(of, b)); });
}
template <class Range, class Value, class Less = std::less<>, class Projection = identity>
constexpr auto lower_bound(Range&& range, const Value& value, Less before = {}, Projection of = {}) {
  return std::lower_bound(begin(range), end(range), value,
                          [&](auto& e, auto& v) { return before(invoke(of, e), v); });
}
template <class Range, class Value, class Less = std::less<>, class Projection = identity>
constexpr auto upper_bound(Range&& range, const Value& value, Less before = {}, Projection of = {}) {
  return std::upper_bound(begin(range), end(range), value,
                          [&](auto& v, auto& e) { return before(v, invoke(of, e)); });
}
template <class Range, class Value>
constexpr bool binary_search(Range&& range, const Value& value) {
  return std::binary_search(begin(range), end(range), value);
}
template <class Value>
struct min_max_result {
  Value min, max;
};
template <class Range, class Less = std::less<>, class Projection = identity>
constexpr auto minmax(Range&& range, Less before = {}, Projection of = {}) {
  const auto by = [&](auto& a, auto& b) { return before(invoke(of, a), invoke(of, b)); };
  const auto [least, most] = std::minmax_element(begin(range), end(range), by);
  return min_max_result<iter_value_t<decltype(begin(range))>>{*least, *most};
}
template <class Range>
constexpr auto max(Range&& range) {
  return *std::max_element(begin(range), end(range));
}
template <class Range, class Value>
constexpr void fill(Range&& range, const Value& value) {
  std::fill(begin(range), end(range), value);
}
template <class Range>
constexpr void reverse(Range&& range) {
  std::reverse(begin(range), end(range));
}
template <class Range, class Out, class Test>
constexpr void copy_if(Range&& range, Out out, Test test) {
  std::copy_if(begin(range), end(range), out, test);
}
template <class Range, class Out, class Function>
constexpr void transform(Range&& range, Out out, Function function) {
  std::transform(begin(range), end(range), out, [&](auto& e) { return invoke(function, e); });
}
template <class Range, class Middle, class Less = std::less<>, class Projection = identity>
constexpr void inplace_merge(Range&& range, Middle middle, Less before = {}, Projection of = {}) {
  std::inplace_merge(begin(range), middle, end(range),
                     [&](auto& a, auto& b) { return before(invoke(of, a), invoke(of, b)); });
}

}  // namespace ranges
}  // namespace std
#endif
