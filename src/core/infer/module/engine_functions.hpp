// Calls optional functions of an engine, including those newer than its version of the table.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::infer {

// A function of the engine's table; null if it is not set or the table ends before it.
template <typename Function>
Function get_function(const weir_engine& engine, Function weir_engine::*member) noexcept {
  static constexpr weir_engine kTable{};
  const auto* const begin = reinterpret_cast<const char*>(&kTable);
  const auto* const end = reinterpret_cast<const char*>(&(kTable.*member) + 1);
  return engine.struct_size >= static_cast<size_t>(end - begin) ? engine.*member : nullptr;
}

// Calls weir_engine::control; `option` may be null. Fails for an engine that does not support
// control or this order.
Status give_order(const weir_engine& engine, weir_session* session, int order,
                  const weir_option* option);

}  // namespace weir::infer
