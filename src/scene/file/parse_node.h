// A value of the document together with its place, and the typed reads with their ranges. Every
// read either gives a value that the format allows or throws a SceneError that says what is wrong
// and what would be right.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/range_text.h"
#include "file/parse_dom.h"
#include "psim/limits.h"
#include "psim/types.h"

namespace psim::scene {

using KeyList = std::span<const std::string_view>;

/// Points into the document and at its parent node: both must outlive it.
class Node {
 public:
  explicit Node(const Json& root) : value_(&root) {}

  const Json& json() const { return *value_; }
  std::size_t size() const { return value_->size(); }
  JsonPath path() const;

  [[noreturn]] void fail(std::string message) const;
  /// The error points at the key of this member.
  [[noreturn]] void fail_at_key(std::string_view key, std::string message) const;

  /// An object with no other keys than these.
  void expect_object(KeyList allowed) const;
  void expect_object() const;
  /// An array of `least` to `most` elements.
  void expect_array(std::size_t least, std::size_t most) const;

  std::optional<Node> find(std::string_view key) const;
  Node require(std::string_view key) const;
  Node element(std::size_t index) const;

  bool is_number() const { return value_->is_number(); }
  bool is_array() const { return value_->is_array(); }
  bool is_string() const { return value_->is_string(); }
  double number(Range range) const;
  std::uint64_t integer(std::uint64_t min, std::uint64_t max) const;
  std::int64_t signed_integer(std::int64_t min, std::int64_t max) const;
  bool boolean() const;
  const std::string& string() const;
  /// A string without control characters.
  const std::string& name() const;
  Vec2 vec2(Range range) const;
  /// Which of the words it is.
  std::size_t one_of(KeyList words) const;

  // Of a member that may be absent.
  double number_or(std::string_view key, double absent, Range range) const;
  bool boolean_or(std::string_view key, bool absent) const;
  Vec2 vec2_or(std::string_view key, Vec2 absent, Range range) const;

 private:
  Node(const Json& value, const Node* parent, std::string_view key, std::size_t index)
      : value_(&value), parent_(parent), key_(key), index_(index) {}

  const Json* value_;
  const Node* parent_ = nullptr;
  std::string_view key_;
  std::size_t index_ = 0;
};

/// ` (did you mean "gravity"?)`, or nothing if no word is near.
std::string hint(std::string_view word, KeyList words);

/// `has 2 elements`
std::string count_text(std::size_t count);

/// `"a", "b" or "c"`
std::string word_list(KeyList words);

}  // namespace psim::scene
