// Regions of interest (GstVideoRegionOfInterestMeta) with the parameters of results.
//
// The parameters of a region are structures:
//   detection   label_id (int), confidence and score (double), model_name (string), x_min, y_min,
//               x_max, y_max (double): parts of the picture's width and height
//   object_id   id (int): the track
//   weir        box and keypoints (arrays of double), rotation (double): see region_meta.cpp;
//               analytics-id (int): the id of the object in GstAnalyticsRelationMeta
// DL Streamer writes and reads detection and object_id.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/video/gstvideometa.h>

#include <optional>
#include <string>
#include <vector>

#include "core/tensor/geometry.hpp"
#include "gstcpp/buffer/picture_results.hpp"

namespace weir::gst {

// The smallest rectangle of whole pixels around the part of the box inside the picture; nullopt for
// a box outside of it.
std::optional<Rect> visible_part(const Box& box, Size picture);
struct RegionIds {
  int id = 1;      // above 0
  int parent = 0;  // 0 = none
  std::optional<uint32_t> analytics{};
};
// Adds a region with the rectangle `at` to a writable buffer.
GstVideoRegionOfInterestMeta* add_region(GstBuffer* buffer, const PictureRegion& region,
                                         const Rect& at, Size picture, const RegionIds& ids);
// An id above those of the buffer's regions.
int next_region_id(GstBuffer* buffer);
// A parameter of a label or text that belongs to the region: label and label_id, or text.
void add_region_label(GstVideoRegionOfInterestMeta* region, const std::string& label,
                      int32_t class_index, float score, const std::string& model);
void add_region_text(GstVideoRegionOfInterestMeta* region, const std::string& text, float score,
                     const std::string& model);

// The regions of a buffer in the order of their metas.
std::vector<PictureRegion> get_regions(GstBuffer* buffer, uint32_t width, uint32_t height);

}  // namespace weir::gst
