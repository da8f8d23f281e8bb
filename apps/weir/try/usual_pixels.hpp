// How models of a family usually take their pixels, for models without a card.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "core/card/card.hpp"
#include "launch/pipeline_description.hpp"
#include "weir/abi.h"

namespace weir::app {

// The picture input that `info` describes, with the family's usual colours, scale and fit; open
// sizes become those of published models (640). nullopt if it is not a picture's tensor. `note`
// says in words what was assumed.
std::optional<card::ImageInput> usual_pixels(std::string_view family, const weir_tensor_info& info,
                                             std::string* note);

// Returns the properties of tensor_preprocess for an input: width, height, fit, ...
Properties preprocess_properties(const card::ImageInput& input);

}  // namespace weir::app
