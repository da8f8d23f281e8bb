// Reading the options of the ONNX Runtime engine.
#include "onnxruntime/ort_options.hpp"

#include <algorithm>

#include "engine_options.hpp"
#include "usable_cores.hpp"

namespace weir::engine {
namespace {

constexpr int kThreadLimit = 1024;  // a typo must not start a million threads

Result<GraphOptimizationLevel> optimization_option(std::string_view text) {
  static constexpr std::pair<const char*, GraphOptimizationLevel> kLevels[]{
      {"none", ORT_DISABLE_ALL},
      {"basic", ORT_ENABLE_BASIC},
      {"extended", ORT_ENABLE_EXTENDED},
      {"all", ORT_ENABLE_ALL}};
  for (const auto& [word, level] : kLevels)
    if (same_word(text, word)) return level;
  return Error{Code::OPTION_VALUE,
               "the option GraphOptimization has a value that cannot be used",
               "GraphOptimization:" + std::string(text),
               "none, basic, extended or all",
               "",
               "custom=GraphOptimization:all"};
}

Status apply(const weir_option& option, OrtOptions* out) {
  const auto key = text_or_empty(option.key), value = text_or_empty(option.value);
  if (same_word(key, "NumThreads")) {
    const auto threads = number_option(key, value, 1);
    if (!threads) return threads.error();
    out->threads = std::min(*threads, kThreadLimit);
  } else if (same_word(key, "GraphOptimization")) {
    const auto level = optimization_option(value);
    if (!level) return level.error();
    out->optimization = *level;
  } else if (same_word(key, "Spinning")) {
    const auto spins = switch_option(key, value);
    if (!spins) return spins.error();
    out->config.emplace_back("session.intra_op.allow_spinning", *spins ? "1" : "0");
  } else if (same_word(key, "LoweringCache")) {
    const auto on = switch_option(key, value);
    if (!on) return on.error();
    out->lowering_cache = *on;
  } else if (key.find('.') != std::string_view::npos) {
    out->config.emplace_back(key, value);
  } else {
    warn_unknown_option(key,
                        "NumThreads, GraphOptimization, Spinning, LoweringCache, session.* keys");
  }
  return ok();
}

}  // namespace

Result<OrtOptions> OrtOptions::read(const weir_open& request) {
  OrtOptions out;
  out.threads = request.threads > 0 ? std::min<int>(request.threads, kThreadLimit) : usable_cores();
  for (uint32_t i = 0; request.options && i < request.n_options; ++i)
    if (auto status = apply(request.options[i], &out); !status) return status.error();
  return out;
}

}  // namespace weir::engine
