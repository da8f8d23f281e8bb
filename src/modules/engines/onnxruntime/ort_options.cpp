// SPDX-License-Identifier: LGPL-2.1-or-later
#include "onnxruntime/ort_options.hpp"

#include <algorithm>
#include <cstdio>

#include "store_option.hpp"
#include "usable_cores.hpp"
#include "weir/engine_tools.hpp"

namespace weir::engine {
namespace {

constexpr int kThreadLimit = 1024;  // a typo must not start a million threads
constexpr int kSpinMicroseconds = 50;
constexpr char kAllowSpinning[] = "session.intra_op.allow_spinning";

Result<GraphOptimizationLevel> optimization_option(std::string_view text) {
  static constexpr std::pair<const char*, GraphOptimizationLevel> kLevels[]{
      {"none", ORT_DISABLE_ALL},
      {"basic", ORT_ENABLE_BASIC},
      {"extended", ORT_ENABLE_EXTENDED},
      {"all", ORT_ENABLE_ALL}};
  for (const auto& [word, level] : kLevels)
    if (equals_ignoring_case(text, word)) return level;
  return bad_option("GraphOptimization", text, "none, basic, extended or all", "all");
}

void set_spinning(bool spins, OrtOptions* out) {
  out->spins = spins;
  out->config.insert_or_assign(kAllowSpinning, std::string(spins ? "1" : "0"));
}

// ONNX Runtime spins for about 20 ms before it sleeps, which costs a live stream a whole core. The
// duration can be set from 1.26 on; older versions can only stop spinning after each invoke.
void bound_spinning(const std::string& version, OrtOptions* out) {
  int major = 0, minor = 0;
  const bool known = std::sscanf(version.c_str(), "%d.%d", &major, &minor) == 2;
  if (known && (major > 1 || (major == 1 && minor >= 26)))
    out->config.emplace("session.intra_op.spin_duration_us", std::to_string(kSpinMicroseconds));
  else
    out->config.insert_or_assign("session.force_spinning_stop", std::string("1"));
}

Status apply(const weir_option& option, OrtOptions* out) {
  const auto key = text_or_empty(option.key), value = text_or_empty(option.value);
  if (equals_ignoring_case(key, "GraphOptimization"))
    return store_option(optimization_option(value), &out->optimization);
  if (equals_ignoring_case(key, "NumThreads")) {
    const auto threads = number_option(key, value, 1);
    if (!threads) return threads.error();
    out->threads = std::min(*threads, kThreadLimit);
    out->by_size = false;
  } else if (equals_ignoring_case(key, "Spinning")) {
    const auto spins = switch_option(key, value);
    if (!spins) return spins.error();
    set_spinning(*spins, out);
  } else if (key.find('.') != std::string_view::npos) {
    out->config[std::string(key)] = value;
    if (key == kAllowSpinning) out->spins = value != "0";
  } else {
    warn_unknown_option(key, "NumThreads, GraphOptimization, Spinning, session.* keys");
  }
  return ok();
}

}  // namespace

Result<OrtOptions> OrtOptions::read(const weir_open& request, const std::string& version) {
  OrtOptions out;
  out.config = {
      {"session.inter_op.allow_spinning", "0"}, {kSharedArenaKey, "1"}, {kWeightsApartKey, "1"}};
  const bool alone = request.threads <= 0;
  out.by_size = alone;
  out.threads = alone ? usable_cores() : std::min<int>(request.threads, kThreadLimit);
  for (uint32_t i = 0; request.options && i < request.n_options; ++i)
    if (auto status = apply(request.options[i], &out); !status) return status.error();
  if (out.config.contains(kAllowSpinning)) return out;
  set_spinning(alone, &out);
  if (alone) bound_spinning(version, &out);
  return out;
}

}  // namespace weir::engine
