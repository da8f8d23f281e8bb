// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/model/option_check.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/infer/module/engine_functions.hpp"
#include "core/infer/module/known_engines.hpp"
#include "core/text/text.hpp"
#include "weir/join.hpp"

namespace weir::infer {
namespace {

struct Declared {
  std::string name, type, usual;  // usual: the default
};

std::vector<Declared> declarations(const weir_engine& engine) {
  std::vector<Declared> out;
  const char* const json = get_function(engine, &weir_engine::options_json);
  const auto list = nlohmann::json::parse(json ? json : "[]", nullptr, false);
  if (!list.is_array()) return out;
  const auto get_text = [](const nlohmann::json& option, const char* member) {
    const auto found = option.find(member);
    return found != option.end() && found->is_string() ? found->get<std::string>() : "";
  };
  for (const auto& option : list)
    if (option.is_object())
      out.push_back(
          {get_text(option, "name"), get_text(option, "type"), get_text(option, "default")});
  return out;
}

bool is_boolean(std::string_view value) {
  constexpr const char* kWords[] = {"true", "false", "1", "0", "yes", "no", "on", "off"};
  return std::any_of(std::begin(kWords), std::end(kWords),
                     [&](const char* word) { return equal_ignoring_case(word, value); });
}

// What a value of the type is; "" if `value` is one.
std::string needed(const std::string& type, const std::string& value) {
  if (type == "integer") return parse_signed(value) ? "" : "an integer";
  if (type == "number") return parse_double(value) ? "" : "a number";
  if (type == "boolean") return is_boolean(value) ? "" : "true or false";
  if (type.find('|') == std::string::npos) return "";
  const auto words = split(type, "|");
  const bool is_one = std::find(words.begin(), words.end(), value) != words.end();
  return is_one ? "" : "one of: " + join(words, ", ");
}

Error unknown(const weir_engine& engine, const std::string& key, const std::string& value,
              const std::vector<Declared>& declared) {
  std::vector<std::string> names;
  for (const auto& option : declared) names.push_back(option.name);
  const std::string close = nearest(key, names);
  return Error{
      .code = Code::OPTION_VALUE,
      .what = std::string("the engine ") + engine.name + " has no such option",
      .offered = "custom=" + key + ":" + value,
      .needed = "one of: " + join(names, ", "),
      .difference = close.empty() ? "" : "did you mean " + close + "?",
      .fix = close.empty() ? "" : "custom=" + close + ":" + value,
  };
}

}  // namespace

Status check_options(const weir_engine& engine,
                     std::span<const std::pair<std::string, std::string>> options) {
  if (options.empty() || (engine.name && known_engine(engine.name))) return ok();
  const auto declared = declarations(engine);
  const auto find = [&declared](const std::string& key) {
    return std::find_if(declared.begin(), declared.end(),
                        [&](const Declared& d) { return equal_ignoring_case(d.name, key); });
  };
  if (declared.empty() || find("custom") != declared.end()) return ok();
  for (const auto& [key, value] : options) {
    const auto option = find(key);
    if (option == declared.end()) return unknown(engine, key, value, declared);
    if (auto type = needed(option->type, value); !type.empty())
      return Error{.code = Code::OPTION_VALUE,
                   .what = std::string("the engine ") + engine.name +
                           " does not accept this value for " + option->name,
                   .offered = "custom=" + key + ":" + value,
                   .needed = std::move(type),
                   .fix = option->usual.empty() ? "" : "custom=" + key + ":" + option->usual};
  }
  return ok();
}

}  // namespace weir::infer
