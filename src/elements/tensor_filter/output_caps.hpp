// The output caps of tensor_filter, and its answers to caps queries.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include "core/tensor/frame_spec.hpp"
#include "elements/tensor_filter/open_model.hpp"
#include "gstcpp/element/ref.hpp"
#include "weir/result.hpp"

namespace weir {

// Rule B of docs/compatibility/types-and-caps.md 1.5: the first of the possible caps for `spec`
// that the peer of `source` accepts, fixed. SPEC_MISMATCH with both sides if it accepts none.
Result<gst::Ref<GstCaps>> choose_output_caps(GstPad* source, const FrameSpec& spec);

// Answers a CAPS query on a pad of the filter from what is known of the model's tensors; `model`
// may be null. False for any other query.
bool answer_caps_query(GstPad* pad, const OpenModel* model, GstQuery* query);

}  // namespace weir
