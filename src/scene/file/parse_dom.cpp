#include "file/parse_dom.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace psim::scene {
namespace {

// Receives the parser's events and builds the document. The library's parser is iterative; so is
// this one: `open_` is the way from the root to the container that is being filled.
class Builder : public nlohmann::json_sax<Json> {
 public:
  explicit Builder(std::string_view text) : text_(text) {}

  Json take() { return std::move(root_); }

  bool null() override { return put(nullptr); }
  bool boolean(bool value) override { return put(value); }
  bool number_integer(number_integer_t value) override { return put(value); }
  bool number_unsigned(number_unsigned_t value) override { return put(value); }
  bool number_float(number_float_t value, const string_t& /*text*/) override { return put(value); }
  bool string(string_t& value) override { return put(std::move(value)); }
  bool binary(binary_t& /*value*/) override { return false; }  // not in JSON text
  bool start_object(std::size_t /*size*/) override { return open(Json::object()); }
  bool start_array(std::size_t /*size*/) override { return open(Json::array()); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }

  bool key(string_t& name) override {
    Open& top = open_.back();
    auto [member, is_new] = top.container->get_ref<Json::object_t&>().try_emplace(name);
    top.key = name;
    if (!is_new) throw SceneError{path(), "the key stands twice: once only", PointAt::second_key};
    top.member = &member->second;
    return true;
  }

  bool parse_error(std::size_t position, const std::string& last_token,
                   const nlohmann::detail::exception& error) override {
    const std::size_t offset = begin_of_token(position, last_token, error.what());
    throw SceneError{path(), message(offset, error), PointAt::value, offset};
  }

 private:
  // `position` is behind the last byte read. Of words and punctuation the library does not tell the
  // token's length.
  std::size_t begin_of_token(std::size_t position, const std::string& last_token, std::string_view what) const {
    if (what.find("unexpected end of input") != what.npos) return text_.size();
    const auto is_word = [](char c) {
      return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '+' || c == '-' ||
             c == '.';
    };
    std::size_t at = std::min(position > 0 ? position - 1 : 0, text_.size() - 1);
    if (what.find("unexpected string literal") != what.npos) {
      return position - std::min(position, last_token.size());
    }
    if (what.find("invalid string") != what.npos) return at;
    const bool invalid = what.find("invalid") != what.npos;  // the byte behind the word was read
    if (!is_word(text_[at]) && !(invalid && at > 0 && is_word(text_[at - 1]))) return at;
    while (at > 0 && is_word(text_[at - 1])) --at;
    return at;
  }

  struct Open {
    Json* container;
    Json* member;     // where the value goes whose key was read
    std::string key;  // that key
  };

  Json* place(Json value) {
    if (open_.empty()) {
      root_ = std::move(value);
      return &root_;
    }
    Open& top = open_.back();
    if (top.container->is_object()) {
      *top.member = std::move(value);
      return top.member;
    }
    auto& elements = top.container->get_ref<Json::array_t&>();
    elements.push_back(std::move(value));
    return &elements.back();
  }

  bool put(Json value) {
    place(std::move(value));
    finish_member();
    return true;
  }

  bool open(Json container) {
    if (open_.size() == kMaxDepth) {
      throw SceneError{
          {}, "is nested too deeply: at most 32 levels", PointAt::value, offset_of_depth(text_, kMaxDepth)};
    }
    open_.push_back({place(std::move(container)), nullptr, {}});
    return true;
  }

  bool close() {
    open_.pop_back();
    finish_member();
    return true;
  }

  void finish_member() {
    if (open_.empty()) return;
    open_.back().key.clear();
    open_.back().member = nullptr;
  }

  // Of the value that is being read. An object that waits for a key has no member yet.
  JsonPath path() const {
    JsonPath path;
    for (std::size_t k = 0; k < open_.size(); ++k) {
      const Open& level = open_[k];
      const bool last = k + 1 == open_.size();
      if (level.container->is_array()) {
        const std::size_t size = level.container->size();
        path.push_back({{}, last ? size : size - 1, true});
      } else if (!level.key.empty() || level.member != nullptr) {
        path.push_back({level.key, 0, false});
      }
    }
    return path;
  }

  std::string message(std::size_t offset, const nlohmann::detail::exception& error) const {
    if (error.id == 406) {  // number overflow
      const std::size_t end = text_.find_first_of(",]} \t\r\n", offset);
      return printable(text_.substr(offset, end - offset), 30) + " is too large: a finite number, at most 1.8e308";
    }
    constexpr std::array<std::string_view, 8> kNotFinite = {"NaN", "nan", "Inf", "inf", "-NaN", "-nan", "-Inf", "-inf"};
    for (const std::string_view word : kNotFinite) {
      if (text_.substr(offset).starts_with(word)) {
        return "NaN and infinity are not allowed: a finite number";
      }
    }
    // "[json...] parse error at line 1, column 2: syntax error while parsing X - what; last
    // read: '...'; expected Y": the place and what was read are ours to say.
    const std::string whole = error.what();
    std::string_view what = whole;
    constexpr std::string_view kWhat = " - ", kRead = "; last read", kExpected = "; expected ";
    if (const auto at = what.find(kWhat); at != what.npos) what.remove_prefix(at + kWhat.size());
    std::string_view expected;
    if (const auto at = what.rfind(kExpected); at != what.npos) expected = what.substr(at);
    what = what.substr(0, std::min(what.find(kRead), what.size() - expected.size()));
    return "not valid JSON: " + printable(what, 120) + printable(expected, 120);
  }

  std::string_view text_;
  Json root_;
  std::vector<Open> open_;
};

}  // namespace

Json read_document(std::string_view text) {
  // The library takes a NUL for the end of the text.
  const std::size_t nul = text.find('\0');
  if (nul != text.npos) {
    throw SceneError{{}, "a NUL byte: a scene is JSON in UTF-8", PointAt::value, nul};
  }
  if (text.find_first_not_of(" \t\r\n") == text.npos) {
    throw SceneError{{}, "the file is empty: a scene is a JSON object", PointAt::value, text.size()};
  }
  Builder builder(text);
  Json::sax_parse(text, &builder);
  return builder.take();
}

}  // namespace psim::scene
