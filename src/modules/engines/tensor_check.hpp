// Checks the tensors of frames and streams against those of a model.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "weir/abi.h"
#include "weir/module.hpp"
#include "weir/result.hpp"

namespace weir::engine {

// Empty when a dimension is unknown, the rank too high, the type unknown or the product too large.
std::optional<uint64_t> tensor_bytes(const weir_tensor_info& info) noexcept;
bool is_fixed(const weir_tensor_info& info) noexcept;

// Formats as caps, innermost first: "float32 3:224:224:?"; preceded by the name if there is one.
std::string describe(const weir_tensor_info& info);
std::string describe(std::span<const weir_tensor_info> infos);

// Compares the number of tensors, types, ranks and known dimensions. A dimension of -1 on either
// side and the model's type WEIR_TYPE_END match anything. SPEC_MISMATCH on a difference. `role` is
// "input" or "output".
Status check_infos(std::span<const weir_tensor_info> model, std::span<const weir_tensor_info> given,
                   const char* role);

// Checks for dense host memory of the described size; otherwise FRAME_SIZE or FORMAT_UNSUPPORTED.
// Only an output may have null data.
Status check_memory(const weir_tensor& tensor, size_t index, const char* role);

std::span<weir_tensor> get_tensors(const weir_frame& frame) noexcept;

// SPEC_MISMATCH unless there are as many tensors as the model has.
Status check_count(std::span<const weir_tensor_info> model, size_t given, const char* role);
// Checks the number, descriptions and memory of a frame's inputs.
Status check_inputs(std::span<const weir_tensor_info> model, std::span<const weir_tensor> given);
// Checks the number of outputs, and the memory of those that have any.
Status check_outputs(std::span<const weir_tensor_info> model, std::span<const weir_tensor> given);

// Copies an engine's output into the given memory; INVOKE_FAILED when that has another size or
// type. Without given memory, copies into memory of the host and sets the description to `info`.
Status write_output(const weir_tensor_info& info, const void* data, size_t index, weir_tensor* to);

}  // namespace weir::engine
