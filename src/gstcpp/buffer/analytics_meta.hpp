// Writes and reads GstAnalyticsRelationMeta, the results of elements of GStreamer 1.24 and later.
//
//   object      GstAnalyticsODMtd: the smallest rectangle of whole pixels around the part of the
//               box inside the picture, as of the region of interest; around all of a rotated box
//   track       GstAnalyticsTrackingMtd, to which the object relates
//   label       GstAnalyticsClsMtd, to which its object relates
//   mask        GstAnalyticsSegmentationMtd: it and its object relate to each other
//   class map   GstAnalyticsSegmentationMtd that relates to the GstAnalyticsClsMtd of its labels
//   parent      the object is part of its parent
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/tensor/geometry.hpp"
#include "gstcpp/buffer/picture_results.hpp"

struct _GstAnalyticsRelationMeta;

namespace weir::gst {

// Whether the GStreamer that this is built with has them; without, nothing below is defined.
#ifdef WEIR_ANALYTICS
inline constexpr bool kHasAnalytics = true;
inline constexpr bool kHasSegmentation = GST_CHECK_VERSION(1, 26, 0);
#else
inline constexpr bool kHasAnalytics = false;
inline constexpr bool kHasSegmentation = false;
#endif

// Adds to the metadata of a writable buffer, which is made where it is missing: elements that draw
// it keep what they drew before until a picture has some. A buffer gets kMaxEntries at most, since
// GStreamer stores a matrix of all pairs of entries.
class AnalyticsWriter {
 public:
  static constexpr size_t kMaxEntries = 2000;
  using Object = std::optional<uint32_t>;  // the id of its entry; nullopt: there was no room

  AnalyticsWriter(GstBuffer* buffer, const PictureResults& results);
  // Boxes are in pixels of the picture; `at` is the rectangle of the region of interest.
  Object add_object(const PictureRegion& region, const Rect& at, Object parent);
  void add_track(Object object, uint32_t track, GstClockTime first_seen, GstClockTime now);
  void add_mask(Object object, const Segmentation& segmentation);
  void add_label(Object object, const std::string& label, float score);
  // Of the whole picture.
  void add_picture_label(const std::string& label, float score);
  void add_class_map(const Segmentation& map, const Box& box);
  // Entries for which there was no room.
  size_t left_out() const noexcept { return left_out_; }

 private:
  bool has_room();
  Object add_classes(const std::vector<std::string>& labels, float score);
  Object add_segmentation(const Segmentation& segmentation, const Box& box, bool is_of_object);
  void relate(Object from, Object to, int types);

  _GstAnalyticsRelationMeta* meta_;
  size_t left_out_ = 0;
};

// What became no row, no mask and no class map.
struct AnalyticsLeftOut {
  uint64_t objects = 0, labels = 0, segmentations = 0;
};

// The first segmentation of the picture that can be read.
struct ClassMap {
  results::RegionGrid grid;                  // empty: none
  Box box{};                                 // in pixels of the picture
  std::map<uint32_t, std::string> labels{};  // by number
};

// Appends the objects that are none of the regions already, since tensor_to_roi writes both. Gives
// regions their masks if has_masks is true. `class_map` may be null.
AnalyticsLeftOut read_analytics(GstBuffer* buffer, bool has_masks,
                                std::vector<PictureRegion>* regions, ClassMap* class_map);

}  // namespace weir::gst
