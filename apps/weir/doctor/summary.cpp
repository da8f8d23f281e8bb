// SPDX-License-Identifier: LGPL-2.1-or-later
#include "doctor/summary.hpp"

#include <cstdio>
#include <filesystem>

#include "colour.hpp"
#include "core/config/install_paths.hpp"
#include "machine/install_command.hpp"
#include "weir/join.hpp"

namespace weir::app {
namespace {

// GStreamer looks below its own prefix only.
std::string missing_plugin_fix() {
  namespace fs = std::filesystem;
  const fs::path libraries = fs::path(config::kInstalledModules).parent_path().parent_path();
  const fs::path installed = libraries / "gstreamer-1.0";
  std::error_code ignored;
  if (fs::exists(installed / "libgstweir.so", ignored))
    return "export GST_PLUGIN_PATH=" + installed.string();
  return std::string(kInstallWeir) + ", or GST_PLUGIN_PATH=<the folder with libgstweir.so>";
}

void add_plugin(const Json& plugin, std::vector<Problem>* out) {
  if (plugin["found"]) {
    if (plugin["version"] != config::kVersion)
      out->push_back(
          {"the plug-in and this command have different versions",
           plugin["file"].get<std::string>() + " is " + plugin["version"].get<std::string>(),
           std::string(kInstallWeir) +
               ", or GST_PLUGIN_PATH=<the folder of the matching plug-in>"});
    return;
  }
  const std::string error = plugin["load_error"];
  if (!error.empty())
    out->push_back({"the plug-in cannot be loaded: " + plugin["file"].get<std::string>(), error,
                    std::string(install_command(kInstallWeir, "make build, then make install"))});
  else
    out->push_back({"the plug-in libgstweir.so was not found",
                    "looked in " + join(plugin["searched"].get<std::vector<std::string>>(), ", "),
                    missing_plugin_fix()});
}

void add_refused(const char* kind, const Json& items, std::vector<Problem>* out) {
  for (const auto& item : items)
    if (item["state"] == "refused") {
      const std::string name = item["name"];
      const std::string fix = item.value("install", "");
      out->push_back(
          {"the " + item.value("kind", std::string(kind)) + " " + name + " cannot be used",
           item["problem"], fix});
    }
}

std::string gibibytes(uint64_t bytes) {
  constexpr double kGibibyte = 1024.0 * 1024 * 1024;
  char text[32];
  std::snprintf(text, sizeof text, "%.1f GiB", static_cast<double>(bytes) / kGibibyte);
  return text;
}

void print_machine(const Json& machine) {
  const auto gpus = machine["gpus"].get<std::vector<std::string>>();
  const int cores = machine["cores"];
  std::printf("CPU          %s, %d core%s\n", machine["processor"].get<std::string>().c_str(),
              cores, cores == 1 ? "" : "s");
  std::printf("GPU          %s\n", gpus.empty() ? "none found" : join(gpus, ", ").c_str());
  if (const uint64_t memory = machine["memory_bytes"]; memory > 0)
    std::printf("Memory       %s, %s available\n", gibibytes(memory).c_str(),
                gibibytes(machine["available_bytes"]).c_str());
}

// The names of the items that can be used, with their version where `with_version` is set.
std::string usable(const Json& items, bool with_version) {
  std::vector<std::string> names;
  for (const auto& item : items)
    if (item["state"] == "usable") {
      const std::string name = item["name"], version = item.value("version", "");
      // Python's goes on with the date and the compiler; "1" is that of a module of Weir.
      const std::string number = version.substr(0, version.find(" ("));
      names.push_back(with_version && number != "1" ? name + " " + number : name);
    }
  return names.empty() ? "none" : join(names, ", ");
}

void print_what_to_install(const Json& engines, const Json& libraries) {
  std::vector<std::vector<std::string>> rows{{"engine", "to install it"}};
  for (const auto& engine : engines)
    if (engine["state"] == "not installed") rows.push_back({engine["name"], engine["install"]});
  if (rows.size() > 1) std::printf("\nNot installed\n%s", table(rows, "  ").c_str());
  for (const auto& library : libraries)
    if (library["state"] != "usable")
      std::printf("\n%s is %s: without it there are no %s\n  %s\n",
                  library["name"].get<std::string>().c_str(),
                  library["state"].get<std::string>().c_str(),
                  library["needed_for"].get<std::string>().c_str(),
                  library["install"].get<std::string>().c_str());
}

}  // namespace

std::vector<Problem> find_problems(const Json& facts) {
  std::vector<Problem> out;
  add_plugin(facts["plugin"], &out);
  for (const auto& conflict : facts["conflicts"]) {
    const std::string plugin = conflict["plugin"], version = conflict["version"];
    out.push_back({"the plug-in " + plugin + (version.empty() ? "" : " (version " + version + ")") +
                       " conflicts with Weir: " + conflict["file"].get<std::string>(),
                   conflict["reason"], conflict["fix"]});
  }
  add_refused("engine", facts["engines"], &out);
  add_refused("decoder", facts["decoders"], &out);
  add_refused("converter", facts["converters"], &out);
  add_refused("sub-plugin", facts["sub_plugins"]["files"], &out);
  for (const char* file : {"configuration", "nnstreamer"})
    for (const auto& problem : facts[file]["problems"])
      out.push_back({"the configuration has an error", problem, ""});
  return out;
}

std::string verdict(const Json& facts, const std::vector<Problem>& problems) {
  if (!facts["usable"]) return "Weir does not work";
  if (problems.empty()) return "Weir works";
  const size_t count = problems.size();
  return "Weir works, with " + std::to_string(count) + (count == 1 ? " problem" : " problems");
}

void print_summary(const Json& facts, const std::vector<Problem>& problems) {
  const Colour colour = !facts["usable"]   ? Colour::Red
                        : problems.empty() ? Colour::Green
                                           : Colour::Yellow;
  std::printf("%s\n", coloured(stdout, colour, verdict(facts, problems)).c_str());
  for (const auto& problem : problems) {
    std::printf("  %s\n", printable_text(problem.what).c_str());
    if (!problem.reason.empty())
      std::printf("    reason: %s\n", printable_text(problem.reason).c_str());
    if (!problem.fix.empty()) std::printf("    fix: %s\n", printable_text(problem.fix).c_str());
  }
  std::printf("\nVersions     Weir %s, %s\n", config::kVersion,
              facts["gstreamer"].get<std::string>().c_str());
  print_machine(facts["machine"]);
  if (facts["usable"])
    std::printf("Plug-in      %s\n", facts["plugin"]["file"].get<std::string>().c_str());
  const std::string owners = join(facts["owners"].items(), ", ", [](const auto& owner) {
    return std::to_string(owner.value().template get<size_t>()) + " of the plug-in " + owner.key();
  });
  std::printf("Elements     %s\n", owners.empty() ? "none" : owners.c_str());
  if (const std::string from = facts["yields_to"]; !from.empty())
    std::printf("             Weir yields to NNStreamer's elements: %s\n", from.c_str());
  std::printf("Engines      %s\n", usable(facts["engines"], true).c_str());
  std::printf("Decoders     %s\n", usable(facts["decoders"], false).c_str());
  std::printf("Converters   %s\n", usable(facts["converters"], false).c_str());
  if (!facts["sub_plugins"]["files"].empty())
    std::printf("Sub-plugins  %s\n", usable(facts["sub_plugins"]["files"], false).c_str());
  std::printf("Libraries    %s\n", usable(facts["libraries"], true).c_str());
  print_what_to_install(facts["engines"], facts["libraries"]);
}

}  // namespace weir::app
