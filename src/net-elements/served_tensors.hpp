// The tensors of a stream as the Open Inference Protocol describes them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>
#include <vector>

#include "core/tensor/frame_spec.hpp"
#include "net/protocol/oip_messages.hpp"

namespace weir {

// `name` for one tensor, "name_0", "name_1" for several; `names` go before those if there is one
// for each tensor.
std::vector<net::TensorText> describe_tensors(const std::vector<TensorSpec>& tensors,
                                              const std::string& name,
                                              const std::vector<std::string>& names = {});
// A stream that has no tensors, such as image/jpeg or text: one element of bytes.
std::vector<net::TensorText> describe_bytes(const std::string& name);
bool has_tensors(const GstCaps* caps);

}  // namespace weir
