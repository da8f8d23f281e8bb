// tensor_preprocess: decoded video becomes a network's input tensor in one pass over the pixels.
#include <atomic>
#include <memory>

#include "core/preprocess/request.hpp"
#include "elements/tensor_preprocess/frame_preprocessor.hpp"
#include "elements/tensor_preprocess/preprocess_settings.hpp"
#include "gstcpp/counted_transform.hpp"
#include "gstcpp/tensor_caps.hpp"
#include "gstcpp/tensor_meta.hpp"

namespace weir {
namespace {

using gst::Ref;
using preprocess::Request;

class TensorPreprocess : public gst::CountedTransform<TensorPreprocess> {
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
      GST_STATIC_PAD_TEMPLATE(
          "src", GST_PAD_SRC, GST_PAD_ALWAYS,
          GST_STATIC_CAPS(WEIR_CAPS_TENSOR "; " WEIR_CAPS_TENSORS("{ static, flexible }"))),
  };

  using Settings = PreprocessSettings;
  static constexpr auto kProperties = kPreprocessProperties;

  Status start() {
    ledger_.reset();
    regions_ = regions_empty_ = regions_beyond_limit_ = 0;
    property_changed("card");  // the file may have changed
    const auto request = current();
    if (!request) return request.error();
    return ok();
  }

  bool stop() {
    work_.reset();
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
          spec->tensors = preprocess::tensors_of(*request, *p);
          const auto closed =
              gst::possible_caps(GST_BASE_TRANSFORM_SRC_PAD(self()), *spec, one.get());
          auto meet = Ref<GstCaps>::adopt(gst_caps_intersect(one.get(), closed.get()));
          if (!gst_caps_is_empty(meet.get())) open = std::move(meet);
        }
    }
    return gst_caps_fixate(open.release());
  }

  Status set_caps(GstCaps* in, GstCaps* out) {
    work_.reset();
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
    if (settings().regions == RegionsChoice::Meta)
      gst_query_add_allocation_meta(query, GST_VIDEO_REGION_OF_INTEREST_META_API_TYPE, nullptr);
    return true;
  }

  gboolean decide_allocation(GstQuery* query) {
    if (work_)
      if (const Status status = work_->allocate_as(gst::allocation_of(query)); !status)
        return gst::post_error(element(), status.error()), FALSE;
    return parent_class()->decide_allocation(self(), query);
  }

  GstFlowReturn prepare_output_buffer(GstBuffer* in, GstBuffer** out) {
    if (!work_) {
      ledger_.dropped(DropReason::Error);
      return GST_FLOW_NOT_NEGOTIATED;
    }
    auto buffer = work_->acquire(in);
    if (!buffer) return failed(buffer.error());
    copy_metadata(in, buffer->get());
    *out = buffer->release();
    return GST_FLOW_OK;
  }

  GstFlowReturn transform(GstBuffer* in, GstBuffer* out) {
    if (const Status status = work_->run(in, out); !status) return failed(status.error());
    pool_allocated_ = work_->allocated();
    const RegionCounts regions = work_->regions();
    regions_ += regions.prepared;
    regions_empty_ += regions.empty;
    regions_beyond_limit_ += regions.beyond_limit;
    auto ways_back = work_->ways_back();
    if (ways_back.empty()) return nothing_of(in);
    gst::set_picture_maps(out, std::move(ways_back));
    ledger_.consumed_and_pushed();
    return GST_FLOW_OK;
  }

  void add_stats(GstStructure* stats) const {
    gst_structure_set(stats, "pool-allocated", G_TYPE_UINT64, pool_allocated_.load(), "regions",
                      G_TYPE_UINT64, regions_.load(), "regions-empty", G_TYPE_UINT64,
                      regions_empty_.load(), "regions-beyond-limit", G_TYPE_UINT64,
                      regions_beyond_limit_.load(), nullptr);
  }

  Settings settings_;

 private:
  // A frame without regions: those behind learn that its time has passed.
  GstFlowReturn nothing_of(GstBuffer* in) {
    ledger_.dropped(DropReason::Policy);
    if (GST_BUFFER_PTS_IS_VALID(in))
      gst_pad_push_event(GST_BASE_TRANSFORM_SRC_PAD(self()),
                         gst_event_new_gap(GST_BUFFER_PTS(in), GST_BUFFER_DURATION(in)));
    return GST_BASE_TRANSFORM_FLOW_DROPPED;
  }

  static bool flexible(const Request& request) {
    return request.regions && request.most_regions == 0;
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
    gst_structure_get_fraction(video, "framerate", &spec.rate.numerator, &spec.rate.denominator);
    GstPad* pad = GST_BASE_TRANSFORM_SRC_PAD(self());
    if (!request) {
      spec.format = Format::Static;
      spec.tensors.resize(1);
      return gst::possible_caps(pad, spec, filter);
    }
    spec.format = flexible(*request) ? Format::Flexible : Format::Static;
    if (spec.format == Format::Flexible) return gst::possible_caps(pad, spec, filter);
    auto out = Ref<GstCaps>::adopt(gst_caps_new_empty());
    for (auto& tensors : preprocess::possible_frames(*request)) {
      spec.tensors = std::move(tensors);
      auto caps = gst::possible_caps(pad, spec, filter);
      out = Ref<GstCaps>::adopt(gst_caps_merge(out.release(), caps.release()));
    }
    // Static tensors could be carried as flexible ones too: nobody asked for that here.
    const auto fixed = Ref<GstCaps>::adopt(
        gst_caps_from_string(WEIR_CAPS_TENSOR "; " WEIR_CAPS_TENSORS("static")));
    return Ref<GstCaps>::adopt(
        gst_caps_intersect_full(out.get(), fixed.get(), GST_CAPS_INTERSECT_FIRST));
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
    const FrameSpec ours{Format::Static, preprocess::tensors_of(*request, *preparations),
                         output->rate};
    if (auto difference = first_difference(ours.tensors, output->tensors);
        !difference.empty() && !flexible(*request))
      return mismatch(ours.to_string(), output->to_string(), difference);
    GstVideoInfo video;
    if (!gst_video_info_from_caps(&video, in))
      return Error{Code::FORMAT_UNSUPPORTED, "the video caps cannot be read", "", "", "", ""};
    return begin(*request, *std::move(preparations), video);
  }

  Status begin(const Request& request, std::vector<preprocess::Preparation> preparations,
               const GstVideoInfo& video) {
    const size_t threads = settings().threads;
    if (request.regions) {
      auto regions = RegionPreprocessor::make(std::move(preparations[0]), video,
                                              request.most_regions, threads);
      if (!regions) return regions.error();
      work_ = *std::move(regions);
      return ok();
    }
    auto frames = FramePreprocessor::make(std::move(preparations), video, threads);
    if (!frames) return frames.error();
    work_ = *std::move(frames);
    return ok();
  }

  Error mismatch(std::string offered, std::string needed, std::string difference) const {
    const auto request = current();
    return Error{Code::SPEC_MISMATCH,
                 "the element behind tensor_preprocess needs another tensor",
                 std::move(offered),
                 std::move(needed),
                 std::move(difference),
                 request && flexible(*request)
                     ? "regions=meta max-regions=16 makes a static tensor"
                     : "leave width, height, type and layout away: they are taken from behind"};
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
    if (offered && needed && !offered->tensors.empty() && needed->info_valid())
      difference = first_difference(offered->tensors, needed->tensors);
    gst::post_error(element(),
                    mismatch(gst::UniqueText(gst_caps_to_string(ours.get())).get(),
                             gst::UniqueText(gst_caps_to_string(theirs.get())).get(), difference));
  }

  mutable std::mutex request_mutex_;  // guards request_; never held with the settings lock
  mutable std::optional<Result<Request>> request_;
  std::atomic<uint64_t> pool_allocated_{0};  // shown by stats
  std::atomic<uint64_t> regions_{0}, regions_empty_{0}, regions_beyond_limit_{0};
  std::unique_ptr<PictureWork> work_;  // made when caps come; streaming thread
  bool told_ = false;                  // whether set_caps said why it failed; streaming thread
};

}  // namespace

bool register_tensor_preprocess(GstPlugin* plugin) {
  return TensorPreprocess::register_in(plugin);
}

}  // namespace weir
