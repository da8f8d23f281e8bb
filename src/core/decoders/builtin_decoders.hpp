// The decoders that need no module file.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "weir/abi.h"

namespace weir::decoders {

// Also sets the host of this copy of the code, which the decoders report their errors to.
const weir_module& builtin_decoders();

}  // namespace weir::decoders
