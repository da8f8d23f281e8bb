// Reports which configuration files were read, their settings, and the origin of each.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "doctor/configuration_facts.hpp"

#include <cstdio>

namespace weir::app {
namespace {

const char* state(const config::ConfigurationFile& file) {
  return file.read ? "read" : file.found ? "cannot be read" : "not found";
}

}  // namespace

std::string problem(const Error& fault) {
  std::string text = fault.what;
  if (!fault.offered.empty()) text += ": " + fault.offered;
  if (!fault.difference.empty()) text += " (" + fault.difference + ")";
  return text;
}

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

}  // namespace weir::app
