// The memories of an output buffer: one for each tensor.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <vector>

#include "core/ledger/ledger.hpp"
#include "core/tensor/frame_spec.hpp"
#include "gstcpp/ref.hpp"

namespace weir {

// A buffer with one memory for each tensor: `in` itself where its memories lie so, else shared with
// it; a buffer whose memories lie otherwise is gathered first, which counts as copied. More than 16
// tensors stay in one memory. Metadata are copied.
Result<gst::Ref<GstBuffer>> one_memory_each(gst::Ref<GstBuffer> in,
                                            const std::vector<TensorSpec>& tensors, Ledger* ledger);

}  // namespace weir
