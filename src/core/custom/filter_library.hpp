// Opens users' shared objects with filters: framework=custom and framework=cpp.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "core/infer/module/module_tables.hpp"
#include "weir/result.hpp"

namespace weir::custom {

// Opens the file once; it stays open until the process ends. Null: it does not export
// weir_module_entry. The path is used as it is, without a search. No code runs of a file that
// neither exports it nor registers filters, or that is not a regular file:
//   MODEL_NOT_FOUND, MODULE_REFUSED.
Result<std::shared_ptr<const infer::ModuleTables>> open_filter_library(const std::string& path);

// True if the file has the callbacks of NNStreamer's custom filters and nothing else. Same errors.
Result<bool> has_callbacks(const std::string& path);

// The folders to search for a filter by name: [filter] path (colon-separated), then the folder
// chosen when Weir was built, then NNStreamer's folders of custom filters.
std::vector<std::string> filter_folders();
// FOLDER/NAME.so in the first folder that has it; "" if none has.
std::string library_of_filter(const std::string& name);

}  // namespace weir::custom
