// What the subcommands share for output: errors, tables, JSON.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "core/text/pasted.hpp"
#include "weir/result.hpp"

namespace weir::app {

using Json = nlohmann::ordered_json;

// {"code": 3003, "id": "WEIR-3003", "what": ..., and the parts that are not empty}
Json to_json(const Error& error);
// On stdout, with a line end. Bytes that are not UTF-8 are replaced.
void print(const Json& document);
// Text on stderr, or {"error": ...} on stdout. Returns kExitError.
int report(const Error& error, bool json);

// Columns as wide as their longest cell; a column whose cells are all numbers goes to the right.
// The first row is the heading. Control characters, which names in files may have, become blanks.
std::string table(std::vector<std::vector<std::string>> rows, std::string_view indent);

}  // namespace weir::app
