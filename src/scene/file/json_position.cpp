#include "file/json_position.h"

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>

namespace psim::scene {
namespace {

bool is_continuation(char c) { return (static_cast<unsigned char>(c) & 0xC0u) == 0x80u; }

// A place in a JSON text that is known to be valid. Past the end it stands still.
class Walker {
 public:
  explicit Walker(std::string_view text) : text_(text) {
    if (text_.starts_with("\xEF\xBB\xBF")) at_ = 3;
    skip_space();
  }

  std::size_t offset() const { return at_; }
  char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }

  void skip_char() {
    if (at_ < text_.size()) ++at_;
    skip_space();
  }

  void skip_space() {
    while (at_ < text_.size() && std::string_view(" \t\r\n").find(text_[at_]) != text_.npos) ++at_;
  }

  // From the opening quote to behind the closing one; returns the text with its quotes.
  std::string_view skip_string() {
    const std::size_t from = at_++;
    while (at_ < text_.size() && text_[at_] != '"') at_ += text_[at_] == '\\' ? 2 : 1;
    at_ = std::min(at_ + 1, text_.size());
    const std::string_view quoted = text_.substr(from, at_ - from);
    skip_space();
    return quoted;
  }

  void skip_value() {
    std::size_t depth = 0;
    do {
      switch (peek()) {
        case '"':
          skip_string();
          break;
        case '{':
        case '[':
          ++depth;
          skip_char();
          break;
        case '}':
        case ']':
          if (depth > 0) --depth;
          skip_char();
          break;
        case ',':
        case ':':
          skip_char();
          break;
        default:
          skip_literal();
          break;
      }
    } while (depth > 0 && at_ < text_.size());
  }

 private:
  void skip_literal() {
    at_ = std::min(text_.find_first_of(",:]}\"[{ \t\r\n", at_), text_.size());
    skip_space();
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

bool same_key(std::string_view quoted, const std::string& key) {
  if (quoted.find('\\') == quoted.npos) {
    return quoted.size() == key.size() + 2 && quoted.substr(1, key.size()) == key;
  }
  const nlohmann::json plain = nlohmann::json::parse(quoted, nullptr, false);
  return plain.is_string() && plain.get_ref<const std::string&>() == key;
}

// Leaves the walker at the member's value, `key_offset` at its key; false if there is no such one.
bool enter_member(Walker& walker, const std::string& key, int occurrence, std::size_t& key_offset) {
  if (walker.peek() != '{') return false;
  walker.skip_char();
  while (walker.peek() == '"') {
    const std::size_t here = walker.offset();
    const std::string_view quoted = walker.skip_string();
    if (same_key(quoted, key) && --occurrence == 0) {
      key_offset = here;
      walker.skip_char();  // ':'
      return true;
    }
    walker.skip_char();
    walker.skip_value();
    if (walker.peek() != ',') return false;
    walker.skip_char();
  }
  return false;
}

bool enter_element(Walker& walker, std::size_t index) {
  if (walker.peek() != '[') return false;
  walker.skip_char();
  for (; index > 0; --index) {
    walker.skip_value();
    if (walker.peek() != ',') return false;
    walker.skip_char();
  }
  return true;
}

bool is_plain_name(std::string_view key) {
  return !key.empty() && std::ranges::all_of(key, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
}

}  // namespace

TextPosition position_of(std::string_view text, std::size_t offset) {
  const std::string_view before = text.substr(0, std::min(offset, text.size()));
  const std::size_t line_begin = before.rfind('\n') + 1;  // npos + 1 = 0
  std::string_view line = before.substr(line_begin);
  if (line_begin == 0 && line.starts_with("\xEF\xBB\xBF")) line.remove_prefix(3);
  TextPosition position;
  position.line += static_cast<std::size_t>(std::ranges::count(before, '\n'));
  position.column += static_cast<std::size_t>(std::ranges::count_if(line, [](char c) { return !is_continuation(c); }));
  return position;
}

std::size_t offset_of(std::string_view text, const JsonPath& path, PointAt at) {
  Walker walker(text);
  std::size_t reached = walker.offset();
  for (std::size_t k = 0; k < path.size(); ++k) {
    const bool last = k + 1 == path.size();
    std::size_t key_offset = reached;
    const bool found = path[k].is_index
                           ? enter_element(walker, path[k].index)
                           : enter_member(walker, path[k].key, last && at == PointAt::second_key ? 2 : 1, key_offset);
    if (!found) return reached;
    if (last && at != PointAt::value && !path[k].is_index) return key_offset;
    reached = walker.offset();
  }
  return reached;
}

std::size_t offset_of_depth(std::string_view text, std::size_t depth) {
  std::size_t open = 0;
  for (Walker walker(text); walker.offset() < text.size();) {
    const char c = walker.peek();
    if (c == '"') {
      walker.skip_string();
      continue;
    }
    if (c == '[' || c == '{') {
      if (++open > depth) return walker.offset();
    } else if (c == ']' || c == '}') {
      --open;
    }
    walker.skip_char();
  }
  return text.size();
}

std::string path_text(const JsonPath& path) {
  constexpr std::size_t kMostSteps = 12;
  if (path.empty()) return "scene";
  std::string text;
  for (std::size_t k = 0; k < path.size(); ++k) {
    if (k == kMostSteps) return text + "...";
    if (path[k].is_index) {
      text += '[' + std::to_string(path[k].index) + ']';
    } else if (is_plain_name(path[k].key) && path[k].key.size() <= 60) {
      if (!text.empty()) text += '.';
      text += path[k].key;
    } else {
      text += "[\"" + printable(path[k].key) + "\"]";
    }
  }
  return text;
}

std::string printable(std::string_view text, std::size_t most) {
  std::string out;
  for (std::size_t k = 0; k < text.size(); ++k) {
    if (out.size() >= most && !is_continuation(text[k])) return out + "...";
    const auto byte = static_cast<std::uint8_t>(text[k]);
    if (byte < 0x20 || byte == 0x7F) {
      constexpr std::string_view kHex = "0123456789abcdef";
      out += "\\x";
      out += kHex[byte >> 4];
      out += kHex[byte & 15];
    } else {
      out += text[k];
    }
  }
  return out;
}

}  // namespace psim::scene
