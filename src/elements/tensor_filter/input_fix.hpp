// What to paste when a stream does not fit a model.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "elements/tensor_filter/open_model.hpp"

namespace weir {

// `error` is that of a plan or a frame with these tensors. If the stream does not fit a model of
// pictures, the fix prepares pictures as the model's card describes, or else as `weir try` does:
// with the size, order and range of values. Reads the model's file. Other errors are returned as
// they are.
Error with_input_fix(Error error, const OpenModel& model, const std::vector<TensorSpec>& stream,
                     gst::Medium medium);

}  // namespace weir
