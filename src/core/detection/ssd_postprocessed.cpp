// Reads the rows of TFLite_Detection_PostProcess.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/detection/ssd_postprocessed.hpp"

#include <algorithm>

namespace weir::detection {

Candidates decode(const PostprocessedSsd& head, float threshold, PictureSize picture) {
  const auto width = static_cast<float>(picture.width), height = static_cast<float>(picture.height);
  const auto part = [](float value) { return std::clamp(value, 0.f, 1.f); };
  const size_t rows =
      head.count > 0
          ? static_cast<size_t>(std::min(head.count, static_cast<float>(head.scores.size())))
          : 0;
  Candidates found;
  for (size_t i = 0; i < rows; ++i) {
    const float score = head.scores[i];
    if (!(score >= threshold && std::isfinite(score)) || !(std::abs(head.classes[i]) < 1 << 24))
      continue;
    const auto box = head.boxes.subspan(4 * i, 4);
    if (!std::all_of(box.begin(), box.end(), [](float value) { return std::isfinite(value); }))
      continue;
    const float top = part(box[0]), left = part(box[1]);
    const float bottom = part(box[2]), right = part(box[3]);
    found.push_back({.x = left * width,
                     .y = top * height,
                     .width = (right - left) * width,
                     .height = (bottom - top) * height,
                     .score = score,
                     .class_index = static_cast<int32_t>(head.classes[i]),
                     .row = static_cast<uint32_t>(i)});
  }
  return found;
}

}  // namespace weir::detection
