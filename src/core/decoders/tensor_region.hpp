// The decoder tensor_region: the best detections as the regions that tensor_crop cuts out.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "weir/abi.h"

namespace weir::decoders {

const weir_decoder_type& tensor_region();

}  // namespace weir::decoders
