// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/protocol/oip_types.hpp"

#include <algorithm>
#include <array>

namespace weir::net {
namespace {

constexpr std::array kTypes{
    OipType{"INT8", WEIR_INT8, 2},     OipType{"INT16", WEIR_INT16, 2},
    OipType{"INT32", WEIR_INT32, 2},   OipType{"INT64", WEIR_INT64, 3},
    OipType{"UINT8", WEIR_UINT8, 4},   OipType{"UINT16", WEIR_UINT16, 4},
    OipType{"UINT32", WEIR_UINT32, 4}, OipType{"UINT64", WEIR_UINT64, 5},
    OipType{"FP16", WEIR_FLOAT16, 0},  OipType{"FP32", WEIR_FLOAT32, 6},
    OipType{"FP64", WEIR_FLOAT64, 7},  OipType{"BOOL", WEIR_UINT8, 1},
    OipType{"BYTES", WEIR_UINT8, 8},
};

}  // namespace

const OipType* oip_type(std::string_view name) noexcept {
  const auto found = std::find_if(kTypes.begin(), kTypes.end(),
                                  [name](const auto& type) { return type.name == name; });
  return found == kTypes.end() ? nullptr : &*found;
}

const OipType* find_oip_type(uint32_t type) noexcept {
  const auto found = std::find_if(kTypes.begin(), kTypes.end(),
                                  [type](const auto& known) { return known.type == type; });
  return found == kTypes.end() ? nullptr : &*found;
}

}  // namespace weir::net
