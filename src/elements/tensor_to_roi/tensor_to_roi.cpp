// tensor_to_roi: attaches the results of one stream to the pictures of another as regions of
// interest.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <atomic>
#include <map>
#include <optional>
#include <vector>

#include "elements/tensor_to_roi/roi_results_pad.hpp"
#include "gstcpp/buffer/analytics_meta.hpp"
#include "gstcpp/buffer/region_meta.hpp"
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
      "Attaches results to video as GstVideoRegionOfInterestMeta and GstAnalyticsRelationMeta"};
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
    regions_ = outside_ = left_out_ = 0;
    first_seen_.clear();
    return ok();
  }
  // Numbers of tracks start again with a stream, and after a seek.
  gboolean sink_event(GstEvent* event) {
    const auto type = GST_EVENT_TYPE(event);
    if (type == GST_EVENT_STREAM_START || type == GST_EVENT_FLUSH_STOP) first_seen_.clear();
    return Paired::sink_event(event);
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
    const bool adds = found_ && (gst::kHasAnalytics || !found_->regions.empty());
    if (adds && !gst_buffer_is_writable(in)) *out = gst_buffer_copy(in);
    return GST_FLOW_OK;
  }

  GstFlowReturn transform_ip(GstBuffer* buffer) {
    if (const auto found = std::exchange(found_, nullptr)) attach(*found, buffer);
    ledger_.consumed_and_pushed();
    return GST_FLOW_OK;
  }

  void add_stats(GstStructure* stats) const {
    gst_structure_set(stats, "regions-attached", G_TYPE_UINT64, regions_.load(), "regions-outside",
                      G_TYPE_UINT64, outside_.load(), "analytics-left-out", G_TYPE_UINT64,
                      left_out_.load(), nullptr);
    results_.add_stats(stats);
  }

  Settings settings_;

 private:
  // A region, in pixels of the picture, and what it became.
  struct Attached {
    const gst::PictureRegion& region;
    std::optional<Rect> at;                // nullopt: outside of the picture
    gst::AnalyticsWriter::Object entry{};  // in GstAnalyticsRelationMeta
    GstVideoRegionOfInterestMeta* meta = nullptr;
  };
  static const Attached* parent_of(const Attached& child, const std::vector<Attached>& all) {
    const int32_t parent = child.region.parent;
    return parent >= 0 ? &all[static_cast<size_t>(parent)] : nullptr;
  }

  void attach(const RegionResults& found, GstBuffer* buffer) {
    const bool has_other_size =
        found.width > 0 && found.height > 0 && (found.width != width_ || found.height != height_);
    std::vector<gst::PictureRegion> copies;
    if (has_other_size)
      for (const auto& region : found.regions)
        copies.push_back(
            scaled(region, double(width_) / found.width, double(height_) / found.height));
    std::vector<Attached> all;
    for (const auto& region : has_other_size ? copies : found.regions)
      all.push_back({region, gst::visible_part(region.box, {width_, height_})});
    if constexpr (gst::kHasAnalytics) add_analytics(found, buffer, &all);
    add_regions(buffer, &all);
    add_labels(found, all);
  }

  void add_regions(GstBuffer* buffer, std::vector<Attached>* all) {
    int id = gst::next_region_id(buffer);
    for (auto& object : *all) {
      ++(object.at ? regions_ : outside_);
      if (!object.at) continue;
      const Attached* parent = parent_of(object, *all);
      const int parent_id = parent && parent->meta ? parent->meta->id : 0;
      object.meta = gst::add_region(buffer, object.region, *object.at, {width_, height_},
                                    {id++, parent_id, object.entry});
    }
  }

  void add_analytics(const RegionResults& found, GstBuffer* buffer, std::vector<Attached>* all) {
    const GstClockTime now = GST_BUFFER_PTS(buffer);
    gst::AnalyticsWriter out(buffer, found);
    for (auto& object : *all)
      if (object.at) add_object(*all, now, &object, &out);
    for (const auto& label : found.labels)
      if (!label.is_text) add_analytics_label(label, *all, &out);
    for (const auto& map : found.class_maps)
      if (map.mask) out.add_class_map(map, scaled(map.box, width_, height_));
    left_out_ += out.left_out();
  }

  void add_object(const std::vector<Attached>& all, GstClockTime now, Attached* object,
                  gst::AnalyticsWriter* out) {
    const auto& region = object->region;
    const Attached* parent = parent_of(*object, all);
    object->entry = out->add_object(region, *object->at, parent ? parent->entry : std::nullopt);
    if (region.track > 0)
      out->add_track(object->entry, region.track, first_seen(region.track, now), now);
    if (region.mask.mask) out->add_mask(object->entry, region.mask);
  }
  static void add_analytics_label(const gst::RegionLabel& label, const std::vector<Attached>& all,
                                  gst::AnalyticsWriter* out) {
    if (label.region < 0) {
      out->add_picture_label(label.text, label.score);
      return;
    }
    const Attached& object = all[static_cast<size_t>(label.region)];
    if (object.at) out->add_label(object.entry, label.text, label.score);
  }

  // Trackers count upwards: the lowest numbers are those of the oldest tracks.
  GstClockTime first_seen(uint32_t track, GstClockTime now) {
    constexpr size_t kMaxTracks = 10000;
    if (!GST_CLOCK_TIME_IS_VALID(now)) return now;
    const auto [seen, is_new] = first_seen_.try_emplace(track, now);
    const GstClockTime first = std::min(seen->second, now);
    if (is_new && first_seen_.size() > kMaxTracks) first_seen_.erase(first_seen_.begin());
    return first;
  }

  // A region outside of the picture has no meta.
  static void add_labels(const RegionResults& found, const std::vector<Attached>& all) {
    for (const auto& label : found.labels) {
      auto* meta = label.region >= 0 ? all[static_cast<size_t>(label.region)].meta : nullptr;
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
    region.box = scaled(region.box, x, y);
    region.mask.box = scaled(region.mask.box, x, y);
    for (auto& point : region.points) times(&point.x, x), times(&point.y, y);
    return region;
  }
  static Box scaled(const Box& box, double x, double y) {
    return {static_cast<float>(box.x1 * x), static_cast<float>(box.y1 * y),
            static_cast<float>(box.x2 * x), static_cast<float>(box.y2 * y)};
  }

  // Used by the streaming thread of the pictures.
  uint32_t width_ = 0, height_ = 0;
  std::map<uint32_t, GstClockTime> first_seen_;  // of each track
  std::atomic<uint64_t> regions_{0}, outside_{0}, left_out_{0};
};

}  // namespace

bool register_tensor_to_roi(GstPlugin* plugin) {
  return TensorToRoi::register_in(plugin);
}

}  // namespace weir
