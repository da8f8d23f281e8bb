// Fuzz target: parses label files. Accepted files are UTF-8 text with one label per line.
// SPDX-License-Identifier: LGPL-2.1-or-later

#include <algorithm>
#include <string>

#include "fuzz_input.hpp"
#include "memory_file.hpp"
#include "weir/label_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const weir::fuzz::MemoryFile file(text);
  try {
    const auto labels = weir::read_label_file("option1", file.path());
    const auto ends = static_cast<size_t>(std::count(text.begin(), text.end(), '\n'));
    weir::fuzz::require(labels.size() == ends + (text.ends_with('\n') ? 0 : 1),
                        "a line is a label");
    for (const auto& label : labels)
      weir::fuzz::require(weir::is_text(label) && label.find('\n') == label.npos,
                          "a label is text of one line");
  } catch (const weir::Failure& failure) {
    weir::fuzz::require(!failure.error().what.empty() && !failure.error().fix.empty(),
                        "an error says what to do");
  }
  return 0;
}
