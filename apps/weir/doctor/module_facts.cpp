// Opens every decoder and converter module once, after a trial in a forked process.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "doctor/module_facts.hpp"

#include "core/infer/module/module_library.hpp"
#include "doctor/engine_facts.hpp"
#include "doctor/trial.hpp"

namespace weir::app {
namespace {

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

}  // namespace

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

}  // namespace weir::app
