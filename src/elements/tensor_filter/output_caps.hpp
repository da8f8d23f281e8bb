// The caps that leave tensor_filter.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include "core/tensor/frame_spec.hpp"
#include "elements/tensor_filter/opened_model.hpp"
#include "gstcpp/ref.hpp"
#include "weir/result.hpp"

namespace weir {

// Rule B of the specification: the first of the possible caps for `spec` that the peer of `source`
// takes, fixed. SPEC_MISMATCH with both sides when it takes none.
Result<gst::Ref<GstCaps>> choose_output_caps(GstPad* source, const FrameSpec& spec);

// What a pad of the filter takes or gives: with a model (may be null) what is known of its tensors.
gst::Ref<GstCaps> offered_caps(GstPad* pad, const OpenedModel* model, GstCaps* filter);

}  // namespace weir
