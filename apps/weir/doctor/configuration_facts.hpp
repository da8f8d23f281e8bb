// The part of `weir doctor` about weir.ini.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/config/configuration.hpp"
#include "report.hpp"

namespace weir::app {

// Members files, settings, problems.
Json to_json(const config::Configuration& configuration);
void print(const config::Configuration& configuration);
// One line for an error in a configuration file.
std::string problem(const Error& fault);

}  // namespace weir::app
