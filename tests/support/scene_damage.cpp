#include "scene_damage.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <vector>

#include "support.h"

namespace psim::test {
namespace {

struct Token {
  std::size_t begin = 0, end = 0;
  bool key = false, number = false;
};

// Strings, numbers and words, in the order of the text; enough of JSON to aim by.
std::vector<Token> tokens_of(std::string_view text) {
  std::vector<Token> tokens;
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at];
    Token token{at, at + 1};
    if (c == '"') {
      while (token.end < text.size() && text[token.end] != '"') token.end += text[token.end] == '\\' ? 2 : 1;
      token.end = std::min(token.end + 1, text.size());
      const std::size_t next = text.find_first_not_of(" \t\r\n", token.end);
      token.key = next != text.npos && text[next] == ':';
    } else if (c == '-' || std::isalnum(static_cast<unsigned char>(c)) != 0) {
      token.end = std::min(text.find_first_of(",]}: \t\r\n", at), text.size());
      token.number = c == '-' || std::isdigit(static_cast<unsigned char>(c)) != 0;
    } else {
      ++at;
      continue;
    }
    at = token.end;
    tokens.push_back(token);
  }
  return tokens;
}

constexpr std::array<std::string_view, 40> kValues = {"null",
                                                      "true",
                                                      "false",
                                                      "\"\"",
                                                      "\"text\"",
                                                      "[]",
                                                      "{}",
                                                      "[[]]",
                                                      "[1]",
                                                      "{\"disc\": 1}",
                                                      "0",
                                                      "-0",
                                                      "-1",
                                                      "1",
                                                      "0.5",
                                                      "1e400",
                                                      "-1e400",
                                                      "1e308",
                                                      "-1e308",
                                                      "1e-320",
                                                      "NaN",
                                                      "nan",
                                                      "Infinity",
                                                      "-Infinity",
                                                      "4294967295",
                                                      "4294967296",
                                                      "18446744073709551615",
                                                      "18446744073709551616",
                                                      "99999999999999999999999999999999999999",
                                                      "-9223372036854775809",
                                                      "01",
                                                      "1.",
                                                      ".5",
                                                      "+1",
                                                      "0x10",
                                                      "1e",
                                                      "'a'",
                                                      "\"\\u0000\"",
                                                      "\"\\ud800\"",
                                                      "undefined"};
constexpr std::array<std::string_view, 24> kKeys = {"psim",   "world",    "bounds",    "boundary", "gravity", "step",
                                                    "dt",     "substeps", "materials", "bodies",   "shape",   "disc",
                                                    "radius", "position", "mass",      "groups",   "layout",  "count",
                                                    "region", "joints",   "a",         "b",        "fields",  "links"};
constexpr std::array<std::string_view, 10> kBadBytes = {"\xFF",     "\xC0\xAF", "\xED\xA0\x80", "\xF4\x90\x80\x80",
                                                        "\xE2\x82", "\x80",     "\xEF\xBB\xBF", "\x7F",
                                                        "\x1B[2J",  "\r"};

class Damager {
 public:
  Damager(std::string_view scene, std::uint64_t seed) : random_(seed), text_(scene) {}

  Damage take() {
    const std::size_t times = random_.chance(0.7) ? 1 : 2 + random_.below(2);
    for (std::size_t k = 0; k < times; ++k) once();
    return {what_, text_};
  }

 private:
  // A token of which `wanted` holds; none: the text has no such token.
  template <class Wanted>
  const Token* pick(const std::vector<Token>& tokens, const Wanted& wanted) {
    std::vector<const Token*> found;
    for (const Token& token : tokens) {
      if (wanted(token)) found.push_back(&token);
    }
    return found.empty() ? nullptr : found[random_.below(found.size())];
  }

  std::string of(const Token& token) const { return text_.substr(token.begin, token.end - token.begin); }
  void put(const Token& token, std::string_view words) { text_.replace(token.begin, token.end - token.begin, words); }
  std::size_t somewhere() { return random_.below(text_.size() + 1); }

  void once() {
    const std::vector<Token> tokens = tokens_of(text_);
    const auto value = [](const Token& t) { return !t.key; };
    const auto key = [](const Token& t) { return t.key; };
    const auto number = [](const Token& t) { return t.number; };
    const Token* token = nullptr;
    switch (random_.below(22)) {
      case 0:
        return note("cut"), text_.resize(somewhere());
      case 1:
      case 2:
      case 3:
        if ((token = pick(tokens, value)) == nullptr) return;
        return note("a value of another kind"), put(*token, kValues[random_.below(kValues.size())]);
      case 4:
        if ((token = pick(tokens, number)) == nullptr) return;
        return note("a number turned negative"),
               put(*token, of(*token).starts_with('-') ? of(*token).substr(1) : "-" + of(*token));
      case 5:
        if ((token = pick(tokens, number)) == nullptr) return;
        return note("a huge number"), put(*token, random_.chance(0.5) ? "10000000" : "1e18");
      case 6:
        if ((token = pick(tokens, number)) == nullptr) return;
        return note("a number of 5,000 digits"), put(*token, std::string(5000, '7'));
      case 7:
        if ((token = pick(tokens, key)) == nullptr) return;
        return note("another key"), put(*token, "\"" + std::string(kKeys[random_.below(kKeys.size())]) + "\"");
      case 8:
        if ((token = pick(tokens, key)) == nullptr) return;
        return note("a typing error in a key"), put(*token, "\"" + of(*token).substr(2));
      case 9:
        if ((token = pick(tokens, key)) == nullptr) return;
        note("a key twice");
        return void(
            text_.insert(token->begin, of(*token) + ": " + std::string(kValues[random_.below(kValues.size())]) + ", "));
      case 10:
        if ((token = pick(tokens, value)) == nullptr) return;
        return note("deep nesting"), put(*token, nested());
      case 11:
        return note("bad bytes"), void(text_.insert(somewhere(), kBadBytes[random_.below(kBadBytes.size())]));
      case 12:
        return note("a NUL"), void(text_.insert(somewhere(), 1, '\0'));
      case 13:
        return note("a byte order mark"), void(text_.insert(0, "\xEF\xBB\xBF"));
      case 14:
        note("nearly nothing");
        text_ = random_.chance(0.5) ? "" : std::string(random_.below(5), " \n{["[random_.below(4)]);
        return;
      case 15:
        return joints(tokens);
      case 16:
        if (text_.empty()) return;
        return note("a byte lost"), void(text_.erase(random_.below(text_.size()), 1));
      case 17:
        if (text_.empty()) return;
        return note("a byte changed"), void(text_[random_.below(text_.size())] = static_cast<char>(random_.below(256)));
      case 18:
        return note("a piece twice"), copy_piece();
      case 19:
        return note("a comment"), void(text_.insert(somewhere(), random_.chance(0.5) ? "// no\n" : "/* no */"));
      case 20:
        if ((token = pick(tokens, value)) == nullptr) return;
        return note("a long text"), put(*token, "\"" + std::string(random_.chance(0.9) ? 2000 : 1 << 20, 'x') + "\"");
      default:
        if ((token = pick(tokens, value)) == nullptr) return;
        return note("a long list"), put(*token, list());
    }
  }

  // One body joined with itself, or with one that is not there.
  void joints(const std::vector<Token>& tokens) {
    std::vector<const Token*> ends;
    for (std::size_t k = 0; k + 1 < tokens.size(); ++k) {
      const std::string name = tokens[k].key ? of(tokens[k]) : "";
      if (name == "\"a\"" || name == "\"b\"") ends.push_back(&tokens[k + 1]);
    }
    if (ends.empty()) return;
    note("a joint's body");
    const std::size_t k = random_.below(ends.size());
    constexpr std::array<std::string_view, 5> kEnds = {"\"nobody\"", "4294967295", "-1", "1.5", "\"\""};
    if (random_.chance(0.5) && k + 1 < ends.size()) return put(*ends[k], of(*ends[k + 1]));
    put(*ends[k], kEnds[random_.below(kEnds.size())]);
  }

  std::string nested() {
    constexpr std::size_t kDepths[] = {5, 31, 33, 1000, 200'000};
    const std::size_t depth = kDepths[random_.below(5)];
    std::string text;
    const bool lists = random_.chance(0.5);
    for (std::size_t k = 0; k < depth; ++k) text += lists ? "[" : "{\"a\":";
    if (random_.chance(0.3)) return text;
    text += "1";
    return text + std::string(depth, lists ? ']' : '}');
  }

  std::string list() {
    const std::size_t n = random_.chance(0.9) ? 20 : 50'000;
    const std::string_view value = kValues[random_.below(kValues.size())];
    std::string text = "[";
    for (std::size_t k = 0; k < n; ++k) text += std::string(value) + (k + 1 < n ? "," : "]");
    return text;
  }

  void copy_piece() {
    if (text_.empty()) return;
    const std::size_t from = random_.below(text_.size());
    const std::string piece = text_.substr(from, 1 + random_.below(200));
    text_.insert(somewhere(), piece);
  }

  void note(std::string_view what) { what_ += (what_.empty() ? "" : ", ") + std::string(what); }

  Random random_;
  std::string text_;
  std::string what_;
};

}  // namespace

Damage damaged(std::string_view scene, std::uint64_t seed) { return Damager(scene, seed).take(); }

}  // namespace psim::test
