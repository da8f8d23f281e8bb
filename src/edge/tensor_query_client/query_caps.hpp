// The caps of a query client and those that its server announces.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include "core/wire/edge_texts.hpp"
#include "gstcpp/element/ref.hpp"
#include "weir/result.hpp"

namespace weir {

// The caps of the answers to frames of `input`. A frame rate that the server leaves open is that of
// `input`. SPEC_MISMATCH if the server does not take `input`, whatever its frame rate;
// PEER_MESSAGE_INVALID if the server announces no caps, or several for its answers.
Result<gst::Ref<GstCaps>> answer_caps(const wire::QueryCapability& capability,
                                      const GstCaps* input);

}  // namespace weir
