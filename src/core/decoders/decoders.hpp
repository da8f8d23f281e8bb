// The decoders that need no module file.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>

#include "weir/abi.h"

namespace weir::decoders {

// The module with all of them. Also sets the host of this copy of the code, which the decoders
// report their errors to.
const weir_module& builtin_decoders();

// Detections as boxes on a transparent RGBA frame.
const weir_decoder_type& bounding_boxes();
// Class maps and depths of a network as pictures.
const weir_decoder_type& image_segment();
// Key points of a body as lines, dots and names on a transparent frame.
const weir_decoder_type& pose_estimation();
// The best detections as the regions that tensor_crop cuts out.
const weir_decoder_type& tensor_region();

// One decoder for each mode that writes results (weir/results.h): detection, classification,
// segmentation, pose, depth and text.
std::span<const weir_decoder_type* const> results_decoders();
// One for each mode that writes results as text: json, webvtt, coco and mot.
std::span<const weir_decoder_type* const> record_decoders();

}  // namespace weir::decoders
