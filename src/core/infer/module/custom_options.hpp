// Parses custom= of tensor_filter: "NumThreads:2,Delegate:XNNPACK".
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace weir::infer {

// The options of an engine; a part without ":" has an empty value. Blanks around keys and values
// are removed.
std::vector<std::pair<std::string, std::string>> custom_options(std::string_view custom);

}  // namespace weir::infer
