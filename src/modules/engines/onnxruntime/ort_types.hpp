// Maps element types of ONNX Runtime to those of Weir.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <onnxruntime_c_api.h>

#include <array>
#include <optional>

#include "weir/abi.h"

namespace weir::engine {

struct OrtTypePair {
  ONNXTensorElementDataType onnx;
  weir_type weir;
};
// Bool is last: Weir has no bool and uses a byte of 0 or 1.
inline constexpr std::array<OrtTypePair, 12> kOrtTypes{
    {{ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT, WEIR_FLOAT32},
     {ONNX_TENSOR_ELEMENT_DATA_TYPE_UINT8, WEIR_UINT8},
     {ONNX_TENSOR_ELEMENT_DATA_TYPE_INT8, WEIR_INT8},
     {ONNX_TENSOR_ELEMENT_DATA_TYPE_UINT16, WEIR_UINT16},
     {ONNX_TENSOR_ELEMENT_DATA_TYPE_INT16, WEIR_INT16},
     {ONNX_TENSOR_ELEMENT_DATA_TYPE_INT32, WEIR_INT32},
     {ONNX_TENSOR_ELEMENT_DATA_TYPE_INT64, WEIR_INT64},
     {ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT16, WEIR_FLOAT16},
     {ONNX_TENSOR_ELEMENT_DATA_TYPE_DOUBLE, WEIR_FLOAT64},
     {ONNX_TENSOR_ELEMENT_DATA_TYPE_UINT32, WEIR_UINT32},
     {ONNX_TENSOR_ELEMENT_DATA_TYPE_UINT64, WEIR_UINT64},
     {ONNX_TENSOR_ELEMENT_DATA_TYPE_BOOL, WEIR_UINT8}}};

inline std::optional<weir_type> from_ort(ONNXTensorElementDataType type) noexcept {
  for (const auto& pair : kOrtTypes)
    if (pair.onnx == type) return pair.weir;
  return std::nullopt;
}

// The ONNX standard's name, for messages.
inline const char* ort_type_name(ONNXTensorElementDataType type) noexcept {
  static constexpr std::array kNames{
      "undefined",      "float",      "uint8",          "int8",       "uint16",   "int16",
      "int32",          "int64",      "string",         "bool",       "float16",  "double",
      "uint32",         "uint64",     "complex64",      "complex128", "bfloat16", "float8e4m3fn",
      "float8e4m3fnuz", "float8e5m2", "float8e5m2fnuz", "uint4",      "int4"};
  return static_cast<size_t>(type) < kNames.size() ? kNames[type] : "unknown";
}

}  // namespace weir::engine
