// ForwardingEngine: an engine that chooses another engine when a model is opened.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::custom {

// The result of open(): the engine, the owner of its table, and the number of paths used to find
// it; the others are passed to the engine.
struct FoundEngine {
  const weir_engine* engine = nullptr;
  std::shared_ptr<const void> owner;
  uint32_t paths_used = 1;
};
using FindEngine = Result<FoundEngine> (*)(const weir_open& request);

// A table that uses `Find`; the caller sets name and flags.
template <FindEngine Find>
weir_engine forwarding_table();

// Parts of forwarding_table().
int forward_open(FindEngine find, const weir_open* request, weir_model** out, weir_error* error);
weir_engine forwarding_functions();

template <FindEngine Find>
weir_engine forwarding_table() {
  weir_engine table = forwarding_functions();
  table.open = [](const weir_open* request, weir_model** out, weir_error* error) {
    return forward_open(Find, request, out, error);
  };
  return table;
}

}  // namespace weir::custom
