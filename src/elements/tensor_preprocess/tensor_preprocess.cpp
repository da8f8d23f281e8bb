// tensor_preprocess: converts decoded video to a network's input tensor in one pass over the
// pixels.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <atomic>
#include <memory>

#include "core/preprocess/request.hpp"
#include "elements/tensor_preprocess/frame_preprocessor.hpp"
#include "elements/tensor_preprocess/preprocess_settings.hpp"
#include "elements/tensor_preprocess/regions_pad.hpp"
#include "elements/tensor_preprocess/video_negotiation.hpp"
#include "gstcpp/buffer/frame_builder.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"
#include "gstcpp/element/counted_transform.hpp"
#include "gstcpp/element/derived_setting.hpp"

namespace weir {
namespace {

using gst::Ref;
using preprocess::Request;

class TensorPreprocess : public gst::CountedTransform<TensorPreprocess> {
 public:
  static constexpr gst::ElementInfo kInfo{
      "WeirTensorPreprocess", "tensor_preprocess", "TensorPreprocess", "Converter/Tensor",
      "Converts decoded video to the input tensor of a network, in one pass over the pixels"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE(
          "sink", GST_PAD_SINK, GST_PAD_ALWAYS,
          GST_STATIC_CAPS("video/x-raw, format=(string){ RGB, BGR, RGBx, BGRx, xRGB, xBGR, RGBA, "
                          "BGRA, ARGB, ABGR, GRAY8, NV12, NV21, I420, YV12, YUY2, UYVY }, "
                          "width=(int)[ 1, 65536 ], "
                          "height=(int)[ 1, 65536 ], " WEIR_CAPS_RATE
                          ", interlace-mode=(string)progressive")),
      GST_STATIC_PAD_TEMPLATE(
          "src", GST_PAD_SRC, GST_PAD_ALWAYS,
          GST_STATIC_CAPS(WEIR_CAPS_TENSOR "; " WEIR_CAPS_TENSORS("{ static, flexible }"))),
      GST_STATIC_PAD_TEMPLATE(
          "regions", GST_PAD_SINK, GST_PAD_REQUEST,
          GST_STATIC_CAPS(WEIR_CAPS_TENSOR "; " WEIR_CAPS_TENSORS("{ static, flexible }"))),
  };

  using Settings = PreprocessSettings;
  static constexpr auto kProperties = kPreprocessProperties;

  Status start() {
    ledger_.reset();
    regions_ = regions_empty_ = regions_beyond_limit_ = boxes_late_ = 0;
    property_changed("card");  // the file may have changed
    const auto request = current();
    if (!request) return request.error();
    if (const auto crop = parse_crop(settings()); !crop) return crop.error();
    return check_regions_pad();
  }

  bool stop() {
    work_.reset();
    allocation_ = {};
    return true;
  }

  void property_changed(const char* name) {
    if (name == std::string_view("crop")) {
      crop_changed_ = true;
      return;
    }
    request_.reset();
  }

  GstPad* request_new_pad(GstPadTemplate* pad_template, const gchar*, const GstCaps*) {
    using Shell = gst::Element<TensorPreprocess, gst::BaseTransform>;
    if (boxes_pad_) return nullptr;
    boxes_pad_ = gst_pad_new_from_template(pad_template, "regions");
    gst_pad_set_chain_function(boxes_pad_, &Shell::chain<&TensorPreprocess::boxes_chain>);
    gst_pad_set_event_function(boxes_pad_, &Shell::pad_event<&TensorPreprocess::boxes_event>);
    // Boxes are not forwarded: events and queries end at this pad too.
    gst_pad_set_iterate_internal_links_function(
        boxes_pad_, [](GstPad*, GstObject*) -> GstIterator* { return nullptr; });
    gst_pad_set_active(boxes_pad_, TRUE);
    gst_element_add_pad(element(), boxes_pad_);
    return boxes_pad_;
  }
  void release_pad(GstPad* pad) {
    gst_pad_set_active(pad, FALSE);
    boxes_.end();  // otherwise pictures would wait for more boxes
    boxes_pad_ = nullptr;
    gst_element_remove_pad(element(), pad);
  }

  // A picture that waits for boxes must not block the deactivation of the pads.
  GstStateChangeReturn change_state(GstStateChange change) {
    if (change == GST_STATE_CHANGE_READY_TO_PAUSED) boxes_.start();
    if (change == GST_STATE_CHANGE_PAUSED_TO_READY) boxes_.stop();
    const auto result = GST_ELEMENT_CLASS(parent_class())->change_state(element(), change);
    if (change == GST_STATE_CHANGE_PAUSED_TO_READY) boxes_.forget_stream();
    return result;
  }

  GstFlowReturn boxes_chain(GstBuffer* raw) {
    const auto buffer = Ref<GstBuffer>::adopt(raw);
    if (const Status status = boxes_.receive(buffer.get()); !status) {
      gst::post_error(element(), status.error());
      return GST_FLOW_ERROR;
    }
    return GST_FLOW_OK;
  }

  // Not forwarded: the output stream follows the pictures.
  gboolean boxes_event(GstPad*, GstEvent* raw) {
    const auto event = Ref<GstEvent>::adopt(raw);
    const Status status = boxes_.handle(raw);
    if (!status) gst::post_error(element(), status.error());
    return status.has_value();
  }

  GstCaps* transform_caps(GstPadDirection direction, GstCaps* caps, GstCaps* filter) {
    const auto request = current();
    auto result = Ref<GstCaps>::adopt(gst_caps_new_empty());
    for (guint i = 0; i < gst_caps_get_size(caps); ++i) {
      const GstStructure* one = gst_caps_get_structure(caps, i);
      auto other = direction == GST_PAD_SINK ? tensors_for(source(), one, request, filter)
                                             : video_for(sink(), one);
      result = Ref<GstCaps>::adopt(gst_caps_merge(result.release(), other.release()));
    }
    if (!filter) return result.release();
    return gst_caps_intersect_full(result.get(), filter, GST_CAPS_INTERSECT_FIRST);
  }

  // Fixes what the request and downstream leave open.
  GstCaps* fixate_caps(GstPadDirection direction, GstCaps*, GstCaps* other) {
    auto open = Ref<GstCaps>::adopt(other);
    if (direction == GST_PAD_SINK) open = closed(source(), std::move(open), current());
    return gst_caps_fixate(open.release());
  }

  Status set_caps(GstCaps* in, GstCaps* out) {
    Status status = configure(in, out);
    reported_ = !status;
    return status;
  }

  gboolean sink_event(GstEvent* event) {
    if (GST_EVENT_TYPE(event) == GST_EVENT_FLUSH_START) boxes_.flush_pictures(true);
    if (GST_EVENT_TYPE(event) == GST_EVENT_FLUSH_STOP) boxes_.flush_pictures(false);
    if (GST_EVENT_TYPE(event) != GST_EVENT_CAPS) return parent_class()->sink_event(self(), event);
    GstCaps* caps = nullptr;
    gst_event_parse_caps(event, &caps);
    if (const Status known = check_video(caps); !known) return refused(event, known.error());
    const auto held = Ref<GstCaps>::share(caps);
    reported_ = false;
    refused_ = !parent_class()->sink_event(self(), event);
    if (!refused_) return TRUE;
    if (reported_) return FALSE;
    const auto ours = Ref<GstCaps>::adopt(transform_caps(GST_PAD_SINK, held.get(), nullptr));
    if (const auto error = downstream_mismatch(source(), current(), ours.get()))
      gst::post_error(element(), *error);
    return FALSE;
  }

  // A pad rejects caps without an error: accept unsupported video here, sink_event posts the error.
  gboolean query(GstPadDirection direction, GstQuery* query) {
    GstCaps* caps = nullptr;
    if (direction == GST_PAD_SINK && GST_QUERY_TYPE(query) == GST_QUERY_ACCEPT_CAPS) {
      gst_query_parse_accept_caps(query, &caps);
      if (!check_video(caps)) return gst_query_set_accept_caps_result(query, TRUE), TRUE;
    }
    const gboolean handled = parent_class()->query(self(), direction, query);
    if (GST_QUERY_TYPE(query) != GST_QUERY_CAPS || !handled) return handled;
    GstCaps* filter = nullptr;
    gst_query_parse_caps(query, &filter);
    gst_query_parse_caps_result(query, &caps);
    if (direction == GST_PAD_SINK) {
      const auto all = with_other_formats(sink(), Ref<GstCaps>::share(caps), filter);
      gst_query_set_caps_result(query, all.get());
    } else if (gst_caps_is_empty(caps)) {
      gst_query_set_caps_result(query, caps_of_any_video(filter).get());
    }
    return TRUE;
  }

  bool propose_allocation(GstQuery* decided, GstQuery* query) {
    if (!parent_class()->propose_allocation(self(), decided, query)) return false;
    gst_query_add_allocation_meta(query, GST_VIDEO_META_API_TYPE, nullptr);
    gst_query_add_allocation_meta(query, GST_VIDEO_CROP_META_API_TYPE, nullptr);
    if (settings().regions == RegionsChoice::Meta)
      gst_query_add_allocation_meta(query, GST_VIDEO_REGION_OF_INTEREST_META_API_TYPE, nullptr);
    return true;
  }

  gboolean decide_allocation(GstQuery* query) {
    allocation_ = gst::parse_allocation(query, allocation_);
    if (work_)
      if (const Status status = work_->allocate_as(allocation_); !status)
        return gst::post_error(element(), status.error()), FALSE;
    return parent_class()->decide_allocation(self(), query);
  }

  GstFlowReturn prepare_output_buffer(GstBuffer* in, GstBuffer** out) {
    if (!work_ || refused_) {
      ledger_.dropped(DropReason::Error);
      return GST_FLOW_NOT_NEGOTIATED;
    }
    if (crop_changed_.exchange(false)) {
      const auto crop = parse_crop(settings());
      if (!crop) return failed(crop.error());
      work_->set_crop(*crop);
    }
    if (wait_for_boxes_ && !take_boxes(in)) {
      ledger_.dropped(DropReason::Flush);
      return GST_FLOW_FLUSHING;
    }
    auto buffer = work_->acquire(in, buffer_limit_);
    if (!buffer) return failed(buffer.error());
    if (const auto warning = work_->next_warning()) gst::post_warning(element(), *warning);
    copy_metadata(in, buffer->get());
    *out = buffer->release();
    return GST_FLOW_OK;
  }

  GstFlowReturn transform(GstBuffer* in, GstBuffer* out) {
    const Status status = work_->run(in, out);
    ledger_.copied(work_->take_copied());
    if (!status) return failed(status.error());
    pool_allocated_ = work_->allocated();
    const RegionCounts regions = work_->regions();
    regions_ += regions.prepared;
    regions_empty_ += regions.empty;
    regions_beyond_limit_ += regions.beyond_limit;
    auto maps = work_->source_maps();
    if (maps.empty()) return drop_without_output(in);
    gst::set_source_maps(out, std::move(maps), work_->maps_of());
    ledger_.consumed_and_pushed();
    return GST_FLOW_OK;
  }

  void add_stats(GstStructure* stats) const {
    gst_structure_set(stats, "pool-allocated", G_TYPE_UINT64, pool_allocated_.load(), "regions",
                      G_TYPE_UINT64, regions_.load(), "regions-empty", G_TYPE_UINT64,
                      regions_empty_.load(), "regions-beyond-limit", G_TYPE_UINT64,
                      regions_beyond_limit_.load(), "boxes-unused", G_TYPE_UINT64, boxes_.unused(),
                      "boxes-late", G_TYPE_UINT64, boxes_late_.load(), nullptr);
  }

  Settings settings_;
  BufferLimit buffer_limit_{kInfo.factory_name};

 private:
  GstPad* sink() const { return GST_BASE_TRANSFORM_SINK_PAD(self()); }
  GstPad* source() const { return GST_BASE_TRANSFORM_SRC_PAD(self()); }

  // Elements link and query before caps arrive; a source without usable formats gets its error
  // then.
  Ref<GstCaps> caps_of_any_video(GstCaps* filter) {
    const auto video = Ref<GstCaps>::adopt(gst_pad_get_pad_template_caps(sink()));
    return Ref<GstCaps>::adopt(transform_caps(GST_PAD_SINK, video.get(), filter));
  }

  Status check_regions_pad() const {
    const bool wanted = settings().regions == RegionsChoice::Pad;
    if (wanted == (boxes_pad_ != nullptr)) return ok();
    return Error{
        .code = Code::OPTION_VALUE,
        .what = wanted ? "there is no stream of boxes" : "the stream of boxes is not used",
        .offered = wanted ? "regions=pad, and no pad regions" : "a pad regions without regions=pad",
        .needed = "regions=pad and the pad regions",
        .fix = "tensor_preprocess name=p regions=pad ...  boxes. ! p.regions"};
  }

  // False: the stream is flushing. A frame without boxes in time has none.
  bool take_boxes(GstBuffer* in) {
    preprocess::PictureRegions boxes;
    const GstClockTime time = gst::running_time(self()->segment, GST_BUFFER_PTS(in));
    if (GST_CLOCK_TIME_IS_VALID(time)) {
      using Outcome = sync::TimedOutcome;
      const Outcome outcome = boxes_.take(time, *wait_for_boxes_, &boxes);
      if (outcome == Outcome::Flushed) return false;
      if (outcome == Outcome::Late) ++boxes_late_;
    }
    work_->set_boxes(std::move(boxes));
    return true;
  }

  // Later frames do not have the previous caps.
  gboolean refused(GstEvent* caps, const Error& error) {
    gst_event_unref(caps);
    refused_ = true;
    gst::post_error(element(), error);
    return FALSE;
  }

  // For a frame without regions: a GAP event signals downstream that its time has passed.
  GstFlowReturn drop_without_output(GstBuffer* in) {
    ledger_.dropped(DropReason::Policy);
    if (auto gap = gst::gap_like(in)) gst_pad_push_event(source(), gap.release());
    return GST_BASE_TRANSFORM_FLOW_DROPPED;
  }

  // Reads the card at the first use and after each change of a property.
  Result<Request> current() const {
    return *request_.get([this] { return make_request(settings()); });
  }

  Status configure(GstCaps* in, GstCaps* out) {
    const auto request = current();
    if (!request) return request.error();
    const auto spec = gst::spec_from_caps(out);
    if (!spec) return spec.error();
    auto preparations = preprocess::resolve_frame(*request, spec->tensors);
    if (!preparations) return preparations.error();
    const auto output = gst::fixed_spec_from_caps(out);
    if (!output) return output.error();
    const FrameSpec ours{Format::Static, preprocess::make_output_specs(*request, *preparations),
                         output->rate};
    if (auto difference = first_difference(ours.tensors, output->tensors);
        !difference.empty() && !is_flexible(*request))
      return tensor_mismatch(request, ours.to_string(), output->to_string(), difference);
    GstVideoInfo video;
    if (!gst_video_info_from_caps(&video, in))
      return unreadable_video(gst::UniqueText(gst_caps_to_string(in)).get());
    return begin(*request, *std::move(preparations), video);
  }

  Status begin(const Request& request, std::vector<preprocess::Preparation> preparations,
               const GstVideoInfo& video) {
    const Settings s = settings();
    const size_t threads = s.threads;
    crop_changed_ = true;  // the new work has no crop yet
    wait_for_boxes_.reset();
    if (s.regions == RegionsChoice::Pad) wait_for_boxes_ = s.max_wait;
    if (request.regions) {
      auto regions = RegionPreprocessor::make(
          std::move(preparations[0]), video,
          {.max = request.max_regions, .clip = request.clip_regions, .shape = request.region_shape},
          threads);
      if (!regions) return regions.error();
      work_ = *std::move(regions);
      return ok();
    }
    auto frames = FramePreprocessor::make(std::move(preparations), video, threads);
    if (!frames) return frames.error();
    work_ = *std::move(frames);
    return ok();
  }

  gst::DerivedSetting<Result<Request>> request_;
  std::atomic<bool> crop_changed_{false};
  std::atomic<uint64_t> pool_allocated_{0};  // read by stats
  std::atomic<uint64_t> regions_{0}, regions_empty_{0}, regions_beyond_limit_{0}, boxes_late_{0};
  GstPad* boxes_pad_ = nullptr;  // owned by the element; changes only while not streaming
  RegionsPad boxes_;
  std::optional<GstClockTime> wait_for_boxes_;  // nullopt: boxes do not come from the pad
  gst::Allocation allocation_;                  // requested by the peer; streaming thread
  std::unique_ptr<PictureWork> work_;           // made for caps; streaming thread
  bool reported_ = false;                       // set_caps() posted its error; streaming thread
  // Whether the last caps were rejected: later frames do not have the earlier caps, which the base
  // class does not set again when they return. Streaming thread.
  bool refused_ = false;
};

}  // namespace

bool register_tensor_preprocess(GstPlugin* plugin) {
  return TensorPreprocess::register_in(plugin);
}

}  // namespace weir
