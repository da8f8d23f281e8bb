// How models of a family usually take their pixels, for models without a card, and the shapes of
// models that leave them open.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/card/card.hpp"
#include "core/infer/model/model.hpp"
#include "launch/pipeline_description.hpp"
#include "weir/abi.h"

namespace weir::app {

// The picture input that `info` describes, with the family's usual colours, scale and fit. nullopt
// if it is not a picture's tensor. `note` says in words what was assumed.
std::optional<card::ImageInput> default_image_input(std::string_view family,
                                                    const weir_tensor_info& info,
                                                    std::string* note);

// Returns the properties of tensor_preprocess for an input: width, height, fit, ...
Properties preprocess_properties(const card::ImageInput& input);

// The model's inputs with `shape` for the first one, else with the sizes of its metadata for open
// extents, or those of published models (640).
std::vector<weir_tensor_info> sized_inputs(const infer::Model& model,
                                           const std::vector<int64_t>& shape);

// The outputs of the model for these inputs. Runs the model once on zeros if its outputs have open
// extents; where that fails, they stay open.
std::vector<weir_tensor_info> sized_outputs(const infer::Model& model, const std::string& path,
                                            const std::vector<weir_tensor_info>& inputs);

}  // namespace weir::app
