// ResultRoles: what the tensors of a stream of results are, from the caps fields weir-columns and
// weir-source (weir/results.h).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace weir {

struct ResultRole {
  std::string columns;  // as in results.h; "" = not a result
  std::string source;   // the name of what made it; "" = not known
  bool operator==(const ResultRole&) const = default;
};
// One for each tensor of a frame; missing ones are empty.
using ResultRoles = std::vector<ResultRole>;

// Reads both fields; entries beyond 256 and texts beyond 64 KiB are ignored. Columns are not
// checked.
ResultRoles parse_roles(std::string_view columns, std::string_view sources);
// The texts of the fields.
std::string columns_text(const ResultRoles& roles);
std::string sources_text(const ResultRoles& roles);

// Appends the roles of the next `tensors` tensors to those of the `before` tensors of a frame.
void append_roles(const ResultRoles& more, size_t tensors, size_t before, ResultRoles* roles);
// The roles of the chosen tensors; empty if none of them has one.
ResultRoles pick_roles(const ResultRoles& roles, std::span<const size_t> tensors);

}  // namespace weir
