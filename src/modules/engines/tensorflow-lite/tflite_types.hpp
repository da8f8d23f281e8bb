// Maps element types of TensorFlow Lite to those of Weir.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <tensorflow/lite/c/c_api_types.h>

#include <array>
#include <optional>
#include <utility>

#include "weir/abi.h"

namespace weir::engine {

// Bool is last: Weir has no bool and uses a byte of 0 or 1.
inline constexpr std::array<std::pair<TfLiteType, weir_type>, 11> kTfliteTypes{
    {{kTfLiteFloat32, WEIR_FLOAT32},
     {kTfLiteInt32, WEIR_INT32},
     {kTfLiteUInt8, WEIR_UINT8},
     {kTfLiteInt64, WEIR_INT64},
     {kTfLiteInt16, WEIR_INT16},
     {kTfLiteInt8, WEIR_INT8},
     {kTfLiteFloat16, WEIR_FLOAT16},
     {kTfLiteFloat64, WEIR_FLOAT64},
     {kTfLiteUInt64, WEIR_UINT64},
     {kTfLiteUInt32, WEIR_UINT32},
     {kTfLiteBool, WEIR_UINT8}}};

inline std::optional<weir_type> from_tflite(TfLiteType type) noexcept {
  for (const auto& [theirs, ours] : kTfliteTypes)
    if (theirs == type) return ours;
  return std::nullopt;
}

// For messages.
inline const char* tflite_type_name(TfLiteType type) noexcept {
  static constexpr std::array kNames{"none",    "float32", "int32",      "uint8",     "int64",
                                     "string",  "bool",    "int16",      "complex64", "int8",
                                     "float16", "float64", "complex128", "uint64",    "resource",
                                     "variant", "uint32"};
  return static_cast<size_t>(type) < kNames.size() ? kNames[type] : "unknown";
}

}  // namespace weir::engine
