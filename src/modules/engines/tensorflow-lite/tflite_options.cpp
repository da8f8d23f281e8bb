// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tensorflow-lite/tflite_options.hpp"

#include <algorithm>
#include <utility>

#include "store_option.hpp"
#include "usable_cores.hpp"
#include "weir/engine_tools.hpp"

namespace weir::engine {
namespace {

void choose_delegate(std::string_view name, TfliteOptions* out) {
  const bool is_none = equals_ignoring_case(name, "None");
  if (is_none || equals_ignoring_case(name, "XNNPACK"))
    out->xnnpack = !is_none;
  else
    log(WEIR_LOG_WARNING, "the delegate " + std::string(name) +
                              " is not available here, the default is used; known: XNNPACK, None");
}

Status apply(const weir_option& option, TfliteOptions* out) {
  const auto key = text_or_empty(option.key), value = text_or_empty(option.value);
  if (equals_ignoring_case(key, "NumThreads"))
    return store_option(number_option(key, value, 1), &out->threads);
  if (equals_ignoring_case(key, "Resize") && equals_ignoring_case(value, "rank")) {
    out->resize = out->resize_rank = true;
    return ok();
  }
  if (equals_ignoring_case(key, "Resize")) {
    if (auto resize = switch_option(key, value))
      return store_option(std::move(resize), &out->resize);
    return bad_option(key, value, "true, false or rank", "rank");
  }
  if (equals_ignoring_case(key, "Delegate")) {
    choose_delegate(value, out);
  } else if (!equals_ignoring_case(key, "Lowering")) {  // parsed in tflite_choice.cpp
    warn_unknown_option(key, "NumThreads, Delegate, Resize, Lowering");
  }
  return ok();
}

}  // namespace

Result<TfliteOptions> TfliteOptions::read(const weir_open& request) {
  TfliteOptions out;
  if (request.threads > 0) out.threads = request.threads;
  for (uint32_t i = 0; request.options && i < request.n_options; ++i)
    if (auto status = apply(request.options[i], &out); !status) return status.error();
  if (out.threads > 1) out.threads = std::min(out.threads, usable_cores());
  return out;
}

}  // namespace weir::engine
