// Finds a data file of this installation for a path below another prefix.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <string_view>

namespace weir::config {

// Documents name /usr/share/weir/models/NAME. If `path` does not exist, and this installation, with
// another prefix, has that file: its path. Else "".
std::string installed_file(const std::string& path);
// The same for the data folder PREFIX/share/weir.
std::string file_below(const std::string& data_folder, std::string_view path);

}  // namespace weir::config
