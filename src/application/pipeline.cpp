// Counts uses: a pipeline is freed by the thread that destroys it, never by a streaming thread.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pipeline.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include "core/process/sink_data.hpp"
#include "core/text/text.hpp"
#include "weir/c_error.hpp"

namespace weir::application {
namespace {

struct Named {
  std::string name, kind;
  int depth;
};

bool is_sink(const std::string& kind) {
  return kind == "tensor_sink" || kind == "appsink";
}

Result<std::vector<Named>> list_elements(weir_pipeline* pipeline) {
  std::vector<Named> out;
  const auto add = [](const char* name, const char* kind, int depth, void* data) {
    static_cast<std::vector<Named>*>(data)->push_back({name, kind, depth});
  };
  CError error;
  const int result = weir_pipeline_elements(pipeline, add, &out, error.place());
  if (result < 0) return error.take(result);
  return out;
}

ml_pipeline_state_e to_ml_state(int state) {
  if (state == WEIR_PIPELINE_PLAYING) return ML_PIPELINE_STATE_PLAYING;
  return state == WEIR_PIPELINE_PAUSED ? ML_PIPELINE_STATE_PAUSED : ML_PIPELINE_STATE_READY;
}

// The value of a property as text; "" for one that the element does not have.
std::string get_text(weir_pipeline* pipeline, const std::string& name, const char* property) {
  char* text = nullptr;
  if (weir_pipeline_get(pipeline, name.c_str(), property, &text, nullptr) < 0) return "";
  const std::unique_ptr<char, decltype(&weir_pipeline_text_free)> owner(text,
                                                                        weir_pipeline_text_free);
  return text;
}

// The factory name of the element that calls by this name find.
std::string find_kind(weir_pipeline* pipeline, const std::string& name) {
  const ElementRef found(weir_pipeline_get_element(pipeline, name.c_str()));
  const auto* factory = found ? gst_element_get_factory(found.get()) : nullptr;
  return factory ? GST_OBJECT_NAME(factory) : "";
}

}  // namespace

std::variant<std::shared_ptr<Pipeline>, Refusal> Pipeline::construct(const char* text,
                                                                     StateCallback callback) {
  if (!gst_init_check(nullptr, nullptr, nullptr))
    return refusal(Error{.code = Code::INTERNAL, .what = "GStreamer cannot be started"});
  const auto restriction = ElementRestriction::read();
  if (!restriction) return Refusal{ML_ERROR_PERMISSION_DENIED, restriction.error()};
  if (auto status = restriction->check_text(text); !status)
    return Refusal{ML_ERROR_NOT_SUPPORTED, status.error()};
  std::shared_ptr<Pipeline> out(new Pipeline);
  out->state_callback_ = callback;
  CError error;
  const int result = weir_pipeline_parse(text, &out->pipeline_, error.place());
  if (result < 0) return Refusal{ML_ERROR_STREAMS_PIPE, error.take(result)};
  const ElementRef pipeline(weir_pipeline_get_element(out->pipeline_, nullptr));
  if (auto status = restriction->check_children(pipeline.get()); !status)
    return Refusal{ML_ERROR_NOT_SUPPORTED, status.error()};
  if (auto status = out->connect(); !status) return refusal(status.error());
  if (auto status = out->prepare(); !status) return Refusal{ML_ERROR_STREAMS_PIPE, status.error()};
  return out;
}

// Connects the sinks and holds the callbacks that elements use.
Status Pipeline::connect() {
  const auto elements = list_elements(pipeline_);
  if (!elements) return elements.error();
  for (const auto& element : *elements) {
    if (element.depth == 0 && find_kind(pipeline_, element.name) == element.kind)
      kinds_.emplace(element.name, element.kind);
    hold(element.name, element.kind);
    if (!is_sink(element.kind)) continue;
    CError error;
    if (auto status =
            error.status(weir_pipeline_discard(pipeline_, element.name.c_str(), error.place()));
        !status)
      return status;
  }
  for (const auto& [name, kind] : kinds_)
    if (auto status = is_sink(kind) ? connect_sink(name) : ok(); !status) return status;
  if (!state_callback_.function) return ok();
  CError error;
  return error.status(weir_pipeline_on_state(pipeline_, on_state, this, error.place()));
}

// Of several in bins, none can be named: their frames stay discarded.
Status Pipeline::connect_sink(const std::string& name) {
  const ElementRef found(weir_pipeline_get_element(pipeline_, name.c_str()));
  if (found) g_object_set_data(G_OBJECT(found.get()), process::kDropsUnreadable, found.get());
  auto sink = std::make_unique<SinkCallbacks>(this);
  CError error;
  const int result = weir_pipeline_on_frame(pipeline_, name.c_str(), SinkCallbacks::on_frame,
                                            sink.get(), error.place());
  if (result < 0 && result != -WEIR_OPTION_VALUE) return error.take(result);
  if (result >= 0) sinks_[name] = std::move(sink);
  return ok();
}

void Pipeline::hold(const std::string& name, const std::string& kind) {
  const auto add = [&](CallbackKind callback, const char* property) {
    held_.emplace_back(callback, get_text(pipeline_, name, property));
    hold_callback(held_.back());
  };
  if (kind == "tensor_filter" && get_text(pipeline_, name, "framework") == "custom-easy")
    add(CallbackKind::Filter, "model");
  if (kind == "tensor_if" &&
      equal_ignoring_case(get_text(pipeline_, name, "compared-value"), "custom"))
    add(CallbackKind::Condition, "compared-value-option");
}

// Pauses the pipeline, as NNStreamer does: frames can be pushed before it is started.
Status Pipeline::prepare() {
  constexpr GstClockTime kLimit = 10 * GST_MSECOND;
  if (state_callback_.function) on_state(WEIR_PIPELINE_STOPPED, this);
  CError error;
  if (auto status = error.status(weir_pipeline_pause(pipeline_, error.place())); !status)
    return status;
  GstState state = GST_STATE_NULL;
  if (get_state(kLimit, &state) != GST_STATE_CHANGE_FAILURE) return ok();
  CError reason;
  auto failed = reason.status(weir_pipeline_wait(pipeline_, 0, reason.place()));
  return failed ? Status(Error{.code = Code::INTERNAL, .what = "the pipeline cannot be paused"})
                : failed;
}

GstStateChangeReturn Pipeline::get_state(GstClockTime limit, GstState* state) const {
  const ElementRef pipeline(weir_pipeline_get_element(pipeline_, nullptr));
  return gst_element_get_state(pipeline.get(), state, nullptr, limit);
}

Refusal Pipeline::refused(const Error& error) const {
  CError failure;
  const int result = weir_pipeline_wait(pipeline_, 0, failure.place());
  const bool is_of_stream = result < 0 && failure.take(result).what == error.what;
  if (error.code == Code::CANCELLED || !is_of_stream) return refusal(error);
  return Refusal{ML_ERROR_STREAMS_PIPE, error};
}

// An error or an end of the stream is forgotten only by a restart. A restart is refused on a
// streaming thread, which a filter's callback may be.
Status Pipeline::flush() {
  const bool has_failed_or_ended =
      weir_pipeline_wait(pipeline_, 0, nullptr) != WEIR_PIPELINE_TIME_PASSED;
  const bool is_over =
      has_failed_or_ended || std::any_of(kinds_.begin(), kinds_.end(), [this](const auto& each) {
        return each.second == "appsrc" && has_ended(each.first);
      });
  if (is_over || pipeline_of_callback() == &kSomePipeline || !flush_by_events()) return restart();
  return ok();
}

// Returns false if an element refuses.
bool Pipeline::flush_by_events() {
  if (weir_pipeline_pause(pipeline_, nullptr) < 0) return false;
  const ElementRef pipeline(weir_pipeline_get_element(pipeline_, nullptr));
  const bool has_started = gst_element_send_event(pipeline.get(), gst_event_new_flush_start());
  const bool has_stopped = gst_element_send_event(pipeline.get(), gst_event_new_flush_stop(TRUE));
  return has_started && has_stopped;
}

// Pauses the pipeline after NULL.
Status Pipeline::restart() {
  CError error;
  if (auto status = error.status(weir_pipeline_stop(pipeline_, error.place())); !status)
    return status;
  std::vector<std::weak_ptr<SourceEvents>> all;
  {
    std::lock_guard lock(mutex_);
    ended_.clear();
    all = events_;
  }
  // Stopping replaces an appsrc.
  for (const auto& each : all)
    if (const auto events = each.lock())
      events->connect(
          ElementRef(weir_pipeline_get_element(pipeline_, events->source().c_str())).get());
  CError again;
  return again.status(weir_pipeline_pause(pipeline_, again.place()));
}

int Pipeline::end(const std::string& name, weir_error** error) {
  {
    std::lock_guard lock(mutex_);
    ended_.insert(name);
  }
  return weir_pipeline_end(pipeline_, name.c_str(), error);
}

bool Pipeline::has_ended(const std::string& name) const {
  {
    std::lock_guard lock(mutex_);
    if (ended_.contains(name)) return true;
  }
  const ElementRef element(weir_pipeline_get_element(pipeline_, name.c_str()));
  GstPad* const pad = element ? gst_element_get_static_pad(element.get(), "src") : nullptr;
  if (!pad) return false;
  const bool out = GST_PAD_IS_EOS(pad);
  gst_object_unref(pad);
  return out;
}

void Pipeline::connect_events(const std::shared_ptr<SourceEvents>& events) {
  {
    std::lock_guard lock(mutex_);
    std::erase_if(events_, [](const auto& each) { return each.expired(); });
    events_.push_back(events);
  }
  events->connect(ElementRef(weir_pipeline_get_element(pipeline_, events->source().c_str())).get());
}

Pipeline::~Pipeline() {
  close();  // for a pipeline whose construction failed
}

void Pipeline::on_state(int state, void* data) {
  const auto* self = static_cast<const Pipeline*>(data);
  const InCallback here(self);
  self->state_callback_.function(to_ml_state(state), self->state_callback_.data);
}

Result<Pipeline::Use> Pipeline::use() {
  std::lock_guard lock(mutex_);
  if (closed_)
    return Error{.code = Code::OPTION_VALUE, .what = "the pipeline of this handle was destroyed"};
  ++uses_;
  return Use(shared_from_this());
}

void Pipeline::leave() {
  std::lock_guard lock(mutex_);
  --uses_;
  left_.notify_all();
}

Status Pipeline::not_from_its_callback() const {
  if (pipeline_of_callback() != this) return ok();
  return Error{.code = Code::CANCELLED,
               .what = "a callback cannot change the state of its own pipeline",
               .offered = "a call in a callback, for which the call would wait",
               .needed = "a call on another thread",
               .fix = "return from the callback, and make the call on another thread"};
}

Status Pipeline::stop() {
  const auto pipeline = use();
  if (!pipeline) return pipeline.error();
  CError error;
  return error.status(weir_pipeline_stop(pipeline->get(), error.place()));
}

void Pipeline::close() {
  std::vector<std::weak_ptr<SourceEvents>> all;
  {
    std::lock_guard lock(mutex_);
    closed_ = true;
    all.swap(events_);
  }
  if (pipeline_) weir_pipeline_stop(pipeline_, nullptr);  // ends waiting calls and callbacks
  for (const auto& each : all)
    if (const auto events = each.lock()) events->close();
  std::unique_lock lock(mutex_);
  left_.wait(lock, [this] { return uses_ == 0; });
  weir_pipeline* pipeline = std::exchange(pipeline_, nullptr);
  const auto parts = std::exchange(parts_, {});
  lock.unlock();
  for (void* part : parts) (void)Handles::all().take<Object>(part, "part");
  weir_pipeline_free(pipeline);
  for (const auto& name : std::exchange(held_, {})) release_callback(name);
}

void* Pipeline::add_part(std::shared_ptr<Object> part) {
  void* const handle = Handles::all().add(std::move(part));
  std::lock_guard lock(mutex_);
  parts_.insert(handle);
  return handle;
}

void Pipeline::remove_part(void* handle) {
  std::lock_guard lock(mutex_);
  parts_.erase(handle);
}

SinkCallbacks* Pipeline::sink(const std::string& name) const {
  const auto found = sinks_.find(name);
  return found == sinks_.end() ? nullptr : found->second.get();
}

std::string Pipeline::get_kind(const std::string& name) const {
  const auto found = kinds_.find(name);
  return found == kinds_.end() ? "" : found->second;
}

Result<Pipeline::Use> use_pipeline(void* handle) {
  const auto found = Handles::all().find<Pipeline>(handle, "pipe");
  if (!found) return found.error();
  return (*found)->use();
}

Status check_kind(const Pipeline::Use& pipeline, const char* name, const std::string& kinds) {
  CError error;
  const int result = weir_pipeline_property_type(pipeline.get(), name, "name", error.place());
  if (result < 0) return error.take(result);
  const std::string kind = pipeline->get_kind(name);
  const bool any = kinds.empty() || kinds == kind || kinds.starts_with(kind + " or ") ||
                   kinds.ends_with(" or " + kind);
  if (any && (kinds.empty() || !kind.empty())) return ok();
  return Error{
      .code = Code::OPTION_VALUE,
      .what = "the element " + std::string(name) + " does not support this call",
      .offered = kind.empty() ? "an element inside a bin, not in the pipeline description" : kind,
      .needed = kinds};
}

}  // namespace weir::application
