// Corrects the fix of a stream that does not fit a model that has a card.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "core/tensor/model_tensor.hpp"
#include "weir/result.hpp"

namespace weir {

// `error` is that of fit(). Elements that only convert the type and the size leave out the mean and
// the scale of the model's card: if a card describes `inputs`, the fix is tensor_preprocess with
// it. Reads the model's file.
Error with_card(Error error, const std::string& model_path, const std::vector<ModelTensor>& inputs);

}  // namespace weir
