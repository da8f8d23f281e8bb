// Parses the property accelerator (docs/compatibility/filter.md 4.4): "true:npu,gpu,!cpu.simd".
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "weir/result.hpp"

namespace weir::infer {

struct AcceleratorRequest {
  enum class Kind { EngineDefault, None, Hardware } kind = Kind::EngineDefault;
  // In the user's order, in lower case; empty: the engine's automatic choice.
  std::vector<std::string> names, excluded;
};

// Parses (true|false)[:acc[,acc...]], with the list optionally in parentheses, ignoring case; "" =
// the engine's default. Text that does not match selects no accelerator and sets `warning` (may be
// null).
AcceleratorRequest parse_accelerator(std::string_view text,
                                     std::optional<Error>* warning = nullptr);

// Returns the value of weir_open.accelerator: "" = the engine's default, "none", "auto", or names.
// `supported` is the engine's list, its automatic choice first. The result is the first requested
// name in it, otherwise the automatic choice. For an engine without a list it is all preferences,
// "npu,gpu".
std::string choose_accelerator(const AcceleratorRequest& request,
                               const std::vector<std::string>& supported);

// OPTION_VALUE when the engine supports none of the hardware that the request names, so that
// another is used; nullopt otherwise, and for an engine without a list. `text` is the property.
std::optional<Error> unavailable_hardware(const AcceleratorRequest& request,
                                          const std::vector<std::string>& supported,
                                          std::string_view engine, std::string_view text);

// The number of a name; names with the same number are the same hardware.
std::optional<unsigned> accelerator_number(std::string_view name) noexcept;

}  // namespace weir::infer
