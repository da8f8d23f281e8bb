// A user's shared object with filters: framework=custom and framework=cpp.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "core/infer/module_tables.hpp"
#include "weir/result.hpp"

namespace weir::custom {

// Opens the file, once per file; it stays open until the process ends. Null: it exports no
// weir_module_entry. The path is used as it is, no folder is searched. Nothing of a file is run
// that exports neither that nor registers filters, or that is no regular file:
//   MODEL_NOT_FOUND, MODULE_REFUSED.
Result<std::shared_ptr<const infer::ModuleTables>> open_filter_library(const std::string& path);

// Whether the file has the callbacks of NNStreamer's custom filters and nothing else; the same
// refusals.
Result<bool> has_callbacks(const std::string& path);

// Where libraries are looked for that bring a filter by name: [filter] path (colon list), then the
// folder chosen when Weir was built, then NNStreamer's folders of custom filters.
std::vector<std::string> filter_folders();
// FOLDER/NAME.so of the first folder that has it; "" when none has.
std::string library_of_filter(const std::string& name);

}  // namespace weir::custom
