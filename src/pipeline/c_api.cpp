// The C API of pipelines: checks pointers and texts, then calls the C++ classes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pipeline/c_api.hpp"

#include <algorithm>
#include <cstring>
#include <span>

#include "gstcpp/buffer/module_values.hpp"
#include "pipeline/element_access.hpp"

namespace {

using namespace weir;
using library::guarded;
using library::keep;
using library::null_pointer;
using pipeline::AllowedElements;
using pipeline::Pipeline;
using pipeline::to_return_code;
using pipeline::WaitResult;
using pipeline::with;
using pipeline::with_element;

int to_weir_state(GstState state) noexcept {
  switch (state) {
    case GST_STATE_PLAYING:
      return WEIR_PIPELINE_PLAYING;
    case GST_STATE_PAUSED:
      return WEIR_PIPELINE_PAUSED;
    default:
      return WEIR_PIPELINE_STOPPED;
  }
}

// Converts the result of the program's function to an error of the stream.
Status call(weir_frame_function function, void* data, const weir_pulled& frame) {
  weir_error* failure = nullptr;
  const int result = function(&frame, data, &failure);
  if (result >= 0) {
    weir_error_free(failure);
    return ok();
  }
  const std::string what = weir_error_what(failure);
  Error error{
      .code = Code::CALLBACK_FAILED,
      .what = "the callback for frames failed: " + (what.empty() ? "without a message" : what),
      .offered = weir_error_offered(failure),
      .needed = weir_error_needed(failure),
      .difference = weir_error_difference(failure),
      .fix = weir_error_fix(failure)};
  weir_error_free(failure);
  return error;
}

}  // namespace

int weir_pipeline_parse(const char* text, weir_pipeline** pipeline, weir_error** error) {
  return guarded(error, [&] {
    if (!text || !pipeline) return keep(error, null_pointer("text or pipeline"));
    *pipeline = nullptr;
    auto made = Pipeline::parse(text);
    if (!made) return keep(error, made.error());
    *pipeline = std::make_unique<weir_pipeline>(weir_pipeline{*std::move(made)}).release();
    return static_cast<int>(WEIR_OK);
  });
}

int weir_pipeline_parse_allowed(const char* text, const char* const* allowed, uint32_t n_allowed,
                                weir_pipeline** pipeline, weir_error** error) {
  return guarded(error, [&] {
    if (!text || !pipeline || (!allowed && n_allowed > 0))
      return keep(error, null_pointer("text, allowed or pipeline"));
    *pipeline = nullptr;
    const std::span<const char* const> list(allowed, n_allowed);
    if (std::find(list.begin(), list.end(), nullptr) != list.end())
      return keep(error, null_pointer("a name in allowed"));
    std::vector<std::string> names(list.begin(), list.end());
    const auto forbidden = [error](const Status& status) {
      (void)keep(error, status.error());
      return 1;
    };
    AllowedElements elements(std::move(names));
    if (const auto status = pipeline::start_gstreamer(); !status)
      return keep(error, status.error());
    if (const auto status = elements.check(std::string_view(text)); !status)
      return forbidden(status);
    auto made = Pipeline::parse(text);
    if (!made) return keep(error, made.error());
    if (const auto status = (*made)->restrict_to(std::move(elements)); !status)
      return forbidden(status);
    *pipeline = std::make_unique<weir_pipeline>(weir_pipeline{*std::move(made)}).release();
    return static_cast<int>(WEIR_OK);
  });
}

int weir_pipeline_adopt(GstElement* element, weir_pipeline** pipeline, weir_error** error) {
  return guarded(error, [&] {
    if (!element || !pipeline) return keep(error, null_pointer("element or pipeline"));
    *pipeline = nullptr;
    auto adopted = Pipeline::adopt(element);
    if (!adopted) return keep(error, adopted.error());
    *pipeline = std::make_unique<weir_pipeline>(weir_pipeline{*std::move(adopted)}).release();
    return static_cast<int>(WEIR_OK);
  });
}

void weir_pipeline_free(weir_pipeline* pipeline) {
  if (!pipeline) return;
  Pipeline::dispose(std::move(pipeline->pipeline));
  delete pipeline;
}

int weir_pipeline_start(weir_pipeline* pipeline, weir_error** error) {
  return with(pipeline, error, [](Pipeline& p) { return p.start(); });
}

int weir_pipeline_pause(weir_pipeline* pipeline, weir_error** error) {
  return with(pipeline, error, [](Pipeline& p) { return p.pause(); });
}

int weir_pipeline_stop(weir_pipeline* pipeline, weir_error** error) {
  return with(pipeline, error, [](Pipeline& p) { return p.stop(); });
}

int weir_pipeline_get_state(weir_pipeline* pipeline) {
  return pipeline ? to_weir_state(pipeline->pipeline->state()) : -WEIR_OPTION_VALUE;
}

int weir_pipeline_on_state(weir_pipeline* pipeline, weir_state_function function, void* data,
                           weir_error** error) {
  return with(pipeline, error, [&](Pipeline& p) {
    if (!function) return p.on_state(nullptr);
    return p.on_state([function, data](GstState state) { function(to_weir_state(state), data); });
  });
}

int weir_pipeline_on_message(weir_pipeline* pipeline, weir_message_function function, void* data,
                             weir_error** error) {
  return with(pipeline, error, [&](Pipeline& p) {
    if (!function) return p.on_message(nullptr);
    return p.on_message([function, data](GstMessage* message) { function(message, data); });
  });
}

int weir_pipeline_wait(weir_pipeline* pipeline, int64_t timeout_ns, weir_error** error) {
  return guarded(error, [&] {
    if (!pipeline) return keep(error, null_pointer("pipeline"));
    const auto waited = pipeline->pipeline->wait(std::chrono::nanoseconds(timeout_ns));
    return waited ? static_cast<int>(*waited) : keep(error, waited.error());
  });
}

int weir_pipeline_read_message(weir_pipeline* pipeline, weir_error** message, weir_error** error) {
  return guarded(error, [&] {
    if (!pipeline || !message) return keep(error, null_pointer("pipeline or message"));
    *message = nullptr;
    const auto read = pipeline->pipeline->read_message();
    if (!read) return static_cast<int>(WEIR_PIPELINE_NO_MESSAGE);
    (void)keep(message, read->error);
    return static_cast<int>(read->is_error ? WEIR_PIPELINE_ERROR : WEIR_PIPELINE_WARNING);
  });
}

int weir_pipeline_push(weir_pipeline* pipeline, const char* name, const weir_tensor* tensors,
                       uint32_t n_tensors, int64_t pts, int64_t duration, weir_error** error) {
  const auto push = [&](Pipeline& p) {
    return p.push(name, std::span(tensors, n_tensors), pts, duration);
  };
  const void* given = n_tensors > 0 ? static_cast<const void*>(tensors) : name;
  return with(pipeline, error, push, name, given);
}

int weir_pipeline_end(weir_pipeline* pipeline, const char* name, weir_error** error) {
  return with(
      pipeline, error, [&](Pipeline& p) { return p.end(name); }, name);
}

int weir_pipeline_source_tensors(weir_pipeline* pipeline, const char* name, weir_tensor_info* infos,
                                 uint32_t n_infos, weir_error** error) {
  return guarded(error, [&] {
    if (!pipeline || !name || (!infos && n_infos > 0))
      return keep(error, null_pointer("an argument"));
    const auto tensors = pipeline->pipeline->source_tensors(name);
    if (!tensors) return keep(error, tensors.error());
    for (size_t i = 0; i < tensors->size() && i < n_infos; ++i) {
      infos[i] = weir::gst::tensor_info((*tensors)[i]);
      infos[i].name = nullptr;
    }
    return static_cast<int>(tensors->size());
  });
}

int weir_pipeline_pull(weir_pipeline* pipeline, const char* name, int64_t timeout_ns,
                       weir_pulled** frame, weir_error** error) {
  return guarded(error, [&] {
    if (!pipeline || !name || !frame) return keep(error, null_pointer("an argument"));
    *frame = nullptr;
    auto pulled = pipeline->pipeline->pull(name, std::chrono::nanoseconds(timeout_ns));
    if (!pulled) return keep(error, pulled.error());
    if (pulled->frame)
      *frame = std::make_unique<weir_pulled>(weir_pulled{std::move(pulled->frame)}).release();
    return static_cast<int>(pulled->result);
  });
}

int weir_pipeline_ended(weir_pipeline* pipeline, const char* name, weir_error** error) {
  return guarded(error, [&] {
    if (!pipeline || !name) return keep(error, null_pointer("an argument"));
    const auto ended = pipeline->pipeline->ended(name);
    return ended ? static_cast<int>(*ended) : keep(error, ended.error());
  });
}

int weir_pipeline_on_frame(weir_pipeline* pipeline, const char* name, weir_frame_function function,
                           void* data, weir_error** error) {
  const auto set = [&](Pipeline& p) {
    if (!function) return p.on_frame(name, nullptr);
    return p.on_frame(name, [function, data](const auto& frame) {
      return call(function, data, weir_pulled{frame});
    });
  };
  return with(pipeline, error, set, name);
}

int weir_pipeline_discard(weir_pipeline* pipeline, const char* name, weir_error** error) {
  return with(
      pipeline, error, [name](Pipeline& p) { return p.discard(name); }, name);
}

uint32_t weir_pulled_count(const weir_pulled* frame) {
  return frame ? static_cast<uint32_t>(frame->frame->tensors().size()) : 0;
}

int weir_pulled_tensor(const weir_pulled* frame, uint32_t index, weir_tensor* tensor) {
  if (!tensor || index >= weir_pulled_count(frame)) return -WEIR_OPTION_VALUE;
  *tensor = frame->frame->tensors()[index];
  return WEIR_OK;
}

int64_t weir_pulled_pts(const weir_pulled* frame) {
  return frame ? frame->frame->pts() : -1;
}

int64_t weir_pulled_duration(const weir_pulled* frame) {
  return frame ? frame->frame->duration() : -1;
}

const char* weir_pulled_caps(const weir_pulled* frame) {
  return frame ? frame->frame->caps().c_str() : "";
}

const char* weir_pulled_caps_field(const weir_pulled* frame, const char* field) {
  return frame && field ? frame->frame->caps_field(field) : "";
}

const char* weir_pulled_label(const weir_pulled* frame, uint32_t index, int32_t class_index) {
  return frame ? frame->frame->label(index, class_index) : "";
}

uint32_t weir_pulled_map_count(const weir_pulled* frame) {
  return frame ? static_cast<uint32_t>(frame->frame->maps().size()) : 0;
}

int weir_pulled_map(const weir_pulled* frame, uint32_t index, weir_source_map* map) {
  if (!map || index >= weir_pulled_map_count(frame)) return -WEIR_OPTION_VALUE;
  *map = weir::abi_map(frame->frame->maps()[index]);
  return WEIR_OK;
}

weir_pulled* weir_pulled_keep(const weir_pulled* frame) {
  return frame ? new (std::nothrow) weir_pulled(*frame) : nullptr;
}

void weir_pulled_free(weir_pulled* frame) {
  delete frame;
}
