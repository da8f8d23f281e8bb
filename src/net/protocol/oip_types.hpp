// The element types of the Open Inference Protocol, and how tensors of each are sent.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string_view>

#include "weir/abi.h"

namespace weir::net {

struct OipType {
  std::string_view name;   // "FP32"
  uint32_t type;           // weir_type of a stream
  uint32_t content_field;  // of InferTensorContents; 0 = only as raw contents
};

// Returns null for a type that streams do not have. BOOL is uint8 of 0 and 1, BYTES one vector of
// uint8.
const OipType* oip_type(std::string_view name) noexcept;
// Returns the type with which a stream's tensor is sent; null for WEIR_TYPE_END.
const OipType* find_oip_type(uint32_t type) noexcept;

}  // namespace weir::net
