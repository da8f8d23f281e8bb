// Helpers of tests that register filters of the program: framework=custom-easy.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <dlfcn.h>

#include <cstring>

#include "elements/tests/element_test_support.hpp"
#include "weir/custom_filter.hpp"

namespace weir::test {

// Looked up as in a program: this test links its own copy of the core, not that of the plug-in.
inline const weir::FilterFunctions& functions() {
  static const weir::FilterFunctions all = [] {
    const auto plugin = Ref<GstPlugin>::adopt(gst_registry_find_plugin(gst_registry_get(), "weir"));
    void* file = dlopen(gst_plugin_get_filename(plugin.get()), RTLD_NOW);
    weir::FilterFunctions out{};
    const auto find = [file](auto& function, const char* name) {
      void* found = file ? dlsym(file, name) : nullptr;
      EXPECT_NE(found, nullptr) << name;
      std::memcpy(&function, &found, sizeof function);
    };
    find(out.add, "weir_filter_register");
    find(out.remove, "weir_filter_unregister");
    find(out.what, "weir_error_what");
    find(out.offered, "weir_error_offered");
    find(out.needed, "weir_error_needed");
    find(out.difference, "weir_error_difference");
    find(out.fix, "weir_error_fix");
    find(out.free, "weir_error_free");
    return out;
  }();
  return all;
}

}  // namespace weir::test
