// A validator for the part of JSON Schema 2020-12 that docs/scene.schema.json uses. A keyword that
// it does not know is an error, so that nothing in the schema goes unchecked.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

namespace psim::test {

class JsonSchema {
 public:
  using Json = nlohmann::json;

  explicit JsonSchema(Json schema) : root_(std::move(schema)) {}

  /// Empty, or the place of the first violation and the keyword that was violated.
  std::string violation(const Json& document) const { return check(root_, document, ""); }

 private:
  std::string check(const Json& schema, const Json& value, const std::string& at) const {
    for (const auto& [keyword, rule] : schema.items()) {
      const std::string wrong = apply(schema, keyword, rule, value, at);
      if (!wrong.empty()) return wrong;
    }
    return {};
  }

  std::string apply(const Json& schema, const std::string& keyword, const Json& rule, const Json& value,
                    const std::string& at) const {
    const auto violated_if = [&](bool bad) { return bad ? at + ": " + keyword : std::string(); };
    const auto number = [&] { return value.get<double>(); };
    if (keyword == "$schema" || keyword == "$defs" || keyword == "title" || keyword == "description" ||
        keyword == "default" || keyword == "x-default") {
      return {};
    }
    if (keyword == "$ref") {
      return check(root_.at(Json::json_pointer(rule.get<std::string>().substr(1))), value, at);
    }
    if (keyword == "type") return violated_if(!has_type(value, rule.get<std::string>()));
    if (keyword == "enum") {
      return violated_if(std::find(rule.begin(), rule.end(), value) == rule.end());
    }
    if (keyword == "oneOf") {
      std::size_t fitting = 0;
      for (const Json& choice : rule) fitting += check(choice, value, at).empty() ? 1 : 0;
      return violated_if(fitting != 1);
    }
    if (keyword == "minimum") return violated_if(value.is_number() && number() < rule);
    if (keyword == "maximum") return violated_if(value.is_number() && number() > rule);
    if (keyword == "exclusiveMinimum") return violated_if(value.is_number() && number() <= rule);
    if (keyword == "minItems") return violated_if(value.is_array() && value.size() < rule);
    if (keyword == "maxItems") return violated_if(value.is_array() && value.size() > rule);
    if (keyword == "pattern") {
      if (rule != "^[^\\u0000-\\u001f\\u007f]*$") return at + ": unknown pattern";
      if (!value.is_string()) return {};
      const auto& text = value.get_ref<const std::string&>();
      return violated_if(std::any_of(text.begin(), text.end(),
                                     [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; }));
    }
    if (keyword == "items") return check_items(rule, value, at);
    if (keyword == "required") {
      if (!value.is_object()) return {};
      for (const Json& key : rule) {
        if (!value.contains(key.get<std::string>())) return at + ": required " + key.dump();
      }
      return {};
    }
    if (keyword == "properties" || keyword == "additionalProperties") {
      return check_members(schema, keyword, value, at);
    }
    return at + ": unknown keyword " + keyword;
  }

  std::string check_items(const Json& rule, const Json& value, const std::string& at) const {
    if (!value.is_array()) return {};
    for (std::size_t k = 0; k < value.size(); ++k) {
      const std::string wrong = check(rule, value[k], at + '/' + std::to_string(k));
      if (!wrong.empty()) return wrong;
    }
    return {};
  }

  std::string check_members(const Json& schema, const std::string& keyword, const Json& value,
                            const std::string& at) const {
    if (!value.is_object()) return {};
    static const Json kNone = Json::object();
    const Json& known = schema.contains("properties") ? schema["properties"] : kNone;
    for (const auto& [key, member] : value.items()) {
      const std::string place = at + '/' + key;
      std::string wrong;
      if (keyword == "properties") {
        if (known.contains(key)) wrong = check(known[key], member, place);
      } else if (!known.contains(key)) {
        const Json& rule = schema["additionalProperties"];
        if (rule.is_object()) {
          wrong = check(rule, member, place);
        } else if (rule == false) {
          wrong = place + ": additionalProperties";
        }
      }
      if (!wrong.empty()) return wrong;
    }
    return {};
  }

  static bool has_type(const Json& value, const std::string& type) {
    if (type == "object") return value.is_object();
    if (type == "array") return value.is_array();
    if (type == "string") return value.is_string();
    if (type == "boolean") return value.is_boolean();
    if (type == "null") return value.is_null();
    if (type == "number") return value.is_number();
    if (type == "integer") {
      return value.is_number_integer() || (value.is_number() && value.get<double>() == std::floor(value.get<double>()));
    }
    return false;
  }

  Json root_;
};

}  // namespace psim::test
