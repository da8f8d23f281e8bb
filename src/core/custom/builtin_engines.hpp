// The engines that need no module file.
#pragma once
#include "weir/abi.h"

namespace weir::custom {

const weir_module& builtin_engines();

}  // namespace weir::custom
