// SPDX-License-Identifier: LGPL-2.1-or-later
#include "doctor/engine_options.hpp"

#include <cstdio>

#include "core/infer/model/declared_options.hpp"
#include "core/subplugin/table.hpp"
#include "core/text/text.hpp"

namespace weir::app {
namespace {

std::string get_text(const Json& option, const char* member) {
  const auto found = option.find(member);
  return found != option.end() && found->is_string() ? found->get<std::string>() : "";
}

std::pair<std::string, std::string> split_once(std::string_view text) {
  const size_t colon = std::min(text.find(':'), text.size());
  return {std::string(strip(text.substr(0, colon))),
          std::string(strip(text.substr(std::min(colon + 1, text.size()))))};
}

// Filters for NNStreamer parse custom= themselves; some describe their options.
std::vector<EngineOption> described_options(const weir_engine& engine) {
  std::vector<EngineOption> out;
  const auto& table = subplugin::table();
  for (const auto& [key, text] : table.descriptions(subplugin::Kind::Filter, engine.name))
    out.push_back({key, "text", "", text});
  return out;
}

}  // namespace

std::vector<EngineOption> engine_options(const weir_engine& engine) {
  if (engine.options_json && std::string_view(engine.options_json) == infer::kAllDeclared)
    return described_options(engine);
  return engine_options(engine.options_json);
}

std::vector<EngineOption> engine_options(const char* options_json) {
  std::vector<EngineOption> out;
  const Json list = Json::parse(options_json ? options_json : "[]", nullptr, false);
  if (!list.is_array()) return out;
  for (const auto& option : list)
    if (option.is_object() && !get_text(option, "name").empty())
      out.push_back({get_text(option, "name"), get_text(option, "type"),
                     get_text(option, "default"), get_text(option, "help")});
  return out;
}

Json to_json(const std::vector<EngineOption>& options) {
  Json out = Json::array();
  for (const auto& option : options)
    out.push_back({{"name", option.name},
                   {"type", option.type},
                   {"default", option.by_default},
                   {"help", option.help}});
  return out;
}

std::vector<std::pair<std::string, std::string>> custom_options(const std::string& text) {
  std::vector<std::pair<std::string, std::string>> out;
  for (const auto part : split(text, ",")) {
    const auto [key, value] = split_once(strip(part));
    if (!key.empty()) out.emplace_back(key, value);
  }
  return out;
}

void print_options(const std::vector<EngineOption>& options) {
  if (options.empty()) return;
  std::vector<std::vector<std::string>> rows{{"name", "type", "default", "meaning"}};
  for (const auto& option : options)
    rows.push_back({option.name, option.type, option.by_default.empty() ? "-" : option.by_default,
                    option.help});
  std::printf("\nOptions, as custom=name:value,name:value\n%s", table(rows, "  ").c_str());
}

}  // namespace weir::app
