// The properties of tensor_filter that decide which model is opened and how. They may change while
// frames flow and apply from the next frame on.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string_view>

#include "elements/tensor_filter/filter_settings.hpp"
#include "weir/result.hpp"

namespace weir {

// Whether a change of the property reopens the model.
bool requires_reopen(std::string_view property);
// Rejects lists that cannot be parsed, whatever the model is.
Status check_lists(const FilterSettings& settings);

}  // namespace weir
