// Decodes heads of YOLOv10.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/detection/yolo_v10.hpp"

#include <algorithm>

namespace weir::detection {

Candidates decode_yolov10(std::span<const float> rows, float threshold, PictureSize picture) {
  const auto width = static_cast<float>(picture.width), height = static_cast<float>(picture.height);
  Candidates found;
  for (size_t i = 0; i < rows.size() / kYolov10Row; ++i) {
    const auto row = rows.subspan(i * kYolov10Row, kYolov10Row);
    if (row[4] < threshold) break;
    const bool is_finite =
        std::all_of(row.begin(), row.end(), [](float value) { return std::isfinite(value); });
    if (!is_finite || !(std::abs(row[5]) < 1 << 24)) continue;
    const Candidate candidate{.x = row[0] * width,
                              .y = row[1] * height,
                              .width = (row[2] - row[0]) * width,
                              .height = (row[3] - row[1]) * height,
                              .score = row[4],
                              .class_index = static_cast<int32_t>(row[5]),
                              .row = static_cast<uint32_t>(i)};
    if (candidate.is_finite()) found.push_back(candidate);
  }
  return found;
}

}  // namespace weir::detection
