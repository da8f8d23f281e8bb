// Reads annotation files of COCO: boxes and key points of pictures, as JSON.
// https://cocodataset.org/#format-data
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/evaluate/objects.hpp"
#include "weir/result.hpp"

namespace weir::evaluate {

struct CocoPicture {
  std::string file;                // as the annotations name it
  uint32_t width = 0, height = 0;  // 0: the annotations do not have it
  std::vector<TruthObject> objects;
};

struct CocoTruth {
  std::vector<std::string> categories;  // by rising id
  std::vector<CocoPicture> pictures;    // in the order of the file
  size_t key_points = 0;                // of an object; 0: boxes only
  std::vector<Error> warnings;          // about boxes that reach outside of their pictures
};

// `path` is for messages. LABELS_INVALID, with the entry, for a text that is not JSON or no such
// file, and for truth that contradicts itself: ids that occur twice, annotations of unknown
// pictures or categories, boxes without area or outside of their picture, key points that do not
// fit.
Result<CocoTruth> parse_coco_truth(const std::string& path, std::string_view text);

}  // namespace weir::evaluate
