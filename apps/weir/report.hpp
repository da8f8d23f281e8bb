// Output shared by the subcommands: errors, tables, JSON.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <nlohmann/json.hpp>

#include <string>
#include <string_view>
#include <vector>

#include "core/text/shell_quote.hpp"
#include "weir/result.hpp"

namespace weir::app {

using Json = nlohmann::ordered_json;

// {"code": 3003, "id": "WEIR-3003", "what": ...} and the other members that are not empty.
Json to_json(const Error& error);
// Prints to stdout with a newline. Replaces bytes that are not UTF-8, escapes all control
// characters.
void print(const Json& document);
// Prints text to stderr, or {"error": ...} to stdout. Returns kExitError.
int report(const Error& error, bool json);

// Columns are as wide as their longest cell; a column of numbers is right-aligned. The first row is
// the heading. Control characters, which file names may contain, become blanks; bytes that are not
// UTF-8 are escaped.
std::string table(std::vector<std::vector<std::string>> rows, std::string_view indent);

}  // namespace weir::app
