// Reports every file and folder that is searched, whether it exists, and the origin of each
// setting.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "doctor/nnstreamer_facts.hpp"

#include <cstdio>
#include <filesystem>

#include "doctor/configuration_facts.hpp"

namespace weir::app {
namespace {

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

std::string description_of(const config::Setting& setting, const config::Configuration& weir) {
  const std::string stronger = overridden_by(setting, weir), none = without_effect(setting);
  if (!none.empty()) return "without effect: " + none;
  return stronger.empty() ? "" : "overridden by " + stronger;
}

}  // namespace

Json to_json(const config::NnstreamerConfiguration& configuration,
             const config::Configuration& weir) {
  Json files = Json::array(), settings = Json::array(), folders = Json::array(),
       problems = Json::array();
  for (const auto& file : configuration.candidates())
    files.push_back({{"path", file.path}, {"source", file.source}, {"state", name_of(file.state)}});
  for (const auto& setting : configuration.all())
    settings.push_back({{"group", setting.group},
                        {"key", setting.key},
                        {"value", setting.value},
                        {"origin", setting.origin},
                        {"overridden_by", overridden_by(setting, weir)},
                        {"without_effect", without_effect(setting)}});
  for (const auto kind : config::kFolderKinds)
    for (const auto& folder : configuration.folders(kind))
      folders.push_back({{"kind", name_of(kind)},
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
    std::printf("  %s (%s): %s\n", file.path.c_str(), file.source.c_str(), name_of(file.state));
  std::vector<std::vector<std::string>> settings{{"setting", "value", "from", "remarks"}};
  for (const auto& setting : configuration.all())
    settings.push_back({"[" + setting.group + "] " + setting.key, setting.value, setting.origin,
                        description_of(setting, weir)});
  if (settings.size() > 1) std::fputs(table(settings, "  ").c_str(), stdout);
  std::vector<std::vector<std::string>> folders{{"folder of", "place", "from", "state"}};
  for (const auto kind : config::kFolderKinds)
    for (const auto& folder : configuration.folders(kind))
      folders.push_back(
          {name_of(kind), folder.path, folder.origin, is_there(folder) ? "found" : "not found"});
  if (folders.size() > 1) std::fputs(table(folders, "  ").c_str(), stdout);
}

}  // namespace weir::app
