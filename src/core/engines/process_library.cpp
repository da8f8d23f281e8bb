// The sources of engines and decoders besides module files: custom filters, built-in decoders, and
// sub-plugins built for NNStreamer.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/custom/builtin_engines.hpp"
#include "core/decoders/decoders.hpp"
#include "core/infer/module/module_library.hpp"
#include "core/process/process_object.hpp"
#include "core/subplugin/loader.hpp"

namespace weir::infer {

ModuleLibrary& ModuleLibrary::instance() {
  struct WithAllSources : ModuleLibrary {
    WithAllSources() {
      add_builtin(&custom::builtin_engines());
      add_builtin(&decoders::builtin_decoders());
      add_source({subplugin::engine, [] { return subplugin::available(subplugin::Kind::Filter); }});
    }
  };
  static auto& library = process::object<WithAllSources>("module-library");
  return library;
}

}  // namespace weir::infer
