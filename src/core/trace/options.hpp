// Options: the parameters of GST_TRACERS="weir(...)".
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <string>
#include <string_view>

#include "weir/result.hpp"

namespace weir::trace {

struct Options {
  // file=: where the trace is written at the end; "" writes none.
  std::string file = "weir-trace.json";
  size_t limit = size_t{1} << 22;  // limit=: the most records per thread, 32 bytes each
};

// Parses comma-separated options. OPTION_SYNTAX names the one that is invalid.
Result<Options> read_options(std::string_view text);

}  // namespace weir::trace
