// tensor_from_roi: turns the regions of interest of pictures into tensors of results.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <mutex>
#include <vector>

#include "core/results/results_writer.hpp"
#include "gstcpp/buffer/allocation.hpp"
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
      "Turns GstVideoRegionOfInterestMeta of video into results"};
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
  };

  Status start() {
    ledger_.reset();
    settings_now_ = settings();
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
    read(gst::get_regions(in, width_, height_));
    std::vector<gst::MappedMemory> maps;
    results::write(results_, features_, [&](size_t size) -> std::span<std::byte> {
      auto memory = value_or_throw(gst::allocate_memory(size));
      maps.emplace_back(memory.get(), GST_MAP_WRITE);
      gst_buffer_append_memory(out, memory.release());
      return maps.back().bytes();
    });
    maps.clear();
    gst::set_source_maps(out, {picture_as_it_is(width_, height_, false)});
    ledger_.consumed_and_pushed();
    return GST_FLOW_OK;
  }

  Settings settings_;

 private:
  results::Features features() const { return {.points_per_object = settings().keypoints}; }
  // With the frame rate of the pictures, where that is known.
  Ref<GstCaps> output_caps(const GstCaps* video) const {
    Fraction rate;
    if (gst_caps_is_fixed(video))
      gst_structure_get_fraction(gst_caps_get_structure(video, 0), "framerate", &rate.numerator,
                                 &rate.denominator);
    auto caps = gst::caps_of_decoder(results::make_caps(features(), settings().source), rate);
    return caps ? *std::move(caps) : Ref<GstCaps>::adopt(gst_caps_new_empty());
  }

  int32_t find_class(const gst::PictureRegion& region) const {
    if (region.class_index >= 0) return region.class_index;
    const auto found = std::find(names_.begin(), names_.end(), region.label);
    return found == names_.end() ? 0 : static_cast<int32_t>(found - names_.begin());
  }

  void read(const std::vector<gst::PictureRegion>& regions) {
    results_.clear();
    results_.points_per_object = features_.points_per_object;
    std::vector<int32_t> row_of;  // of each region; -1 = left out
    for (const auto& region : regions) {
      const bool is_used = region.score > 0 && region.score >= settings_now_.threshold;
      row_of.push_back(is_used ? static_cast<int32_t>(results_.objects.size()) : -1);
      if (!is_used) continue;
      results_.objects.push_back({.box = region.box,
                                  .score = region.score,
                                  .class_index = find_class(region),
                                  .track = std::min(region.track, kMaxTrack),
                                  .parent = region.parent,
                                  .rotation = region.rotation});
      for (size_t i = 0; i < features_.points_per_object; ++i)
        results_.points.push_back(i < region.points.size() ? region.points[i]
                                                           : results::KeyPoint{});
    }
    for (auto& object : results_.objects)
      if (object.parent >= 0) object.parent = row_of[static_cast<size_t>(object.parent)];
  }

  static constexpr uint32_t kMaxTrack = WEIR_RESULTS_TRACK_LIMIT - 1;
  Settings settings_now_;  // while streaming
  std::vector<std::string> names_;
  uint32_t width_ = 0, height_ = 0;
  results::Features features_;
  FrameResults results_;  // kept for its memory
};

}  // namespace

bool register_tensor_from_roi(GstPlugin* plugin) {
  return TensorFromRoi::register_in(plugin);
}

}  // namespace weir
