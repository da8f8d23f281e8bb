// Finds the engine, the files and the options for the settings.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/model_source.hpp"

#include "core/infer/module/accelerator.hpp"
#include "core/infer/module/custom_options.hpp"
#include "core/infer/module/module_library.hpp"
#include "core/isolate/isolated_engine.hpp"
#include "core/text/text.hpp"
#include "elements/tensor_filter/isolated_filter.hpp"

namespace weir {
namespace {

std::vector<std::string> paths_of(const std::string& model) {
  std::vector<std::string> out;
  for (const auto part : split(model, ",")) {
    const auto path = strip(part);
    if (!path.empty()) out.emplace_back(path);
  }
  return out;
}

bool automatic(const std::string& framework) {
  return framework.empty() || equal_ignoring_case(framework, "auto") ||
         equal_ignoring_case(framework, "any");
}

// Properties that engines may request by name (core/infer/model/declared_options.hpp).
std::vector<std::pair<std::string, std::string>> declared(const FilterSettings& s) {
  const auto number = [](auto value) { return value ? std::to_string(value) : ""; };
  std::vector<std::pair<std::string, std::string>> out{
      {"input", s.input},
      {"inputtype", s.inputtype},
      {"inputname", s.inputname},
      {"inputlayout", s.inputlayout},
      {"output", s.output},
      {"outputtype", s.outputtype},
      {"outputname", s.outputname},
      {"outputlayout", s.outputlayout},
      {"custom", s.custom},
      {"accelerator", s.accelerator},
      {"latency", number(s.latency)},
      {"throughput", number(s.throughput)},
      {"suspend", number(s.suspend)},
      {"shared-tensor-filter-key", s.shared_tensor_filter_key.value_or("")},
      {"invoke-dynamic", s.invoke_dynamic ? "true" : ""},
      {"invoke-async", s.invoke_async ? "true" : ""},
      {"async-timeout", s.invoke_async ? number(s.async_timeout) : ""}};
  std::erase_if(out, [](const auto& option) { return option.second.empty(); });
  return out;
}

// Without a name that is similar, an engine for the model's file is better than one of no name.
Error with_automatic_engine(Error error, const std::vector<std::string>& paths) {
  const bool is_guessed = !error.difference.empty();
  if (error.code == Code::ENGINE_UNKNOWN && !is_guessed &&
      infer::ModuleLibrary::instance().choose_engine(paths))
    error.fix = "framework=auto";
  return error;
}

}  // namespace

Result<infer::ModelSource> model_source(const FilterSettings& s,
                                        const std::shared_ptr<isolate::Monitor>& monitor,
                                        std::optional<Error>* warning) {
  const auto paths = paths_of(s.model);
  const auto no_model = [] {
    return Error{.code = Code::MODEL_NOT_FOUND,
                 .what = "no model is set",
                 .offered = "model=\"\"",
                 .needed = "the path of a model file; weir models list prints models to try",
                 .fix = "model=/path/to/model"};
  };
  if (paths.empty() && automatic(s.framework)) return no_model();
  auto& library = infer::ModuleLibrary::instance();
  const auto engine = monitor ? Result<const weir_engine*>(&isolate::isolated_engine())
                      : automatic(s.framework) ? library.engine_for_model(paths)
                                               : library.engine(s.framework);
  if (!engine) return with_automatic_engine(engine.error(), paths);
  if (paths.empty() && !((*engine)->flags & WEIR_ENGINE_NEEDS_NO_MODEL)) return no_model();
  infer::ModelSource source;
  source.engine = *engine;
  source.options.paths = paths;
  source.options.options = infer::custom_options(s.custom);
  source.options.declared = declared(s);
  source.options.threads = s.threads;
  if (monitor) {
    auto isolation = isolation_of(s, automatic(s.framework), monitor);
    isolation->declared = source.options.declared;
    source.options.host_context = std::move(isolation);
  }
  const auto request = infer::parse_accelerator(s.accelerator, warning);
  const auto supported = infer::accelerators_of(**engine);
  source.options.accelerator = infer::choose_accelerator(request, supported);
  if (auto unavailable =
          infer::unavailable_hardware(request, supported, (*engine)->name, s.accelerator))
    *warning = std::move(unavailable);
  return source;
}

std::string framework_name(const FilterSettings& s) {
  const auto choice = automatic_engine(s);
  return choice ? choice->engine : s.framework;
}

std::optional<infer::EngineChoice> automatic_engine(const FilterSettings& s) {
  if (!automatic(s.framework)) return std::nullopt;
  const auto paths = paths_of(s.model);
  if (paths.empty()) return std::nullopt;
  const auto choice = infer::ModuleLibrary::instance().choose_engine(paths);
  return choice ? std::optional(*choice) : std::nullopt;
}

}  // namespace weir
