// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pytorch/torch_options.hpp"

#include <algorithm>

#include "weir/engine_tools.hpp"

namespace weir::engine {
namespace {

constexpr int kThreadLimit = 1024;  // a typo must not start a million threads

Status apply(const weir_option& option, TorchOptions* out) {
  const auto key = text_or_empty(option.key), value = text_or_empty(option.value);
  if (equals_ignoring_case(key, "NumThreads")) {
    const auto threads = number_option(key, value, 1);
    if (!threads) return threads.error();
    out->threads = std::min(*threads, kThreadLimit);
    return ok();
  }
  const std::pair<const char*, bool*> switches[]{{"Freeze", &out->freeze},
                                                 {"Optimize", &out->optimize}};
  for (const auto& [name, target] : switches)
    if (equals_ignoring_case(key, name)) {
      const auto on = switch_option(key, value);
      if (!on) return on.error();
      *target = *on;
      return ok();
    }
  const auto taken = out->declared.take(key, value);
  if (!taken) return taken.error();
  if (!*taken) warn_unknown_option(key, "NumThreads, Freeze, Optimize");
  return ok();
}

}  // namespace

Result<TorchOptions> TorchOptions::read(const weir_open& request) {
  TorchOptions out;
  if (request.threads > 0) out.threads = std::min<int>(request.threads, kThreadLimit);
  for (uint32_t i = 0; request.options && i < request.n_options; ++i)
    if (auto status = apply(request.options[i], &out); !status) return status.error();
  return out;
}

}  // namespace weir::engine
