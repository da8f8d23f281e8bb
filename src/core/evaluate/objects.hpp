// Objects of pictures: those that the truth has and those that a pipeline found.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <vector>

namespace weir::evaluate {

// A box in pixels, as files of COCO and MOTChallenge have it.
struct Rectangle {
  double x = 0, y = 0, width = 0, height = 0;
  double area() const noexcept { return width * height; }
  bool operator==(const Rectangle&) const = default;
};

struct LabelledPoint {
  double x = 0, y = 0;
  bool is_labelled = false;  // visibility 1 or 2 in COCO's files; whether a found object has it
};

struct TruthObject {
  size_t category = 0;  // an index, not the id of a file
  Rectangle box;
  double area = 0;          // of the object's outline, which is usually less than that of its box
  bool is_crowd = false;    // the box of many objects: finding any of them is no error
  bool is_ignored = false;  // finding it is no error, missing it neither; crowds are ignored too
  std::vector<LabelledPoint> points;
};

struct FoundObject {
  size_t category = 0;
  Rectangle box;
  double score = 0;
  std::vector<LabelledPoint> points;
};

struct PictureObjects {
  std::vector<TruthObject> truth;
  std::vector<FoundObject> found;
};

}  // namespace weir::evaluate
