// The schemes of bounding_boxes for SSD models.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "core/decoders/box_scheme.hpp"

namespace weir::decoders {

std::unique_ptr<BoxScheme> open_mobilenet_ssd(const SchemeOptions& options);
// Takes the first class of each anchor that reaches the threshold, not the best one.
std::unique_ptr<BoxScheme> open_mobilenet_ssd_of_first_class(const SchemeOptions& options);
std::unique_ptr<BoxScheme> open_mobilenet_ssd_postprocess(const SchemeOptions& options);

}  // namespace weir::decoders
