// Names of registered filters and classes, and return values of the C API.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <exception>
#include <memory>
#include <string>

#include "core/infer/module/host.hpp"
#include "core/text/text.hpp"

namespace weir::custom {

inline constexpr char kNameNeeded[] = "a name without a comma that is not auto or any";
inline constexpr char kNameFree[] = "an unused name; or unregister the other one first";

inline bool can_be_a_name(const std::string& name) {
  return !name.empty() && name.find(',') == std::string::npos &&
         !equal_ignoring_case(name, "auto") && !equal_ignoring_case(name, "any");
}

// The C return value for the Status of `body`; stores the error in *error.
template <class Body>
int to_return_code(weir_error** error, Body&& body) noexcept {
  if (error) *error = nullptr;
  try {
    const Status status = body();
    if (status) return WEIR_OK;
    if (error) *error = std::make_unique<weir_error>(weir_error{status.error(), true}).release();
    return -static_cast<int>(status.error().code);
  } catch (const std::bad_alloc&) {
    return -WEIR_OUT_OF_MEMORY;
  } catch (const std::exception&) {
    return -WEIR_INTERNAL;
  }
}

}  // namespace weir::custom
