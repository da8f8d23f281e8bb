// tensor_to_roi: attaches the results of one stream to the pictures of another as regions of
// interest.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <atomic>

#include "elements/tensor_to_roi/roi_results_pad.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/counted_transform.hpp"
#include "weir/module.hpp"

namespace weir {
namespace {

using gst::Ref;

#define WEIR_ANY_VIDEO "video/x-raw(ANY)"

class TensorToRoi : public gst::CountedTransform<TensorToRoi> {
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
  static constexpr uint64_t kLongest = uint64_t{24} * 3600 * 1000000000;
  static constexpr std::tuple kProperties{
      gst::Property{"sync", &Settings::sync, "Which results a picture gets"},
      gst::Property{"max-age", &Settings::max_age,
                    "With sync=newest: maximum time difference in nanoseconds between a picture "
                    "and its results; 0 = results are used until others arrive"},
      gst::Property{"max-wait", &Settings::max_wait,
                    "With sync=same-time: maximum time in nanoseconds that a picture waits for its "
                    "results; after that it is pushed without them",
                    gst::Changeable::InReady, uint64_t{0}, kLongest},
      gst::Property{"labels", &Settings::labels,
                    "Path of a text file with one class name per line, the first for class 0; "
                    "several, separated by semicolons, for the sources of the results"},
      gst::Property{"threshold", &Settings::threshold, "Minimum score of the results that are used",
                    gst::Changeable::InReady, 0.0f, 1.0f},
  };

  void constructed() {
    using Shell = gst::Element<TensorToRoi, gst::BaseTransform>;
    results_pad_ = gst_pad_new_from_static_template(&kPads[2], "results");
    gst_pad_set_chain_function(results_pad_, &Shell::chain<&TensorToRoi::results_chain>);
    gst_pad_set_event_function(results_pad_, &Shell::pad_event<&TensorToRoi::results_event>);
    // Results are not forwarded: queries end at this pad too.
    gst_pad_set_iterate_internal_links_function(
        results_pad_, [](GstPad*, GstObject*) -> GstIterator* { return nullptr; });
    gst_element_add_pad(element(), results_pad_);
    gst_base_transform_set_in_place(self(), TRUE);
  }

  Status start() {
    ledger_.reset();
    regions_ = outside_ = 0;
    return ok();
  }
  bool stop() {
    found_.reset();
    return true;
  }

  // A picture that waits for results must not block the deactivation of the pads.
  GstStateChangeReturn change_state(GstStateChange change) {
    if (change == GST_STATE_CHANGE_READY_TO_PAUSED) {
      const Settings s = settings();
      records::Labels labels;
      try {
        labels = records::read_labels("labels", s.labels);
      } catch (const Failure& failure) {
        gst::post_error(element(), failure.error());
        return GST_STATE_CHANGE_FAILURE;
      }
      limits_ = {s.max_age, s.max_wait};
      same_time_ = s.sync == ResultsSync::SameTime;
      latency_ = same_time_ ? s.max_wait : 0;
      results_.start(s.sync, std::move(labels), s.threshold);
    }
    if (change == GST_STATE_CHANGE_PAUSED_TO_READY) results_.stop();
    const auto result = GST_ELEMENT_CLASS(parent_class())->change_state(element(), change);
    if (change == GST_STATE_CHANGE_PAUSED_TO_READY) results_.forget_stream();
    return result;
  }

  GstFlowReturn results_chain(GstBuffer* raw) {
    const auto buffer = Ref<GstBuffer>::adopt(raw);
    if (const Status status = results_.receive_counted(buffer.get()); !status) {
      gst::post_error(element(), status.error());
      return GST_FLOW_ERROR;
    }
    return GST_FLOW_OK;
  }
  gboolean results_event(GstPad*, GstEvent* raw) {
    const auto event = Ref<GstEvent>::adopt(raw);
    const Status status = results_.handle(raw);
    if (!status) gst::post_error(element(), status.error());
    return status.has_value();
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

  gboolean sink_event(GstEvent* event) {
    if (GST_EVENT_TYPE(event) == GST_EVENT_FLUSH_START) results_.flush_pictures(true);
    if (GST_EVENT_TYPE(event) == GST_EVENT_FLUSH_STOP) results_.flush_pictures(false);
    return parent_class()->sink_event(self(), event);
  }

  gboolean query(GstPadDirection direction, GstQuery* query) {
    if (!parent_class()->query(self(), direction, query)) return FALSE;
    if (direction == GST_PAD_SRC && GST_QUERY_TYPE(query) == GST_QUERY_LATENCY) add_wait(query);
    return TRUE;
  }
  // Pictures pass unchanged: their memory is downstream's.
  bool propose_allocation(GstQuery*, GstQuery* query) {
    return gst_pad_peer_query(GST_BASE_TRANSFORM_SRC_PAD(self()), query);
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
  // False: the stream is flushing.
  bool take_results(GstBuffer* in) {
    found_.reset();
    if (same_time_ && !gst_pad_is_linked(results_pad_)) return true;
    const GstClockTime time = gst::running_time(self()->segment, GST_BUFFER_PTS(in));
    return results_.take(GST_CLOCK_TIME_IS_VALID(time) ? static_cast<int64_t>(time) : sync::kNoTime,
                         limits_, &found_);
  }

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

  void add_wait(GstQuery* query) const {
    gboolean live = FALSE;
    GstClockTime least = 0, most = 0;
    gst_query_parse_latency(query, &live, &least, &most);
    const uint64_t wait = latency_;
    if (!live || wait == 0) return;
    if (GST_CLOCK_TIME_IS_VALID(most)) most += wait;
    gst_query_set_latency(query, live, least + wait, most);
  }

  GstPad* results_pad_ = nullptr;  // owned by the element
  RoiResultsPad results_;
  bool same_time_ = false;            // changes only while not streaming
  std::atomic<uint64_t> latency_{0};  // how long pictures wait for results, nanoseconds
  // Used by the streaming thread of the pictures.
  RoiResultsPad::Limits limits_;
  uint32_t width_ = 0, height_ = 0;
  RoiResultsPad::Results found_;  // for the current picture
  std::atomic<uint64_t> regions_{0}, outside_{0};
};

}  // namespace

bool register_tensor_to_roi(GstPlugin* plugin) {
  return TensorToRoi::register_in(plugin);
}

}  // namespace weir
