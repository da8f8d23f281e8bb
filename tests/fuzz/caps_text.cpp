// Fuzz target: caps and structures that a peer, a module or a file wrote. No text
// overflows the stack, fails an assertion of GStreamer or makes it leak.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/caps_text.hpp"

#include <string>

#include "fuzz_input.hpp"
#include "weir/printable_text.hpp"

using weir::fuzz::require;

namespace {

void check_error(const weir::Error& error) {
  require(!error.what.empty() && !error.needed.empty(), "an error says what is needed");
  require(error.offered == weir::printable_text(error.offered),
          "an error has no control characters");
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  gst_init(nullptr, nullptr);
  gst_debug_set_default_threshold(GST_LEVEL_NONE);
  g_log_set_always_fatal(GLogLevelFlags(G_LOG_LEVEL_CRITICAL | G_LOG_FATAL_MASK));
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  if (const auto caps = weir::gst::caps_from_text(text)) {
    const weir::gst::UniqueText written{gst_caps_to_string(caps->get())};
    // It may be refused: GStreamer writes a list of several types with the type of the first value.
    (void)weir::gst::caps_from_text(written.get());
  } else {
    check_error(caps.error());
  }
  const auto structure = weir::gst::structure_from_text(text);
  if (!structure) check_error(structure.error());
  return 0;
}
