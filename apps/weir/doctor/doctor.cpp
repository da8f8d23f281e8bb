// `weir doctor`: reports what is installed and where, what conflicts, what is missing and how to
// install it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdio>
#include <map>

#include "commands.hpp"
#include "core/config/install_paths.hpp"
#include "core/infer/module/module_library.hpp"
#include "doctor/configuration_facts.hpp"
#include "doctor/engine_facts.hpp"
#include "doctor/library_facts.hpp"
#include "doctor/machine_facts.hpp"
#include "doctor/module_facts.hpp"
#include "doctor/nnstreamer_facts.hpp"
#include "doctor/plugin_facts.hpp"
#include "doctor/sub_plugin_facts.hpp"
#include "doctor/summary.hpp"
#include "report.hpp"
#include "weir/join.hpp"

namespace weir::app {
namespace {

// How many elements each plug-in provides.
std::map<std::string, size_t> owners_of(const PluginFacts& facts) {
  std::map<std::string, size_t> out;
  for (const auto& element : facts.elements) ++out[element.plugin];
  return out;
}

Json to_json(const PluginFacts& facts) {
  Json elements = Json::array();
  for (const auto& element : facts.elements)
    elements.push_back({{"name", element.name},
                        {"plugin", element.plugin},
                        {"file", element.file},
                        {"rank", element.rank}});
  Json conflicts = Json::array();
  for (const auto& conflict : facts.conflicts)
    conflicts.push_back({{"plugin", conflict.plugin},
                         {"file", conflict.file},
                         {"version", conflict.version},
                         {"reason", conflict.reason},
                         {"fix", conflict.fix}});
  return {{"gstreamer", facts.gstreamer},
          {"plugin",
           {{"found", facts.found},
            {"file", facts.file},
            {"version", facts.version},
            {"load_error", facts.load_error},
            {"searched", facts.searched}}},
          {"elements", elements},
          {"owners", owners_of(facts)},
          {"yields_to", facts.yields_to},
          {"conflicts", conflicts}};
}

Json to_json(const EngineFact& fact) {
  return {{"name", fact.name},
          {"state", name_of(fact.state)},
          {"version", fact.version},
          {"module", fact.file},
          {"library", fact.library},
          {"aliases", fact.aliases},
          {"extensions", fact.extensions},
          {"problem", fact.problem},
          {"install", fact.install}};
}

void print_plugin(const PluginFacts& facts) {
  std::printf("\nPlug-in\n  %s\n", facts.found ? facts.file.c_str() : "not found");
  if (facts.elements.empty()) return;
  std::vector<std::vector<std::string>> rows{{"element", "plug-in", "file"}};
  for (const auto& element : facts.elements)
    rows.push_back({element.name, element.plugin, element.file});
  std::printf("\nElements\n%s", table(rows, "  ").c_str());
}

Json to_json(const MachineFacts& facts) {
  return {{"processor", facts.processor},
          {"cores", facts.cores},
          {"gpus", facts.gpus},
          {"memory_bytes", facts.memory_bytes},
          {"available_bytes", facts.available_bytes}};
}

Json to_json(const std::vector<Problem>& problems) {
  Json out = Json::array();
  for (const auto& problem : problems)
    out.push_back({{"what", problem.what}, {"reason", problem.reason}, {"fix", problem.fix}});
  return out;
}

Json to_json(const std::vector<ModuleFact>& facts) {
  Json out = Json::array();
  for (const auto& fact : facts)
    out.push_back({{"name", fact.name},
                   {"state", fact.problem.empty() ? "usable" : "refused"},
                   {"module", fact.file},
                   {"problem", fact.problem}});
  return out;
}

Json to_json(const std::vector<LibraryFact>& facts) {
  Json out = Json::array();
  for (const auto& fact : facts)
    out.push_back({{"name", fact.name},
                   {"state", fact.state},
                   {"version", fact.version},
                   {"file", fact.file},
                   {"needed_for", fact.needed_for},
                   {"install", fact.install}});
  return out;
}

void print_libraries(const std::vector<LibraryFact>& facts) {
  std::vector<std::vector<std::string>> rows{
      {"library", "state", "version", "needed for", "place"}};
  for (const auto& fact : facts)
    rows.push_back({fact.name, fact.state, fact.version, fact.needed_for, fact.file});
  std::printf("\nLibraries\n%s", table(rows, "  ").c_str());
}

void print_modules(const char* kind, const std::vector<ModuleFact>& facts) {
  std::vector<std::vector<std::string>> rows{{kind, "state", "place"}};
  for (const auto& fact : facts)
    rows.push_back({fact.name, fact.problem.empty() ? "usable" : "refused", fact.file});
  std::string title = std::string(kind) + "s";
  title[0] = static_cast<char>(title[0] - 'a' + 'A');
  std::printf("\n%s\n%s", title.c_str(), facts.empty() ? "  none\n" : table(rows, "  ").c_str());
}

void print_folders() {
  std::printf("\nModule folders\n");
  for (const auto& folder : infer::ModuleLibrary::search_path())
    std::printf("  %s\n", folder.c_str());
}

std::string place_of(const EngineFact& engine) {
  if (!engine.library.empty()) return engine.library;
  if (!engine.file.empty()) return engine.file;
  return engine.state == EngineState::Usable ? "built in" : "";
}

void print_engines(const std::vector<EngineFact>& engines) {
  std::vector<std::vector<std::string>> rows{{"engine", "state", "version", "files", "place"}};
  std::vector<std::string> unavailable;
  for (const auto& engine : engines) {
    if (engine.state == EngineState::NotAvailable) {
      unavailable.push_back(engine.name);
      continue;
    }
    rows.push_back(
        {engine.name, name_of(engine.state), engine.version, engine.extensions, place_of(engine)});
  }
  std::printf("\nEngines\n%s", table(rows, "  ").c_str());
  if (!unavailable.empty())
    std::printf("  known engines without a module in this version: %s\n",
                join(unavailable, ", ").c_str());
}

}  // namespace

int doctor(const DoctorOptions& options) {
  const PluginFacts plugin = plugin_facts();
  const auto engines = engine_facts();
  const auto libraries = library_facts(plugin);
  const auto decoders = decoder_facts();
  const auto converters = converter_facts();
  const auto configuration = config::Configuration::load();
  const auto nnstreamer = config::NnstreamerConfiguration::load();
  Json document{{"version", config::kVersion}, {"usable", plugin.found}};
  document.update(to_json(plugin));
  document["machine"] = to_json(machine_facts());
  document["configuration"] = to_json(configuration);
  document["nnstreamer"] = to_json(nnstreamer, configuration);
  document["module_path"] = infer::ModuleLibrary::search_path();
  document["engines"] = Json::array();
  for (const auto& engine : engines) document["engines"].push_back(to_json(engine));
  document["libraries"] = to_json(libraries);
  document["decoders"] = to_json(decoders);
  document["converters"] = to_json(converters);
  document["sub_plugins"] = sub_plugins_as_json();
  const auto problems = problems_of(document);
  document["verdict"] = verdict(document, problems);
  document["problems"] = to_json(problems);
  if (options.json) {
    print(document);
    return plugin.found ? kExitGood : kExitError;
  }
  print_summary(document, problems);
  if (options.all) {
    print_plugin(plugin);
    print(configuration);
    print(nnstreamer, configuration);
    print_libraries(libraries);
    print_folders();
    print_modules("decoder", decoders);
    print_modules("converter", converters);
    print_sub_plugins();
    print_engines(engines);
  } else {
    std::puts("\nweir doctor --all shows each element, setting, folder and file.");
  }
  return plugin.found ? kExitGood : kExitError;
}

}  // namespace weir::app
