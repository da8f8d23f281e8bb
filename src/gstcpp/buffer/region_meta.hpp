// Regions of interest (GstVideoRegionOfInterestMeta) with the parameters of results.
//
// The parameters of a region are structures:
//   detection   label_id (int), confidence and score (double), model_name (string), x_min, y_min,
//               x_max, y_max (double): parts of the picture's width and height
//   object_id   id (int): the track
//   weir        box and keypoints (arrays of double), rotation (double): see region_meta.cpp;
//               analytics (int): the id of the object in GstAnalyticsRelationMeta
// DL Streamer writes and reads detection and object_id.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/video/gstvideometa.h>

#include <string>
#include <vector>

#include "gstcpp/buffer/picture_results.hpp"

namespace weir::gst {

// Whether a part of the box lies inside the picture.
bool is_inside(const Box& box, uint32_t width, uint32_t height);
// Adds a region to a writable buffer of a picture of width * height; the rectangle is the smallest
// one of whole pixels around the part of the box inside the picture. `id` is above 0; the parent's
// is 0 for none. Returns null for a box outside of the picture.
GstVideoRegionOfInterestMeta* add_region(GstBuffer* buffer, const PictureRegion& region,
                                         uint32_t width, uint32_t height, int id, int parent_id);
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
