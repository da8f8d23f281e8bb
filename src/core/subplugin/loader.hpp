// Finding and opening the files of sub-plugins for NNStreamer (specification 8.1).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "core/subplugin/table.hpp"
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::subplugin {

// What is registered under the name, else what libnnstreamer_KIND_NAME.so of the first folder that
// has it registers when it is loaded; it stays open until the process ends. Null: there is neither.
// MODULE_REFUSED for a symbolic link where none may be, a file that cannot be loaded, one that does
// not register the name, and where the library that such files call is missing.
Result<const void*> open(Kind kind, std::string_view name);
// Every file of the kind, opened; those that cannot be used are told in the log,
// once in a process.
void open_all(Kind kind);
// A warning in the log, the first time only.
void tell_once(const std::string& who, const std::string& message);
// The file of open(); "" when there is none.
std::string file_of(Kind kind, std::string_view name);
// Names that are registered or have a file, sorted; nothing is opened.
std::vector<std::string> available(Kind kind);

// Where the library with the functions that sub-plugins call is: [nnstreamer] library, else as
// built.
std::string library_path();
// That library, opened so that they find them; once.
Status load_library();

// Filters as engines: the library above brings this with it. The engine of a descriptor lives until
// the process ends; null: it cannot be used, and the reason is in the log.
using EngineAdapter = const weir_engine* (*)(const void* descriptor);
void set_engine_adapter(EngineAdapter adapter) noexcept;
// Null: there is no such sub-plugin.
Result<const weir_engine*> engine(std::string_view name);

}  // namespace weir::subplugin
