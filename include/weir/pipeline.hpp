// Pipelines for programs: parse the text of gst-launch-1.0, push and pull frames as typed spans,
// control elements by their name=. The API exposes no GStreamer types, except that adopt() takes a
// GstPipeline. Wraps pipeline.h: link with libweir-pipeline (pkg-config weir-pipeline).
//
//   auto made = weir::Pipeline::parse(
//       "appsrc name=in ! tensor_filter model=m.onnx ! tensor_sink name=out");
//   if (!made) return complain(made.error().message());
//   weir::Pipeline& pipeline = *made;
//   pipeline.start();
//   pipeline.push<float>("in", values, {.shape = {1, 4}});
//   auto frame = pipeline.pull<float>("out", std::chrono::seconds(1));
//
// After an element has posted an error on the bus, every call fails with it until stop(), except
// read_message(). Any thread may call. On a streaming thread, in on_frame or any other callback,
// stop() fails with CANCELLED; in on_frame start(), pause() and wait() without a limit do too. The
// object may be destroyed there: the stream stops when the callback has returned. A moved-from
// object may only be assigned to or destroyed.
// SPDX-License-Identifier: LGPL-2.1-or-later
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
#include <utility>
#include <vector>

#include "weir/c_error.hpp"
#include "weir/pipeline.h"
#include "weir/source_map.hpp"
#include "weir/tensor_info.hpp"

namespace weir {

using Nanoseconds = std::chrono::nanoseconds;

// A type of a property's value: a number or bool.
template <class T>
concept PropertyNumber = std::is_arithmetic_v<T>;

// A frame pulled from a pipeline: 1 to 256 tensors; a frame of media is one uint8 tensor. Copies
// share the memory, which is read-only.
class Frame {
 public:
  explicit Frame(weir_pulled* frame) : frame_(frame, weir_pulled_free) {}
  size_t size() const noexcept { return weir_pulled_count(frame_.get()); }
  // Returns tensor `index`, which must be below size(). The memory lives as long as a copy of this
  // object.
  Tensor operator[](size_t index) const noexcept {
    weir_tensor tensor{};
    weir_pulled_tensor(frame_.get(), static_cast<uint32_t>(index), &tensor);
    return Tensor(tensor);
  }
  // Returns the PTS of the buffer; nullopt: none.
  std::optional<Nanoseconds> pts() const noexcept { return time(weir_pulled_pts(frame_.get())); }
  std::optional<Nanoseconds> duration() const noexcept {
    return time(weir_pulled_duration(frame_.get()));
  }
  std::string caps() const { return weir_pulled_caps(frame_.get()); }  // GStreamer caps text
  // Returns the text of a field of the caps, such as weir-columns; "" if there is none.
  std::string caps_field(const std::string& field) const {
    return weir_pulled_caps_field(frame_.get(), field.c_str());
  }
  // Returns the label of a class in tensor `index` of results; "" if the stream has none for it.
  std::string label(size_t index, int32_t class_index) const {
    return weir_pulled_label(frame_.get(), static_cast<uint32_t>(index), class_index);
  }
  // Returns the maps from pixels of the tensors to those of the source picture: one for all
  // tensors, or one for each; of a batch of regions one for each region. Empty if the frame does
  // not come from a picture.
  std::vector<SourceMap> source_maps() const {
    std::vector<SourceMap> maps(weir_pulled_map_count(frame_.get()));
    for (size_t i = 0; i < maps.size(); ++i) {
      weir_source_map map{};
      weir_pulled_map(frame_.get(), static_cast<uint32_t>(i), &map);
      maps[i] = source_map(map);
    }
    return maps;
  }

 private:
  static std::optional<Nanoseconds> time(int64_t ns) noexcept {
    return ns < 0 ? std::nullopt : std::optional(Nanoseconds(ns));
  }
  std::shared_ptr<weir_pulled> frame_;
};

// Attributes of a pushed frame.
struct PushOptions {
  TensorShape shape = {};  // outermost-first; optional if the appsrc has caps
  std::optional<Nanoseconds> pts = std::nullopt, duration = std::nullopt;
};

enum class PipelineState {
  Stopped = WEIR_PIPELINE_STOPPED,
  Paused = WEIR_PIPELINE_PAUSED,
  Playing = WEIR_PIPELINE_PLAYING
};

// A warning or an error that an element posted. `error.what` starts with the name of the element.
struct PipelineMessage {
  bool is_error = false;
  Error error;
};

class Pipeline;

// Controls the valve element with this name.
class Valve {
 public:
  Status open() { return set(1); }
  Status close() { return set(0); }  // drops frames

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

// Controls the input-selector or output-selector with this name.
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
  // Builds the pipeline. Errors: OPTION_SYNTAX for text that does not parse, OPTION_VALUE for an
  // element that does not exist.
  static Result<Pipeline> parse(const std::string& text) {
    weir_pipeline* pipeline = nullptr;
    CError error;
    const int result = weir_pipeline_parse(text.c_str(), &pipeline, error.place());
    if (result < 0) return error.take(result);
    return Pipeline(pipeline);
  }

  // Makes a Pipeline of a GstPipeline in the state NULL, which the program has built with
  // GStreamer; a floating reference is taken, otherwise one is added. OPTION_VALUE, without taking
  // a reference, for another object or state, and for a pipeline that another Pipeline has adopted.
  // Messages no longer come to its bus: warnings and errors come to read_message(), all of them to
  // on_message(). weir_pipeline_adopt says what changes in appsrc, appsink and tensor_sink.
  static Result<Pipeline> adopt(_GstElement* element) {
    weir_pipeline* pipeline = nullptr;
    CError error;
    const int result = weir_pipeline_adopt(element, &pipeline, error.place());
    if (result < 0) return error.take(result);
    return Pipeline(pipeline);
  }

  // Starts or resumes from a pause; returns before the first frame is through.
  Status start() { return call(weir_pipeline_start); }
  Status pause() { return call(weir_pipeline_pause); }
  // Discards frames in the pipeline, frames not pulled, and the error with which calls fail.
  // Messages stay for read_message(). The destructor stops too.
  Status stop() { return call(weir_pipeline_stop); }
  // Returns the current state, or the target of a state change.
  PipelineState state() const {
    return static_cast<PipelineState>(weir_pipeline_get_state(handle()));
  }
  // Waits until every stream has ended; false on a time-out. Frames that are not pulled block their
  // stream, see pull().
  Result<bool> wait(std::optional<Nanoseconds> timeout = std::nullopt) {
    CError error;
    const int result = weir_pipeline_wait(handle(), ns(timeout), error.place());
    if (result < 0) return error.take(result);
    return result == WEIR_PIPELINE_DONE;
  }

  // Removes the oldest warning or error that an element posted and returns it; nullopt if none is
  // left. Warnings say for example that a new value of a property is not used. The errors are all
  // that were posted, also those after the one with which calls fail. The newest 64 messages are
  // kept until they are read, also over stop().
  std::optional<PipelineMessage> read_message() {
    CError message;
    const int kind = weir_pipeline_read_message(handle(), message.place(), nullptr);
    if (kind <= WEIR_PIPELINE_NO_MESSAGE) return std::nullopt;
    return PipelineMessage{kind == WEIR_PIPELINE_ERROR,
                           message.take(-weir_error_code(*message.place()))};
  }

  // Pushes a frame into the appsrc `name`; the elements are copied. If the text sets the appsrc's
  // caps, the frame must match them (SPEC_MISMATCH, FRAME_SIZE); media take the bytes of a frame as
  // uint8. Otherwise the caps are static tensors derived from type and shape. CANCELLED when the
  // pipeline is stopped or after end().
  template <TensorElement T>
  Status push(const std::string& name, std::span<const T> elements,
              const PushOptions& options = {}) {
    const TensorView view(elements, options.shape);
    return push(name, std::span(&view, 1), options);
  }
  // Pushes a frame of several tensors with their own shapes; options.shape is ignored.
  Status push(const std::string& name, std::span<const TensorView> tensors,
              const PushOptions& options = {}) {
    std::vector<weir_tensor> all;
    for (const auto& view : tensors) all.push_back(view.c_tensor());
    CError error;
    return error.status(weir_pipeline_push(handle(), name.c_str(), all.data(),
                                           static_cast<uint32_t>(all.size()), ns(options.pts),
                                           ns(options.duration), error.place()));
  }
  // Sends EOS from the appsrc `name`.
  Status end(const std::string& name) {
    CError error;
    return error.status(weir_pipeline_end(handle(), name.c_str(), error.place()));
  }

  // Pulls the next frame of the appsink or tensor_sink `name`; nullopt on a time-out or at the end
  // of the stream, which ended() distinguishes. Frames are queued from start() on: 64 for a
  // tensor_sink, max-buffers for an appsink. A full queue blocks the stream, or drops its oldest
  // frame with appsink drop=true.
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
  // Pulls a frame of tensors of type T; SPEC_MISMATCH, which discards the frame, if a tensor has
  // another type.
  template <TensorElement T>
  Result<std::optional<Frame>> pull(const std::string& name,
                                    std::optional<Nanoseconds> timeout = std::nullopt) {
    auto frame = pull(name, timeout);
    if (!frame || !*frame) return frame;
    for (size_t i = 0; i < (*frame)->size(); ++i)
      if (const auto typed = (**frame)[i].template as<T>(); !typed) return typed.error();
    return frame;
  }
  // Returns true if the stream has ended and every frame has been pulled.
  Result<bool> ended(const std::string& name) {
    CError error;
    const int result = weir_pipeline_ended(handle(), name.c_str(), error.place());
    if (result < 0) return error.take(result);
    return result == 1;
  }

  // Calls `function` on a streaming thread for each frame instead of queueing it; an empty function
  // returns to pulling. Only while stopped. An exception ends the stream with CALLBACK_FAILED.
  Status on_frame(const std::string& name, std::function<void(const Frame&)> function) {
    std::unique_ptr<Kept> kept;
    if (function) kept = std::make_unique<Kept>(std::make_shared<Function>(std::move(function)));
    CError error;
    const auto status = error.status(weir_pipeline_on_frame(
        handle(), name.c_str(), kept ? hand_over : nullptr, kept.get(), error.place()));
    if (status) state_->functions[name] = std::move(kept);
    return status;
  }

  // Drops the frames of the sink `name` without reading them, instead of queueing them, until the
  // next on_frame(). Only while stopped.
  Status discard(const std::string& name) {
    CError error;
    return error.status(weir_pipeline_discard(handle(), name.c_str(), error.place()));
  }

  // Calls `function` for each message of GStreamer, on the thread that posts it; an empty function
  // ends that. Only while stopped. weir_pipeline_on_message says what the function may do; it must
  // not throw.
  Status on_message(std::function<void(_GstMessage*)> function) {
    auto kept = std::make_unique<MessageFunction>(std::move(function));
    const auto pass = [](_GstMessage* message, void* data) {
      (*static_cast<const MessageFunction*>(data))(message);
    };
    CError error;
    const auto status = error.status(
        weir_pipeline_on_message(handle(), *kept ? +pass : nullptr, kept.get(), error.place()));
    if (status) state_->on_message = std::move(kept);
    return status;
  }

  // Returns the elements of the text in its order: name and kind, such as "out" and "tensor_sink".
  Result<std::vector<std::pair<std::string, std::string>>> elements() const {
    std::vector<std::pair<std::string, std::string>> out;
    CError error;
    const auto add = [](const char* name, const char* kind, int depth, void* data) {
      auto* list = static_cast<std::vector<std::pair<std::string, std::string>>*>(data);
      if (depth == 0) list->emplace_back(name, kind);
    };
    const int result = weir_pipeline_elements(handle(), add, &out, error.place());
    if (result < 0) return error.take(result);
    return out;
  }

  // Return handles; the pipeline must outlive them.
  Valve valve(const std::string& name) { return {handle(), name}; }
  Switch selector(const std::string& name) { return {handle(), name}; }

  // Set and get properties, as text or typed. OPTION_VALUE for one that does not exist, cannot be
  // set in this state, or does not accept the value; for get<T> also if the value is not a T.
  Status set(const std::string& element, const std::string& property, const std::string& value) {
    CError error;
    return error.status(weir_pipeline_set(handle(), element.c_str(), property.c_str(),
                                          value.c_str(), error.place()));
  }
  Status set(const std::string& element, const std::string& property, const char* value) {
    return set(element, property, std::string(value));
  }
  template <PropertyNumber T>
  Status set(const std::string& element, const std::string& property, T value) {
    return set(element, property, to_string(value));
  }
  Result<std::string> get(const std::string& element, const std::string& property) const {
    return get(weir_pipeline_get, element, property);
  }
  // Returns the property as JSON: numbers, texts, arrays, and objects such as the property "stats".
  Result<std::string> get_json(const std::string& element, const std::string& property) const {
    return get(weir_pipeline_get_json, element, property);
  }
  template <PropertyNumber T>
  Result<T> get(const std::string& element, const std::string& property) const {
    const auto text = get(element, property);
    if (!text) return text.error();
    if (const auto value = read<T>(*text)) return *value;
    return Error{
        .code = Code::OPTION_VALUE,
        .what = "the property " + property + " of " + element + " does not have the requested type",
        .offered = *text};
  }

 private:
  using Function = std::function<void(const Frame&)>;
  using Kept = std::shared_ptr<const Function>;  // a running call may destroy the pipeline
  using MessageFunction = std::function<void(_GstMessage*)>;

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
  template <class Get>
  Result<std::string> get(Get function, const std::string& element,
                          const std::string& property) const {
    char* text = nullptr;
    CError error;
    const int result = function(handle(), element.c_str(), property.c_str(), &text, error.place());
    if (result < 0) return error.take(result);
    const std::unique_ptr<char, decltype(&weir_pipeline_text_free)> owner(text,
                                                                          weir_pipeline_text_free);
    return std::string(text);
  }
  template <class T>
  static std::string to_string(T value) {
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
    std::unique_ptr<MessageFunction> on_message;
    std::unique_ptr<weir_pipeline, Free> pipeline;  // destroyed first: it calls the functions
  };
  std::unique_ptr<State> state_ = std::make_unique<State>();
};

}  // namespace weir
