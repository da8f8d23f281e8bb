// The engine cpp: classes that a program or a library registered by name (specification 4.12).
#pragma once
#include "weir/abi.h"

namespace weir::custom {

// model=NAME[,lib.so]
const weir_engine& cpp_engine();

}  // namespace weir::custom
