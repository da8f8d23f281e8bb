// Matches the tensors of a stream and the user's settings with what a model declares.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "core/tensor/model_tensor.hpp"

namespace weir {

// Fills the model's open parts from the stream's tensors, with the model's exact rank. A model
// without tensors leaves their number open. Mismatching counts, types or dimensions are a
// SPEC_MISMATCH with a line to paste.
Result<std::vector<ModelTensor>> fit(const std::vector<ModelTensor>& model,
                                     const std::vector<TensorSpec>& stream);

// Merges the user's input= and inputtype= (or output...) with the model's declaration. Parts that
// contradict the model are a SPEC_MISMATCH that names `property`.
Result<std::vector<ModelTensor>> with_user_settings(std::vector<ModelTensor> model,
                                                    const std::string& dimensions,
                                                    const std::string& types,
                                                    const std::string& property);

// Whether a tensor has the dimensions of a picture: colours, width, height or width, height,
// colours, innermost first.
bool looks_like_picture(const TensorSpec& tensor);

// A gst-launch fragment that converts `offered` to `needed`, "" if none is known. `is_video`:
// whether the elements of the stream may be replaced by others that read video.
std::string suggested_fix(const TensorSpec& offered, const ModelTensor& needed, bool is_video);

}  // namespace weir
