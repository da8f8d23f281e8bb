// Finds and opens sub-plugin files for NNStreamer (docs/compatibility/app-api.md 8.1).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "core/subplugin/table.hpp"
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::subplugin {

// Returns the registered descriptor of the name, or else the one that libnnstreamer_KIND_NAME.so in
// the first matching folder registers when it is loaded; the file stays open until the process
// ends. Null: neither exists. MODULE_REFUSED for a symbolic link that is not allowed, a file that
// cannot be loaded or does not register the name, and a missing library of the functions that it
// calls.
Result<const void*> open(Kind kind, std::string_view name);
// Opens every file of the kind; logs unusable ones once per process.
void open_all(Kind kind);
// Logs a warning the first time only.
void log_once(const std::string& who, const std::string& message);
// The file that open() would load; "" if there is none.
std::string find_file(Kind kind, std::string_view name);
// Names that are registered or have a file, sorted; opens nothing.
std::vector<std::string> available(Kind kind);

// The path of the library with the functions that sub-plugins call: [nnstreamer] library, or the
// default of the build.
std::string library_path();
// Opens that library once, so that sub-plugins find its functions.
Status load_library();

// Converts filters to engines; set by the library above when it is loaded. The engine of a
// descriptor lives until the process ends; null: it is unusable, with the reason in the log.
using EngineAdapter = const weir_engine* (*)(const void* descriptor);
void set_engine_adapter(EngineAdapter adapter) noexcept;
// Null: there is no such sub-plugin.
Result<const weir_engine*> engine(std::string_view name);

// Asks filters whether hardware can be used (gst_tensor_filter_check_hw_availability); set by the
// library above when it is loaded. `hardware` is an accl_hw, `custom` may be null.
using HardwareCheck = bool (*)(const void* descriptor, unsigned hardware, const char* custom);
void set_hardware_check(HardwareCheck check) noexcept;
// Checks that the engine or filter of this name can be used with the hardware, a number of
// infer::accelerator_number(). ENGINE_NOT_INSTALLED: a library that the engine needs is missing.
// OPTION_VALUE: it does not run on the hardware. Errors of ModuleLibrary::engine().
Status check_available(std::string_view name, unsigned hardware, const char* custom);

}  // namespace weir::subplugin
