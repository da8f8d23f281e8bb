// `weir check`, `nnstreamer-check`: prints the configuration and the sub-plugins in the format of
// NNStreamer's tool (docs/compatibility/app-api.md 8.2). `weir doctor` prints more.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>

#include <algorithm>
#include <cstdio>

#include "commands.hpp"
#include "core/config/nnstreamer.hpp"
#include "core/infer/module/module_library.hpp"
#include "core/subplugin/loader.hpp"
#include "doctor/engine_options.hpp"
#include "doctor/plugin_info.hpp"
#include "nnstreamer/nnstreamer_version.h"
#include "report.hpp"
#include "weir/join.hpp"

namespace weir::app {
namespace {

using subplugin::Kind;
using Configuration = config::NnstreamerConfiguration;
using Descriptions = std::vector<std::pair<std::string, std::string>>;

constexpr const char* kLine = "============================================================";

const char* boolean_text(bool value) {
  return value ? "TRUE" : "FALSE";
}

std::string candidate(const Configuration& configuration, const char* source) {
  for (const auto& one : configuration.candidates())
    if (one.source == source) return one.path;
  return "";
}

// The filter folders whose origin is `of`: "hard-coded", "envvar" or ".ini".
std::string folders(const Configuration& configuration, const char* of) {
  std::vector<std::string> out;
  for (const auto& folder : configuration.folders(config::FolderKind::Filters)) {
    const char* from = folder.origin == "hard-coded"              ? "hard-coded"
                       : folder.origin.starts_with("NNSTREAMER_") ? "envvar"
                                                                  : ".ini";
    if (std::string_view(from) == of) out.push_back(folder.path);
  }
  return join(out, ", ");
}

void print_configuration(const Configuration& c) {
  std::printf("NNStreamer configuration:\n%s\n", kLine);
  std::printf("Configuration Loaded: %s\n", boolean_text(!c.path().empty()));
  std::printf("Configuration file path: %s\n", c.path().c_str());
  std::printf("    Candidates: envvar(NNSTREAMER_CONF): %s\n",
              candidate(c, "NNSTREAMER_CONF").c_str());
  std::printf("                build-config: %s\n", candidate(c, "built for").c_str());
  std::printf("                hard-coded: %s\n", candidate(c, "hard-coded").c_str());
  std::printf("[Common]\n  Enable envvar: %s\n  Enable sym-linked subplugins: %s\n",
              boolean_text(c.enable_envvar()), boolean_text(c.enable_symlink()));
  std::printf("[Filter]\n  Filter paths from .ini: %s\n", folders(c, ".ini").c_str());
  std::printf("             from envvar: %s\n", folders(c, "envvar").c_str());
  std::printf("         from hard-coded: %s\n\n%s\n\n", folders(c, "hard-coded").c_str(), kLine);
}

Descriptions get_descriptions(const std::vector<EngineOption>& options) {
  Descriptions out;
  for (const auto& option : options) out.emplace_back(option.name, option.help);
  return out;
}

Descriptions descriptions(Kind kind, const std::string& name) {
  auto& library = infer::ModuleLibrary::instance();
  if (kind == Kind::Filter)
    if (const auto found = library.engine(name))
      if (auto own = get_descriptions(engine_options(**found)); !own.empty()) return own;
  if (kind == Kind::Decoder)
    if (const auto found = library.decoder(name))
      return get_descriptions(engine_options((*found)->options_json));
  if (kind == Kind::Converter)
    if (const auto found = library.converter(name))
      return get_descriptions(engine_options((*found)->options_json));
  (void)subplugin::open(kind, name);  // registers the sub-plugin's descriptions
  return subplugin::table().descriptions(kind, name);
}

std::vector<std::string> names(Kind kind) {
  const auto& library = infer::ModuleLibrary::instance();
  auto out = subplugin::available(kind);
  const auto own = kind == Kind::Filter      ? library.engine_names()
                   : kind == Kind::Decoder   ? library.decoder_names()
                   : kind == Kind::Converter ? library.converter_names()
                                             : std::vector<std::string>();
  out.insert(out.end(), own.begin(), own.end());
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

void print_subplugins(Kind kind, const char* heading) {
  std::printf("[%s]\n", heading);
  for (const auto& name : names(kind)) {
    std::printf("  %s\n", name.c_str());
    const auto all = descriptions(kind, name);
    for (const auto& [key, text] : all) std::printf("    - %s: %s\n", key.c_str(), text.c_str());
    if (all.empty()) std::puts("    - No custom property found");
  }
}

}  // namespace

int check() {
  const PluginInfo plugin = get_plugin_info();
  if (!plugin.found) {
    Error error{.code = Code::FILE_NOT_FOUND,
                .what = "GStreamer does not find the plug-in with the tensor elements",
                .needed = "libgstweir.so in one of its folders",
                .fix = "weir doctor"};
    if (!plugin.load_error.empty()) error.offered = plugin.file + ": " + plugin.load_error;
    return report(error, false);
  }
  std::printf("NNStreamer version: %s\n           loaded : TRUE\n           path   : %s\n\n",
              NNSTREAMER_VERSION, plugin.file.c_str());
  print_configuration(Configuration::load());
  std::printf("NNStreamer registered sub-plugins:\n%s\n", kLine);
  print_subplugins(Kind::Filter, "Filter");
  print_subplugins(Kind::Decoder, "Decoder");
  print_subplugins(Kind::Converter,
                   "Conterver");  // misspelled on purpose: users' scripts expect it
  print_subplugins(Kind::Trainer, "Trainer");
  return kExitGood;
}

}  // namespace weir::app
