// Formats faces as one JSON list.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <string>

#include "cascade.hpp"

namespace mtcnn {

// [{"box": [x1, y1, x2, y2], "score": s, "landmarks": [[x, y], ...]}, ...] in pixels.
std::string faces_text(std::span<const Face> faces);
// Converts all rows of weir/detection.hpp with five key points.
std::vector<Face> faces_of_rows(std::span<const float> rows);

}  // namespace mtcnn
