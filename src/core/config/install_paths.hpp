// Install paths: the folders and files that `make install` fills, and the version of this build.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <string>
#include <string_view>

namespace weir::config {

// Absolute. Below the prefix of the build, or where the tree was moved to after `make install`: the
// plug-in, the library and the programs look beside themselves. install_paths.cpp alone depends on
// the prefix, so that another prefix compiles one file and links. Core looks at these places last,
// after those that the environment and weir.ini name.
extern const char* const kInstalledModules;     // folder of engines, decoders and converters
extern const char* const kInstalledFilters;     // folder of custom filters
extern const char* const kInstalledCards;       // folder of model cards
extern const char* const kInstalledSettings;    // folder of weir.ini and nnstreamer.ini
extern const char* const kInstalledWorker;      // the program weir-worker
extern const char* const kInstalledNnstreamer;  // libnnstreamer.so

// Folder of the documents, laid out as the sources. A function, because the descriptor of a plug-in
// uses it while the constants above are initialised.
const char* installed_documents();

extern const char* const kVersion;  // "3.0.0"

// The prefix of the tree in which the program or library `file` is installed: its folder without
// the one of `folders`, relative to a prefix, with which that ends. `built_for` when it ends with
// none of them, as in a build folder.
std::string find_prefix(std::string_view file, std::span<const std::string_view> folders,
                        std::string_view built_for);
// `path` below another prefix; as it is when it is not below `built_for`, as "/etc".
std::string below_prefix(std::string_view path, std::string_view built_for,
                         std::string_view prefix);

}  // namespace weir::config
