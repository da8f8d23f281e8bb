// What maps over the picture come to in a few numbers: the parts of classes, the range of depths.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <vector>

#include "core/records/result_frame.hpp"

namespace weir::records {

struct ClassPart {
  uint32_t class_index = 0;
  double part = 0;  // of the picture, 0 to 1
};
// The part of each class that occurs, in ascending order. With `map`, which leads to the picture,
// cells whose centre is outside of it do not count, such as those of a letterbox.
std::vector<ClassPart> parts_of_classes(const ClassMapView& classes,
                                        const std::optional<SourceMap>& map);

struct DepthRange {
  float min = 0, max = 0;
  double mean = 0;
};
// Statistics of the cells in the picture, as above; numbers that are not finite do not count. All 0
// without any.
DepthRange range_of_depths(const DepthView& depths, const std::optional<SourceMap>& map);

}  // namespace weir::records
