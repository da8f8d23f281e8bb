// Sizes and words of tensor descriptions whose shapes are outermost-first.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "weir/abi.h"

namespace weir::direct {

// Type, rank and every extent known.
bool is_fixed(const weir_tensor_info& info) noexcept;
// Nothing when it is not fixed, or more than 2^48 bytes.
std::optional<uint64_t> bytes_of(const weir_tensor_info& info) noexcept;
// "(1, 224, ?)" as NumPy prints shapes, "any shape".
std::string shape_words(const weir_tensor_info& info);
// "float32 (1, 224, ?) x", the name last where there is one.
std::string words(const weir_tensor_info& info);
// "input 0 (x)"
std::string place_words(const char* role, size_t index, const weir_tensor_info& info);
// The first difference of `given` from `wanted`, whose unknown parts fit all; "" when there is
// none.
std::string shape_difference(const weir_tensor_info& given, const weir_tensor_info& wanted);

}  // namespace weir::direct
