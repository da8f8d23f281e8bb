// The schemes of bounding_boxes for YOLO models.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "core/decoders/box_scheme.hpp"

namespace weir::decoders {

std::unique_ptr<BoxScheme> open_yolov5(const SchemeOptions& options);
std::unique_ptr<BoxScheme> open_yolov8(const SchemeOptions& options);
std::unique_ptr<BoxScheme> open_yolov8_obb(const SchemeOptions& options);
std::unique_ptr<BoxScheme> open_yolov10(const SchemeOptions& options);

}  // namespace weir::decoders
