// Which properties of tensor_filter decide what model is opened and how: they may change while
// frames flow, and take effect with the next one.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string_view>

#include "elements/tensor_filter/filter_settings.hpp"
#include "weir/result.hpp"

namespace weir {

bool opens_the_model(std::string_view property);
// An error for lists that cannot be read, whatever the model is.
Status check_lists(const FilterSettings& settings);

}  // namespace weir
