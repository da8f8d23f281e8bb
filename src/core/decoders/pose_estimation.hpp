// The decoder pose_estimation: key points of a body as lines, dots and names on a transparent
// frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "weir/abi.h"

namespace weir::decoders {

const weir_decoder_type& pose_estimation();

}  // namespace weir::decoders
