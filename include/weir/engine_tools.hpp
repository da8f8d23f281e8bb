// Helpers for engines in C++ (engine.hpp, or the C table of abi.h): options, tensor descriptions,
// common errors and logging. Header-only: a module links nothing of Weir.
// SPDX-License-Identifier: LGPL-2.1-or-later
//
//   for (const weir_option& option : options.all()) {
//     const auto key = weir::engine::text_or_empty(option.key);
//     if (weir::engine::equals_ignoring_case(key, "NumThreads"))
//       threads = weir::value_or_throw(weir::engine::number_option(key, option.value, 1));
//     else
//       weir::engine::warn_unknown_option(key, "NumThreads");
//   }
#pragma once
#include <algorithm>
#include <charconv>
#include <iterator>
#include <string>
#include <string_view>

#include "weir/module.hpp"

namespace weir::engine {

// ---- Logging -----------------------------------------------------------------------------------

inline const char* module_name = "engine";  // the category of log(); set it to the engine's name

// Logs through the host; without a host, does nothing.
inline void log(weir_log_level level, const std::string& text) {
  if (module_host && module_host->log) module_host->log(level, module_name, text.c_str());
}

// ---- Options -----------------------------------------------------------------------------------

// Compares ASCII letters without case.
inline bool equals_ignoring_case(std::string_view a, std::string_view b) {
  const auto low = [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [low](char x, char y) { return low(x) == low(y); });
}

// Returns `text`, or "" for null.
inline std::string_view text_or_empty(const char* text) {
  return text ? text : "";
}

// Makes the error OPTION_VALUE for the option `key` with the value `text`. `valid` is a value for
// the fix.
inline Error bad_option(std::string_view key, std::string_view text, std::string needed,
                        std::string_view valid) {
  const std::string name(key);
  return Error{.code = Code::OPTION_VALUE,
               .what = "the option " + name + " has a value that cannot be used",
               .offered = name + ":" + std::string(text),
               .needed = std::move(needed),
               .fix = "custom=" + name + ":" + std::string(valid)};
}

// Parses an integer >= `min`; otherwise OPTION_VALUE.
inline Result<int> number_option(std::string_view key, std::string_view text, int min) {
  int value = 0;
  const auto [end, bad] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (bad == std::errc{} && end == text.data() + text.size() && value >= min) return value;
  return bad_option(key, text, "an integer of at least " + std::to_string(min),
                    std::to_string(min < 1 ? 1 : min));
}

// Parses true/false, 1/0, yes/no or on/off; otherwise OPTION_VALUE.
inline Result<bool> switch_option(std::string_view key, std::string_view text) {
  for (const auto name : {"true", "1", "yes", "on"})
    if (equals_ignoring_case(text, name)) return true;
  for (const auto name : {"false", "0", "no", "off"})
    if (equals_ignoring_case(text, name)) return false;
  return bad_option(key, text, "true or false", "true");
}

// Logs a warning. `known` lists the engine's options.
inline void warn_unknown_option(std::string_view key, std::string_view known) {
  log(WEIR_LOG_WARNING, "the option " + std::string(key) +
                            " is unknown and is ignored; known: " + std::string(known));
}

// ---- Tensor descriptions -----------------------------------------------------------------------

// Returns a description without name, type (WEIR_TYPE_END) and rank (WEIR_RANK_UNKNOWN).
inline weir_tensor_info open_tensor_info() {
  weir_tensor_info info{};
  info.type = WEIR_TYPE_END;
  info.rank = WEIR_RANK_UNKNOWN;
  info.layout = WEIR_LAYOUT_ANY;
  info.batch_axis = WEIR_NO_BATCH_AXIS;
  return info;
}

// Sets rank and shape, outermost first, from `rank` numbers at `first`; `rank` is at most 16.
template <class Iterator>
void set_shape(weir_tensor_info* info, Iterator first, size_t rank) {
  info->rank = static_cast<uint32_t>(rank);
  std::fill(std::copy_n(first, rank, info->shape), std::end(info->shape), 0);
}

// Makes the error MODEL_UNSUPPORTED for the tensor `which` ("an output", "the model's tensor x")
// whose type `offered` no stream can have.
inline Error unsupported_type(const std::string& which, std::string offered, std::string fix,
                              std::string needed = "numbers of 8 to 64 bits, or bool") {
  return Error{.code = Code::MODEL_UNSUPPORTED,
               .what = which + " has a type that streams do not support",
               .offered = std::move(offered),
               .needed = std::move(needed),
               .fix = std::move(fix)};
}

// Makes the error MODEL_UNSUPPORTED for the tensor `which` with a rank above 16.
inline Error unsupported_rank(const std::string& which, long long rank) {
  return Error{.code = Code::MODEL_UNSUPPORTED,
               .what = which + " has too many dimensions",
               .offered = "rank " + std::to_string(rank),
               .needed = "rank 16 at most"};
}

}  // namespace weir::engine
