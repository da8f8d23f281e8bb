// tensor_preprocess: decoded video becomes a network's input tensor in one pass over the pixels.
#include <atomic>
#include <memory>

#include "core/preprocess/request.hpp"
#include "elements/tensor_preprocess/frame_preprocessor.hpp"
#include "elements/tensor_preprocess/preprocess_settings.hpp"
#include "gstcpp/base_classes.hpp"
#include "gstcpp/tensor_caps.hpp"
#include "gstcpp/tensor_meta.hpp"

namespace weir {
namespace {

using gst::Ref;
using preprocess::Request;

class TensorPreprocess : public gst::Element<TensorPreprocess, gst::BaseTransform> {
 public:
  static constexpr gst::ElementInfo kInfo{
      "WeirTensorPreprocess", "tensor_preprocess", "TensorPreprocess", "Converter/Tensor",
      "Turns decoded video into the tensor that a network takes, in one pass over the pixels"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE(
          "sink", GST_PAD_SINK, GST_PAD_ALWAYS,
          GST_STATIC_CAPS("video/x-raw, format=(string){ RGB, BGR, RGBx, BGRx, xRGB, xBGR, RGBA, "
                          "BGRA, ARGB, ABGR, GRAY8, NV12, I420 }, width=(int)[ 1, 65536 ], "
                          "height=(int)[ 1, 65536 ], " WEIR_CAPS_RATE
                          ", interlace-mode=(string)progressive")),
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS(WEIR_CAPS_TENSOR "; " WEIR_CAPS_TENSORS("static"))),
  };

  using Settings = PreprocessSettings;
  static constexpr auto kProperties = kPreprocessProperties;

  Status start() {
    ledger_.reset();
    property_changed("card");  // the file may have changed
    const auto request = current();
    if (!request) return request.error();
    return ok();
  }

  bool stop() {
    frames_.reset();
    return true;
  }

  void property_changed(const char*) {
    std::lock_guard lock(request_mutex_);
    request_.reset();
  }

  GstCaps* transform_caps(GstPadDirection direction, GstCaps* caps, GstCaps* filter) {
    const auto request = current();
    auto result = Ref<GstCaps>::adopt(gst_caps_new_empty());
    for (guint i = 0; i < gst_caps_get_size(caps); ++i) {
      const GstStructure* one = gst_caps_get_structure(caps, i);
      auto other = direction == GST_PAD_SINK ? tensors_for(one, request, filter) : video_for(one);
      result = Ref<GstCaps>::adopt(gst_caps_merge(result.release(), other.release()));
    }
    if (!filter) return result.release();
    return gst_caps_intersect_full(result.get(), filter, GST_CAPS_INTERSECT_FIRST);
  }

  // What the request and the stream behind both leave open is decided here.
  GstCaps* fixate_caps(GstPadDirection direction, GstCaps*, GstCaps* other) {
    auto open = Ref<GstCaps>::adopt(other);
    const auto request = current();
    if (direction == GST_PAD_SINK && !gst_caps_is_empty(open.get()) && request) {
      const auto one = first_choice(open.get());
      auto spec = gst::spec_from_caps(one.get());
      if (spec)
        if (const auto p = preprocess::resolve_frame(*request, spec->tensors)) {
          spec->tensors = tensors_of(*p);
          const auto closed =
              gst::possible_caps(GST_BASE_TRANSFORM_SRC_PAD(self()), *spec, one.get());
          auto meet = Ref<GstCaps>::adopt(gst_caps_intersect(one.get(), closed.get()));
          if (!gst_caps_is_empty(meet.get())) open = std::move(meet);
        }
    }
    return gst_caps_fixate(open.release());
  }

  Status set_caps(GstCaps* in, GstCaps* out) {
    frames_.reset();
    Status status = configure(in, out);
    told_ = !status;
    return status;
  }

  gboolean sink_event(GstEvent* event) {
    if (GST_EVENT_TYPE(event) != GST_EVENT_CAPS) return parent_class()->sink_event(self(), event);
    GstCaps* caps = nullptr;
    gst_event_parse_caps(event, &caps);
    const auto held = Ref<GstCaps>::share(caps);
    told_ = false;
    if (parent_class()->sink_event(self(), event)) return TRUE;
    if (!told_) tell_mismatch(held.get());
    return FALSE;
  }

  // Pads refuse caps without a word; a warning names the format and what to put in front.
  gboolean query(GstPadDirection direction, GstQuery* query) {
    const gboolean answered = parent_class()->query(self(), direction, query);
    if (direction != GST_PAD_SINK || GST_QUERY_TYPE(query) != GST_QUERY_ACCEPT_CAPS || !answered)
      return answered;
    gboolean accepted = TRUE;
    gst_query_parse_accept_caps_result(query, &accepted);
    if (accepted) return answered;
    GstCaps* caps = nullptr;
    gst_query_parse_accept_caps(query, &caps);
    const GstStructure* first = caps && !gst_caps_is_any(caps) && !gst_caps_is_empty(caps)
                                    ? gst_caps_get_structure(caps, 0)
                                    : nullptr;
    const char* format = first ? gst_structure_get_string(first, "format") : nullptr;
    if (!format || !gst_structure_has_name(first, "video/x-raw")) return answered;
    if (const auto known = preprocess::picture_format(format); !known)
      gst::post_warning(element(), known.error());
    return answered;
  }

  bool propose_allocation(GstQuery* decided, GstQuery* query) {
    if (!parent_class()->propose_allocation(self(), decided, query)) return false;
    gst_query_add_allocation_meta(query, GST_VIDEO_META_API_TYPE, nullptr);
    gst_query_add_allocation_meta(query, GST_VIDEO_CROP_META_API_TYPE, nullptr);
    return true;
  }

  GstFlowReturn submit_input_buffer(gboolean discont, GstBuffer* buffer) {
    ledger_.received();
    const auto flow = parent_class()->submit_input_buffer(self(), discont, buffer);
    if (flow == GST_BASE_TRANSFORM_FLOW_DROPPED)
      ledger_.dropped(DropReason::Qos);
    else if (flow != GST_FLOW_OK)
      ledger_.dropped(flow == GST_FLOW_EOS ? DropReason::Eos : DropReason::Error);
    return flow;
  }

  GstFlowReturn prepare_output_buffer(GstBuffer* in, GstBuffer** out) {
    auto buffer = frames_ ? frames_->acquire() : Ref<GstBuffer>();
    if (!buffer) {
      if (frames_) gst::post_error(element(), out_of_memory());
      ledger_.dropped(DropReason::Error);
      return frames_ ? GST_FLOW_ERROR : GST_FLOW_NOT_NEGOTIATED;
    }
    if (!parent_class()->copy_metadata(self(), in, buffer.get()))
      GST_WARNING_OBJECT(self(), "metadata of a buffer could not be copied");
    *out = buffer.release();
    return GST_FLOW_OK;
  }

  GstFlowReturn transform(GstBuffer* in, GstBuffer* out) {
    if (const Status status = frames_->run(in, out); !status) {
      gst::post_error(element(), status.error());
      ledger_.dropped(DropReason::Error);
      return GST_FLOW_ERROR;
    }
    pool_allocated_ = frames_->pool_stats().allocated;
    gst::set_picture_maps(out, frames_->ways_back());
    ledger_.consumed_and_pushed();
    return GST_FLOW_OK;
  }

  void add_stats(GstStructure* stats) const {
    gst_structure_set(stats, "pool-allocated", G_TYPE_UINT64, pool_allocated_.load(), nullptr);
  }

  Settings settings_;
  Ledger ledger_;

 private:
  static Error out_of_memory() {
    return Error{Code::OUT_OF_MEMORY, "no memory for an output buffer", "", "", "", ""};
  }

  static std::vector<TensorSpec> tensors_of(const std::vector<preprocess::Preparation>& all) {
    std::vector<TensorSpec> out;
    for (const auto& preparation : all) out.push_back(preparation.tensor());
    return out;
  }

  // The card is read once, then again when a property changes.
  Result<Request> current() const {
    const Settings s = settings();
    std::lock_guard lock(request_mutex_);
    if (!request_) request_.emplace(request_of(s));
    return *request_;
  }

  // Fixed; other/tensors where that is possible.
  static Ref<GstCaps> first_choice(const GstCaps* caps) {
    guint index = 0;
    while (index < gst_caps_get_size(caps) &&
           !gst_structure_has_name(gst_caps_get_structure(caps, index), "other/tensors"))
      ++index;
    if (index == gst_caps_get_size(caps)) index = 0;
    return Ref<GstCaps>::adopt(gst_caps_fixate(gst_caps_copy_nth(caps, index)));
  }

  Ref<GstCaps> tensors_for(const GstStructure* video, const Result<Request>& request,
                           const GstCaps* filter) const {
    FrameSpec spec;
    spec.format = Format::Static;
    gst_structure_get_fraction(video, "framerate", &spec.rate.numerator, &spec.rate.denominator);
    GstPad* pad = GST_BASE_TRANSFORM_SRC_PAD(self());
    if (!request) {
      spec.tensors.resize(1);
      return gst::possible_caps(pad, spec, filter);
    }
    auto out = Ref<GstCaps>::adopt(gst_caps_new_empty());
    for (auto& tensors : preprocess::possible_frames(*request)) {
      spec.tensors = std::move(tensors);
      auto caps = gst::possible_caps(pad, spec, filter);
      out = Ref<GstCaps>::adopt(gst_caps_merge(out.release(), caps.release()));
    }
    return out;
  }

  // Any video: that no tensor fits is told when caps come, for an empty answer has no words.
  Ref<GstCaps> video_for(const GstStructure* tensors) const {
    auto video =
        Ref<GstCaps>::adopt(gst_pad_get_pad_template_caps(GST_BASE_TRANSFORM_SINK_PAD(self())));
    const GValue* rate = gst_structure_get_value(tensors, "framerate");
    if (!rate) return video;
    video = Ref<GstCaps>::adopt(gst_caps_make_writable(video.release()));
    gst_caps_set_value(video.get(), "framerate", rate);
    return video;
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
    const FrameSpec ours{Format::Static, tensors_of(*preparations), output->rate};
    if (auto difference = first_difference(ours.tensors, output->tensors); !difference.empty())
      return mismatch(ours.to_string(), output->to_string(), difference);
    GstVideoInfo video;
    if (!gst_video_info_from_caps(&video, in))
      return Error{Code::FORMAT_UNSUPPORTED, "the video caps cannot be read", "", "", "", ""};
    auto frames = FramePreprocessor::make(*std::move(preparations), video, settings().threads);
    if (!frames) return frames.error();
    frames_ = *std::move(frames);
    return ok();
  }

  static Error mismatch(std::string offered, std::string needed, std::string difference) {
    return Error{Code::SPEC_MISMATCH,
                 "the element behind tensor_preprocess needs another tensor",
                 std::move(offered),
                 std::move(needed),
                 std::move(difference),
                 "leave width, height, type and layout away: they are taken from behind"};
  }

  // After caps for which no common tensor was found.
  void tell_mismatch(GstCaps* video) {
    GstPad* pad = GST_BASE_TRANSFORM_SRC_PAD(self());
    const auto ours = Ref<GstCaps>::adopt(transform_caps(GST_PAD_SINK, video, nullptr));
    const auto theirs = Ref<GstCaps>::adopt(gst_pad_peer_query_caps(pad, nullptr));
    if (gst_caps_can_intersect(ours.get(), theirs.get())) return;
    std::string difference;
    const auto offered = gst::spec_from_caps(ours.get());
    const auto needed = gst::spec_from_caps(theirs.get());
    if (offered && needed && needed->info_valid())
      difference = first_difference(offered->tensors, needed->tensors);
    gst::post_error(element(),
                    mismatch(gst::UniqueText(gst_caps_to_string(ours.get())).get(),
                             gst::UniqueText(gst_caps_to_string(theirs.get())).get(), difference));
  }

  mutable std::mutex request_mutex_;  // guards request_; never held with the settings lock
  mutable std::optional<Result<Request>> request_;
  std::atomic<uint64_t> pool_allocated_{0};    // shown by stats
  std::unique_ptr<FramePreprocessor> frames_;  // made when caps come; streaming thread
  bool told_ = false;  // whether set_caps said why it failed; streaming thread
};

}  // namespace

bool register_tensor_preprocess(GstPlugin* plugin) {
  return TensorPreprocess::register_in(plugin);
}

}  // namespace weir
