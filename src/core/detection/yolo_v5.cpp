// Decodes heads of YOLOv5.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/detection/yolo_v5.hpp"

#include "core/detection/best_class.hpp"

namespace weir::detection {

Candidates decode_yolov5(std::span<const float> rows, size_t classes, float threshold,
                         YoloUnit unit, PictureSize picture) {
  constexpr size_t kFixed = 5;
  const size_t length = kFixed + classes;
  const bool scales = unit == YoloUnit::Picture;
  const float to_x = scales ? static_cast<float>(picture.width) : 1;
  const float to_y = scales ? static_cast<float>(picture.height) : 1;
  Candidates found;
  for (size_t i = 0; i < rows.size() / length; ++i) {
    const auto row = rows.subspan(i * length, length);
    const auto scores = row.subspan(kFixed);
    const float best = best_score(scores), probability = best * row[4];
    if (!(probability > threshold)) continue;
    const float width = row[2] * to_x, height = row[3] * to_y;
    const Candidate candidate{.x = row[0] * to_x - width / 2,
                              .y = row[1] * to_y - height / 2,
                              .width = width,
                              .height = height,
                              .score = probability,
                              .class_index = class_with(scores, best),
                              .row = static_cast<uint32_t>(i)};
    if (candidate.is_finite()) found.push_back(candidate);
  }
  return found;
}

size_t yolo_rows(PictureSize picture, size_t anchors) noexcept {
  size_t cells = 0;
  for (const size_t stride : {32, 16, 8})
    cells += (picture.width / stride) * (picture.height / stride);
  return anchors * cells;
}

}  // namespace weir::detection
