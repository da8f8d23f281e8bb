// Finds the prefix of an installed tree that was moved after `make install`.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <string>
#include <string_view>

namespace weir::config {

// The prefix of the tree in which the program or library `file` is installed: its folder without
// the one of `folders`, relative to a prefix, with which that ends. `built_for` when it ends with
// none of them, as in a build folder.
std::string prefix_of(std::string_view file, std::span<const std::string_view> folders,
                      std::string_view built_for);
// `path` below another prefix; as it is when it is not below `built_for`, as "/etc".
std::string below_prefix(std::string_view path, std::string_view built_for,
                         std::string_view prefix);

}  // namespace weir::config
