// Fuzz target: parses the configuration's layers: weir.ini, nnstreamer.ini, the file that it names,
// and environment variables. The input has these four parts, separated by zero bytes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <map>
#include <string>

#include "core/config/configuration.hpp"
#include "core/config/nnstreamer.hpp"
#include "core/text/text.hpp"
#include "fuzz_input.hpp"
#include "memory_file.hpp"

namespace {

using weir::fuzz::require;

void check(const weir::config::Configuration& weir,
           const weir::config::NnstreamerConfiguration& nnstreamer) {
  for (const auto& setting : weir.all()) {
    const auto found = weir.find(setting.group, setting.key);
    require(found && found->value == setting.value, "what is listed has an effect");
  }
  for (const auto& setting : nnstreamer.all()) {
    const auto found = nnstreamer.find(setting.group, setting.key);
    require(found && found->value == setting.value, "what is listed has an effect");
    (void)weir::config::overriding(setting, weir);
  }
  for (const auto kind : weir::config::kFolderKinds)
    for (const auto& folder : nnstreamer.folders(kind))
      require(folder.path.starts_with('/'), "code is loaded from absolute folders only");
  for (const auto& fault : weir.faults()) require(!fault.what.empty(), "an error has a text");
  for (const auto& fault : nnstreamer.faults()) require(!fault.what.empty(), "an error has a text");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  auto parts = weir::split(text, std::string_view("\0", 1), 4);
  parts.resize(4);
  const weir::fuzz::MemoryFile weir_file(parts[0]), extra_file(parts[2]);
  const weir::fuzz::MemoryFile nnstreamer_file("[common]\nextra_config_path=" + extra_file.path() +
                                               "\n" + std::string(parts[1]));
  std::map<std::string, std::string> variables;
  for (const auto line : weir::split(parts[3], "\n")) {
    const size_t equals = std::min(line.find('='), line.size());
    variables.emplace(line.substr(0, equals), line.substr(std::min(equals + 1, line.size())));
  }
  variables["WEIR_CONFIG"] = weir_file.path();
  variables["NNSTREAMER_CONF"] = nnstreamer_file.path();
  const auto environment = [&](const char* name) {
    const auto found = variables.find(name);
    return found == variables.end() ? nullptr : found->second.c_str();
  };
  check(weir::config::Configuration(environment),
        weir::config::NnstreamerConfiguration(environment));
  return 0;
}
