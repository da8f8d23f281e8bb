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
#include "doctor/module_facts.hpp"
#include "doctor/nnstreamer_facts.hpp"
#include "doctor/plugin_facts.hpp"
#include "doctor/sub_plugin_facts.hpp"
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
  std::printf("Weir %s, %s\n\nPlug-in\n", config::kVersion, facts.gstreamer.c_str());
  if (facts.found) {
    std::printf("  found: %s (version %s)\n", facts.file.c_str(), facts.version.c_str());
    if (facts.version != config::kVersion)
      std::printf("  warning: it has a different version than this command\n");
  } else if (!facts.load_error.empty()) {
    std::printf("  cannot be loaded: %s\n  reason: %s\n  fix: make build, then make install\n",
                facts.file.c_str(), facts.load_error.c_str());
  } else {
    std::printf("  not found; looked for libgstweir.so in\n");
    for (const auto& folder : facts.searched) std::printf("    %s\n", folder.c_str());
    std::printf("  fix: make install, or GST_PLUGIN_PATH=<the folder with libgstweir.so>\n");
  }
  if (facts.elements.empty()) return;
  std::vector<std::vector<std::string>> rows{{"element", "plug-in", "file"}};
  for (const auto& element : facts.elements)
    rows.push_back({element.name, element.plugin, element.file});
  std::printf("\nElements\n%s", table(rows, "  ").c_str());
  const std::string owners = join(owners_of(facts), ", ", [](const auto& owner) {
    return std::to_string(owner.second) + " of " + owner.first;
  });
  std::printf("  elements in use: %s\n", owners.c_str());
  if (!facts.yields_to.empty())
    std::printf("  Weir yields to NNStreamer's elements: %s\n", facts.yields_to.c_str());
}

void print_conflicts(const PluginFacts& facts) {
  std::printf("\nConflicts\n");
  if (facts.conflicts.empty()) std::printf("  none\n");
  for (const auto& conflict : facts.conflicts)
    std::printf("  plug-in %s: %s%s\n    %s\n    fix: %s\n", conflict.plugin.c_str(),
                conflict.file.c_str(),
                conflict.version.empty() ? "" : (" (version " + conflict.version + ")").c_str(),
                conflict.reason.c_str(), conflict.fix.c_str());
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

void print_modules(const char* kind, const std::vector<ModuleFact>& facts) {
  std::vector<std::vector<std::string>> rows{{kind, "state", "place"}};
  std::string reasons;
  for (const auto& fact : facts) {
    rows.push_back({fact.name, fact.problem.empty() ? "usable" : "refused", fact.file});
    if (!fact.problem.empty())
      reasons += "  " + fact.name + " is rejected\n    reason: " + fact.problem + "\n";
  }
  std::string title = std::string(kind) + "s";
  title[0] = static_cast<char>(title[0] - 'a' + 'A');
  std::printf("\n%s\n%s%s", title.c_str(), facts.empty() ? "  none\n" : table(rows, "  ").c_str(),
              reasons.c_str());
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
  std::string details;
  for (const auto& engine : engines) {
    if (engine.state == EngineState::NotAvailable) {
      unavailable.push_back(engine.name);
      continue;
    }
    rows.push_back(
        {engine.name, name_of(engine.state), engine.version, engine.extensions, place_of(engine)});
    if (engine.state == EngineState::Usable) continue;
    details += "  " + engine.name + " is " + name_of(engine.state) + "\n";
    if (!engine.problem.empty()) details += "    reason: " + engine.problem + "\n";
    if (!engine.install.empty()) details += "    fix: " + engine.install + "\n";
  }
  std::printf("\nEngines\n%s", table(rows, "  ").c_str());
  if (!unavailable.empty())
    std::printf("  known engines without a module in this version: %s\n",
                join(unavailable, ", ").c_str());
  std::printf("\nMissing\n%s", details.empty() ? "  nothing\n" : details.c_str());
}

}  // namespace

int doctor(bool json) {
  const PluginFacts plugin = plugin_facts();
  const auto engines = engine_facts();
  const auto decoders = decoder_facts();
  const auto converters = converter_facts();
  const auto configuration = config::Configuration::load();
  const auto nnstreamer = config::NnstreamerConfiguration::load();
  if (json) {
    Json document{{"version", config::kVersion}, {"usable", plugin.found}};
    document.update(to_json(plugin));
    document["configuration"] = to_json(configuration);
    document["nnstreamer"] = to_json(nnstreamer, configuration);
    document["module_path"] = infer::ModuleLibrary::search_path();
    document["engines"] = Json::array();
    for (const auto& engine : engines) document["engines"].push_back(to_json(engine));
    document["decoders"] = to_json(decoders);
    document["converters"] = to_json(converters);
    document["sub_plugins"] = sub_plugins_as_json();
    print(document);
  } else {
    print_plugin(plugin);
    print_conflicts(plugin);
    print(configuration);
    print(nnstreamer, configuration);
    print_folders();
    print_modules("decoder", decoders);
    print_modules("converter", converters);
    print_sub_plugins();
    print_engines(engines);
  }
  return plugin.found ? kExitGood : kExitError;
}

}  // namespace weir::app
