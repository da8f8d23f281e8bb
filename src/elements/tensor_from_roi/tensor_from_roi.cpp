// tensor_from_roi: turns the regions of interest of pictures into tensors of results.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

#include "core/results/region_grid.hpp"
#include "core/results/results_writer.hpp"
#include "gstcpp/buffer/allocation.hpp"
#include "gstcpp/buffer/analytics_meta.hpp"
#include "gstcpp/buffer/module_values.hpp"
#include "gstcpp/buffer/region_meta.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"
#include "gstcpp/element/counted_transform.hpp"
#include "weir/label_file.hpp"
#include "weir/results.h"

namespace weir {
namespace {

using gst::Ref;
using results::FrameResults;

class TensorFromRoi : public gst::CountedTransform<TensorFromRoi> {
 public:
  static constexpr gst::ElementInfo kInfo{
      "WeirTensorFromRoi", "tensor_from_roi", "TensorFromRoi", "Converter/Tensor",
      "Turns GstVideoRegionOfInterestMeta and GstAnalyticsRelationMeta of video into results"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS("video/x-raw(ANY)")),
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS(WEIR_CAPS_TENSORS("flexible"))),
  };
  struct Settings {
    std::string labels;
    std::string source = "roi";
    uint32_t keypoints = 0;
    float threshold = 0;
    bool masks = false;
    bool class_map = false;
  };
  static constexpr std::tuple kProperties{
      gst::Property{"labels", &Settings::labels,
                    "Path of a text file with one class name per line, the first for class 0; "
                    "gives the class of regions without label_id"},
      gst::Property{"source", &Settings::source, "Name of the source of the results"},
      gst::Property{"keypoints", &Settings::keypoints, "Number of key points in a row",
                    gst::Changeable::InReady, 0u, 1000u},
      gst::Property{"threshold", &Settings::threshold, "Minimum score of the regions that are used",
                    gst::Changeable::InReady, 0.0f, 1.0f},
      gst::Property{"masks", &Settings::masks,
                    "Whether rows have masks, from the segmentation of objects"},
      gst::Property{"class-map", &Settings::class_map,
                    "Whether frames have a class map, from the segmentation of the picture"},
  };

  Status start() {
    ledger_.reset();
    objects_left_out_ = labels_left_out_ = segmentations_left_out_ = 0;
    settings_now_ = settings();
    if (!gst::kHasSegmentation && (settings_now_.masks || settings_now_.class_map))
      return no_segmentation(settings_now_.masks ? "masks=true" : "class-map=true");
    try {
      names_ = settings_now_.labels.empty() ? std::vector<std::string>()
                                            : read_label_file("labels", settings_now_.labels);
    } catch (const Failure& failure) {
      return failure.error();
    }
    return ok();
  }

  GstCaps* transform_caps(GstPadDirection direction, GstCaps* caps, GstCaps* filter) {
    return caps_of_other_pad(direction, filter, [&] { return output_caps(caps); });
  }

  bool set_caps(GstCaps* in, GstCaps*) {
    const GstStructure* structure = gst_caps_get_structure(in, 0);
    int width = 0, height = 0;
    gst_structure_get_int(structure, "width", &width);
    gst_structure_get_int(structure, "height", &height);
    width_ = static_cast<uint32_t>(std::max(width, 0));
    height_ = static_cast<uint32_t>(std::max(height, 0));
    features_ = features();
    return true;
  }

  GstFlowReturn prepare_output_buffer(GstBuffer* in, GstBuffer** out) {
    *out = gst_buffer_new();
    gst_buffer_copy_into(
        *out, in,
        static_cast<GstBufferCopyFlags>(GST_BUFFER_COPY_FLAGS | GST_BUFFER_COPY_TIMESTAMPS), 0,
        static_cast<gsize>(-1));
    return GST_FLOW_OK;
  }

  GstFlowReturn transform(GstBuffer* in, GstBuffer* out) {
    auto regions = gst::get_regions(in, width_, height_);
    gst::ClassMap class_map;
    if constexpr (gst::kHasAnalytics) {
      const auto left_out = gst::read_analytics(in, features_.has_masks, &regions,
                                                features_.has_class_map ? &class_map : nullptr);
      objects_left_out_ += left_out.objects;
      labels_left_out_ += left_out.labels;
      segmentations_left_out_ += left_out.segmentations;
    }
    read(regions);
    // Tables have the map of the picture; the class map, which is the last, its own.
    std::vector<SourceMap> source_maps{picture_as_it_is(width_, height_, false)};
    if (features_.has_class_map) {
      source_maps.resize(results::tensor_count(features_), source_maps[0]);
      source_maps.back() = read_class_map(std::move(class_map));
    }
    std::vector<gst::MappedMemory> maps;
    results::write(results_, features_, [&](size_t size) -> std::span<std::byte> {
      auto memory = value_or_throw(gst::allocate_memory(size));
      maps.emplace_back(memory.get(), GST_MAP_WRITE);
      gst_buffer_append_memory(out, memory.release());
      return maps.back().bytes();
    });
    maps.clear();
    gst::set_source_maps(out, std::move(source_maps));
    ledger_.consumed_and_pushed();
    return GST_FLOW_OK;
  }

  void add_stats(GstStructure* stats) const {
    gst_structure_set(stats, "objects-left-out", G_TYPE_UINT64, objects_left_out_.load(),
                      "labels-left-out", G_TYPE_UINT64, labels_left_out_.load(),
                      "segmentations-left-out", G_TYPE_UINT64, segmentations_left_out_.load(),
                      nullptr);
  }

  Settings settings_;

 private:
  static Error no_segmentation(const char* setting) {
    return {.code = Code::OPTION_VALUE,
            .what = std::string(setting) + " needs segmentation as metadata",
            .offered = "Weir was built with GStreamer " + std::to_string(GST_VERSION_MAJOR) + "." +
                       std::to_string(GST_VERSION_MINOR),
            .needed = "GStreamer 1.26 or later, with its library gstreamer-analytics-1.0",
            .fix = "tensor_from_roi masks=false class-map=false"};
  }
  results::Features features() const {
    const auto s = settings();
    return {.points_per_object = s.keypoints, .has_masks = s.masks, .has_class_map = s.class_map};
  }
  // With the frame rate of the pictures, where that is known.
  Ref<GstCaps> output_caps(const GstCaps* video) const {
    Fraction rate;
    if (gst_caps_is_fixed(video))
      gst_structure_get_fraction(gst_caps_get_structure(video, 0), "framerate", &rate.numerator,
                                 &rate.denominator);
    auto caps = gst::caps_of_decoder(results::make_caps(features(), settings().source), rate);
    return caps ? *std::move(caps) : Ref<GstCaps>::adopt(gst_caps_new_empty());
  }

  std::optional<int32_t> find_label(const std::string& label) const {
    const auto found = std::find(names_.begin(), names_.end(), label);
    if (found == names_.end()) return std::nullopt;
    return static_cast<int32_t>(found - names_.begin());
  }
  int32_t find_class(const gst::PictureRegion& region) const {
    return region.class_index >= 0 ? region.class_index : find_label(region.label).value_or(0);
  }

  // Returns where it lies.
  SourceMap read_class_map(gst::ClassMap map) {
    SourceMap place = picture_as_it_is(width_, height_, false);
    results_.map_width = map.grid.width;
    results_.map_height = map.grid.height;
    results_.class_map = std::move(map.grid.numbers);
    if (results_.class_map.empty()) return place;
    place.xx = double{map.box.width()} / map.grid.width;
    place.yy = double{map.box.height()} / map.grid.height;
    place.x0 = map.box.x1;
    place.y0 = map.box.y1;
    place.width = map.grid.width;
    place.height = map.grid.height;
    if (!names_.empty() && !map.labels.empty()) replace_numbers(map.labels);
    return place;
  }

  // A number with a label becomes the class of that label in `labels`; 0 where they do not have it.
  void replace_numbers(const std::map<uint32_t, std::string>& labels) {
    std::vector<uint16_t> class_of(1 << 16);
    std::iota(class_of.begin(), class_of.end(), uint16_t{0});
    for (const auto& [number, label] : labels)
      if (number < class_of.size())
        class_of[number] = static_cast<uint16_t>(find_label(label).value_or(0));
    for (auto& number : results_.class_map) number = class_of[number];
  }

  // Masks over the boxes of their objects, all of one size: that of the largest, or what
  // kMaxMaskSide and kMaxMaskCells leave.
  void read_masks(const std::vector<const gst::PictureRegion*>& used) {
    constexpr double kMaxMaskSide = 256, kMaxMaskCells = 1 << 24;
    const auto side = static_cast<uint32_t>(std::min(
        kMaxMaskSide, std::sqrt(kMaxMaskCells / std::max<double>(1, double(used.size())))));
    std::vector<results::RegionGrid> grids;
    Size size{1, 1};
    for (const auto* region : used) {
      const auto& grid = grids.emplace_back(gst::read_mask(region->mask.mask.get()));
      segmentations_left_out_ += region->mask.mask && grid.numbers.empty();
      size.width = std::max(size.width, std::min(grid.width, side));
      size.height = std::max(size.height, std::min(grid.height, side));
    }
    results_.mask_width = size.width;
    results_.mask_height = size.height;
    for (size_t i = 0; i < used.size(); ++i)
      results::append_mask(grids[i], used[i]->mask.box, used[i]->box, size, &results_.masks);
  }

  void read(const std::vector<gst::PictureRegion>& regions) {
    results_.clear();
    std::vector<const gst::PictureRegion*> used;
    results_.points_per_object = features_.points_per_object;
    std::vector<int32_t> row_of;  // of each region; -1 = left out
    for (const auto& region : regions) {
      const float score = region.score.value_or(1);
      const bool is_used = score > 0 && score >= settings_now_.threshold;
      row_of.push_back(is_used ? static_cast<int32_t>(results_.objects.size()) : -1);
      if (!is_used) continue;
      used.push_back(&region);
      results_.objects.push_back({.box = region.box,
                                  .score = score,
                                  .class_index = find_class(region),
                                  .track = std::min(region.track, kMaxTrack),
                                  .parent = region.parent,
                                  .rotation = region.rotation});
      for (size_t i = 0; i < features_.points_per_object; ++i)
        results_.points.push_back(i < region.points.size() ? region.points[i]
                                                           : results::KeyPoint{});
    }
    if (features_.has_masks) read_masks(used);
    for (auto& object : results_.objects)
      if (object.parent >= 0) object.parent = row_of[static_cast<size_t>(object.parent)];
  }

  static constexpr uint32_t kMaxTrack = WEIR_RESULTS_TRACK_LIMIT - 1;
  Settings settings_now_;  // while streaming
  std::vector<std::string> names_;
  uint32_t width_ = 0, height_ = 0;
  results::Features features_;
  FrameResults results_;  // kept for its memory
  // Of GstAnalyticsRelationMeta.
  std::atomic<uint64_t> objects_left_out_{0}, labels_left_out_{0}, segmentations_left_out_{0};
};

}  // namespace

bool register_tensor_from_roi(GstPlugin* plugin) {
  return TensorFromRoi::register_in(plugin);
}

}  // namespace weir
