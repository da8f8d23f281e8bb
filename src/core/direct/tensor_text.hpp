// Sizes and texts of tensor descriptions with outermost-first shapes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "weir/abi.h"

namespace weir::direct {

// True if type, rank and every extent are known.
bool is_fixed(const weir_tensor_info& info) noexcept;
// Nullopt if it is not fixed, or more than 2^48 bytes.
std::optional<uint64_t> count_bytes(const weir_tensor_info& info) noexcept;
// "(1, 224, ?)" as NumPy prints shapes, "any shape".
std::string shape_text(const weir_tensor_info& info);
// "float32 (1, 224, ?) x", with the name last if there is one.
std::string to_string(const weir_tensor_info& info);
// "input 0 (x)"
std::string place_text(const char* role, size_t index, const weir_tensor_info& info);
// The first difference between `given` and `wanted`, whose unknown parts match anything; "" without
// one.
std::string shape_difference(const weir_tensor_info& given, const weir_tensor_info& wanted);

}  // namespace weir::direct
