// ForwardingEngine: an engine whose models are another engine's, chosen when they are opened.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::custom {

// What open() found: the engine, who keeps its table, and how many of the paths were used to find
// it; the others are the engine's.
struct FoundEngine {
  const weir_engine* engine = nullptr;
  std::shared_ptr<const void> owner;
  uint32_t paths_used = 1;
};
using FindEngine = Result<FoundEngine> (*)(const weir_open& request);

// The functions of a table over `Find`; name and flags are the caller's to fill.
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
