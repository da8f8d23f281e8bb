// Schema: checks JSON by the JSON Schemas of docs/schema, for tests.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>

namespace weir::test {

// The keywords of JSON Schema that our schemas use. Members that a schema does not name are an
// error here: they are not documented.
class Schema {
 public:
  using Json = nlohmann::json;

  explicit Schema(Json schema) : root_(std::move(schema)) {}
  // Of docs/schema; null if WEIR_TEST_SCHEMAS, which meson sets, does not say where that is.
  static std::unique_ptr<Schema> from_file(const std::string& name) {
    const char* folder = std::getenv("WEIR_TEST_SCHEMAS");
    if (!folder) return nullptr;
    std::ifstream file(std::string(folder) + "/" + name);
    return std::make_unique<Schema>(Json::parse(file));
  }
  const Json& root() const { return root_; }
  // The first violation; "" if there is none.
  std::string check(const Json& value) const { return check(root_, value, "#", Members::Named); }

 private:
  enum class Members { Named, Any };

  static bool is_of(const std::string& type, const Json& value) {
    if (type == "object") return value.is_object();
    if (type == "array") return value.is_array();
    if (type == "string") return value.is_string();
    if (type == "integer") return value.is_number_integer();
    if (type == "number") return value.is_number();
    return type == "null" && value.is_null();
  }

  std::string check(const Json& schema, const Json& value, const std::string& at,
                    Members members) const {
    if (schema == false) return at + ": is not allowed here";
    if (schema.contains("$ref")) {
      const std::string name = schema["$ref"].get<std::string>().substr(strlen("#/$defs/"));
      return check(root_["$defs"].at(name), value, at, members);
    }
    if (schema.contains("const") && value != schema["const"]) return at + ": const";
    if (schema.contains("enum") &&
        std::find(schema["enum"].begin(), schema["enum"].end(), value) == schema["enum"].end())
      return at + ": enum";
    if (schema.contains("type")) {
      const Json types = schema["type"].is_array() ? schema["type"] : Json::array({schema["type"]});
      bool fits = false;
      for (const auto& type : types) fits |= is_of(type, value);
      if (!fits) return at + ": type of " + value.dump();
    }
    if (schema.contains("oneOf")) {
      const auto fits = [&](const Json& one) {
        return check(one, value, at, Members::Any).empty();
      };
      if (std::count_if(schema["oneOf"].begin(), schema["oneOf"].end(), fits) != 1)
        return at + ": oneOf";
    }
    if (value.is_number()) return check_number(schema, value.get<double>(), at);
    if (value.is_string()) return check_text(schema, value.get<std::string>(), at);
    if (value.is_array()) return check_array(schema, value, at);
    return value.is_object() ? check_object(schema, value, at, members) : "";
  }
  static std::string check_number(const Json& schema, double number, const std::string& at) {
    const auto is_broken = [&](const char* keyword, auto breaks) {
      return schema.contains(keyword) && breaks(schema[keyword].get<double>());
    };
    if (is_broken("minimum", [=](double limit) { return number < limit; })) return at + ": minimum";
    if (is_broken("maximum", [=](double limit) { return number > limit; })) return at + ": maximum";
    if (is_broken("exclusiveMinimum", [=](double limit) { return !(number > limit); }))
      return at + ": exclusiveMinimum";
    if (is_broken("exclusiveMaximum", [=](double limit) { return !(number < limit); }))
      return at + ": exclusiveMaximum";
    return "";
  }
  // Lengths are of ASCII texts here.
  static std::string check_text(const Json& schema, const std::string& text,
                                const std::string& at) {
    if (text.size() < schema.value("minLength", size_t{0})) return at + ": minLength";
    if (text.size() > schema.value("maxLength", text.size())) return at + ": maxLength";
    if (schema.contains("pattern") && !std::regex_search(text, std::regex(schema["pattern"])))
      return at + ": pattern";
    return "";
  }
  std::string check_array(const Json& schema, const Json& value, const std::string& at) const {
    if (schema.contains("minItems") && value.size() < schema["minItems"]) return at + ": minItems";
    if (schema.contains("maxItems") && value.size() > schema["maxItems"]) return at + ": maxItems";
    if (!schema.contains("items")) return "";
    for (size_t i = 0; i < value.size(); ++i)
      if (auto wrong =
              check(schema["items"], value[i], at + "/" + std::to_string(i), Members::Named);
          !wrong.empty())
        return wrong;
    return "";
  }
  std::string check_object(const Json& schema, const Json& value, const std::string& at,
                           Members members) const {
    for (const auto& name : schema.value("required", Json::array()))
      if (!value.contains(name.get<std::string>())) return at + ": lacks " + name.dump();
    if (!schema.contains("properties")) return "";
    for (const auto& [name, member] : value.items()) {
      if (!schema["properties"].contains(name)) {
        if (members == Members::Named) return at + ": unknown member " + name;
        continue;
      }
      if (auto wrong = check(schema["properties"][name], member, at + "/" + name, Members::Named);
          !wrong.empty())
        return wrong;
    }
    return "";
  }

  const Json root_;
};

}  // namespace weir::test
