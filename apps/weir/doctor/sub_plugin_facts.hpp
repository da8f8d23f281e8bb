// The part of `weir doctor` about sub-plugins for NNStreamer.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "report.hpp"

namespace weir::app {

// Opens each file of every kind. Members library, found, files.
Json sub_plugins_as_json();
void print_sub_plugins();

}  // namespace weir::app
