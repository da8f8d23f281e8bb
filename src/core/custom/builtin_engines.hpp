// The engines that need no module file.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "weir/abi.h"

namespace weir::custom {

const weir_module& builtin_engines();

}  // namespace weir::custom
