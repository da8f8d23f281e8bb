// The files of a folder, in the order of their names.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "weir/result.hpp"

namespace weir::app {

// Whether the name has the extension of a picture: .jpg, .jpeg, .png, .bmp, .webp, .tif, .tiff.
bool is_picture_name(const std::filesystem::path& path);
std::vector<std::filesystem::path> pictures_in(const std::filesystem::path& folder);
// Hidden ones are left out.
std::vector<std::filesystem::path> folders_in(const std::filesystem::path& folder);
// FILE_NOT_FOUND, with the system's reason.
Result<std::string> read_file(const std::filesystem::path& path);
// "photos/a.jpg", or "photos/a.jpg and 3 more". Precondition: not empty.
std::string format_first(const std::vector<std::string>& names);

}  // namespace weir::app
