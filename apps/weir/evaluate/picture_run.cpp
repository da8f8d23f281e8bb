// Pushes decoded pictures and pulls results on one thread, so that neither waits for the other.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "evaluate/picture_run.hpp"

#include <chrono>
#include <cmath>
#include <optional>

#include "evaluate/folder_files.hpp"
#include "gstcpp/element/elements.hpp"
#include "gstcpp/element/property_text.hpp"
#include "weir/pipeline.hpp"

namespace weir::app {
namespace {

using std::chrono::milliseconds;

constexpr char kSource[] = "weir-evaluate-pictures", kSink[] = "weir-evaluate-results",
               kDecoder[] = "weir-evaluate-json";
constexpr milliseconds kBusInterval{20};  // between looks at the queue of pictures

class PictureRun {
 public:
  PictureRun(Pipeline pipeline, const LabelledSequence& sequence, const RunHandlers& handlers)
      : pipeline_(std::move(pipeline)),
        sequence_(sequence),
        handlers_(handlers),
        states_(sequence.pictures.size()) {}

  Status play() {
    const Status status = play_all();
    warn();
    if (status) return check_complete();
    // The cause may have been posted after an error that follows from it.
    const auto ended = pipeline_.ended(kSink);
    return ended ? status : ended.error();
  }

 private:
  enum class State { Waiting, LeftOut, Played, Done };

  Status play_all() {
    if (auto status = pipeline_.start(); !status) return status;
    for (size_t i = 0; i < states_.size(); ++i)
      if (auto status = push(i); !status) return status;
    if (auto status = pipeline_.end(kSource); !status) return status;
    while (true) {
      const auto ended = pipeline_.ended(kSink);
      if (!ended) return ended.error();
      if (*ended) return ok();
      if (auto status = pull(kBusInterval); !status) return status;
    }
  }

  bool is_full() const {
    constexpr uint64_t kMaxAhead = 4;
    const auto waiting = pipeline_.get<uint64_t>(kSource, "current-level-buffers");
    return waiting && *waiting >= kMaxAhead;
  }

  Status push(size_t index) {
    while (is_full())
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
    states_[index] = State::Played;
    if (auto status = pipeline_.set(kSource, "caps", caps_text(*picture)); !status) return status;
    const PushOptions times{.pts = get_time(index),
                            .duration = get_time(index + 1) - get_time(index)};
    if (auto status = pipeline_.push(kSource, std::span(picture->pixels), times); !status)
      return status;
    return pull(milliseconds(0));
  }

  Nanoseconds get_time(size_t index) const {
    return Nanoseconds(std::llround(static_cast<double>(index) * static_cast<double>(GST_SECOND) /
                                    sequence_.frame_rate));
  }
  std::string caps_text(const DecodedPicture& picture) const {
    const auto caps = gst::Ref<GstCaps>::adopt(gst_caps_copy(picture.caps.get()));
    int numerator = 1, denominator = 1;
    gst_util_double_to_fraction(sequence_.frame_rate, &numerator, &denominator);
    gst_caps_set_simple(caps.get(), "framerate", GST_TYPE_FRACTION, numerator, denominator,
                        nullptr);
    return gst::UniqueText(gst_caps_to_string(caps.get())).get();
  }

  // All results that are there, or after `timeout`.
  Status pull(Nanoseconds timeout) {
    while (true) {
      const auto frame = pipeline_.pull(kSink, timeout);
      warn();
      if (!frame) return frame.error();
      if (!*frame) return ok();
      timeout = Nanoseconds(0);
      if (auto status = take(**frame); !status) return status;
    }
  }

  void warn() {
    while (const auto message = pipeline_.read_message())
      if (!message->is_error) handlers_.warn(message->error);
  }

  Status take(const Frame& results) {
    const auto time = results.pts();
    const auto index = static_cast<size_t>(
        std::llround(std::chrono::duration<double>(time.value_or(Nanoseconds(0))).count() *
                     sequence_.frame_rate));
    if (!time || index >= states_.size() || states_[index] == State::Waiting ||
        states_[index] == State::LeftOut)
      return mismatch("results have a timestamp that no picture has",
                      time ? std::to_string(std::chrono::floor<milliseconds>(*time).count()) + " ms"
                           : "no timestamp");
    const std::string& path = sequence_.pictures[index].path;
    if (states_[index] == State::Done)
      return mismatch("a picture has more than one frame of results", path);
    if (index < last_) return mismatch("the results are not in the order of the pictures", path);
    last_ = index;
    states_[index] = State::Done;
    const auto bytes = results[0].bytes();
    const auto* text = reinterpret_cast<const char*>(bytes.data());
    const Json frame = Json::parse(text, text + bytes.size(), nullptr, false);
    if (!frame.is_object()) return mismatch("results cannot be read", path);
    handlers_.progress();
    return handlers_.results(index, frame);
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

  Pipeline pipeline_;
  const LabelledSequence& sequence_;
  const RunHandlers& handlers_;
  std::vector<State> states_;
  size_t last_ = 0;  // picture with results
};

// Sinks in the text would block the stream when the queue of frames that no one pulls is full.
Status discard_other_frames(Pipeline& pipeline, GstElement* bin) {
  for (const auto& element : gst::elements_in(bin)) {
    const std::string kind = gst::get_factory_name(element.get()),
                      name = GST_OBJECT_NAME(element.get());
    if ((kind != "tensor_sink" && kind != "appsink") || name == kSink) continue;
    if (auto status = pipeline.on_frame(name, [](const Frame&) {}); !status) return status;
  }
  return ok();
}

}  // namespace

Status play_pictures(const PipelineDescription& pipeline, const LabelledSequence& sequence,
                     const RunHandlers& handlers) {
  PipelineDescription played;
  played.text(std::string("appsrc name=") + kSource + " format=time ! ")
      .append(pipeline)
      .text(std::string(" ! tensor_decoder name=") + kDecoder +
            " mode=json custom=masks:rle ! appsink sync=false name=" + kSink);
  const auto made = played.make();
  if (!made) return made.error();
  auto adopted = Pipeline::adopt(made->get());
  if (!adopted) return adopted.error();
  if (auto status = discard_other_frames(*adopted, made->get()); !status) return status;
  return PictureRun(*std::move(adopted), sequence, handlers).play();
}

}  // namespace weir::app
