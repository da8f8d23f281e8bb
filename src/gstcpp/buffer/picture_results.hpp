// PictureResults: results in the form in which metadata of pictures has them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/video/gstvideometa.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/results/frame_results.hpp"
#include "core/results/region_grid.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::gst {

// The numbers of regions, for each cell of a grid over a part of the picture.
struct Segmentation {
  Ref<GstBuffer> mask{};                     // of make_mask(); null = none
  Box box{};                                 // the part, in pixels of the picture
  std::map<uint32_t, std::string> labels{};  // of the regions, by number
};

// A buffer that elements of GStreamer read: GRAY8 or GRAY16 with GstVideoMeta.
Ref<GstBuffer> make_mask(const results::RegionGrid& grid);
// Empty for a buffer that is null, has another format or is smaller than its metadata.
results::RegionGrid read_mask(GstBuffer* mask);

struct PictureRegion {
  std::string label;
  Box box{};  // pixels of the picture
  std::optional<float> score{};
  int32_t class_index = -1;  // -1 = unknown
  uint32_t track = 0;
  float rotation = 0;
  int32_t parent = -1;  // index of another region; -1 = none
  std::vector<results::KeyPoint> points;
  std::string model;                       // "" = unknown
  Segmentation mask{};                     // cells that are not 0 belong to the region
  std::optional<uint32_t> analytics_id{};  // of its entry in GstAnalyticsRelationMeta
};

// Of `object` for an empty label.
GQuark make_quark(const std::string& label);

// A label or a text, of a region or of the whole picture.
struct RegionLabel {
  int32_t region = -1;  // index; -1 = the picture
  bool is_text = false;
  std::string text, model;
  int32_t class_index = -1;
  float score = 0;
};

struct PictureResults {
  std::vector<PictureRegion> regions;
  std::vector<RegionLabel> labels;
  // The numbers are those of classes; boxes are in parts of the picture's width and height.
  std::vector<Segmentation> class_maps;
};

}  // namespace weir::gst
