// Install paths: the folders and files that `make install` fills, and the version of this build.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

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

}  // namespace weir::config
