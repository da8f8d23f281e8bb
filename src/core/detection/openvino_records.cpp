// Decodes the records of OpenVINO's detectors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/detection/openvino_records.hpp"

#include <algorithm>

namespace weir::detection {

Candidates decode_openvino(std::span<const float> records, float threshold, PictureSize picture) {
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

}  // namespace weir::detection
