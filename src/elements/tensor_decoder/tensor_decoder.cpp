// tensor_decoder: converts a network's results to labels, pictures or bytes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/video/video.h>

#include <cstring>
#include <memory>
#include <set>
#include <string>

#include "elements/tensor_decoder/class_labels.hpp"
#include "elements/tensor_decoder/frame_decoder.hpp"
#include "gstcpp/buffer/allocation.hpp"
#include "gstcpp/buffer/frame_builder.hpp"
#include "gstcpp/buffer/module_values.hpp"
#include "gstcpp/buffer/result_output.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/counted_transform.hpp"
#include "gstcpp/element/described_caps.hpp"
#include "gstcpp/element/model_event.hpp"
#include "gstcpp/element/property_file.hpp"
#include "gstcpp/pads/early_events.hpp"
#include "gstcpp/pads/expected_caps.hpp"
#include "gstcpp/pads/timed_tensors.hpp"
#include "weir/join.hpp"

namespace weir {
namespace {

using gst::Ref;

// The size of raw video; 0 for other caps.
size_t bytes_of_picture(const GstCaps* caps) {
  GstVideoInfo info;
  const bool raw = gst_structure_has_name(gst_caps_get_structure(caps, 0), "video/x-raw");
  return raw && gst_video_info_from_caps(&info, caps) ? GST_VIDEO_INFO_SIZE(&info) : 0;
}

class TensorDecoder : public gst::CountedTransform<TensorDecoder> {
 public:
  static constexpr gst::ElementInfo kInfo{
      "WeirTensorDecoder", "tensor_decoder", "TensorDecoder", "Converter/Tensor",
      "Converts the outputs of a network to results, labels, pictures or bytes"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE(
          "sink", GST_PAD_SINK, GST_PAD_ALWAYS,
          GST_STATIC_CAPS(WEIR_CAPS_TENSOR
                          "; other/tensors, format=(string)static, num_tensors=(int)[ 1, 256 "
                          "], " WEIR_CAPS_RATE "; " WEIR_CAPS_TENSORS("flexible"))),
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS, GST_STATIC_CAPS_ANY),
  };

  using Settings = DecoderSettings;
  std::string sub_plugins() const { return join(decoder_names(), ","); }
  static constexpr auto kPlaying = gst::Changeable::WhilePlaying;
  static constexpr std::tuple kProperties{
      gst::Property{"silent", &Settings::silent, "Accepted for compatibility; has no effect",
                    gst::Changeable::WhilePlaying},
      gst::Property{
          "mode", &Settings::mode,
          "Name of the decoder, one of sub-plugins; its page (doc-uri) describes all options",
          kPlaying},
      gst::Property{
          "option1", &Settings::option1,
          "image_labeling: label file; direct_video: video format; bounding_boxes, image_segment: "
          "scheme of the tensors; pose_estimation: size of the output, W:H; tensor_region: number "
          "of regions; python3: script; custom-code: name of the function",
          kPlaying},
      gst::Property{"option2", &Settings::option2,
                    "bounding_boxes, tensor_region: label file; image_segment: number of classes; "
                    "pose_estimation: size of the model's input, W:H",
                    kPlaying},
      gst::Property{"option3", &Settings::option3,
                    "bounding_boxes: parameters of the scheme; pose_estimation: key point file; "
                    "tensor_region: file of prior boxes, then its parameters",
                    kPlaying},
      gst::Property{"option4", &Settings::option4,
                    "bounding_boxes: size of the output, W:H; pose_estimation: heatmap-only or "
                    "heatmap-offset; tensor_region: size of the model's input, W:H",
                    kPlaying},
      gst::Property{"option5", &Settings::option5, "bounding_boxes: size of the model's input, W:H",
                    kPlaying},
      gst::Property{"option6", &Settings::option6,
                    "bounding_boxes: 1 = number objects from frame to frame", kPlaying},
      gst::Property{"option7", &Settings::option7,
                    "bounding_boxes: 1 = log the boxes at level INFO", kPlaying},
      gst::Property{"option8", &Settings::option8,
                    "bounding_boxes: accepted for compatibility; has no effect", kPlaying},
      gst::Property{"option9", &Settings::option9,
                    "For decoders built for NNStreamer; no decoder of Weir uses it", kPlaying},
      gst::Property{"threshold", &Settings::threshold,
                    "Minimum score of a result, 0 to 1; -1 = the default of the mode", kPlaying,
                    -1.0f, 1.0f},
      gst::Property{"iou", &Settings::iou,
                    "Overlap, 0 to 1, beyond which the weaker of two results is removed; -1 = the "
                    "default of the mode",
                    kPlaying, -1.0f, 1.0f},
      gst::Property{"labels", &Settings::labels,
                    "Path of a label file with one line for each class", kPlaying},
      gst::Property{"max-results", &Settings::max_results,
                    "Maximum number of results of a frame; 0 = the default of the mode", kPlaying,
                    0u, 65536u},
      gst::Property{"classes", &Settings::classes,
                    "Classes to keep: labels or numbers, separated by ','; unset = all", kPlaying},
      gst::Property{"custom", &Settings::custom,
                    "More options of the mode: key:value, separated by ','", kPlaying},
      gst::Property{"config-file", &Settings::config_file,
                    "File with lines of property=value, read when this is set", kPlaying},
      gst::ReadOnly{"sub-plugins", &TensorDecoder::sub_plugins, "Installed decoders"},
  };

  Status check_change(const char* name, const Settings& wanted) const {
    if (std::strcmp(name, "config-file") != 0) return ok();
    return gst::check_property_file(wanted.config_file);
  }
  void property_changed(const char* name) {
    expected_.forget();
    if (std::strcmp(name, "config-file") != 0) return;
    config_file_.read(G_OBJECT(element()), settings().config_file);
  }

  Status start() {
    ledger_.reset();
    if (auto status = config_file_.report(element()); !status) return status;
    model_.reset();
    auto opened = open_for_stream(take_settings(&followed_));
    if (!opened) return opened.error();
    waiting_ = false;
    use(*std::move(opened));
    return ok();
  }
  bool stop() {
    std::lock_guard lock(probe_mutex_);
    decoder_.reset();
    probe_.reset();
    probe_model_.reset();
    expected_.forget();
    input_ = {};
    results_.configure(nullptr);
    early_.clear();
    return true;
  }

  GstCaps* transform_caps(GstPadDirection direction, GstCaps* caps, GstCaps* filter) {
    return caps_of_other_pad(direction, filter, [&] { return output_or_empty(caps); });
  }

  Status set_caps(GstCaps* in, GstCaps* out) {
    auto spec = gst::fixed_spec_from_caps(in);
    if (!spec) return spec.error();
    input_ = *std::move(spec);
    input_caps_ = Ref<GstCaps>::share(in);
    decoder_->set_caps(in);
    auto caps = decoder_->configure(input_);
    picture_bytes_ = bytes_of_picture(out);
    results_.configure(out);
    return caps ? ok() : Status(caps.error());
  }

  GstFlowReturn prepare_output_buffer(GstBuffer* in, GstBuffer** out) {
    *out = gst_buffer_new();
    gst_buffer_copy_into(*out, in, GST_BUFFER_COPY_METADATA, 0, static_cast<gsize>(-1));
    return GST_FLOW_OK;
  }

  gboolean query(GstPadDirection direction, GstQuery* query) {
    if (direction == GST_PAD_SRC && GST_QUERY_TYPE(query) == GST_QUERY_CAPS &&
        gst_pad_is_active(GST_BASE_TRANSFORM_SRC_PAD(self())) &&
        !gst_pad_has_current_caps(GST_BASE_TRANSFORM_SINK_PAD(self()))) {
      GstCaps* filter = nullptr;
      gst_query_parse_caps(query, &filter);
      const auto expected =
          expected_.query(GST_BASE_TRANSFORM_SINK_PAD(self()), filter,
                          [this](GstCaps* input) { return expected_caps(input); });
      if (!gst_caps_is_empty(expected.get())) {
        gst_query_set_caps_result(query, expected.get());
        return TRUE;
      }
    }
    if (direction != GST_PAD_SINK || GST_QUERY_TYPE(query) != GST_QUERY_ACCEPT_CAPS)
      return gst::with_static_filter(query, [&](GstQuery* described) {
        return parent_class()->query(self(), direction, described);
      });
    // Accepts caps that the decoder rejects: sink_event then posts the reason.
    GstCaps* caps = nullptr;
    gst_query_parse_accept_caps(query, &caps);
    gst_query_set_accept_caps_result(query, gst_caps_can_intersect(caps, input_template().get()));
    return TRUE;
  }

  gboolean sink_event(GstEvent* event) {
    if (gst::is_model_event(event)) {
      follow_model(Ref<GstEvent>::adopt(event));
      return TRUE;
    }
    if (GST_EVENT_TYPE(event) == GST_EVENT_CAPS && !input_.valid()) follow_early_properties(event);
    if (hold(event)) return TRUE;
    switch (GST_EVENT_TYPE(event)) {
      case GST_EVENT_STREAM_START:
        set_model(nullptr);
        labels_.clear();
        warned_.clear();
        break;
      case GST_EVENT_CUSTOM_DOWNSTREAM_STICKY:
        labels_.receive(event, decoder_.get());
        break;
      case GST_EVENT_FLUSH_STOP:
        if (decoder_) decoder_->reset();
        break;
      case GST_EVENT_GAP:
        if (push_frame_of_gap(event)) return gst_event_unref(event), TRUE;
        break;
      case GST_EVENT_CAPS:
        return handle_caps_event(event);
      default:
        break;
    }
    return parent_class()->sink_event(self(), event);
  }

  GstFlowReturn submit_input_buffer(gboolean discont, GstBuffer* buffer) {
    if (waiting_ && !begin()) {
      ledger_.received();
      gst_buffer_unref(buffer);
      ledger_.dropped(DropReason::Error);
      return GST_FLOW_NOT_NEGOTIATED;
    }
    if (decoder_ && input_.valid() && is_written()) follow_properties();
    return gst::CountedTransform<TensorDecoder>::submit_input_buffer(discont, buffer);
  }

  GstFlowReturn transform(GstBuffer* in, GstBuffer* out) {
    const auto kept = decode(in, out);
    if (kept && !*kept && reader_.has_empty_tensor())
      if (auto gap = gst::gap_like(in))
        gst_pad_push_event(GST_BASE_TRANSFORM_SRC_PAD(self()), gap.release());
    reader_.clear();
    if (!kept) return failed(kept.error());
    if (!*kept) {
      ledger_.dropped(DropReason::Policy);
      return GST_BASE_TRANSFORM_FLOW_DROPPED;
    }
    ledger_.consumed_and_pushed();
    return GST_FLOW_OK;
  }

  Settings settings_;
  BufferLimit buffer_limit_{kInfo.factory_name};

 private:
  static Result<OpenDecoder> open_as(const Settings& s) {
    auto options = make_options(s);
    if (!options) return options.error();
    return open_decoder(s.mode, *std::move(options));
  }
  // Opens a decoder that knows the model of the stream.
  Result<OpenDecoder> open_for_stream(const Settings& s) {
    auto opened = open_as(s);
    if (!opened) return opened;
    const auto model = model_for(*opened->decoder, s);
    opened->decoder->set_model(model);
    opened->probe->set_model(model);
    return opened;
  }
  // The model of the stream, with the labels of its card where the decoder needs them.
  std::shared_ptr<const DescribedModel> model_for(const FrameDecoder& decoder, const Settings& s) {
    if (!model_ || !decoder.uses_model() || !s.labels.value_or("").empty()) return model_;
    DescribedModel out = *model_;
    labels_.add_card_labels(&out);
    return std::make_shared<const DescribedModel>(std::move(out));
  }
  void use(OpenDecoder opened) {
    for (const auto& warning : opened.warnings) gst::post_warning(element(), warning);
    labels_.pass_to(opened.decoder.get());
    std::lock_guard lock(probe_mutex_);
    decoder_ = std::move(opened.decoder);
    probe_ = std::move(opened.probe);
    expected_.forget();
  }

  gboolean handle_caps_event(GstEvent* event) {
    GstCaps* caps = nullptr;
    gst_event_parse_caps(event, &caps);
    const auto held = Ref<GstCaps>::share(caps);
    const uint64_t errors_before = gst::errors_posted_by_this_thread();
    if (parent_class()->sink_event(self(), event)) return send_labels(), replay(), TRUE;
    if (errors_before == gst::errors_posted_by_this_thread()) report_refusal(held.get());
    return FALSE;
  }

  // A model event may follow the caps, as from a capsfilter. Caps that the decoder rejects without
  // it wait for it, and so do the events after them, until the first frame.
  bool hold(GstEvent* event) {
    const auto type = GST_EVENT_TYPE(event);
    if (type == GST_EVENT_CAPS) {
      GstCaps* caps = nullptr;
      gst_event_parse_caps(event, &caps);
      waiting_ = may_wait_for_model(caps);
      if (waiting_) gst_event_unref(event);  // they stay on the sink pad
      return waiting_;
    }
    if (type == GST_EVENT_FLUSH_STOP || type == GST_EVENT_STREAM_START) early_.clear();
    const bool is_serialized = (gst_event_type_get_flags(type) & GST_EVENT_TYPE_SERIALIZED) != 0;
    // Others come on any thread.
    if (!is_serialized || !waiting_ || type == GST_EVENT_FLUSH_STOP ||
        type == GST_EVENT_STREAM_START)
      return false;
    if (type == GST_EVENT_EOS) return replay(), false;
    early_.push(Ref<GstEvent>::adopt(event));
    return true;
  }
  bool may_wait_for_model(GstCaps* caps) {
    if (!decoder_ || !decoder_->uses_model()) return false;
    const auto spec = gst::fixed_spec_from_caps(caps);
    if (!spec || (model_ && has_outputs(*model_, *spec))) return false;
    std::lock_guard lock(probe_mutex_);
    probe_->set_caps(caps);
    return !probe_->configure(*spec);
  }
  // Called at the first frame, or with the model: takes the caps that wait.
  bool begin() {
    const auto caps =
        Ref<GstCaps>::adopt(gst_pad_get_current_caps(GST_BASE_TRANSFORM_SINK_PAD(self())));
    waiting_ = false;
    return caps && handle_caps_event(gst_event_new_caps(caps.get()));
  }
  void send_labels() {
    if (!results_.is_results()) return;
    if (const auto missing = labels_.missing(*decoder_, followed_.in_force.labels.value_or("")))
      gst::post_warning(element(), *missing);
    labels_.send(*decoder_, results_.source(), GST_BASE_TRANSFORM_SRC_PAD(self()));
  }
  void replay() {
    for (auto& event : early_.take()) sink_event(event.release());
  }

  void set_model(std::shared_ptr<const DescribedModel> model) {
    if (!model && !model_) return;
    model_ = std::move(model);
    auto known = decoder_ ? model_for(*decoder_, followed_.in_force) : model_;
    std::lock_guard lock(probe_mutex_);
    if (decoder_) decoder_->set_model(known);
    if (probe_) probe_->set_model(known);
    probe_model_ = std::move(known);
    expected_.forget();
  }
  // Between two frames: a decoder that has read the stream without this model is opened again.
  void follow_model(const Ref<GstEvent>& event) {
    auto described = gst::parse_model_event(event.get());
    if (!described) {
      GST_CAT_WARNING_OBJECT(category(), self(),
                             "ignored an event that describes no model: %" GST_PTR_FORMAT,
                             static_cast<void*>(event.get()));
      return;
    }
    if (model_ && *model_ == *described) return;
    set_model(std::make_shared<const DescribedModel>(*std::move(described)));
    if (waiting_) return static_cast<void>(begin());
    if (!decoder_ || !decoder_->uses_model() || !input_.valid()) return;
    if (!has_outputs(*model_, input_)) return;  // their caps follow
    if (const Status status = follow(followed_.in_force); !status)
      return gst::post_error(element(), status.error());
    gst_base_transform_reconfigure_src(self());
  }

  // Without it, an element that joins results with other streams would wait.
  bool push_frame_of_gap(GstEvent* gap) {
    if (!results_.is_results()) return false;
    auto frame = results_.frame_of_gap(gap, buffer_limit_);
    if (!frame) {
      gst::post_error(element(), frame.error());
      return true;
    }
    if (!*frame) return false;
    ledger_.pushed();
    gst_pad_push(GST_BASE_TRANSFORM_SRC_PAD(self()), frame->release());
    return true;
  }

  // Called between two frames: replaces the decoder if the stream can continue with the new one.
  void follow_properties() {
    if (follow_settings(&followed_, [this](const Settings& wanted) { return follow(wanted); }))
      gst_base_transform_reconfigure_src(self());
  }
  // At the first caps: with properties that cannot read them, the stream goes on as before.
  void follow_early_properties(GstEvent* event) {
    if (!decoder_) return;
    GstCaps* caps = nullptr;
    gst_event_parse_caps(event, &caps);
    follow_settings(&followed_, [this, caps](const Settings& wanted) {
      auto opened = open_for_stream(wanted);
      if (!opened) return Status(opened.error());
      if (auto made = configure_with(opened->probe.get(), caps); !made) return Status(made.error());
      use(*std::move(opened));
      return ok();
    });
  }
  Status follow(const Settings& wanted) {
    auto opened = open_for_stream(wanted);
    if (!opened) return opened.error();
    // GstBaseTransform does not set unchanged caps again, so the decoder is configured here.
    opened->decoder->set_caps(input_caps_.get());
    opened->probe->set_caps(input_caps_.get());
    const auto caps = opened->decoder->configure(input_);
    if (!caps) return caps.error();
    if (auto status = gst::check_downstream(GST_BASE_TRANSFORM_SRC_PAD(self()), caps->get(),
                                            "another mode= of tensor_decoder");
        !status)
      return status;
    if (auto probed = opened->probe->configure(input_); !probed) return probed.error();
    picture_bytes_ = bytes_of_picture(caps->get());
    results_.configure(caps->get());
    use(*std::move(opened));
    send_labels();
    return ok();
  }

  Ref<GstCaps> input_template() const {
    return Ref<GstCaps>::adopt(gst_pad_get_pad_template_caps(GST_BASE_TRANSFORM_SINK_PAD(self())));
  }

  // For queries, which must not post errors.
  Ref<GstCaps> output_or_empty(GstCaps* caps) {
    auto out = output_for(caps);
    if (out) return *std::move(out);
    GST_CAT_DEBUG_OBJECT(category(), self(), "no output for these caps: %s",
                         out.error().message().c_str());
    return Ref<GstCaps>::adopt(gst_caps_new_empty());
  }

  Result<Ref<GstCaps>> output_for(GstCaps* caps) {
    std::lock_guard lock(probe_mutex_);
    return configure_with(probe_.get(), caps);
  }
  static Result<Ref<GstCaps>> configure_with(FrameDecoder* decoder, GstCaps* caps) {
    if (!decoder || !gst_caps_is_fixed(caps)) return Ref<GstCaps>::adopt(gst_caps_new_any());
    const auto spec = gst::fixed_spec_from_caps(caps);
    if (!spec) return spec.error();
    decoder->set_caps(caps);
    return decoder->configure(*spec);
  }

  // The output for such an input, with any framerate. Empty if the decoder cannot read it, or more
  // is open: elements of tensors offer open caps after those of their stream.
  Ref<GstCaps> expected_caps(GstCaps* input) {
    gst_caps_set_simple(input, "framerate", GST_TYPE_FRACTION, 0, 1, nullptr);
    auto made = expected_output(input);
    if (!made || gst_caps_is_any(made->get())) return Ref<GstCaps>::adopt(gst_caps_new_empty());
    auto open = Ref<GstCaps>::adopt(gst_caps_make_writable(made->release()));
    gst_caps_set_simple(open.get(), "framerate", GST_TYPE_FRACTION_RANGE, 0, 1, G_MAXINT, 1,
                        nullptr);
    return open;
  }
  // As the properties are now: the caps will apply those written since the start.
  Result<Ref<GstCaps>> expected_output(GstCaps* input) {
    auto written = is_written() ? open_as(settings()) : Result<OpenDecoder>(OpenDecoder{});
    std::lock_guard lock(probe_mutex_);
    if (!written || !written->probe) return configure_with(probe_.get(), input);
    written->probe->set_model(probe_model_);
    return configure_with(written->probe.get(), input);
  }

  // Posts the reason when GstBaseTransform rejected caps without an error.
  void report_refusal(GstCaps* caps) {
    const auto output = output_for(caps);
    if (!output) return gst::post_error(element(), output.error());
    const auto& ours = *output;
    const bool picture =
        !gst_caps_is_any(ours.get()) && !gst_caps_is_empty(ours.get()) &&
        gst_structure_has_name(gst_caps_get_structure(ours.get(), 0), "video/x-raw");
    const Status status = gst::check_downstream(
        GST_BASE_TRANSFORM_SRC_PAD(self()), ours.get(),
        picture ? "tensor_decoder ! videoconvert ! videoscale" : "another mode= of tensor_decoder");
    if (!status) gst::post_error(element(), status.error());
  }

  // Equal warnings of the frames of a stream are one.
  void post_once(const Error& warning) {
    constexpr size_t kMaxWarnings = 64;
    if (warned_.size() < kMaxWarnings && warned_.insert(warning.message()).second)
      gst::post_warning(element(), warning);
  }

  Result<bool> decode(GstBuffer* in, GstBuffer* out) {
    if (auto status = reader_.read(in, input_); !status) return status.error();
    ledger_.copied(reader_.bytes_copied());
    if (reader_.has_empty_tensor() && !decoder_->reads_results()) return write_nothing_found(out);
    decoder_->set_times(gst::abi_time(gst::running_time(self()->segment, GST_BUFFER_PTS(in))),
                        gst::get_unix_time(in, self()->segment, element()));
    auto kept = decoder_->decode(input_, in, reader_, out, buffer_limit_, &ledger_);
    if (const auto warning = decoder_->warning()) post_once(*warning);
    if (kept && *kept && gst_buffer_get_size(out) < picture_bytes_)
      return Error{.code = Code::FRAME_SIZE,
                   .what = "the output of the decoder is smaller than a picture of its caps",
                   .offered = std::to_string(gst_buffer_get_size(out)) + " bytes",
                   .needed = std::to_string(picture_bytes_) + " bytes",
                   .fix = "correct the decoder " + settings().mode};
    if (kept && *kept && results_.is_results())
      if (auto status = results_.place(out); !status) return status.error();
    return kept;
  }

  // False: the output cannot say so, and the frame is dropped.
  Result<bool> write_nothing_found(GstBuffer* out) {
    if (picture_bytes_ > 0) return write_transparent_picture(out);
    if (!results_.is_results()) return false;
    auto frame = results_.empty_frame(buffer_limit_);
    if (!frame) return frame.error();
    if (!*frame) return false;
    gst_buffer_copy_into(out, frame->get(), GST_BUFFER_COPY_MEMORY, 0, static_cast<gsize>(-1));
    if (auto status = results_.place(out); !status) return status.error();
    return true;
  }

  Result<bool> write_transparent_picture(GstBuffer* out) const {
    auto memory = gst::allocate_memory(picture_bytes_);
    if (!memory) return memory.error();
    gst_buffer_append_memory(out, memory->release());
    gst_buffer_memset(out, 0, 0, picture_bytes_);
    return true;
  }

  std::mutex probe_mutex_;               // guards probe_ and probe_model_
  std::shared_ptr<FrameDecoder> probe_;  // answers caps queries on any thread
  std::shared_ptr<const DescribedModel> probe_model_;
  gst::ExpectedCaps expected_;
  std::shared_ptr<FrameDecoder> decoder_;  // streaming thread
  FrameSpec input_;                        // streaming thread
  Ref<GstCaps> input_caps_;                // streaming thread
  size_t picture_bytes_ = 0;               // streaming thread; of the output; 0: not raw video
  gst::ResultOutput results_;              // streaming thread
  ClassLabels labels_;                     // streaming thread
  std::shared_ptr<const DescribedModel> model_;  // of the stream; null: not known; streaming thread
  bool waiting_ = false;                         // caps wait for the model; streaming thread
  gst::EarlyEvents early_;                       // what came after them
  gst::FrameLayout reader_;                      // streaming thread
  gst::PropertyFile config_file_;
  std::set<std::string> warned_;          // by frames of the stream; streaming thread
  gst::LiveSettings<Settings> followed_;  // the settings of decoder_; streaming thread
};

}  // namespace

bool register_tensor_decoder(GstPlugin* plugin) {
  return TensorDecoder::register_in(plugin);
}

}  // namespace weir
