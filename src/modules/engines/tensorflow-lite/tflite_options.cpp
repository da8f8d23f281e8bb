// Reading the options of the TensorFlow Lite engine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tensorflow-lite/tflite_options.hpp"

#include <algorithm>

#include "engine_options.hpp"
#include "usable_cores.hpp"

namespace weir::engine {
namespace {

void choose_delegate(std::string_view name, TfliteOptions* out) {
  out->xnnpack = !same_word(name, "None");
  if (out->xnnpack && !same_word(name, "XNNPACK"))
    log(WEIR_LOG_WARNING, "the delegate " + std::string(name) +
                              " is not available here, XNNPACK is used; known: XNNPACK, None");
}

}  // namespace

Result<TfliteOptions> TfliteOptions::read(const weir_open& request) {
  TfliteOptions out;
  if (request.threads > 0) out.threads = request.threads;
  for (uint32_t i = 0; request.options && i < request.n_options; ++i) {
    const auto key = text_or_empty(request.options[i].key);
    const auto value = text_or_empty(request.options[i].value);
    if (same_word(key, "NumThreads")) {
      const auto threads = number_option(key, value, 1);
      if (!threads) return threads.error();
      out.threads = *threads;
    } else if (same_word(key, "Delegate")) {
      choose_delegate(value, &out);
    } else if (same_word(key, "Resize")) {
      const auto resize = switch_option(key, value);
      if (!resize) return resize.error();
      out.resize = *resize;
    } else if (!same_word(key, "Lowering") &&
               !same_word(key, "LoweringCache")) {  // tflite_choice.cpp reads it
      warn_unknown_option(key, "NumThreads, Delegate, Resize, Lowering, LoweringCache");
    }
  }
  if (out.threads > 1) out.threads = std::min(out.threads, usable_cores());
  return out;
}

}  // namespace weir::engine
