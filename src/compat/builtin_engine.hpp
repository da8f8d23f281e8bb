// What the descriptors of both versions share: an engine's hardware, and which version it has.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compat/builtin_model.hpp"
#include "weir/result.hpp"

namespace weir::compat {

inline BuiltinModel* opened_filter(void* priv) {
  return static_cast<BuiltinModel*>(priv);
}

inline void close_filter(const GstTensorFilterProperties*, void** priv) {
  if (priv) delete opened_filter(std::exchange(*priv, nullptr));
}

// Returns the paths without null pointers.
std::vector<std::string> file_paths(const char* const* files, int count);

// Returns the engine's hardware; one list per engine, never freed.
const std::vector<accl_hw>& list_hardware(const weir_engine& engine);
bool runs_on(const weir_engine& engine, accl_hw hw);

// The members that a descriptor of version 0 has in NNStreamer (docs/compatibility/programs.md).
struct V0Members {
  std::string_view engine;
  const char* name;
  bool allocates, verifies;
  bool sets_inputs, resizes_inputs, reloads, lists_hardware, has_statistics;
};
// Returns null for an engine whose descriptor has version 1.
const V0Members* find_v0_members(std::string_view engine);
Result<const GstTensorFilterFramework*> builtin_filter_v0(const weir_engine& engine,
                                                          const V0Members& members);

}  // namespace weir::compat
