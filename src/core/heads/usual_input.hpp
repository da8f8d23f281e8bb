// How models of a family usually take their pixels, for models without a card.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "core/card/card.hpp"
#include "weir/abi.h"

namespace weir::heads {

// Of a model whose outputs are of no known family.
inline constexpr std::string_view kUnknownFamily = "unknown";

// The picture input that `info` describes, with the family's usual colours, scale and fit. nullopt
// if it is not a picture's tensor. `note` says in words what was assumed.
std::optional<card::ImageInput> usual_input(std::string_view family, const weir_tensor_info& info,
                                            std::string* note);

// Fills the open extents of a picture's tensor: its sides with those of the model's metadata, or
// of published models (640).
void set_open_sides(const char* metadata_json, weir_tensor_info* info);

}  // namespace weir::heads
