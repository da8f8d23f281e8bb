// ConverterSettings: the properties of tensor_converter.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>

#include "core/sync/backwards_time.hpp"

namespace weir {

struct ConverterSettings {
  std::string input_dim, input_type;
  uint32_t frames_per_tensor = 1;
  bool set_timestamp = true;
  OnBackwardsTime on_backwards_time = OnBackwardsTime::Pass;
  bool silent = true;
  std::string mode;
};

}  // namespace weir
