// Install paths: what meson.build passes to this file alone.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/config/install_paths.hpp"

namespace weir::config {

const char* const kInstalledModules = WEIR_MODULE_DIR;
const char* const kInstalledFilters = WEIR_FILTER_DIR;
const char* const kInstalledCards = WEIR_DATA_DIR "/cards";
const char* const kInstalledSettings = WEIR_CONFIG_DIR;
const char* const kInstalledWorker = WEIR_WORKER_PROGRAM;
const char* const kInstalledNnstreamer = WEIR_NNSTREAMER_LIBRARY;

const char* const kVersion = WEIR_VERSION;

}  // namespace weir::config
