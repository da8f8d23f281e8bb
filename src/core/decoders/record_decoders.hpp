// The modes that write results (weir/results.h) as text: json, webvtt, coco and mot.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>

#include "weir/abi.h"

namespace weir::decoders {

// One decoder for each mode.
std::span<const weir_decoder_type* const> record_decoders();

}  // namespace weir::decoders
