// The decoder "bounding_boxes": detections as boxes on a transparent RGBA frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "weir/abi.h"

namespace weir::decoders {

const weir_decoder_type& bounding_boxes();

}  // namespace weir::decoders
