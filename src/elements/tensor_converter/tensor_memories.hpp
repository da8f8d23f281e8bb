// Gives an output buffer one memory per tensor.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <vector>

#include "core/ledger/ledger.hpp"
#include "core/tensor/frame_spec.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir {

// Returns a buffer with one memory per tensor: `in` itself if its memories match, else one that
// shares with it; otherwise its memories are merged first, counted as copied. More than 16 tensors
// stay in one memory. Metadata is copied.
Result<gst::Ref<GstBuffer>> one_memory_each(gst::Ref<GstBuffer> in,
                                            const std::vector<TensorSpec>& tensors, Ledger* ledger);

}  // namespace weir
