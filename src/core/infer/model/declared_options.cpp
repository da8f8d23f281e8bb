// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/model/declared_options.hpp"

#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <set>

#include "core/infer/module/engine_functions.hpp"
#include "core/infer/module/load_configuration.hpp"
#include "core/text/text.hpp"

namespace weir::infer {

const char kAllDeclared[] = R"([
  {"name": "framework", "type": "text", "default": "", "help": "the name by which the engine was requested"},
  {"name": "custom", "type": "text", "default": "", "help": "the whole value of custom="},
  {"name": "accelerator", "type": "text", "default": "", "help": "the whole value of accelerator="},
  {"name": "input", "type": "text", "default": "", "help": "dimensions of the inputs"},
  {"name": "inputtype", "type": "text", "default": "", "help": "types of the inputs"},
  {"name": "inputname", "type": "text", "default": "", "help": "names of the inputs"},
  {"name": "inputlayout", "type": "text", "default": "", "help": "layouts of the inputs"},
  {"name": "output", "type": "text", "default": "", "help": "dimensions of the outputs"},
  {"name": "outputtype", "type": "text", "default": "", "help": "types of the outputs"},
  {"name": "outputname", "type": "text", "default": "", "help": "names of the outputs"},
  {"name": "outputlayout", "type": "text", "default": "", "help": "layouts of the outputs"},
  {"name": "latency", "type": "integer", "default": "0", "help": "the user reads latency or throughput"},
  {"name": "throughput", "type": "integer", "default": "0", "help": "the user reads latency or throughput"},
  {"name": "suspend", "type": "integer", "default": "0", "help": "milliseconds, 0 = never"},
  {"name": "shared-tensor-filter-key", "type": "text", "default": "", "help": "of models that are shared"},
  {"name": "invoke-dynamic", "type": "boolean", "default": "false", "help": "sizes with each frame"},
  {"name": "invoke-async", "type": "boolean", "default": "false", "help": "any number of outputs"},
  {"name": "async-timeout", "type": "integer", "default": "0", "help": "idle milliseconds, 0 = unlimited"}
])";

namespace {

constexpr char kOwnName[] = "framework";

struct OptionNames {
  std::set<std::string> all;
  std::vector<std::pair<std::string, std::string>> settings;  // name, "group/key" of weir.ini
};

OptionNames option_names(const weir_engine& engine) {
  OptionNames out;
  const char* const options = get_function(engine, &weir_engine::options_json);
  if (!options) return out;
  const auto list = nlohmann::json::parse(options, nullptr, false);
  if (!list.is_array()) return out;
  const auto get_text = [](const auto& option, const char* member) {
    const auto found = option.is_object() ? option.find(member) : option.end();
    return option.is_object() && found != option.end() && found->is_string()
               ? std::optional(found->template get<std::string>())
               : std::nullopt;
  };
  for (const auto& option : list)
    if (const auto name = get_text(option, "name")) {
      out.all.insert(*name);
      if (const auto setting = get_text(option, "setting"))
        out.settings.emplace_back(*name, *setting);
    }
  return out;
}

bool given(const OpenOptions& options, const std::string& name) {
  return std::any_of(options.options.begin(), options.options.end(),
                     [&](const auto& own) { return own.first == name; });
}

// Engines compare option keys case-insensitively.
bool given_in_any_case(const OpenOptions& options, const std::string& name) {
  return std::any_of(options.options.begin(), options.options.end(),
                     [&](const auto& own) { return lower(own.first) == lower(name); });
}

// The value for an option whose configuration cannot be read: names the file, the line and the fix
// for the engine's error message.
std::string unknown(const Error& fault, const std::string& group, const std::string& key) {
  const bool unread = fault.code == Code::FILE_NOT_FOUND;
  std::string out = "unknown, because " +
                    (unread ? fault.offered + " cannot be read: " + fault.difference : fault.what);
  if (!unread && !fault.offered.empty()) out += " (" + fault.offered + ")";
  if (!unread && !fault.difference.empty()) out += ", " + fault.difference;
  return out + "; correct that file, or set the variable " + config::variable_name(group, key);
}

// Adds the settings of weir.ini for options that the user did not set. If the file is invalid, the
// engine gets a value that it rejects, since the setting is unknown.
void add_settings(const OptionNames& names, const OpenOptions& options,
                  std::vector<std::pair<std::string, std::string>>* out) {
  if (names.settings.empty()) return;
  const auto configuration = infer::configuration();
  for (const auto& [name, setting] : names.settings) {
    if (given_in_any_case(options, name)) continue;
    const size_t slash = std::min(setting.find('/'), setting.size());
    const auto group = setting.substr(0, slash);
    const auto key = setting.substr(std::min(slash + 1, setting.size()));
    if (const auto possible_fault = configuration.possible_fault(group, key))
      out->emplace_back(name, unknown(*possible_fault, group, key));
    else if (const auto found = configuration.find(group, key))
      out->emplace_back(name, found->value);
  }
}

}  // namespace

std::vector<std::pair<std::string, std::string>> options_for(const weir_engine& engine,
                                                             const OpenOptions& options) {
  auto out = options.options;
  const auto taken = option_names(engine);
  if (taken.all.contains(kOwnName)) out.emplace_back(kOwnName, engine.name);
  for (const auto& declared : options.declared)
    if (!given(options, declared.first) && taken.all.contains(declared.first))
      out.push_back(declared);
  add_settings(taken, options, &out);
  return out;
}

std::vector<std::pair<std::string, std::string>> get_identity(const weir_engine& engine,
                                                              const OpenOptions& options) {
  OpenOptions lasting = options;
  std::erase_if(lasting.declared, [](const auto& option) {
    return option.first == "latency" || option.first == "throughput" || option.first == "suspend" ||
           option.first == "async-timeout";
  });
  return options_for(engine, lasting);
}

std::vector<weir_option> options_for_inner(const weir_engine& inner, const weir_open& request) {
  const auto taken = option_names(inner).all;
  std::vector<weir_option> all(request.options, request.options + request.n_options);
  const auto own = std::find_if(all.rbegin(), all.rend(), [](const weir_option& option) {
    return option.key && std::string_view(option.key) == kOwnName;
  });
  if (own == all.rend()) return all;
  std::vector<weir_option> out(all.begin(), own.base() - 1);  // the user's
  if (taken.contains(kOwnName)) out.push_back({kOwnName, inner.name});
  std::copy_if(own.base(), all.end(), std::back_inserter(out),
               [&](const weir_option& option) { return taken.contains(option.key); });
  return out;
}

}  // namespace weir::infer
