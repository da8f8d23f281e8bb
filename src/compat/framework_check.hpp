// Checks whether a filter descriptor can be used, on which hardware, and reads its properties.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "nnstreamer_plugin_api_filter.h"
#include "weir/result.hpp"

namespace weir::compat {

struct FrameworkFacts {
  int version;  // 0 or 1
  std::string name;
  bool runs_without_model, verifies_paths;
};

// Reads the properties. MODULE_REFUSED: an invalid version, a missing function, or no name.
// Exceptions of a callback are passed on.
Result<FrameworkFacts> read_facts(const GstTensorFilterFramework& framework);

// subplugin::HardwareCheck: asks a usable filter (const GstTensorFilterFramework*).
bool has_hardware(const void* descriptor, unsigned hardware, const char* custom);

}  // namespace weir::compat
