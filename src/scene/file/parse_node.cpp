#include "file/parse_node.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace psim::scene {
namespace {

// Letters inserted, deleted or replaced to turn a into b.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row[b.size()];
}

std::string kind(const Json& value) {
  switch (value.type()) {
    case Json::value_t::null:
      return "null";
    case Json::value_t::object:
      return "an object";
    case Json::value_t::array:
      return "an array";
    case Json::value_t::string:
      return "a string";
    case Json::value_t::boolean:
      return "true or false";
    default:
      return "a number";
  }
}

std::string in_quotes(std::string_view word) { return '"' + printable(word) + '"'; }

}  // namespace

std::string count_text(std::size_t count) {
  return "has " + std::to_string(count) + (count == 1 ? " element" : " elements");
}

std::string word_list(KeyList words) {
  std::string list;
  for (std::size_t k = 0; k < words.size(); ++k) {
    if (k > 0) list += k + 1 == words.size() ? " or " : ", ";
    list += in_quotes(words[k]);
  }
  return list;
}

std::string hint(std::string_view word, KeyList words) {
  constexpr std::size_t kLongest = 64;  // nobody mistypes a name into more than this
  if (word.size() > kLongest) return {};
  std::string_view nearest;
  std::size_t best = std::min<std::size_t>(2, word.size() / 2) + 1;
  for (const std::string_view candidate : words) {
    if (candidate.size() > kLongest) continue;
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < best) {
      best = distance;
      nearest = candidate;
    }
  }
  return nearest.empty() ? std::string() : " (did you mean " + in_quotes(nearest) + "?)";
}

JsonPath Node::path() const {
  JsonPath path;
  for (const Node* node = this; node->parent_ != nullptr; node = node->parent_) {
    path.push_back({std::string(node->key_), node->index_, node->parent_->value_->is_array()});
  }
  std::ranges::reverse(path);
  return path;
}

void Node::fail(std::string message) const { throw SceneError{path(), std::move(message), PointAt::value}; }

void Node::fail_at_key(std::string_view key, std::string message) const {
  JsonPath to_key = path();
  to_key.push_back({std::string(key), 0, false});
  throw SceneError{std::move(to_key), std::move(message), PointAt::key};
}

void Node::expect_object() const {
  if (!value_->is_object()) fail("must be an object, not " + kind(*value_));
}

void Node::expect_object(KeyList allowed) const {
  expect_object();
  for (const auto& [key, member] : value_->get_ref<const Json::object_t&>()) {
    if (std::ranges::find(allowed, key) != allowed.end()) continue;
    fail_at_key(key, "unknown key" + hint(key, allowed) + "; allowed: " + word_list(allowed));
  }
}

void Node::expect_array(std::size_t least, std::size_t most) const {
  if (!value_->is_array()) fail("must be an array, not " + kind(*value_));
  if (size() >= least && size() <= most) return;
  const std::string allowed = least == most    ? std::to_string(least)
                              : size() < least ? "at least " + std::to_string(least)
                                               : "at most " + std::to_string(most);
  fail(count_text(size()) + ": " + allowed);
}

std::optional<Node> Node::find(std::string_view key) const {
  const auto& members = value_->get_ref<const Json::object_t&>();
  const auto member = members.find(key);
  if (member == members.end()) return std::nullopt;
  return Node(member->second, this, member->first, 0);
}

Node Node::require(std::string_view key) const {
  if (const std::optional<Node> member = find(key)) return *member;
  fail("the key " + in_quotes(key) + " is missing");
}

Node Node::element(std::size_t index) const {
  return Node(value_->get_ref<const Json::array_t&>()[index], this, {}, index);
}

double Node::number(Range range) const {
  if (!is_number()) {
    fail("must be a number " + range_text(range) + ", not " + kind(*value_));
  }
  const double value = value_->get<double>();
  if (!range.contains(value)) fail(exact_text(value) + " is out of range: a number " + range_text(range));
  return value;
}

std::uint64_t Node::integer(std::uint64_t min, std::uint64_t max) const {
  const std::string allowed = "a whole number from " + std::to_string(min) + " to " + std::to_string(max);
  if (!is_number()) fail("must be " + allowed + ", not " + kind(*value_));
  std::uint64_t value = 0;
  if (value_->is_number_unsigned()) {
    value = value_->get<std::uint64_t>();
  } else {
    // 1e6 is a whole number too; above 2^53 only plain digits are exact.
    const double number = value_->get<double>();
    constexpr double kExact = 9007199254740992.0;
    if (number != std::floor(number)) fail(exact_text(number) + " is not whole: " + allowed);
    if (number < 0 || number > kExact) fail(exact_text(number) + " is out of range: " + allowed);
    value = static_cast<std::uint64_t>(number);
  }
  if (value < min || value > max) fail(std::to_string(value) + " is out of range: " + allowed);
  return value;
}

std::int64_t Node::signed_integer(std::int64_t min, std::int64_t max) const {
  const std::string allowed = "a whole number from " + std::to_string(min) + " to " + std::to_string(max);
  if (!is_number()) fail("must be " + allowed + ", not " + kind(*value_));
  const double number = value_->get<double>();
  if (number != std::floor(number)) fail(exact_text(number) + " is not whole: " + allowed);
  if (number < static_cast<double>(min) || number > static_cast<double>(max)) {
    fail(exact_text(number) + " is out of range: " + allowed);
  }
  return static_cast<std::int64_t>(number);
}

bool Node::boolean() const {
  if (!value_->is_boolean()) fail("must be true or false, not " + kind(*value_));
  return value_->get<bool>();
}

const std::string& Node::string() const {
  if (!is_string()) fail("must be a string, not " + kind(*value_));
  return value_->get_ref<const std::string&>();
}

const std::string& Node::name() const {
  const std::string& text = string();
  const bool control =
      std::ranges::any_of(text, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; });
  if (control) fail(in_quotes(text) + " has control characters: a name of one line");
  return text;
}

Vec2 Node::vec2(Range range) const {
  if (!value_->is_array()) fail("must be an array of 2 numbers [x, y], not " + kind(*value_));
  if (size() != 2) fail(count_text(size()) + ": 2 numbers [x, y]");
  return {element(0).number(range), element(1).number(range)};
}

std::size_t Node::one_of(KeyList words) const {
  if (!is_string()) fail("must be " + word_list(words) + ", not " + kind(*value_));
  const std::string& word = string();
  const auto found = std::ranges::find(words, word);
  if (found == words.end()) {
    fail(in_quotes(word) + " is not known" + hint(word, words) + "; allowed: " + word_list(words));
  }
  return static_cast<std::size_t>(found - words.begin());
}

double Node::number_or(std::string_view key, double absent, Range range) const {
  const std::optional<Node> member = find(key);
  return member ? member->number(range) : absent;
}

bool Node::boolean_or(std::string_view key, bool absent) const {
  const std::optional<Node> member = find(key);
  return member ? member->boolean() : absent;
}

Vec2 Node::vec2_or(std::string_view key, Vec2 absent, Range range) const {
  const std::optional<Node> member = find(key);
  return member ? member->vec2(range) : absent;
}

}  // namespace psim::scene
