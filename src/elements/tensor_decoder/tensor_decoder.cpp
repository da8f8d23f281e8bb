// tensor_decoder: converts a network's results to labels, pictures or bytes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/video/video.h>

#include <cstring>
#include <memory>

#include "elements/tensor_decoder/frame_decoder.hpp"
#include "gstcpp/buffer/capture_time.hpp"
#include "gstcpp/buffer/module_values.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/counted_transform.hpp"
#include "gstcpp/element/property_file.hpp"
#include "gstcpp/pads/timed_tensors.hpp"

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
      "Turns the results of a network into labels, pictures or bytes"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE(
          "sink", GST_PAD_SINK, GST_PAD_ALWAYS,
          GST_STATIC_CAPS(WEIR_CAPS_TENSOR
                          "; other/tensors, format=(string)static, num_tensors=(int)[ 1, 256 "
                          "], " WEIR_CAPS_RATE "; " WEIR_CAPS_TENSORS("flexible"))),
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS, GST_STATIC_CAPS_ANY),
  };

  struct Settings {
    bool silent = true;
    std::string mode;
    std::optional<std::string> option1, option2, option3, option4, option5, option6, option7,
        option8, option9;
    std::string config_file;
  };
  std::string sub_plugins() const {
    std::string out;
    for (const auto& name : decoder_names()) out += (out.empty() ? "" : ",") + name;
    return out;
  }
  static constexpr char kOption[] = "An option of the decoder; see its README";
  static constexpr auto kPlaying = gst::Changeable::WhilePlaying;
  static constexpr std::tuple kProperties{
      gst::Property{"silent", &Settings::silent, "Accepted for compatibility; has no effect",
                    gst::Changeable::WhilePlaying},
      gst::Property{"mode", &Settings::mode, "Name of the decoder", kPlaying},
      gst::Property{"option1", &Settings::option1, kOption, kPlaying},
      gst::Property{"option2", &Settings::option2, kOption, kPlaying},
      gst::Property{"option3", &Settings::option3, kOption, kPlaying},
      gst::Property{"option4", &Settings::option4, kOption, kPlaying},
      gst::Property{"option5", &Settings::option5, kOption, kPlaying},
      gst::Property{"option6", &Settings::option6, kOption, kPlaying},
      gst::Property{"option7", &Settings::option7, kOption, kPlaying},
      gst::Property{"option8", &Settings::option8, kOption, kPlaying},
      gst::Property{"option9", &Settings::option9, kOption, kPlaying},
      gst::Property{"config-file", &Settings::config_file,
                    "File with lines of property=value, read when this is set", kPlaying},
      gst::ReadOnly{"sub-plugins", &TensorDecoder::sub_plugins, "Decoders that are installed"},
  };

  void property_changed(const char* name) {
    if (std::strcmp(name, "config-file") != 0) return;
    config_file_.read(G_OBJECT(element()), settings().config_file);
  }

  Status start() {
    ledger_.reset();
    if (auto status = config_file_.report(element()); !status) return status;
    auto opened = open_as(take_settings(&followed_));
    if (!opened) return opened.error();
    use(*std::move(opened));
    return ok();
  }
  bool stop() {
    std::lock_guard lock(probe_mutex_);
    decoder_.reset();
    probe_.reset();
    return true;
  }

  GstCaps* transform_caps(GstPadDirection direction, GstCaps* caps, GstCaps* filter) {
    auto result = direction == GST_PAD_SRC ? input_template() : output_or_empty(caps);
    if (!filter) return result.release();
    return gst_caps_intersect_full(filter, result.get(), GST_CAPS_INTERSECT_FIRST);
  }

  Status set_caps(GstCaps* in, GstCaps* out) {
    auto spec = gst::fixed_spec_from_caps(in);
    if (!spec) return spec.error();
    input_ = *std::move(spec);
    input_caps_ = Ref<GstCaps>::share(in);
    decoder_->set_caps(in);
    auto caps = decoder_->configure(input_);
    picture_bytes_ = bytes_of_picture(out);
    return caps ? ok() : Status(caps.error());
  }

  GstFlowReturn prepare_output_buffer(GstBuffer* in, GstBuffer** out) {
    *out = gst_buffer_new();
    gst_buffer_copy_into(*out, in, GST_BUFFER_COPY_METADATA, 0, static_cast<gsize>(-1));
    return GST_FLOW_OK;
  }

  gboolean query(GstPadDirection direction, GstQuery* query) {
    if (direction != GST_PAD_SINK || GST_QUERY_TYPE(query) != GST_QUERY_ACCEPT_CAPS)
      return parent_class()->query(self(), direction, query);
    // Accepts caps that the decoder rejects: sink_event then posts the reason.
    GstCaps* caps = nullptr;
    gst_query_parse_accept_caps(query, &caps);
    gst_query_set_accept_caps_result(query, gst_caps_can_intersect(caps, input_template().get()));
    return TRUE;
  }

  gboolean sink_event(GstEvent* event) {
    const bool flushed = GST_EVENT_TYPE(event) == GST_EVENT_FLUSH_STOP;
    if (flushed && decoder_) decoder_->reset();
    if (GST_EVENT_TYPE(event) != GST_EVENT_CAPS) return parent_class()->sink_event(self(), event);
    GstCaps* caps = nullptr;
    gst_event_parse_caps(event, &caps);
    const auto held = Ref<GstCaps>::share(caps);
    const uint64_t told = gst::errors_posted_by_this_thread();
    if (parent_class()->sink_event(self(), event)) return TRUE;
    if (told == gst::errors_posted_by_this_thread()) report_refusal(held.get());
    return FALSE;
  }

  GstFlowReturn submit_input_buffer(gboolean discont, GstBuffer* buffer) {
    if (decoder_ && input_.valid() && is_written()) follow_properties();
    return gst::CountedTransform<TensorDecoder>::submit_input_buffer(discont, buffer);
  }

  GstFlowReturn transform(GstBuffer* in, GstBuffer* out) {
    const auto kept = decode(in, out);
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
    return open_decoder(s.mode, {s.option1, s.option2, s.option3, s.option4, s.option5, s.option6,
                                 s.option7, s.option8, s.option9});
  }
  void use(OpenDecoder opened) {
    for (const auto& warning : opened.warnings) gst::post_warning(element(), warning);
    std::lock_guard lock(probe_mutex_);
    decoder_ = std::move(opened.decoder);
    probe_ = std::move(opened.probe);
  }

  // Called between two frames: replaces the decoder if the stream can continue with the new one.
  void follow_properties() {
    if (follow_settings(&followed_, [this](const Settings& wanted) { return follow(wanted); }))
      gst_base_transform_reconfigure_src(self());
  }
  Status follow(const Settings& wanted) {
    auto opened = open_as(wanted);
    if (!opened) return opened.error();
    // GstBaseTransform does not set unchanged caps again, so the decoder is configured here.
    opened->decoder->set_caps(input_caps_.get());
    opened->probe->set_caps(input_caps_.get());
    const auto caps = opened->decoder->configure(input_);
    if (!caps) return caps.error();
    GstPad* pad = GST_BASE_TRANSFORM_SRC_PAD(self());
    const auto theirs = Ref<GstCaps>::adopt(gst_pad_peer_query_caps(pad, nullptr));
    if (!gst_caps_can_intersect(caps->get(), theirs.get()))
      return gst::downstream_mismatch(pad, theirs.get(),
                                      gst::UniqueText(gst_caps_to_string(caps->get())).get(),
                                      "another mode= of tensor_decoder");
    if (auto probed = opened->probe->configure(input_); !probed) return probed.error();
    picture_bytes_ = bytes_of_picture(caps->get());
    use(*std::move(opened));
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
    const auto any = [] { return Ref<GstCaps>::adopt(gst_caps_new_any()); };
    if (!gst_caps_is_fixed(caps)) return any();
    std::lock_guard lock(probe_mutex_);
    if (!probe_) return any();
    const auto spec = gst::fixed_spec_from_caps(caps);
    if (!spec) return spec.error();
    probe_->set_caps(caps);
    return probe_->configure(*spec);
  }

  // Posts the reason when GstBaseTransform rejected caps without an error.
  void report_refusal(GstCaps* caps) {
    const auto output = output_for(caps);
    if (!output) return gst::post_error(element(), output.error());
    const auto& ours = *output;
    GstPad* pad = GST_BASE_TRANSFORM_SRC_PAD(self());
    const auto theirs = Ref<GstCaps>::adopt(gst_pad_peer_query_caps(pad, nullptr));
    if (gst_caps_can_intersect(ours.get(), theirs.get())) return;
    const bool picture =
        !gst_caps_is_any(ours.get()) && !gst_caps_is_empty(ours.get()) &&
        gst_structure_has_name(gst_caps_get_structure(ours.get(), 0), "video/x-raw");
    gst::post_error(element(),
                    gst::downstream_mismatch(pad, theirs.get(),
                                             gst::UniqueText(gst_caps_to_string(ours.get())).get(),
                                             picture ? "tensor_decoder ! videoconvert ! videoscale"
                                                     : "another mode= of tensor_decoder"));
  }

  Result<bool> decode(GstBuffer* in, GstBuffer* out) {
    if (auto status = reader_.read(in, input_); !status) return status.error();
    ledger_.copied(reader_.bytes_copied());
    decoder_->set_times(gst::abi_time(gst::running_time(self()->segment, GST_BUFFER_PTS(in))),
                        gst::unix_time_of(in, self()->segment, element()));
    auto kept = decoder_->decode(input_, in, reader_, out, buffer_limit_, &ledger_);
    if (kept && *kept && gst_buffer_get_size(out) < picture_bytes_)
      return Error{.code = Code::FRAME_SIZE,
                   .what = "the decoder made less than a picture of its caps",
                   .offered = std::to_string(gst_buffer_get_size(out)) + " bytes",
                   .needed = std::to_string(picture_bytes_) + " bytes",
                   .fix = "mend the decoder " + settings().mode};
    return kept;
  }

  std::mutex probe_mutex_;                 // guards probe_
  std::shared_ptr<FrameDecoder> probe_;    // answers caps queries on any thread
  std::shared_ptr<FrameDecoder> decoder_;  // streaming thread
  FrameSpec input_;                        // streaming thread
  Ref<GstCaps> input_caps_;                // streaming thread
  size_t picture_bytes_ = 0;               // streaming thread; of the output; 0: not raw video
  gst::FrameReader reader_;                // streaming thread
  gst::PropertyFile config_file_;
  gst::FollowedSettings<Settings> followed_;  // the settings of decoder_; streaming thread
};

}  // namespace

bool register_tensor_decoder(GstPlugin* plugin) {
  return TensorDecoder::register_in(plugin);
}

}  // namespace weir
