// Pipelines of a program: made from the text that gst-launch-1.0 takes, frames pushed and pulled as
// typed spans, elements found by their name= and switched. No type of GStreamer shows.
// Over pipeline.h: link with libweir-pipeline (pkg-config weir-pipeline).
//
//   auto made = weir::Pipeline::parse("appsrc name=in ! tensor_filter model=m.onnx ! tensor_sink
//   name=out"); if (!made) return complain(made.error().message()); weir::Pipeline& pipeline =
//   *made; pipeline.start(); pipeline.push<float>("in", values, {.shape = {1, 4}}); auto frame =
//   pipeline.pull<float>("out", std::chrono::seconds(1));
//
// What an element reports on its bus is the error of every later call, until stop(). Any thread may
// call. In a function given to on_frame, and in any other callback on a thread of the stream,
// stop() fails with CANCELLED; start(), pause() and wait() without a limit do so in on_frame. The
// object may be destroyed there: the stream then stops once the function has returned. After a move
// the object left behind may only be assigned to or destroyed.
#pragma once
#include <charconv>
#include <chrono>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "weir/c_error.hpp"
#include "weir/pipeline.h"
#include "weir/tensor_info.hpp"

namespace weir {

using Nanoseconds = std::chrono::nanoseconds;

// A frame that came out of a pipeline: 1 to 256 tensors; a frame of media is one uint8 tensor.
// Copies share the memory, which nobody writes.
class Frame {
 public:
  explicit Frame(weir_pulled* frame) : frame_(frame, weir_pulled_free) {}
  size_t size() const noexcept { return weir_pulled_count(frame_.get()); }
  // `index` below size(). Lives as long as a copy of this object.
  Tensor operator[](size_t index) const noexcept {
    weir_tensor tensor{};
    weir_pulled_tensor(frame_.get(), static_cast<uint32_t>(index), &tensor);
    return Tensor(tensor);
  }
  // Of running time; nullopt: none.
  std::optional<Nanoseconds> pts() const noexcept { return time(weir_pulled_pts(frame_.get())); }
  std::optional<Nanoseconds> duration() const noexcept {
    return time(weir_pulled_duration(frame_.get()));
  }
  std::string caps() const { return weir_pulled_caps(frame_.get()); }  // GStreamer's text

 private:
  static std::optional<Nanoseconds> time(int64_t ns) noexcept {
    return ns < 0 ? std::nullopt : std::optional(Nanoseconds(ns));
  }
  std::shared_ptr<weir_pulled> frame_;
};

// Beside the elements of a frame that is pushed.
struct PushOptions {
  TensorShape shape = {};  // outermost-first; may be left out where the appsrc has caps
  std::optional<Nanoseconds> pts = std::nullopt, duration = std::nullopt;
};

enum class PipelineState {
  Stopped = WEIR_PIPELINE_STOPPED,
  Paused = WEIR_PIPELINE_PAUSED,
  Playing = WEIR_PIPELINE_PLAYING
};

class Pipeline;

// The element valve of this name.
class Valve {
 public:
  Status open() { return set(1); }
  Status close() { return set(0); }  // frames are dropped

 private:
  friend class Pipeline;
  Valve(weir_pipeline* pipeline, std::string name) : pipeline_(pipeline), name_(std::move(name)) {}
  Status set(int open) {
    CError error;
    return error.status(weir_pipeline_set_valve(pipeline_, name_.c_str(), open, error.place()));
  }
  weir_pipeline* pipeline_;
  std::string name_;
};

// The element input-selector or output-selector of this name.
class Switch {
 public:
  Status select(const std::string& pad) {
    CError error;
    return error.status(weir_pipeline_select(pipeline_, name_.c_str(), pad.c_str(), error.place()));
  }

 private:
  friend class Pipeline;
  Switch(weir_pipeline* pipeline, std::string name) : pipeline_(pipeline), name_(std::move(name)) {}
  weir_pipeline* pipeline_;
  std::string name_;
};

class Pipeline {
 public:
  // OPTION_SYNTAX for a text that cannot be read, OPTION_VALUE for an element that is not there.
  static Result<Pipeline> parse(const std::string& text) {
    weir_pipeline* pipeline = nullptr;
    CError error;
    const int result = weir_pipeline_parse(text.c_str(), &pipeline, error.place());
    if (result < 0) return error.take(result);
    return Pipeline(pipeline);
  }

  // Start also goes on from a pause; it returns before the first frame has come through.
  Status start() { return call(weir_pipeline_start); }
  Status pause() { return call(weir_pipeline_pause); }
  // Frames inside and frames not pulled are gone, errors too. The destructor stops as well.
  Status stop() { return call(weir_pipeline_stop); }
  // Where it is, or where it is on its way to.
  PipelineState state() const {
    return static_cast<PipelineState>(weir_pipeline_get_state(handle()));
  }
  // Until every stream has ended: true; false when the time has passed. Frames that nobody pulls
  // stop their stream, see pull().
  Result<bool> wait(std::optional<Nanoseconds> timeout = std::nullopt) {
    CError error;
    const int result = weir_pipeline_wait(handle(), ns(timeout), error.place());
    if (result < 0) return error.take(result);
    return result == WEIR_PIPELINE_DONE;
  }

  // Hands a frame to the appsrc `name`; the elements are copied. Where the text gives the appsrc
  // caps, the frame is held against them (SPEC_MISMATCH, FRAME_SIZE); media take the bytes of a
  // frame as uint8. Where it does not, caps of static tensors are written from type and shape.
  // CANCELLED when the pipeline is stopped or after end().
  template <TensorElement T>
  Status push(const std::string& name, std::span<const T> elements,
              const PushOptions& options = {}) {
    const TensorView view(elements, options.shape);
    return push(name, std::span(&view, 1), options);
  }
  // A frame of several tensors, whose shapes are their own; options.shape is not read.
  Status push(const std::string& name, std::span<const TensorView> tensors,
              const PushOptions& options = {}) {
    std::vector<weir_tensor> all;
    for (const auto& view : tensors) all.push_back(view.c_tensor());
    CError error;
    return error.status(weir_pipeline_push(handle(), name.c_str(), all.data(),
                                           static_cast<uint32_t>(all.size()), ns(options.pts),
                                           ns(options.duration), error.place()));
  }
  // No more frames come from the appsrc `name`.
  Status end(const std::string& name) {
    CError error;
    return error.status(weir_pipeline_end(handle(), name.c_str(), error.place()));
  }

  // The next frame of the appsink or tensor_sink `name`; nullopt when the time has passed, or, as
  // ended() says then, the stream has ended. Frames are kept from start() on: 64 of a tensor_sink,
  // of an appsink as its max-buffers says; then the stream waits, or with appsink drop=true the
  // oldest goes.
  Result<std::optional<Frame>> pull(const std::string& name,
                                    std::optional<Nanoseconds> timeout = std::nullopt) {
    weir_pulled* frame = nullptr;
    CError error;
    const int result =
        weir_pipeline_pull(handle(), name.c_str(), ns(timeout), &frame, error.place());
    if (result < 0) return error.take(result);
    if (!frame) return std::optional<Frame>();
    return std::optional<Frame>(Frame(frame));
  }
  // The same; SPEC_MISMATCH when a tensor of the frame is of another type, and the frame is gone.
  template <TensorElement T>
  Result<std::optional<Frame>> pull(const std::string& name,
                                    std::optional<Nanoseconds> timeout = std::nullopt) {
    auto frame = pull(name, timeout);
    if (!frame || !*frame) return frame;
    for (size_t i = 0; i < (*frame)->size(); ++i)
      if (const auto typed = (**frame)[i].template as<T>(); !typed) return typed.error();
    return frame;
  }
  // Has the stream ended and every frame been pulled? Takes none.
  Result<bool> ended(const std::string& name) {
    CError error;
    const int result = weir_pipeline_ended(handle(), name.c_str(), error.place());
    if (result < 0) return error.take(result);
    return result == 1;
  }

  // Called on a thread of the stream for each frame, instead of pulling. Chosen while stopped; an
  // empty function: pulled again. What it throws ends the stream with CALLBACK_FAILED.
  Status on_frame(const std::string& name, std::function<void(const Frame&)> function) {
    std::unique_ptr<Kept> kept;
    if (function) kept = std::make_unique<Kept>(std::make_shared<Function>(std::move(function)));
    CError error;
    const auto status = error.status(weir_pipeline_on_frame(
        handle(), name.c_str(), kept ? hand_over : nullptr, kept.get(), error.place()));
    if (status) state_->functions[name] = std::move(kept);
    return status;
  }

  // Handles: not longer than the pipeline.
  Valve valve(const std::string& name) { return {handle(), name}; }
  Switch selector(const std::string& name) { return {handle(), name}; }

  // Properties, as text or typed. OPTION_VALUE for one that is not there, cannot be set now, does
  // not take the value; for get<T> also when the value is no T.
  Status set(const std::string& element, const std::string& property, const std::string& value) {
    CError error;
    return error.status(weir_pipeline_set(handle(), element.c_str(), property.c_str(),
                                          value.c_str(), error.place()));
  }
  Status set(const std::string& element, const std::string& property, const char* value) {
    return set(element, property, std::string(value));
  }
  template <class T>
  requires std::is_arithmetic_v<T> Status set(const std::string& element,
                                              const std::string& property, T value) {
    return set(element, property, text_of(value));
  }
  Result<std::string> get(const std::string& element, const std::string& property) const {
    char* text = nullptr;
    CError error;
    const int result =
        weir_pipeline_get(handle(), element.c_str(), property.c_str(), &text, error.place());
    if (result < 0) return error.take(result);
    const std::unique_ptr<char, decltype(&weir_pipeline_text_free)> owner(text,
                                                                          weir_pipeline_text_free);
    return std::string(text);
  }
  template <class T>
  requires std::is_arithmetic_v<T> Result<T> get(const std::string& element,
                                                 const std::string& property)
  const {
    const auto text = get(element, property);
    if (!text) return text.error();
    if (const auto value = read<T>(*text)) return *value;
    return Error{Code::OPTION_VALUE,
                 "the property " + property + " of " + element +
                     " is no value of the type that is asked for",
                 *text,
                 "",
                 "",
                 ""};
  }

 private:
  using Function = std::function<void(const Frame&)>;
  using Kept = std::shared_ptr<const Function>;  // a call keeps it too: it may destroy the pipeline

  explicit Pipeline(weir_pipeline* pipeline) { state_->pipeline.reset(pipeline); }
  weir_pipeline* handle() const noexcept { return state_->pipeline.get(); }
  static int64_t ns(std::optional<Nanoseconds> time) noexcept { return time ? time->count() : -1; }
  template <class C>
  Status call(C function) {
    CError error;
    return error.status(function(handle(), error.place()));
  }
  static int hand_over(const weir_pulled* frame, void* data, weir_error** error) {
    const auto failed = [error](const char* what) {
      *error = weir_error_new(WEIR_CALLBACK_FAILED, what, nullptr, nullptr, nullptr, nullptr);
      return -WEIR_CALLBACK_FAILED;
    };
    try {
      weir_pulled* kept = weir_pulled_keep(frame);
      if (!kept) return failed("memory ran out");
      Frame owned(kept);
      const Kept function = *static_cast<const Kept*>(data);
      (*function)(owned);
      return WEIR_OK;
    } catch (const std::exception& e) {
      return failed(e.what());
    } catch (...) {
      return failed("an unknown exception");
    }
  }
  template <class T>
  static std::string text_of(T value) {
    if constexpr (std::is_same_v<T, bool>) {
      return value ? "true" : "false";
    } else if constexpr (std::is_floating_point_v<T>) {
      char text[64];
      return std::string(text, std::to_chars(text, text + sizeof text, value).ptr);
    } else {
      return std::to_string(value);
    }
  }
  template <class T>
  static std::optional<T> read(const std::string& text) {
    if constexpr (std::is_same_v<T, bool>) {
      if (text == "true" || text == "false") return text == "true";
      return std::nullopt;
    } else {
      T value{};
      const char* end = text.data() + text.size();
      const auto [at, fault] = std::from_chars(text.data(), end, value);
      if (fault != std::errc() || at != end) return std::nullopt;
      return value;
    }
  }

  struct Free {
    void operator()(weir_pipeline* pipeline) const noexcept { weir_pipeline_free(pipeline); }
  };
  struct State {
    std::map<std::string, std::unique_ptr<Kept>> functions;
    std::unique_ptr<weir_pipeline, Free> pipeline;  // goes first: it calls the functions
  };
  std::unique_ptr<State> state_ = std::make_unique<State>();
};

}  // namespace weir
