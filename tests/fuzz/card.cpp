// Fuzz target: parses model cards. An accepted card must give a pipeline.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "core/card/card.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const auto card = weir::card::parse({reinterpret_cast<const char*>(data), size}, "fuzz");
  if (!card) return 0;
  for (const auto& input : card->inputs)
    if (weir::card::preparation(input).empty()) std::abort();
  return 0;
}
