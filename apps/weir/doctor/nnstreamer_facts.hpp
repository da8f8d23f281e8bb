// The part of `weir doctor` about nnstreamer.ini and the folders of sub-plugins.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/config/nnstreamer.hpp"
#include "report.hpp"

namespace weir::app {

// Members enabled, files, settings, folders, problems. `weir`: the settings that override them.
Json to_json(const config::NnstreamerConfiguration& configuration,
             const config::Configuration& weir);
void print(const config::NnstreamerConfiguration& configuration, const config::Configuration& weir);

}  // namespace weir::app
