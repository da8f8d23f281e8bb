// Names of options_json.
#include "core/infer/declared_options.hpp"

#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <set>

#include "core/infer/engine_functions.hpp"

namespace weir::infer {

const char kAllDeclared[] = R"([
  {"name": "framework", "type": "text", "default": "", "help": "the name that the engine was asked by"},
  {"name": "custom", "type": "text", "default": "", "help": "all of custom=, as the filter reads it"},
  {"name": "accelerator", "type": "text", "default": "", "help": "all of accelerator="},
  {"name": "input", "type": "text", "default": "", "help": "dimensions of the inputs"},
  {"name": "inputtype", "type": "text", "default": "", "help": "types of the inputs"},
  {"name": "inputname", "type": "text", "default": "", "help": "names of the inputs"},
  {"name": "inputlayout", "type": "text", "default": "", "help": "layouts of the inputs"},
  {"name": "output", "type": "text", "default": "", "help": "dimensions of the outputs"},
  {"name": "outputtype", "type": "text", "default": "", "help": "types of the outputs"},
  {"name": "outputname", "type": "text", "default": "", "help": "names of the outputs"},
  {"name": "outputlayout", "type": "text", "default": "", "help": "layouts of the outputs"},
  {"name": "latency", "type": "integer", "default": "0", "help": "the user measures it"},
  {"name": "throughput", "type": "integer", "default": "0", "help": "the user measures it"},
  {"name": "suspend", "type": "integer", "default": "0", "help": "milliseconds, 0 = never"},
  {"name": "shared-tensor-filter-key", "type": "text", "default": "", "help": "of models that are shared"},
  {"name": "invoke-dynamic", "type": "boolean", "default": "false", "help": "sizes with each frame"},
  {"name": "invoke-async", "type": "boolean", "default": "false", "help": "any number of outputs"},
  {"name": "async-timeout", "type": "integer", "default": "0", "help": "milliseconds of silence, 0 = any"}
])";

namespace {

constexpr char kOwnName[] = "framework";

std::set<std::string> option_names(const weir_engine& engine) {
  std::set<std::string> out;
  const char* const options = function_of(engine, &weir_engine::options_json);
  if (!options) return out;
  const auto list = nlohmann::json::parse(options, nullptr, false);
  if (!list.is_array()) return out;
  for (const auto& option : list)
    if (const auto name = option.is_object() ? option.find("name") : option.end();
        option.is_object() && name != option.end() && name->is_string())
      out.insert(name->get<std::string>());
  return out;
}

bool given(const OpenOptions& options, const std::string& name) {
  return std::any_of(options.options.begin(), options.options.end(),
                     [&](const auto& own) { return own.first == name; });
}

}  // namespace

std::vector<std::pair<std::string, std::string>> options_for(const weir_engine& engine,
                                                             const OpenOptions& options) {
  auto out = options.options;
  const auto taken = option_names(engine);
  if (taken.contains(kOwnName)) out.emplace_back(kOwnName, engine.name);
  for (const auto& declared : options.declared)
    if (!given(options, declared.first) && taken.contains(declared.first)) out.push_back(declared);
  return out;
}

std::vector<std::pair<std::string, std::string>> identity_of(const weir_engine& engine,
                                                             const OpenOptions& options) {
  OpenOptions lasting = options;
  std::erase_if(lasting.declared, [](const auto& option) {
    return option.first == "latency" || option.first == "throughput" || option.first == "suspend" ||
           option.first == "async-timeout";
  });
  return options_for(engine, lasting);
}

std::vector<weir_option> options_for_inner(const weir_engine& inner, const weir_open& request) {
  const auto taken = option_names(inner);
  const std::vector<weir_option> all(request.options, request.options + request.n_options);
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
