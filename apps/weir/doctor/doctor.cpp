// `weir doctor`: reports what is installed and where, what conflicts, what is missing and how to
// install it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <dlfcn.h>
#include <link.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "commands.hpp"
#include "core/config/configuration.hpp"
#include "core/config/install_paths.hpp"
#include "core/config/nnstreamer.hpp"
#include "core/infer/module/module_library.hpp"
#include "core/subplugin/loader.hpp"
#include "doctor/engine_info.hpp"
#include "doctor/forked_load.hpp"
#include "doctor/machine_info.hpp"
#include "doctor/plugin_info.hpp"
#include "doctor/summary.hpp"
#include "machine/install_command.hpp"
#include "report.hpp"
#include "weir/join.hpp"

namespace weir::app {
namespace {

struct ModuleFact {
  std::string name;
  std::string file;
  std::string problem;  // why its file is unusable; "" when it is usable
};

template <class Open>
std::vector<ModuleFact> facts(const char* kind, const std::vector<std::string>& names,
                              Open&& open) {
  std::vector<ModuleFact> out;
  for (const auto& name : names) {
    ModuleFact fact{name, module_file(name, kind), ""};
    if (!fact.file.empty()) fact.problem = failure_of_load([&] { static_cast<void>(open(name)); });
    if (!fact.problem.empty())
      fact.problem = "the module cannot be loaded: " + fact.problem;
    else if (const auto module = open(name); !module) {
      const Error& error = module.error();
      fact.problem = error.what + (error.offered.empty() ? "" : ": " + error.offered);
    }
    out.push_back(std::move(fact));
  }
  return out;
}

// Sorted by name. Each function opens every module of its kind.
std::vector<ModuleFact> decoder_facts() {
  auto& library = infer::ModuleLibrary::instance();
  return facts("decoder", library.decoder_names(),
               [&](const std::string& name) { return library.decoder(name); });
}

std::vector<ModuleFact> converter_facts() {
  auto& library = infer::ModuleLibrary::instance();
  return facts("converter", library.converter_names(),
               [&](const std::string& name) { return library.converter(name); });
}

const char* state(const config::ConfigurationFile& file) {
  return file.read ? "read" : file.found ? "cannot be read" : "not found";
}

// One line for an error in a configuration file.
std::string problem(const Error& fault) {
  std::string text = fault.what;
  if (!fault.offered.empty()) text += ": " + fault.offered;
  if (!fault.difference.empty()) text += " (" + fault.difference + ")";
  return text;
}

// Members files, settings, problems.
Json to_json(const config::Configuration& configuration) {
  Json files = Json::array(), settings = Json::array(), problems = Json::array();
  for (const auto& file : configuration.files())
    files.push_back({{"path", file.path}, {"state", state(file)}});
  for (const auto& setting : configuration.all())
    settings.push_back({{"group", setting.group},
                        {"key", setting.key},
                        {"value", setting.value},
                        {"origin", setting.origin}});
  for (const auto& fault : configuration.faults()) problems.push_back(problem(fault));
  return {{"files", files}, {"settings", settings}, {"problems", problems}};
}

void print(const config::Configuration& configuration) {
  std::printf("\nConfiguration\n");
  if (configuration.files().empty()) std::printf("  no file: WEIR_CONFIG is empty\n");
  for (const auto& file : configuration.files())
    std::printf("  %s: %s\n", file.path.c_str(), state(file));
  std::vector<std::vector<std::string>> rows{{"setting", "value", "from"}};
  for (const auto& setting : configuration.all())
    rows.push_back({"[" + setting.group + "] " + setting.key, setting.value, setting.origin});
  if (rows.size() > 1) std::fputs(table(rows, "  ").c_str(), stdout);
}

bool is_there(const config::Folder& folder) {
  std::error_code ignored;
  return std::filesystem::is_directory(folder.path, ignored);
}

std::string overridden_by(const config::Setting& setting, const config::Configuration& weir) {
  const auto stronger = config::overriding(setting, weir);
  if (!stronger) return "";
  return "[" + stronger->group + "] " + stronger->key + " (" + stronger->origin + ")";
}

// The reason why a setting has no effect here; "" for all others.
std::string without_effect(const config::Setting& setting) {
  if (setting.group == "pytorch" && setting.key == "enable_use_gpu")
    return "Weir's engine pytorch runs on the processor";
  return "";
}

std::string make_description(const config::Setting& setting, const config::Configuration& weir) {
  const std::string stronger = overridden_by(setting, weir), none = without_effect(setting);
  if (!none.empty()) return "without effect: " + none;
  return stronger.empty() ? "" : "overridden by " + stronger;
}

// Members enabled, files, settings, folders, problems. `weir`: the settings that override them.
Json to_json(const config::NnstreamerConfiguration& configuration,
             const config::Configuration& weir) {
  Json files = Json::array(), settings = Json::array(), folders = Json::array(),
       problems = Json::array();
  for (const auto& file : configuration.candidates())
    files.push_back(
        {{"path", file.path}, {"source", file.source}, {"state", to_string(file.state)}});
  for (const auto& setting : configuration.all())
    settings.push_back({{"group", setting.group},
                        {"key", setting.key},
                        {"value", setting.value},
                        {"origin", setting.origin},
                        {"overridden_by", overridden_by(setting, weir)},
                        {"without_effect", without_effect(setting)}});
  for (const auto kind : config::kFolderKinds)
    for (const auto& folder : configuration.folders(kind))
      folders.push_back({{"kind", to_string(kind)},
                         {"path", folder.path},
                         {"origin", folder.origin},
                         {"found", is_there(folder)}});
  for (const auto& fault : configuration.faults()) problems.push_back(problem(fault));
  return {{"enabled", configuration.enabled()},
          {"files", files},
          {"settings", settings},
          {"folders", folders},
          {"problems", problems}};
}

void print(const config::NnstreamerConfiguration& configuration,
           const config::Configuration& weir) {
  std::printf("\nNNStreamer's configuration\n");
  if (!configuration.enabled()) std::printf("  not used: enable=false in [nnstreamer]\n");
  for (const auto& file : configuration.candidates())
    std::printf("  %s (%s): %s\n", file.path.c_str(), file.source.c_str(), to_string(file.state));
  std::vector<std::vector<std::string>> settings{{"setting", "value", "from", "remarks"}};
  for (const auto& setting : configuration.all())
    settings.push_back({"[" + setting.group + "] " + setting.key, setting.value, setting.origin,
                        make_description(setting, weir)});
  if (settings.size() > 1) std::fputs(table(settings, "  ").c_str(), stdout);
  std::vector<std::vector<std::string>> folders{{"folder of", "place", "from", "state"}};
  for (const auto kind : config::kFolderKinds)
    for (const auto& folder : configuration.folders(kind))
      folders.push_back(
          {to_string(kind), folder.path, folder.origin, is_there(folder) ? "found" : "not found"});
  if (folders.size() > 1) std::fputs(table(folders, "  ").c_str(), stdout);
}

struct LibraryFact {
  std::string name;
  std::string state;          // "usable", "not installed" or "not in this build"
  std::string version, file;  // "" when it is not installed
  std::string needed_for;     // what does not work without it
  std::string install;        // "" when it is usable
};

// A function of the library's API, which the command does not link.
using VersionOf = int (*)(int* major, int* minor, int* revision);

void read_version(void* library, LibraryFact* out) {
  if (link_map* loaded = nullptr; dlinfo(library, RTLD_DI_LINKMAP, &loaded) == 0 && loaded)
    out->file = loaded->l_name;
  const auto version_of = reinterpret_cast<VersionOf>(dlsym(library, "mosquitto_lib_version"));
  if (!version_of) return;
  int major = 0, minor = 0, revision = 0;
  version_of(&major, &minor, &revision);
  out->version =
      std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(revision);
}

// Whether the plug-in for streams between devices is there, and was built without MQTT.
bool is_built_without_mqtt(const PluginInfo& plugins) {
  const auto has = [&](const char* name) {
    return std::any_of(plugins.elements.begin(), plugins.elements.end(), [&](const auto& element) {
      return element.plugin == "weiredge" && element.name == name;
    });
  };
  return has("edgesink") && !has("mqttsink");
}

std::vector<LibraryFact> library_facts(const PluginInfo& plugins) {
  LibraryFact out{.name = "libmosquitto",
                  .state = "usable",
                  .version = "",
                  .file = "",
                  .needed_for = "mqttsink, mqttsrc, connect-type=HYBRID and connect-type=MQTT",
                  .install = ""};
  void* const library = dlopen("libmosquitto.so.1", RTLD_LAZY | RTLD_LOCAL);
  if (library) {
    read_version(library, &out);
    dlclose(library);
  } else {
    out.state = "not installed";
    out.install =
        install_command("apt-get install gstreamer1.0-weir-edge", "apt-get install libmosquitto1");
  }
  if (is_built_without_mqtt(plugins)) {
    out.state = "not in this build";
    out.install = install_command("apt-get install --reinstall gstreamer1.0-weir-edge",
                                  "apt-get install libmosquitto-dev && make install");
  }
  return {std::move(out)};
}

using subplugin::Kind;

std::vector<ModuleFact> facts(Kind kind) {
  std::vector<ModuleFact> out;
  for (const auto& name : subplugin::available(kind)) {
    ModuleFact fact{name, subplugin::find_file(kind, name), ""};
    if (const auto opened = subplugin::open(kind, name); !opened) {
      const Error& error = opened.error();
      fact.problem = error.what + (error.offered.empty() ? "" : ": " + error.offered);
    }
    out.push_back(std::move(fact));
  }
  return out;
}

bool library_is_there() {
  std::error_code ignored;
  return std::filesystem::is_regular_file(subplugin::library_path(), ignored);
}

// Opens each file of every kind. Members library, found, files.
Json sub_plugins_as_json() {
  Json files = Json::array();
  for (const auto kind : subplugin::kKinds)
    for (const auto& fact : facts(kind))
      files.push_back({{"kind", to_string(kind)},
                       {"name", fact.name},
                       {"state", fact.problem.empty() ? "usable" : "refused"},
                       {"file", fact.file},
                       {"problem", fact.problem}});
  return {{"library", subplugin::library_path()}, {"found", library_is_there()}, {"files", files}};
}

void print_sub_plugins() {
  std::printf("\nSub-plugins for NNStreamer\n  their functions: %s: %s\n",
              subplugin::library_path().c_str(), library_is_there() ? "found" : "not found");
  std::vector<std::vector<std::string>> rows{{"kind", "name", "state", "place"}};
  for (const auto kind : subplugin::kKinds)
    for (const auto& fact : facts(kind))
      rows.push_back(
          {to_string(kind), fact.name, fact.problem.empty() ? "usable" : "refused", fact.file});
  std::printf("%s", rows.size() > 1 ? table(rows, "  ").c_str() : "  none\n");
}

// How many elements each plug-in provides.
std::map<std::string, size_t> count_elements(const PluginInfo& facts) {
  std::map<std::string, size_t> out;
  for (const auto& element : facts.elements) ++out[element.plugin];
  return out;
}

Json to_json(const PluginInfo& facts) {
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
          {"owners", count_elements(facts)},
          {"yields_to", facts.yields_to},
          {"conflicts", conflicts}};
}

Json to_json(const EngineInfo& fact) {
  return {{"name", fact.name},
          {"state", to_string(fact.state)},
          {"version", fact.version},
          {"module", fact.file},
          {"library", fact.library},
          {"aliases", fact.aliases},
          {"extensions", fact.extensions},
          {"problem", fact.problem},
          {"install", fact.install}};
}

void print_plugin(const PluginInfo& facts) {
  std::printf("\nPlug-in\n  %s\n", facts.found ? facts.file.c_str() : "not found");
  if (facts.elements.empty()) return;
  std::vector<std::vector<std::string>> rows{{"element", "plug-in", "file"}};
  for (const auto& element : facts.elements)
    rows.push_back({element.name, element.plugin, element.file});
  std::printf("\nElements\n%s", table(rows, "  ").c_str());
}

Json to_json(const MachineInfo& facts) {
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

std::string describe_place(const EngineInfo& engine) {
  if (!engine.library.empty()) return engine.library;
  if (!engine.file.empty()) return engine.file;
  return engine.state == EngineState::Usable ? "built in" : "";
}

void print_engines(const std::vector<EngineInfo>& engines) {
  std::vector<std::vector<std::string>> rows{{"engine", "state", "version", "files", "place"}};
  std::vector<std::string> unavailable;
  for (const auto& engine : engines) {
    if (engine.state == EngineState::NotAvailable) {
      unavailable.push_back(engine.name);
      continue;
    }
    rows.push_back({engine.name, to_string(engine.state), engine.version, engine.extensions,
                    describe_place(engine)});
  }
  std::printf("\nEngines\n%s", table(rows, "  ").c_str());
  if (!unavailable.empty())
    std::printf("  known engines without a module in this version: %s\n",
                join(unavailable, ", ").c_str());
}

}  // namespace

int doctor(const DoctorOptions& options) {
  const PluginInfo plugin = get_plugin_info();
  const auto engines = list_engines();
  const auto libraries = library_facts(plugin);
  const auto decoders = decoder_facts();
  const auto converters = converter_facts();
  const auto configuration = config::Configuration::load();
  const auto nnstreamer = config::NnstreamerConfiguration::load();
  Json document{{"version", config::kVersion}, {"usable", plugin.found}};
  document.update(to_json(plugin));
  document["machine"] = to_json(get_machine_info());
  document["configuration"] = to_json(configuration);
  document["nnstreamer"] = to_json(nnstreamer, configuration);
  document["module_path"] = infer::ModuleLibrary::search_path();
  document["engines"] = Json::array();
  for (const auto& engine : engines) document["engines"].push_back(to_json(engine));
  document["libraries"] = to_json(libraries);
  document["decoders"] = to_json(decoders);
  document["converters"] = to_json(converters);
  document["sub_plugins"] = sub_plugins_as_json();
  const auto problems = find_problems(document);
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
