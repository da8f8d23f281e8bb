// SPDX-License-Identifier: LGPL-2.1-or-later
#include "bench/bench_plan.hpp"

#include <algorithm>
#include <array>
#include <fstream>

#include "core/infer/module/host.hpp"
#include "core/infer/module/module_library.hpp"
#include "core/text/text.hpp"
#include "doctor/engine_info.hpp"
#include "doctor/engine_options.hpp"
#include "inspect/command_error.hpp"
#include "inspect/model_paths.hpp"
#include "machine/usable_cores.hpp"

namespace weir::app {
namespace {

constexpr size_t kMaxChoices = 3;  // per option; options with more are not tried
constexpr std::array kBatches{1, 4};

bool lists(std::string_view list, std::string_view word) {
  for (const auto part : split(list, ","))
    if (!word.empty() && strip(part) == word) return true;
  return false;
}

std::string get_extension(const std::string& path) {
  const size_t dot = path.rfind('.');
  return dot == std::string::npos ? "" : lower(path.substr(dot + 1));
}

bool recognises(const weir_engine& engine, const std::string& path) {
  if (!engine.probe) return false;
  constexpr size_t kHead = 4096;
  std::string head(kHead, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  int score = 0;
  weir_error error;
  const int result =
      engine.probe(path.c_str(), head.data(), static_cast<size_t>(file.gcount()), &score, &error);
  return result >= 0 && score > 0;
}

std::vector<int> default_threads() {
  std::vector<int> out;
  const int cores = usable_cores();
  for (int threads = 1; threads < cores; threads *= 2) out.push_back(threads);
  out.push_back(cores);
  return out;
}

// "" for the defaults, then each other value of an option with few choices. Switches are no such
// option: they say what the engine accepts, and not how it runs.
std::vector<std::string> list_variants(const std::vector<EngineOption>& engine_options) {
  std::vector<std::string> out{""};
  for (const auto& option : engine_options) {
    const auto choices = split(option.type, "|");
    const bool is_switch = std::find(choices.begin(), choices.end(), "true") != choices.end();
    if (is_switch || choices.size() < 2 || choices.size() > kMaxChoices) continue;
    for (const auto choice : choices)
      if (choice != option.by_default) out.push_back(option.name + ":" + std::string(choice));
  }
  return out;
}

void add_cases(const BenchOptions& options, const weir_engine& engine, BenchPlan* plan) {
  const auto known = engine_options(engine);
  const bool threaded = known.empty() || std::any_of(known.begin(), known.end(), [](const auto& o) {
                          return equal_ignoring_case(o.name, "NumThreads");
                        });
  auto threads = options.threads.empty() ? default_threads() : options.threads;
  if (!threaded) threads.resize(1);
  const auto batches = options.batches.empty() ? std::vector<int>(kBatches.begin(), kBatches.end())
                                               : options.batches;
  const auto variants =
      options.custom.empty() ? list_variants(known) : std::vector<std::string>{options.custom};
  for (const auto& custom : variants)
    for (const int count : threads)
      for (const int batch : batches)
        plan->cases.push_back({engine.name, count, batch, custom, {}, std::nullopt});
}

void add_named(const BenchOptions& options, BenchPlan* plan) {
  for (const auto& name : options.engines) {
    const auto engine = infer::ModuleLibrary::instance().engine(name);
    if (engine)
      add_cases(options, **engine, plan);
    else
      plan->refused.push_back({name, command_error(engine.error())});
  }
}

Error not_installed(const EngineInfo& fact) {
  return {.code = Code::ENGINE_NOT_INSTALLED,
          .what = "the engine's library is not installed",
          .offered = fact.problem,
          .fix = fact.install};
}

void add_if_suitable(const BenchOptions& options, const std::string& path, const EngineInfo& fact,
                     BenchPlan* plan) {
  const bool usable = fact.state == EngineState::Usable;
  const auto engine = infer::ModuleLibrary::instance().engine(fact.name);
  const std::string extension = get_extension(path);
  const std::string_view own = engine && (*engine)->extensions ? (*engine)->extensions : "";
  const bool takes = lists(fact.extensions, extension) || lists(own, extension) ||
                     (usable && engine && recognises(**engine, path));
  if (usable && takes && engine)
    add_cases(options, **engine, plan);
  else if (usable)
    plan->unrelated.push_back(fact.name);
  else if (takes)
    plan->refused.push_back({fact.name, engine ? not_installed(fact) : engine.error()});
}

void add_all(const BenchOptions& options, const std::string& path, BenchPlan* plan) {
  for (const auto& fact : list_engines())
    if (fact.state != EngineState::NotAvailable) add_if_suitable(options, path, fact, plan);
}

}  // namespace

Result<BenchPlan> plan_bench(const BenchOptions& options) {
  const auto paths = split_paths(options.model);
  if (paths.empty())
    return Error{.code = Code::MODEL_NOT_FOUND,
                 .what = "no model is named",
                 .offered = "\"" + options.model + "\"",
                 .needed = "the path of a model file; weir models list prints models to try",
                 .fix = "weir bench /path/to/model"};
  BenchPlan plan;
  if (options.engines.empty())
    add_all(options, paths[0], &plan);
  else
    add_named(options, &plan);
  return plan;
}

}  // namespace weir::app
