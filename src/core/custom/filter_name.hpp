// What registered filters and classes have in common: their names, and how refusals are answered.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <exception>
#include <memory>
#include <string>

#include "core/infer/host.hpp"
#include "core/text/text.hpp"

namespace weir::custom {

inline constexpr char kNameNeeded[] = "a name without a comma that is not auto or any";
inline constexpr char kNameFree[] = "a name of its own; unregister the other one first";

inline bool can_be_a_name(const std::string& name) {
  return !name.empty() && name.find(',') == std::string::npos &&
         !equal_ignoring_case(name, "auto") && !equal_ignoring_case(name, "any");
}

// What a function of the C interface returns for the Status of `body`; its words go to *error.
template <class Body>
int answer(weir_error** error, Body&& body) noexcept {
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
