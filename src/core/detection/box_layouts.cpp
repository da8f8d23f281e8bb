// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/detection/box_layouts.hpp"

#include <algorithm>

#include "core/detection/best_class.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::detection {
namespace {

constexpr size_t kFixed = 4;

Candidates decode_rows(std::span<const float> rows, size_t classes, bool is_oriented,
                       float threshold, YoloUnit unit, Size picture) {
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

Candidates decode_yolov5(std::span<const float> rows, size_t classes, float threshold,
                         YoloUnit unit, Size picture) {
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

size_t yolo_rows(Size picture, size_t anchors) noexcept {
  size_t cells = 0;
  for (const size_t stride : {32, 16, 8})
    cells += (picture.width / stride) * (picture.height / stride);
  return anchors * cells;
}

Candidates decode_yolov8(std::span<const float> rows, size_t classes, float threshold,
                         YoloUnit unit, Size picture) {
  return decode_rows(rows, classes, false, threshold, unit, picture);
}

Candidates decode_yolov8_obb(std::span<const float> rows, size_t classes, float threshold,
                             YoloUnit unit, Size picture) {
  return decode_rows(rows, classes, true, threshold, unit, picture);
}

Candidates decode_yolov10(std::span<const float> rows, float threshold, Size picture) {
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

Candidates decode_openvino(std::span<const float> records, float threshold, Size picture) {
  const auto width = static_cast<float>(picture.width), height = static_cast<float>(picture.height);
  Candidates found;
  for (size_t i = 0; i < records.size() / kOpenvinoRecord; ++i) {
    const auto record = records.subspan(i * kOpenvinoRecord, kOpenvinoRecord);
    if (record[0] < 0) break;
    const bool is_finite =
        std::all_of(record.begin(), record.end(), [](float value) { return std::isfinite(value); });
    if (!is_finite || record[2] < threshold || !(std::abs(record[1]) < 1 << 24)) continue;
    const Candidate candidate{.x = record[3] * width,
                              .y = record[4] * height,
                              .width = (record[5] - record[3]) * width,
                              .height = (record[6] - record[4]) * height,
                              .score = record[2],
                              .class_index = static_cast<int32_t>(record[1]),
                              .row = static_cast<uint32_t>(i)};
    if (candidate.is_finite()) found.push_back(candidate);
  }
  return found;
}

Candidates decode(const PostprocessedSsd& head, float threshold, Size picture) {
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
