// Options: what stands in the brackets of GST_TRACERS="weir(...)".
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <string>
#include <string_view>

#include "weir/result.hpp"

namespace weir::trace {

struct Options {
  std::string file = "weir-trace.json";  // file=: where the trace goes at the end; "" is nowhere
  size_t limit = size_t{1} << 22;        // limit=: the most records of one thread, 32 bytes each
};

// Options with commas between them. OPTION_SYNTAX names the one that cannot be read.
Result<Options> read_options(std::string_view text);

}  // namespace weir::trace
