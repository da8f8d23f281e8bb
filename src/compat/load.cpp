// Runs when the library is loaded.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <dlfcn.h>

#include <filesystem>

#include "compat/engines.hpp"
#include "compat/guard.hpp"
#include "core/custom/foreign_class.hpp"
#include "core/process/process_object.hpp"
#include "core/subplugin/loader.hpp"
#include "library/process.h"

namespace {

// Makes libnnstreamer-single.so available from this library's folder to files that link with it,
// whatever the loader's search path is.
void open_the_other_name() {
  Dl_info own{};
  if (!dladdr(reinterpret_cast<void*>(open_the_other_name), &own) || !own.dli_fname) return;
  const auto folder = std::filesystem::path(own.dli_fname).parent_path();
  dlopen((folder / "libnnstreamer-single.so").c_str(), RTLD_LAZY | RTLD_LOCAL);
}

}  // namespace

// Runs before the constructors of sub-plugins, which link with this library: process-wide objects
// are those of libweir.
__attribute__((constructor)) static void take_the_process() {
  weir::process::take_objects_from(weir_process_object);
  weir::subplugin::set_engine_adapter(weir::compat::engine_of);
  weir::custom::set_class_engine(weir::compat::class_engine);
  weir::compat::attempt("libnnstreamer.so", open_the_other_name);
}
