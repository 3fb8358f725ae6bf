// Pieces of the JSON text that to_json.cpp and fluid_to_json.cpp write. Numbers are the shortest that read back to the
// same bits.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/range_text.h"
#include "psim/scene.h"

namespace psim::scene {

inline std::string text_of(double value) {
  const std::string text = exact_text(value);
  return text == "-0" ? "-0.0" : text;  // "-0" reads as the integer 0
}

inline std::string text_of(std::string_view words) {
  return nlohmann::json(words).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

inline std::string text_of(Vec2 v) { return '[' + text_of(v.x) + ", " + text_of(v.y) + ']'; }

inline std::string text_of(const Bounds& b) {
  return '[' + text_of(b.xmin) + ", " + text_of(b.ymin) + ", " + text_of(b.xmax) + ", " + text_of(b.ymax) + ']';
}

inline std::string text_of(bool value) { return value ? "true" : "false"; }

template <class T>
std::string list_of(const std::vector<T>& values) {
  std::string text = "[";
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (k > 0) text += ", ";
    text += text_of(values[k]);
  }
  return text + ']';
}

// Members of one object, in the order of the calls.
class Object {
 public:
  Object& raw(std::string_view key, std::string_view text) {
    members_.push_back(text_of(key) + ": " + std::string(text));
    return *this;
  }
  template <class T>
  Object& add(std::string_view key, const T& value) {
    return raw(key, text_of(value));
  }
  Object& add_unless(std::string_view key, double value, double absent) {
    return value == absent ? *this : add(key, value);
  }
  Object& add_unless(std::string_view key, Vec2 value, Vec2 absent) {
    return value.x == absent.x && value.y == absent.y ? *this : add(key, value);
  }
  Object& add_if(std::string_view key, bool value) { return value ? add(key, true) : *this; }

  std::string one_line() const { return members_.empty() ? "{}" : "{ " + joined(", ") + " }"; }
  std::string lines(std::size_t indent) const {
    const std::string margin = '\n' + std::string(indent, ' ');
    return members_.empty() ? "{}" : '{' + margin + "  " + joined("," + margin + "  ") + margin + '}';
  }

 private:
  std::string joined(const std::string& between) const {
    std::string text;
    for (const std::string& member : members_) {
      if (!text.empty()) text += between;
      text += member;
    }
    return text;
  }

  std::vector<std::string> members_;
};

// One element a line.
inline std::string array_lines(const std::vector<std::string>& elements, std::size_t indent) {
  const std::string margin = '\n' + std::string(indent, ' ');
  std::string text = "[";
  for (std::size_t k = 0; k < elements.size(); ++k) {
    text += (k > 0 ? "," : "") + margin + "  " + elements[k];
  }
  return text + margin + ']';
}

/// One element of `fluids`. `fed`: by an emitter, so that it may begin empty.
std::string fluid_text(const SceneFluid& fluid, bool fed);
/// One element of `emitters`, and of `drains`.
std::string emitter_text(const EmitterDesc& emitter);
std::string drain_text(const Bounds& region);

}  // namespace psim::scene
