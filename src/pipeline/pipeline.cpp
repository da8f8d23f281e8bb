// States, the bus, and the doors of the stream.
#include "pipeline/pipeline.hpp"

#include <algorithm>

#include "gstcpp/error.hpp"
#include "pipeline/bus_error.hpp"
#include "pipeline/element_access.hpp"

namespace weir::pipeline {
namespace {

using Clock = std::chrono::steady_clock;
using Time = std::optional<Clock::time_point>;

Time until(std::chrono::nanoseconds limit) {
  // Far beyond any wait, and far from the end of the clock's numbers.
  constexpr std::chrono::hours kForever(24 * 365 * 10);
  if (limit.count() < 0 || limit > kForever) return std::nullopt;
  return Clock::now() + limit;
}

Status gstreamer_is_there() {
  GError* raw = nullptr;
  if (gst_init_check(nullptr, nullptr, &raw)) return ok();
  const gst::Unique<GError, g_error_free> error(raw);
  return Error{
      Code::INTERNAL, "GStreamer cannot be started", error ? error->message : "", "", "", ""};
}

}  // namespace

Result<std::unique_ptr<Pipeline>> Pipeline::parse(const char* text) {
  if (auto status = gstreamer_is_there(); !status) return status.error();
  GError* raw = nullptr;
  auto* made = gst_parse_launch_full(text, nullptr, GST_PARSE_FLAG_FATAL_ERRORS, &raw);
  const gst::Unique<GError, g_error_free> error(raw);
  if (!made)
    return error ? parse_error(*error, text) : Error{Code::OPTION_SYNTAX,
                                                     "the text of the pipeline cannot be used",
                                                     text,
                                                     "",
                                                     "",
                                                     ""};
  auto element = gst::Ref<GstElement>::adopt(GST_ELEMENT(gst_object_ref_sink(made)));
  if (!GST_IS_PIPELINE(made)) {  // the text was one element
    auto whole =
        gst::Ref<GstElement>::adopt(GST_ELEMENT(gst_object_ref_sink(gst_pipeline_new(nullptr))));
    gst_bin_add(GST_BIN(whole.get()), element.get());
    element = std::move(whole);
  }
  return std::unique_ptr<Pipeline>(new Pipeline(std::move(element)));
}

Pipeline::Pipeline(gst::Ref<GstElement> pipeline) : pipeline_(std::move(pipeline)) {
  const gst::Unique<GstIterator, gst_iterator_free> all(
      gst_bin_iterate_recurse(GST_BIN(pipeline_.get())));
  const auto add = [](const GValue* item, gpointer data) {
    auto* self = static_cast<Pipeline*>(data);
    auto* element = GST_ELEMENT(g_value_get_object(item));
    const std::string kind = kind_of(element), name = GST_OBJECT_NAME(element);
    if (FrameSink::is_sink(kind))
      self->sinks_[name] = std::make_unique<FrameSink>(gst::Ref<GstElement>::share(element));
    if (kind == "appsrc")
      self->sources_[name] = std::make_unique<FrameSource>(GST_APP_SRC(element));
  };
  gst_iterator_foreach(all.get(), add, this);
  const auto bus = gst::Ref<GstBus>::adopt(gst_element_get_bus(pipeline_.get()));
  gst_bus_set_sync_handler(bus.get(), on_message, this, nullptr);
}

Pipeline::~Pipeline() {
  (void)stop();
  const auto bus = gst::Ref<GstBus>::adopt(gst_element_get_bus(pipeline_.get()));
  gst_bus_set_sync_handler(bus.get(), nullptr, nullptr, nullptr);
}

// On whichever thread posts. Nobody reads the bus itself.
GstBusSyncReply Pipeline::on_message(GstBus*, GstMessage* message, gpointer data) {
  auto* self = static_cast<Pipeline*>(data);
  if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR) self->took_error(error_of(message));
  if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_EOS &&
      GST_MESSAGE_SRC(message) == GST_OBJECT_CAST(self->pipeline_.get())) {
    std::lock_guard lock(self->mutex_);
    self->ended_ = true;
    self->changed_.notify_all();
  }
  if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_STATE_CHANGED &&
      GST_MESSAGE_SRC(message) == GST_OBJECT_CAST(self->pipeline_.get()))
    self->took_state(message);
  // Not here: it asks elements whose locks the posting thread may hold.
  if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_LATENCY)
    gst_element_call_async(
        self->pipeline_.get(),
        [](GstElement* pipeline, gpointer) { gst_bin_recalculate_latency(GST_BIN(pipeline)); },
        nullptr, nullptr);
  gst_message_unref(message);
  return GST_BUS_DROP;
}

void Pipeline::took_error(const Error& error) {
  {
    std::lock_guard lock(mutex_);
    if (!error_) error_ = error;
    changed_.notify_all();
  }
  for (const auto& [name, sink] : sinks_) sink->queue().wake();
}

void Pipeline::took_state(GstMessage* message) {
  if (!on_state_) return;
  GstState state = GST_STATE_NULL;
  gst_message_parse_state_changed(message, nullptr, &state, nullptr);
  state = std::max(state, GST_STATE_READY);
  if (told_state_.exchange(state) != state) on_state_(state);
}

std::optional<Error> Pipeline::failed() const {
  std::lock_guard lock(mutex_);
  return error_;
}

Status Pipeline::change(GstState state) {
  std::lock_guard changes(changes_);
  if (const auto error = failed()) return *error;
  if (stopped_) {
    for (const auto& [name, sink] : sinks_) sink->open();
    for (const auto& [name, source] : sources_) source->started();
  }
  stopped_ = false;
  if (gst_element_set_state(pipeline_.get(), state) != GST_STATE_CHANGE_FAILURE) return ok();
  if (const auto error = failed()) return *error;
  return Error{Code::INTERNAL,
               "the pipeline cannot change its state and says no reason",
               "",
               gst_element_state_get_name(state),
               "",
               ""};
}

Status Pipeline::stop() {
  std::lock_guard changes(changes_);
  for (const auto& [name, sink] : sinks_) sink->queue().close();
  gst_element_set_state(pipeline_.get(), GST_STATE_NULL);
  for (const auto& [name, source] : sources_) source->stopped();
  stopped_ = true;
  std::lock_guard lock(mutex_);
  error_.reset();
  ended_ = false;
  changed_.notify_all();
  return ok();
}

GstState Pipeline::state() const {
  GstState state = GST_STATE_NULL, next = GST_STATE_VOID_PENDING;
  gst_element_get_state(pipeline_.get(), &state, &next, 0);
  return next == GST_STATE_VOID_PENDING ? state : next;
}

Result<Answer> Pipeline::wait(std::chrono::nanoseconds limit) {
  const Time time = until(limit);
  std::unique_lock lock(mutex_);
  const auto over = [this] { return ended_ || error_; };
  if (time)
    changed_.wait_until(lock, *time, over);
  else
    changed_.wait(lock, over);
  if (error_) return *error_;
  return ended_ ? Answer::Done : Answer::TimePassed;
}

Result<gst::Ref<GstElement>> Pipeline::element(const std::string& name) const {
  return find_element(GST_BIN(pipeline_.get()), name);
}

Result<FrameSink*> Pipeline::sink(const std::string& name) const {
  if (const auto found = sinks_.find(name); found != sinks_.end()) return found->second.get();
  const auto other = element(name);
  if (!other) return other.error();
  return wrong_kind(other->get(), "tensor_sink or appsink");
}

Result<FrameSource*> Pipeline::source(const std::string& name) const {
  if (const auto found = sources_.find(name); found != sources_.end()) return found->second.get();
  const auto other = element(name);
  if (!other) return other.error();
  return wrong_kind(other->get(), "appsrc");
}

Status Pipeline::push(const std::string& name, std::span<const weir_tensor> tensors, int64_t pts,
                      int64_t duration) {
  const auto to = source(name);
  if (!to) return to.error();
  if (const auto error = failed()) return *error;
  if (stopped_) return not_started();
  auto status = (*to)->push(tensors, pts, duration);
  // A stream that an error has stopped takes no frames: the error is the reason.
  if (!status)
    if (const auto error = failed()) return *error;
  return status;
}

Status Pipeline::end(const std::string& name) {
  const auto to = source(name);
  if (!to) return to.error();
  if (const auto error = failed()) return *error;
  return stopped_ ? not_started() : (*to)->end();
}

Result<Pipeline::Pulled> Pipeline::pull(const std::string& name, std::chrono::nanoseconds limit) {
  const auto from = sink(name);
  if (!from) return from.error();
  auto& queue = (*from)->queue();
  auto arrived = queue.take(until(limit), [this] { return failed().has_value(); });
  if (arrived) {
    auto frame = PulledFrame::read(std::move(arrived->buffer), arrived->caps);
    if (!frame) return frame.error();
    return Pulled{Answer::Done, *std::move(frame)};
  }
  if (const auto error = failed()) return *error;
  if (queue.closed()) return not_started();
  return Pulled{queue.ended() ? Answer::Ended : Answer::TimePassed, nullptr};
}

Result<bool> Pipeline::ended(const std::string& name) const {
  const auto from = sink(name);
  if (!from) return from.error();
  if (const auto error = failed()) return *error;
  return (*from)->queue().ended();
}

Status Pipeline::on_frame(const std::string& name, FrameSink::Function function) {
  const auto to = sink(name);
  if (!to) return to.error();
  std::lock_guard changes(changes_);
  if (!stopped_)
    return Error{Code::OPTION_VALUE,
                 "the function for frames is chosen while the pipeline is stopped",
                 name,
                 "a pipeline that is stopped",
                 "",
                 "pipeline.on_frame(...) before pipeline.start()"};
  (*to)->set_function(std::move(function));
  return ok();
}

Status Pipeline::on_state(std::function<void(GstState)> function) {
  std::lock_guard changes(changes_);
  if (!stopped_)
    return Error{Code::OPTION_VALUE,
                 "the function for states is chosen while the pipeline is stopped",
                 "a pipeline that has started",
                 "a pipeline that is stopped",
                 "",
                 "weir_pipeline_stop(pipeline, NULL)"};
  on_state_ = std::move(function);
  return ok();
}

}  // namespace weir::pipeline
