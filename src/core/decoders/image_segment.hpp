// The decoder image_segment: class maps and depths of a network as pictures.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "weir/abi.h"

namespace weir::decoders {

const weir_decoder_type& image_segment();

}  // namespace weir::decoders
