// Pushes decoded pictures and pulls results on one thread, so that neither waits for the other.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "evaluate/picture_run.hpp"

#include <gst/app/gstappsink.h>
#include <gst/app/gstappsrc.h>

#include <cmath>
#include <optional>

#include "evaluate/folder_files.hpp"
#include "run/diagnostics.hpp"

namespace weir::app {
namespace {

constexpr char kSource[] = "weir-evaluate-pictures", kSink[] = "weir-evaluate-results",
               kDecoder[] = "weir-evaluate-json";
constexpr GstClockTime kBusInterval = 20 * GST_MSECOND;  // between looks at the bus

// An error of an element as those of the command. Those of GStreamer's own elements have no code.
Error to_error(const Diagnostic& diagnostic) {
  Error out = diagnostic.error;
  out.what = diagnostic.element + ": " + out.what;
  if (diagnostic.has_code) return out;
  out.code = Code::FORMAT_UNSUPPORTED;
  out.difference = diagnostic.debug;
  return out;
}

class PictureRun {
 public:
  PictureRun(gst::Ref<GstElement> pipeline, const LabelledSequence& sequence,
             const RunHandlers& handlers)
      : pipeline_(std::move(pipeline)),
        source_(element(kSource)),
        sink_(element(kSink)),
        bus_(gst::Ref<GstBus>::adopt(gst_element_get_bus(pipeline_.get()))),
        sequence_(sequence),
        handlers_(handlers),
        states_(sequence.pictures.size()) {}
  ~PictureRun() { gst_element_set_state(pipeline_.get(), GST_STATE_NULL); }
  PictureRun(const PictureRun&) = delete;
  PictureRun& operator=(const PictureRun&) = delete;

  Status play() {
    if (gst_element_set_state(pipeline_.get(), GST_STATE_PLAYING) == GST_STATE_CHANGE_FAILURE) {
      if (auto status = look_at_bus(); !status) return status;
      return Error{.code = Code::FORMAT_UNSUPPORTED, .what = "the pipeline cannot be started"};
    }
    for (size_t i = 0; i < states_.size(); ++i)
      if (auto status = push(i); !status) return status;
    gst_app_src_end_of_stream(GST_APP_SRC(source_.get()));
    while (!gst_app_sink_is_eos(GST_APP_SINK(sink_.get())))
      if (auto status = pull(kBusInterval); !status) return status;
    if (auto status = look_at_bus(); !status) return status;
    return check_complete();
  }

 private:
  enum class State { Waiting, LeftOut, Played, Done };

  gst::Ref<GstElement> element(const char* name) const {
    return gst::Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline_.get()), name));
  }

  Status push(size_t index) {
    constexpr guint64 kMaxAhead = 4;
    while (gst_app_src_get_current_level_buffers(GST_APP_SRC(source_.get())) >= kMaxAhead)
      if (auto status = pull(kBusInterval); !status) return status;
    const auto picture = decode_picture(sequence_.pictures[index].path);
    Status accepted = picture ? handlers_.accept(index, *picture) : picture.error();
    if (!accepted) {
      states_[index] = State::LeftOut;
      if (sequence_.is_video) return accepted;
      handlers_.progress();
      handlers_.warn(accepted.error());
      return ok();
    }
    GstBuffer* buffer = gst_buffer_copy(picture->buffer.get());
    GST_BUFFER_PTS(buffer) = get_time(index);
    GST_BUFFER_DTS(buffer) = GST_CLOCK_TIME_NONE;
    GST_BUFFER_DURATION(buffer) = get_time(index + 1) - get_time(index);
    gst_app_src_set_caps(GST_APP_SRC(source_.get()), make_caps(*picture).get());
    states_[index] = State::Played;
    gst_app_src_push_buffer(GST_APP_SRC(source_.get()), buffer);
    return pull(0);
  }

  GstClockTime get_time(size_t index) const {
    return static_cast<GstClockTime>(std::llround(
        static_cast<double>(index) * static_cast<double>(GST_SECOND) / sequence_.frame_rate));
  }
  gst::Ref<GstCaps> make_caps(const DecodedPicture& picture) const {
    auto caps = gst::Ref<GstCaps>::adopt(gst_caps_copy(picture.caps.get()));
    int numerator = 1, denominator = 1;
    gst_util_double_to_fraction(sequence_.frame_rate, &numerator, &denominator);
    gst_caps_set_simple(caps.get(), "framerate", GST_TYPE_FRACTION, numerator, denominator,
                        nullptr);
    return caps;
  }

  // All results that are there, or after `timeout`.
  Status pull(GstClockTime timeout) {
    while (true) {
      const gst::Unique<GstSample, gst_sample_unref> sample(
          gst_app_sink_try_pull_sample(GST_APP_SINK(sink_.get()), timeout));
      if (!sample) return look_at_bus();
      timeout = 0;
      if (auto status = take(gst_sample_get_buffer(sample.get())); !status) return status;
    }
  }

  Status take(GstBuffer* buffer) {
    const GstClockTime time = GST_BUFFER_PTS(buffer);
    const auto index = static_cast<size_t>(std::llround(
        static_cast<double>(time) / static_cast<double>(GST_SECOND) * sequence_.frame_rate));
    if (!GST_CLOCK_TIME_IS_VALID(time) || index >= states_.size() ||
        states_[index] == State::Waiting || states_[index] == State::LeftOut)
      return mismatch("results have a timestamp that no picture has",
                      GST_CLOCK_TIME_IS_VALID(time)
                          ? std::to_string(GST_TIME_AS_MSECONDS(time)) + " ms"
                          : "no timestamp");
    const std::string& path = sequence_.pictures[index].path;
    if (states_[index] == State::Done)
      return mismatch("a picture has more than one frame of results", path);
    if (index < last_) return mismatch("the results are not in the order of the pictures", path);
    last_ = index;
    states_[index] = State::Done;
    const gst::Mapped bytes(buffer, GST_MAP_READ);
    if (!bytes) return mismatch("results cannot be read", path);
    const auto* text = reinterpret_cast<const char*>(bytes.bytes().data());
    const Json frame = Json::parse(text, text + bytes.bytes().size(), nullptr, false);
    if (!frame.is_object()) return mismatch("results cannot be read", path);
    handlers_.progress();
    return handlers_.results(index, frame);
  }

  Status look_at_bus() {
    std::vector<Diagnostic> errors;
    const auto kinds = static_cast<GstMessageType>(GST_MESSAGE_ERROR | GST_MESSAGE_WARNING);
    while (GstMessage* message = gst_bus_pop_filtered(bus_.get(), kinds)) {
      const Diagnostic diagnostic = parse_diagnostic(message);
      if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR)
        errors.push_back(diagnostic);
      else
        handlers_.warn(to_error(diagnostic));
      gst_message_unref(message);
    }
    if (errors.empty()) return ok();
    // Others follow from those of Weir's elements.
    for (const Diagnostic& diagnostic : errors)
      if (diagnostic.has_code) return to_error(diagnostic);
    return to_error(errors.front());
  }

  Status check_complete() const {
    std::vector<std::string> without;
    for (size_t i = 0; i < states_.size(); ++i)
      if (states_[i] == State::Played) without.push_back(sequence_.pictures[i].path);
    return without.empty() ? ok() : mismatch("pictures have no results", format_first(without));
  }

  static Error mismatch(std::string what, const std::string& offered) {
    return {.code = Code::SPEC_MISMATCH,
            .what = std::move(what),
            .offered = offered,
            .needed = "one frame of results for each picture, with its time",
            .fix = "remove the elements that drop, repeat or join frames from the pipeline"};
  }

  const gst::Ref<GstElement> pipeline_, source_, sink_;
  const gst::Ref<GstBus> bus_;
  const LabelledSequence& sequence_;
  const RunHandlers& handlers_;
  std::vector<State> states_;
  size_t last_ = 0;  // picture with results
};

}  // namespace

Status play_pictures(const PipelineDescription& pipeline, const LabelledSequence& sequence,
                     const RunHandlers& handlers) {
  PipelineDescription played;
  played.text(std::string("appsrc name=") + kSource + " format=time ! ")
      .append(pipeline)
      .text(std::string(" ! tensor_decoder name=") + kDecoder +
            " mode=json custom=masks:rle ! appsink sync=false name=" + kSink);
  auto made = played.make();
  if (!made) return made.error();
  return PictureRun(*std::move(made), sequence, handlers).play();
}

}  // namespace weir::app
