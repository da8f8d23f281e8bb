// Fuzz target: parses files of the property config-file. Keys and values are parts of the text, in
// its order.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/text/property_file.hpp"

#include "core/text/text.hpp"
#include "fuzz_input.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const char* at = text.data();
  for (const auto& [key, value] : weir::parse_property_file(text)) {
    weir::fuzz::require(!key.empty() && key == weir::strip(key) && value == weir::strip(value),
                        "keys and values have no blanks around them");
    weir::fuzz::require(key.data() >= at, "keys come in the order of the lines");
    weir::fuzz::require(value.empty() || (value.data() > key.data() &&
                                          value.data() + value.size() <= text.data() + text.size()),
                        "a value is a part of the text");
    at = key.data() + key.size();
  }
  return 0;
}
