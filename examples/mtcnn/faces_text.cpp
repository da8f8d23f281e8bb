// Formats faces as JSON.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "faces_text.hpp"

#include <cstdio>

#include "weir/join.hpp"

namespace mtcnn {
namespace {

std::string number(float value, const char* format) {
  char text[32];
  std::snprintf(text, sizeof text, format, static_cast<double>(value));
  return text;
}

}  // namespace

std::string faces_text(std::span<const Face> faces) {
  const auto to_text = [](const Face& face) {
    const weir::Box& box = face.box;
    std::string out = "{\"box\": [" + number(box.x1, "%.1f") + ", " + number(box.y1, "%.1f") +
                      ", " + number(box.x2, "%.1f") + ", " + number(box.y2, "%.1f") +
                      "], \"score\": " + number(face.score, "%.4f") + ", \"landmarks\": [";
    for (size_t p = 0; p < kPoints; ++p)
      out += (p ? ", [" : "[") + number(face.points[2 * p], "%.1f") + ", " +
             number(face.points[2 * p + 1], "%.1f") + "]";
    return out + "]}";
  };
  return "[" + weir::join(faces, ", ", to_text) + "]";
}

std::vector<Face> faces_of_rows(std::span<const float> rows) {
  constexpr size_t kLength = weir::DetectionRow<const float>::length(kPoints);
  std::vector<Face> out;
  for (size_t at = 0; at + kLength <= rows.size(); at += kLength) {
    const weir::DetectionRow row(rows.subspan(at, kLength));
    if (!(row.score() > 0)) continue;
    Face face{row.box(), row.score(), {}};
    for (size_t p = 0; p < kPoints; ++p)
      face.points[2 * p] = row.x(p), face.points[2 * p + 1] = row.y(p);
    out.push_back(face);
  }
  return out;
}

}  // namespace mtcnn
