// Outputs of filters on their way to Weir: memory that is given away, sizes, what breaks.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>

#include "compat/open_filter.hpp"

namespace weir::compat {

// 0 for a type that is none.
uint64_t bytes_of(const weir_tensor_info& info) noexcept;

// Gives `memory`, which is the filter's, to `out`: the filter stays open until it is freed.
void give(std::shared_ptr<OpenFilter> filter, GstTensorMemory* memory, const weir_tensor_info& info,
          weir_tensor* out);
// Of a filter that says the number of outputs with each frame: one that is not there this time.
void leave_out(weir_tensor* out) noexcept;
// Frees what was not given away; what that throws is told in the log.
void destroy(OpenFilter& filter, GstTensorMemory* memory) noexcept;

// CALLBACK_FAILED: "the filter NAME what".
Failure broke(const std::string& name, const std::string& what, std::string offered,
              std::string needed, std::string fix);
// "output 0: 17 bytes", "output 0: NULL".
std::string which(size_t index, const GstTensorMemory& memory);
// For an output of which another size is known: `info`.
Failure other_size(const std::string& name, size_t index, const GstTensorMemory& memory,
                   const weir_tensor_info& info);
// For more outputs than there is room for.
Failure too_many(const std::string& name, size_t count, size_t most);

}  // namespace weir::compat
