// Decodes heads of YOLOv8, upright and oriented.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/detection/yolo_v8.hpp"

#include "core/detection/best_class.hpp"

namespace weir::detection {
namespace {

constexpr size_t kFixed = 4;

Candidates decode_rows(std::span<const float> rows, size_t classes, bool is_oriented,
                       float threshold, YoloUnit unit, PictureSize picture) {
  const size_t length = kFixed + classes + (is_oriented ? 1 : 0);
  const bool scales = unit == YoloUnit::Picture;
  const float to_x = scales ? static_cast<float>(picture.width) : 1;
  const float to_y = scales ? static_cast<float>(picture.height) : 1;
  Candidates found;
  for (size_t i = 0; i < rows.size() / length; ++i) {
    const auto row = rows.subspan(i * length, length);
    const auto scores = row.subspan(kFixed, classes);
    const float best = best_score(scores);
    if (!(best > threshold)) continue;
    const float width = row[2] * to_x, height = row[3] * to_y;
    const Candidate candidate{.x = row[0] * to_x - (is_oriented ? 0 : width / 2),
                              .y = row[1] * to_y - (is_oriented ? 0 : height / 2),
                              .width = width,
                              .height = height,
                              .score = best,
                              .class_index = class_with(scores, best),
                              .row = static_cast<uint32_t>(i),
                              .angle = is_oriented ? row[length - 1] : 0};
    if (candidate.is_finite()) found.push_back(candidate);
  }
  return found;
}

}  // namespace

Candidates decode_yolov8(std::span<const float> rows, size_t classes, float threshold,
                         YoloUnit unit, PictureSize picture) {
  return decode_rows(rows, classes, false, threshold, unit, picture);
}

Candidates decode_yolov8_obb(std::span<const float> rows, size_t classes, float threshold,
                             YoloUnit unit, PictureSize picture) {
  return decode_rows(rows, classes, true, threshold, unit, picture);
}

}  // namespace weir::detection
