// Passes a filter's outputs to Weir: memory ownership, sizes, errors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>

#include "compat/open_filter.hpp"

namespace weir::compat {

// Returns the size; 0 for an invalid type.
uint64_t count_bytes(const weir_tensor_info& info) noexcept;

// Transfers the filter's `memory` to `out`; the filter stays open until it is freed.
void give(std::shared_ptr<OpenFilter> filter, GstTensorMemory* memory, const weir_tensor_info& info,
          weir_tensor* out);
// Marks an output as absent, of a filter whose number of outputs varies by frame.
void leave_out(weir_tensor* out) noexcept;
// Frees memory that was not transferred; logs exceptions.
void destroy(OpenFilter& filter, GstTensorMemory* memory) noexcept;

// Makes the error CALLBACK_FAILED: "the filter NAME what".
Failure broke(const std::string& name, const std::string& what, std::string offered,
              std::string needed, std::string fix);
// Returns for example "output 0: 17 bytes" or "output 0: NULL".
std::string which(size_t index, const GstTensorMemory& memory);
// Makes the error for an output whose size differs from that of `info`.
Failure other_size(const std::string& name, size_t index, const GstTensorMemory& memory,
                   const weir_tensor_info& info);
// Makes the error for more outputs than expected.
Failure too_many(const std::string& name, size_t count, size_t max);

}  // namespace weir::compat
