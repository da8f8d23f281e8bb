// Reads the boxes of detectors by the layout of their rows: YOLO v5, v8 and v10, OpenVINO, and SSD
// models that end in TFLite_Detection_PostProcess.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>

#include "core/detection/candidate.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::detection {

// Heads of YOLOv5: rows of centre x, centre y, width, height, objectness and one score per class.

// The unit of the coordinates of a YOLO head.
enum class YoloUnit {
  Picture,  // 0 to 1 across the picture
  Pixels    // of the model's input
};

// Returns the rows whose probability (best class times objectness) is above `threshold`, in their
// order. Boxes and probabilities that are not finite are left out.
Candidates decode_yolov5(std::span<const float> rows, size_t classes, float threshold,
                         YoloUnit unit, Size picture);
// Rows that a YOLOv5 or YOLOv8 model of this input size has: `anchors` (3 or 1) of each cell of
// the grids with 32, 16 and 8 pixels a cell.
size_t yolo_rows(Size picture, size_t anchors) noexcept;

// Heads of YOLOv8: rows of centre x, centre y, width, height, one score per class and, for oriented
// boxes, the angle. Models give columns: transpose their output first.

// Returns the rows whose best class is above `threshold`, in their order. Boxes and scores that are
// not finite are left out.
Candidates decode_yolov8(std::span<const float> rows, size_t classes, float threshold,
                         YoloUnit unit, Size picture);
// The same for oriented boxes: x and y of the candidates are the centre.
Candidates decode_yolov8_obb(std::span<const float> rows, size_t classes, float threshold,
                             YoloUnit unit, Size picture);

// Heads of YOLOv10: rows of x1, y1, x2, y2 (0 to 1 across the picture), score and class, sorted by
// score and already free of duplicates.

inline constexpr size_t kYolov10Row = 6;

// Returns the rows before the first with a score below `threshold`, in their order. Rows with
// values that are not finite are left out.
Candidates decode_yolov10(std::span<const float> rows, float threshold, Size picture);

// Outputs of OpenVINO's person and face detectors: records of picture, class, score and box.

inline constexpr size_t kOpenvinoRecord = 7;

// Reads records of picture index, class, score, xmin, ymin, xmax, ymax (0 to 1 across the picture)
// up to the first with a negative picture index. Returns those with a score of at least
// `threshold`, in their order. Records that are not finite are left out.
Candidates decode_openvino(std::span<const float> records, float threshold, Size picture);

// SSD models whose graph ends in TFLite_Detection_PostProcess: boxes are decoded and suppressed.

struct PostprocessedSsd {
  std::span<const float> boxes;  // ymin, xmin, ymax, xmax of each row, as parts of the picture
  std::span<const float> classes, scores;  // one of each row
  float count = 0;                         // rows that are detections
};

// Returns the rows with a score of at least `threshold`, in their order, clamped to the picture.
// Rows with values that are not finite are left out. Precondition: as many classes and boxes as
// scores.
Candidates decode(const PostprocessedSsd& head, float threshold, Size picture);

}  // namespace weir::detection
