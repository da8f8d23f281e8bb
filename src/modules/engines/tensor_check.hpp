// What frames and streams say of tensors, held against what a model says.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::engine {

// 0 for a number that is no element type.
uint64_t element_bytes(uint32_t type) noexcept;
// Nothing when a dimension is unknown, the rank too high, the type unknown or the product too big.
std::optional<uint64_t> tensor_bytes(const weir_tensor_info& info) noexcept;
bool is_fixed(const weir_tensor_info& info) noexcept;

// As caps write it, innermost first: "float32 3:224:224:?"; with the name when there is one.
std::string describe(const weir_tensor_info& info);
std::string describe(std::span<const weir_tensor_info> infos);

// The same number of tensors, types, ranks and known dimensions; -1 on either side fits all, and so
// does the model's type WEIR_TYPE_END.
// SPEC_MISMATCH otherwise. `role` is "input" or "output".
Status check_infos(std::span<const weir_tensor_info> model, std::span<const weir_tensor_info> given,
                   const char* role);

// Dense host memory whose size is that of its description: FRAME_SIZE or FORMAT_UNSUPPORTED
// otherwise. Data may be null only for an output.
Status check_memory(const weir_tensor& tensor, size_t index, const char* role);

std::span<weir_tensor> tensors_of(const weir_frame& frame) noexcept;

// As many tensors as the model has: SPEC_MISMATCH otherwise.
Status check_count(std::span<const weir_tensor_info> model, size_t given, const char* role);
// A frame's inputs: their number, descriptions and memory.
Status check_inputs(std::span<const weir_tensor_info> model, std::span<const weir_tensor> given);
// Their number, and the memory of those that have some.
Status check_outputs(std::span<const weir_tensor_info> model, std::span<const weir_tensor> given);

// Copies an engine's output into the memory that is there: INVOKE_FAILED where that has another
// size or type. Where there is none, into memory of the host, described as `info` says.
Status write_output(const weir_tensor_info& info, const void* data, size_t index, weir_tensor* to);

}  // namespace weir::engine
