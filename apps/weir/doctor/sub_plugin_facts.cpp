// Reports what each sub-plugin file registers, or why it is unusable.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "doctor/sub_plugin_facts.hpp"

#include <cstdio>
#include <filesystem>

#include "core/subplugin/loader.hpp"
#include "doctor/module_facts.hpp"

namespace weir::app {
namespace {

using subplugin::Kind;

std::vector<ModuleFact> facts(Kind kind) {
  std::vector<ModuleFact> out;
  for (const auto& name : subplugin::available(kind)) {
    ModuleFact fact{name, subplugin::file_of(kind, name), ""};
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

}  // namespace

Json sub_plugins_as_json() {
  Json files = Json::array();
  for (const auto kind : subplugin::kKinds)
    for (const auto& fact : facts(kind))
      files.push_back({{"kind", name_of(kind)},
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
          {name_of(kind), fact.name, fact.problem.empty() ? "usable" : "refused", fact.file});
  std::printf("%s", rows.size() > 1 ? table(rows, "  ").c_str() : "  none\n");
}

}  // namespace weir::app
