// tensor_to_roi: attaches the results of one stream to the pictures of another as regions of
// interest.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <atomic>

#include "elements/tensor_to_roi/roi_results_pad.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/pads/paired_transform.hpp"
#include "weir/module.hpp"

namespace weir {
namespace {

using gst::Ref;

#define WEIR_ANY_VIDEO "video/x-raw(ANY)"

class TensorToRoi : public gst::PairedTransform<TensorToRoi, RoiResultsPad> {
  using Paired = gst::PairedTransform<TensorToRoi, RoiResultsPad>;

 public:
  static constexpr gst::ElementInfo kInfo{
      "WeirTensorToRoi", "tensor_to_roi", "TensorToRoi", "Filter/Editor/Video",
      "Attaches results to video as GstVideoRegionOfInterestMeta"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS(WEIR_ANY_VIDEO)),
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS, GST_STATIC_CAPS(WEIR_ANY_VIDEO)),
      GST_STATIC_PAD_TEMPLATE(
          "results", GST_PAD_SINK, GST_PAD_ALWAYS,
          GST_STATIC_CAPS(WEIR_CAPS_TENSOR "; " WEIR_CAPS_TENSORS("{ static, flexible }"))),
  };
  struct Settings {
    ResultsSync sync = ResultsSync::SameTime;
    uint64_t max_age = 1000000000;
    uint64_t max_wait = 1000000000;
    std::string labels;
    float threshold = 0;
  };
  static constexpr uint64_t kMax = uint64_t{24} * 3600 * 1000000000;
  static constexpr std::tuple kProperties{
      gst::Property{"sync", &Settings::sync, "Which results a picture gets"},
      gst::Property{"max-age", &Settings::max_age,
                    "With sync=newest: maximum time difference in nanoseconds between a picture "
                    "and its results; 0 = results are used until others arrive"},
      gst::Property{"max-wait", &Settings::max_wait,
                    "With sync=same-time: maximum time in nanoseconds that a picture waits for its "
                    "results; after that it is pushed without them",
                    gst::Changeable::InReady, uint64_t{0}, kMax},
      gst::Property{"labels", &Settings::labels,
                    "Path of a text file with one class name per line, the first for class 0; "
                    "several, separated by semicolons, for the sources of the results"},
      gst::Property{"threshold", &Settings::threshold, "Minimum score of the results that are used",
                    gst::Changeable::InReady, 0.0f, 1.0f},
  };

  void constructed() {
    Paired::constructed();
    gst_base_transform_set_in_place(self(), TRUE);
  }

  Status start() {
    ledger_.reset();
    regions_ = outside_ = 0;
    return ok();
  }
  Status start_results(const Settings& s) {
    try {
      results_.start(s.sync, records::read_labels("labels", s.labels), s.threshold);
    } catch (const Failure& failure) {
      return failure.error();
    }
    return ok();
  }

  bool set_caps(GstCaps* in, GstCaps*) {
    const GstStructure* structure = gst_caps_get_structure(in, 0);
    int width = 0, height = 0;
    gst_structure_get_int(structure, "width", &width);
    gst_structure_get_int(structure, "height", &height);
    width_ = static_cast<uint32_t>(std::max(width, 0));
    height_ = static_cast<uint32_t>(std::max(height, 0));
    return true;
  }

  // Metadata is attached to a copy of a shared buffer; both have the same memory.
  GstFlowReturn prepare_output_buffer(GstBuffer* in, GstBuffer** out) {
    *out = in;
    if (!take_results(in)) {
      ledger_.dropped(DropReason::Flush);
      return GST_FLOW_FLUSHING;
    }
    if (found_ && !found_->regions.empty() && !gst_buffer_is_writable(in))
      *out = gst_buffer_copy(in);
    return GST_FLOW_OK;
  }

  GstFlowReturn transform_ip(GstBuffer* buffer) {
    if (const auto found = std::exchange(found_, nullptr)) attach(*found, buffer);
    ledger_.consumed_and_pushed();
    return GST_FLOW_OK;
  }

  void add_stats(GstStructure* stats) const {
    gst_structure_set(stats, "regions-attached", G_TYPE_UINT64, regions_.load(), "regions-outside",
                      G_TYPE_UINT64, outside_.load(), nullptr);
    results_.add_stats(stats);
  }

  Settings settings_;

 private:
  void attach(const RegionResults& found, GstBuffer* buffer) {
    const bool is_scaled = found.width > 0 && found.height > 0;
    const double x = is_scaled ? double(width_) / found.width : 1;
    const double y = is_scaled ? double(height_) / found.height : 1;
    int id = gst::next_region_id(buffer);
    std::vector<GstVideoRegionOfInterestMeta*> metas;
    for (const auto& region : found.regions) {
      const auto* parent = region.parent >= 0 ? metas[static_cast<size_t>(region.parent)] : nullptr;
      metas.push_back(gst::add_region(buffer, scaled(region, x, y), width_, height_, id,
                                      parent ? parent->id : 0));
      ++(metas.back() ? regions_ : outside_);
      id += metas.back() != nullptr;
    }
    add_labels(found, metas);
  }

  // A region outside of the picture has no meta.
  static void add_labels(const RegionResults& found,
                         const std::vector<GstVideoRegionOfInterestMeta*>& metas) {
    for (const auto& label : found.labels) {
      auto* meta = metas[label.region];
      if (!meta) continue;
      if (label.is_text)
        gst::add_region_text(meta, label.text, label.score, label.model);
      else
        gst::add_region_label(meta, label.text, label.class_index, label.score, label.model);
    }
  }
  static gst::PictureRegion scaled(gst::PictureRegion region, double x, double y) {
    const auto times = [](float* number, double factor) {
      *number = static_cast<float>(*number * factor);
    };
    times(&region.box.x1, x), times(&region.box.x2, x);
    times(&region.box.y1, y), times(&region.box.y2, y);
    for (auto& point : region.points) times(&point.x, x), times(&point.y, y);
    return region;
  }

  // Used by the streaming thread of the pictures.
  uint32_t width_ = 0, height_ = 0;
  std::atomic<uint64_t> regions_{0}, outside_{0};
};

}  // namespace

bool register_tensor_to_roi(GstPlugin* plugin) {
  return TensorToRoi::register_in(plugin);
}

}  // namespace weir
