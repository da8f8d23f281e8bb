// Pipeline: states, bus messages, sources and sinks.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pipeline/pipeline.hpp"

#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <utility>
#include <vector>

#include "core/timer/deadline.hpp"
#include "gstcpp/element/elements.hpp"
#include "gstcpp/element/error.hpp"
#include "pipeline/element_access.hpp"

namespace weir::pipeline {
namespace {

using Clock = std::chrono::steady_clock;
using Time = std::optional<Clock::time_point>;

constexpr size_t kMaxMessages = 64;  // documented in pipeline.h
constexpr char kAdopted[] = "weir-adopted";

Time until(std::chrono::nanoseconds limit) {
  if (limit.count() < 0) return std::nullopt;
  return deadline_after(Clock::now(), limit);
}

Error own_thread() {
  return Error{.code = Code::CANCELLED,
               .what = "a callback cannot change the state of its own pipeline",
               .offered = "a call on a streaming thread, for which the call would wait",
               .needed = "a call on another thread",
               .fix = "return from the callback, and make the call on another thread"};
}

// The process in which pipelines ran; 0 before the first one.
std::atomic<pid_t> running_process = 0;

// A child process that fork() made has none of the threads of its parent, and their locks as they
// were: what would wait for them never returns.
bool is_forked() {
  const pid_t process = running_process;
  return process != 0 && process != getpid();
}

Error forked_process() {
  return Error{.code = Code::GRAPH_STALLS,
               .what =
                   "this process was forked from one in which pipelines ran, and lacks their "
                   "threads",
               .offered = "process " + std::to_string(getpid()) + ", forked from process " +
                          std::to_string(running_process),
               .needed = "a process that was started, not forked, or that was forked before",
               .fix = "in Python: multiprocessing.get_context(\"spawn\").Pool()"};
}

// Takes the warnings that an element posts on this thread, while a property of it is set.
class WarningCapture {
 public:
  WarningCapture(GstElement* element, std::vector<BusError>* posted)
      : element_(element), posted_(posted), outer_(std::exchange(innermost, this)) {}
  ~WarningCapture() { innermost = outer_; }
  WarningCapture(const WarningCapture&) = delete;
  WarningCapture& operator=(const WarningCapture&) = delete;

  static bool captures(GstMessage* message) {
    if (!innermost || GST_MESSAGE_SRC(message) != GST_OBJECT_CAST(innermost->element_))
      return false;
    innermost->posted_->push_back(to_error(message));
    return true;
  }

 private:
  static thread_local WarningCapture* innermost;
  GstElement* const element_;
  std::vector<BusError>* const posted_;
  WarningCapture* const outer_;
};
thread_local WarningCapture* WarningCapture::innermost = nullptr;

}  // namespace

Status check_process() {
  return is_forked() ? Status(forked_process()) : ok();
}

Status start_gstreamer() {
  if (auto status = check_process(); !status) return status;
  GError* raw = nullptr;
  if (gst_init_check(nullptr, nullptr, &raw)) return ok();
  const gst::Unique<GError, g_error_free> error(raw);
  return Error{.code = Code::INTERNAL,
               .what = "GStreamer cannot be started",
               .offered = error ? error->message : ""};
}

Result<std::unique_ptr<Pipeline>> Pipeline::parse(const char* text) {
  if (auto status = start_gstreamer(); !status) return status.error();
  GError* raw = nullptr;
  auto* made = gst_parse_launch_full(text, nullptr, GST_PARSE_FLAG_FATAL_ERRORS, &raw);
  const gst::Unique<GError, g_error_free> error(raw);
  if (!made)
    return error ? parse_error(*error, text)
                 : Error{.code = Code::OPTION_SYNTAX,
                         .what = "the pipeline description cannot be parsed",
                         .offered = text};
  auto element = gst::Ref<GstElement>::adopt(GST_ELEMENT(gst_object_ref_sink(made)));
  if (!GST_IS_PIPELINE(made)) {  // the text was a single element
    auto whole =
        gst::Ref<GstElement>::adopt(GST_ELEMENT(gst_object_ref_sink(gst_pipeline_new(nullptr))));
    gst_bin_add(GST_BIN(whole.get()), element.get());
    element = std::move(whole);
  }
  return std::unique_ptr<Pipeline>(new Pipeline(std::move(element), false));
}

Result<std::unique_ptr<Pipeline>> Pipeline::adopt(GstElement* pipeline) {
  const bool is_pipeline = GST_IS_PIPELINE(pipeline);
  if (!is_pipeline || GST_STATE(pipeline) != GST_STATE_NULL)
    return Error{.code = Code::OPTION_VALUE,
                 .what = "this object cannot be adopted as a pipeline",
                 .offered = std::string(G_OBJECT_TYPE_NAME(pipeline)) + " in the state " +
                            gst_element_state_get_name(GST_STATE(pipeline)),
                 .needed = "a GstPipeline in the state NULL",
                 .fix = is_pipeline ? "gst_element_set_state (pipeline, GST_STATE_NULL)"
                                    : "GstElement *pipeline = gst_pipeline_new (NULL); "
                                      "gst_bin_add (GST_BIN (pipeline), element);"};
  // Removed by the destructor. Two owners would take each other's messages and frames.
  if (!g_object_replace_data(G_OBJECT(pipeline), kAdopted, nullptr, pipeline, nullptr, nullptr))
    return Error{.code = Code::OPTION_VALUE,
                 .what = "this pipeline is adopted already",
                 .offered = GST_OBJECT_NAME(pipeline),
                 .needed = "a GstPipeline that no weir_pipeline has adopted",
                 .fix = "weir_pipeline_free(pipeline) before adopting it again"};
  return std::unique_ptr<Pipeline>(
      new Pipeline(gst::Ref<GstElement>::adopt(GST_ELEMENT(gst_object_ref_sink(pipeline))), true));
}

Status Pipeline::restrict_to(AllowedElements allowed) {
  if (auto status = allowed.check(bin()); !status) return status;
  allowed_ = std::move(allowed);
  added_handler_ =
      g_signal_connect(pipeline_.get(), "deep-element-added", G_CALLBACK(on_added), this);
  return ok();
}

// Called on any thread that adds an element.
void Pipeline::on_added(GstBin*, GstBin*, GstElement* element, Pipeline* self) {
  if (const auto status = self->allowed_->check(element); !status) {
    disable(element);
    gst::post_error(self->pipeline_.get(), status.error());
  }
}

Pipeline::Pipeline(gst::Ref<GstElement> pipeline, bool is_adopted)
    : pipeline_(std::move(pipeline)), link_(std::make_shared<BusLink>()) {
  for (const auto& each : gst::elements_in(pipeline_.get())) {
    GstElement* element = each.get();
    const std::string kind = get_factory_name(element), name = GST_OBJECT_NAME(element);
    if (FrameSink::is_sink(kind))
      sinks_.emplace(name, std::make_unique<FrameSink>(each, callbacks_));
    if (kind == "appsrc")
      sources_.emplace(name, std::make_unique<FrameSource>(GST_APP_SRC(element), !is_adopted));
  }
  const auto bus = gst::Ref<GstBus>::adopt(gst_element_get_bus(pipeline_.get()));
  link_->pipeline = this;
  gst_bus_set_sync_handler(
      bus.get(), on_posted, new std::shared_ptr<BusLink>(link_),
      [](gpointer link) { delete static_cast<std::shared_ptr<BusLink>*>(link); });
}

Pipeline::~Pipeline() {
  halt();
  if (added_handler_ > 0) g_signal_handler_disconnect(pipeline_.get(), added_handler_);
  const auto bus = gst::Ref<GstBus>::adopt(gst_element_get_bus(pipeline_.get()));
  gst_bus_set_sync_handler(bus.get(), nullptr, nullptr, nullptr);
  // A thread that posted earlier may be in the handler or about to enter it.
  link_->gate.close();
  g_object_set_data(G_OBJECT(pipeline_.get()), kAdopted, nullptr);
}

void Pipeline::dispose(std::unique_ptr<Pipeline> pipeline) noexcept {
  if (is_forked()) return static_cast<void>(pipeline.release());  // the end of the process frees it
  if (!pipeline->is_own_thread()) return;
  pipeline->callbacks_.close();
  Pipeline* left = pipeline.release();
  try {
    std::thread([left]() noexcept { delete left; }).detach();
  } catch (const std::system_error&) {
    // Without a thread the pipeline leaks, with its callbacks closed.
  }
}

bool Pipeline::is_own_thread() const {
  if (callbacks_.is_inside()) return true;
  std::lock_guard lock(mutex_);
  return streaming_threads_.contains(std::this_thread::get_id());
}

// Called on any thread that posts. Messages are not queued on the bus.
GstBusSyncReply Pipeline::on_posted(GstBus*, GstMessage* message, gpointer data) {
  const auto link = *static_cast<std::shared_ptr<BusLink>*>(data);
  if (const infer::CallGate::Visit visit(link->gate); visit) {
    Pipeline& pipeline = *link->pipeline;
    pipeline.handle(message);
    if (pipeline.on_message_)
      if (const infer::CallGate::Visit call(pipeline.callbacks_); call)
        pipeline.on_message_(message);
  }
  gst_message_unref(message);
  return GST_BUS_DROP;
}

void Pipeline::handle(GstMessage* message) {
  const bool is_own = GST_MESSAGE_SRC(message) == GST_OBJECT_CAST(pipeline_.get());
  switch (GST_MESSAGE_TYPE(message)) {
    case GST_MESSAGE_WARNING:
      if (WarningCapture::captures(message)) return;
      [[fallthrough]];
    case GST_MESSAGE_ERROR:
      return keep(GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR, to_error(message));
    case GST_MESSAGE_STATE_CHANGED:
      return is_own ? took_state(message) : void();
    case GST_MESSAGE_STREAM_STATUS:
      return took_stream_status(message);
    case GST_MESSAGE_LATENCY:
      return call_later([](Pipeline& p) { gst_bin_recalculate_latency(p.bin()); });
    case GST_MESSAGE_CLOCK_LOST:
      return call_later([](Pipeline& p) { p.select_clock(); });
    case GST_MESSAGE_REQUEST_STATE: {  // of a sound server that pauses its clients, for example
      GstState state = GST_STATE_NULL;
      gst_message_parse_request_state(message, &state);
      if (state == GST_STATE_PAUSED) call_later([](Pipeline& p) { p.follow(GST_STATE_PAUSED); });
      if (state == GST_STATE_PLAYING) call_later([](Pipeline& p) { p.follow(GST_STATE_PLAYING); });
      return;
    }
    case GST_MESSAGE_EOS: {
      std::lock_guard lock(mutex_);
      ended_ = ended_ || is_own;
      return changed_.notify_all();
    }
    default:
      return;
  }
}

// Calls the function on a thread of GStreamer: the posting thread may hold locks that it needs.
void Pipeline::call_later(void (*function)(Pipeline&)) {
  struct Call {
    std::shared_ptr<BusLink> link;
    void (*function)(Pipeline&);
  };
  gst_element_call_async(
      pipeline_.get(),
      [](GstElement*, gpointer data) {
        const auto* call = static_cast<Call*>(data);
        const infer::CallGate::Visit visit(call->link->gate);
        if (visit) call->function(*call->link->pipeline);
      },
      new Call{link_, function}, [](gpointer data) { delete static_cast<Call*>(data); });
}

// GStreamer requires pausing and playing again.
void Pipeline::select_clock() {
  std::lock_guard changes(changes_);
  if (stopped_ || GST_STATE_TARGET(pipeline_.get()) != GST_STATE_PLAYING) return;
  for (const auto state : {GST_STATE_PAUSED, GST_STATE_PLAYING})
    gst_element_set_state(pipeline_.get(), state);
}

void Pipeline::follow(GstState state) {
  std::lock_guard changes(changes_);
  if (!stopped_) gst_element_set_state(pipeline_.get(), state);
}

// Each streaming thread posts this when it starts and when it ends.
void Pipeline::took_stream_status(GstMessage* message) {
  GstStreamStatusType type = GST_STREAM_STATUS_TYPE_CREATE;
  gst_message_parse_stream_status(message, &type, nullptr);
  std::lock_guard lock(mutex_);
  if (type == GST_STREAM_STATUS_TYPE_ENTER) streaming_threads_.insert(std::this_thread::get_id());
  if (type == GST_STREAM_STATUS_TYPE_LEAVE) streaming_threads_.erase(std::this_thread::get_id());
}

Status Pipeline::set(const std::string& name, const std::string& property,
                     const std::string& text) {
  const auto found = element(name);
  if (!found) return found.error();
  std::vector<BusError> posted;
  {
    const WarningCapture capture(found->get(), &posted);
    if (auto status = set_property(found->get(), property, text); !status) return status;
  }
  // An accepted value may have warnings too, such as a model that is for the next start.
  const bool is_rejected = !posted.empty() && !has_value(found->get(), property, text);
  for (size_t i = is_rejected ? 1 : 0; i < posted.size(); ++i) keep(false, posted[i]);
  return is_rejected ? Status(posted.front().error) : ok();
}

void Pipeline::keep(bool is_error, BusError posted) {
  {
    std::lock_guard lock(mutex_);
    if (is_error && (!error_ || (posted.has_code && !error_->has_code))) error_ = posted;
    if (messages_.size() == kMaxMessages) messages_.pop_front();
    messages_.push_back({is_error, std::move(posted.error)});
    changed_.notify_all();
  }
  if (!is_error) return;
  for (const auto& [name, sink] : sinks_) sink->queue().wake();
}

std::optional<Pipeline::Message> Pipeline::read_message() {
  std::lock_guard lock(mutex_);
  if (messages_.empty()) return std::nullopt;
  std::optional<Message> oldest(std::move(messages_.front()));
  messages_.pop_front();
  return oldest;
}

void Pipeline::took_state(GstMessage* message) {
  if (!on_state_) return;
  GstState state = GST_STATE_NULL;
  gst_message_parse_state_changed(message, nullptr, &state, nullptr);
  state = std::max(state, GST_STATE_READY);
  if (reported_state_.exchange(state) == state) return;
  if (const infer::CallGate::Visit visit(callbacks_); visit) on_state_(state);
}

std::optional<Error> Pipeline::failed() const {
  if (is_forked()) return forked_process();
  std::lock_guard lock(mutex_);
  return error_ ? std::optional(error_->error) : std::nullopt;
}

Status Pipeline::change(GstState state) {
  if (is_forked()) return forked_process();
  running_process = getpid();
  if (callbacks_.is_inside()) return own_thread();
  // On a streaming thread: a stop in progress waits for this very call.
  const bool must_not_wait = is_own_thread();
  const auto changes =
      must_not_wait ? std::unique_lock(changes_, std::try_to_lock) : std::unique_lock(changes_);
  if (!changes) return own_thread();
  if (const auto error = failed()) return *error;
  if (stopped_) {
    for (const auto& [name, sink] : sinks_) sink->open();
    for (const auto& [name, source] : sources_) source->started();
  }
  stopped_ = false;
  if (gst_element_set_state(pipeline_.get(), state) != GST_STATE_CHANGE_FAILURE) return ok();
  if (const auto error = failed()) return *error;
  return Error{.code = Code::INTERNAL,
               .what = "the pipeline cannot change its state and posted no error",
               .needed = gst_element_state_get_name(state)};
}

Status Pipeline::stop() {
  if (is_forked()) return forked_process();
  if (is_own_thread()) return own_thread();
  halt();
  return ok();
}

void Pipeline::halt() {
  const auto close_queues = [this] {
    for (const auto& [name, sink] : sinks_) sink->queue().close();
  };
  close_queues();  // ends a start or pause that waits for the stream
  std::lock_guard changes(changes_);
  close_queues();  // opened by that start
  gst_element_set_state(pipeline_.get(), GST_STATE_NULL);
  if (allowed_) allowed_->stop_others(bin());
  for (const auto& [name, source] : sources_) source->stopped();
  stopped_ = true;
  std::lock_guard lock(mutex_);
  error_.reset();
  ended_ = false;
  ++stops_;
  streaming_threads_.clear();
  changed_.notify_all();
}

GstState Pipeline::state() const {
  if (is_forked()) return GST_STATE_NULL;
  GstState state = GST_STATE_NULL, next = GST_STATE_VOID_PENDING;
  gst_element_get_state(pipeline_.get(), &state, &next, 0);
  return next == GST_STATE_VOID_PENDING ? state : next;
}

Result<WaitResult> Pipeline::wait(std::chrono::nanoseconds limit) {
  if (is_forked()) return forked_process();
  const Time time = until(limit);
  if (!time && callbacks_.is_inside()) return own_thread();
  std::unique_lock lock(mutex_);
  const uint64_t stops = stops_;
  const auto over = [&] { return ended_ || error_ || stops_ != stops; };
  if (time)
    changed_.wait_until(lock, *time, over);
  else
    changed_.wait(lock, over);
  if (error_) return error_->error;
  if (stops_ != stops) return not_started();
  return ended_ ? WaitResult::Done : WaitResult::TimePassed;
}

namespace {

// The part of an element of this name: at the top level of the pipeline, or else the only one. Null
// if there is none.
template <class Parts>
auto find_part(const Parts& parts, const std::string& name, const GstElement* pipeline)
    -> Result<typename Parts::mapped_type::pointer> {
  const auto [first, last] = parts.equal_range(name);
  if (first == last) return nullptr;
  const auto count = static_cast<size_t>(std::distance(first, last));
  const auto found = std::find_if(
      first, last, [&](const auto& each) { return count == 1 || each.second->is_in(pipeline); });
  if (found == last) return not_unique(name, count);
  return found->second.get();
}

}  // namespace

Result<gst::Ref<GstElement>> Pipeline::element(const std::string& name) const {
  return find_element(GST_BIN(pipeline_.get()), name);
}

Result<FrameSink*> Pipeline::sink(const std::string& name) const {
  if (auto found = find_part(sinks_, name, pipeline_.get()); !found || *found) return found;
  const auto other = element(name);
  if (!other) return other.error();
  return wrong_kind(other->get(), "tensor_sink or appsink");
}

Result<FrameSource*> Pipeline::source(const std::string& name) const {
  if (auto found = find_part(sources_, name, pipeline_.get()); !found || *found) return found;
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
  // A stream stopped by an error rejects frames: return that error.
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

Result<std::vector<TensorSpec>> Pipeline::source_tensors(const std::string& name) const {
  const auto from = source(name);
  if (!from) return from.error();
  return (*from)->tensors();
}

Result<Pipeline::Pulled> Pipeline::pull(const std::string& name, std::chrono::nanoseconds limit) {
  if (is_forked()) return forked_process();
  const auto from = sink(name);
  if (!from) return from.error();
  auto& queue = (*from)->queue();
  auto arrived = queue.take(until(limit), [this] { return failed().has_value(); });
  if (arrived) {
    auto frame = PulledFrame::read(std::move(arrived->buffer), std::move(arrived->caps),
                                   std::move(arrived->labels));
    if (!frame) return frame.error();
    return Pulled{WaitResult::Done, *std::move(frame)};
  }
  if (const auto error = failed()) return *error;
  if (queue.closed()) return not_started();
  return Pulled{queue.ended() ? WaitResult::Ended : WaitResult::TimePassed, nullptr};
}

Result<bool> Pipeline::ended(const std::string& name) const {
  const auto from = sink(name);
  if (!from) return from.error();
  if (const auto error = failed()) return *error;
  return (*from)->queue().ended();
}

namespace {

Error chosen_while_stopped(const std::string& what, const std::string& offered, const char* fix) {
  return Error{.code = Code::OPTION_VALUE,
               .what = what + " can only be set while the pipeline is stopped",
               .offered = offered,
               .needed = "a pipeline that is stopped",
               .fix = fix};
}

}  // namespace

// Calls `choose` under the lock of state changes, or returns the error if the pipeline runs.
Status Pipeline::choose_while_stopped(const Error& refusal, const std::function<void()>& choose) {
  if (callbacks_.is_inside()) return refusal;
  std::lock_guard changes(changes_);
  if (!stopped_) return refusal;
  choose();
  return ok();
}

Status Pipeline::on_frame(const std::string& name, FrameSink::Function function) {
  const auto to = sink(name);
  if (!to) return to.error();
  return choose_while_stopped(
      chosen_while_stopped("the function for frames", name,
                           "pipeline.on_frame(...) before pipeline.start()"),
      [&] { (*to)->set_function(std::move(function)); });
}

Status Pipeline::discard(const std::string& name) {
  const auto [first, last] = sinks_.equal_range(name);
  if (first == last) return sink(name).error();
  return choose_while_stopped(chosen_while_stopped("what happens to frames", name,
                                                   "pipeline.discard(...) before pipeline.start()"),
                              [first = first, last = last] {
                                for (auto each = first; each != last; ++each)
                                  each->second->discard();
                              });
}

Status Pipeline::on_state(std::function<void(GstState)> function) {
  return choose_while_stopped(
      chosen_while_stopped("the function for states", "a pipeline that has started",
                           "weir_pipeline_stop(pipeline, NULL)"),
      [&] { on_state_ = std::move(function); });
}

Status Pipeline::on_message(std::function<void(GstMessage*)> function) {
  return choose_while_stopped(
      chosen_while_stopped("the function for messages", "a pipeline that has started",
                           "weir_pipeline_stop(pipeline, NULL)"),
      [&] { on_message_ = std::move(function); });
}

}  // namespace weir::pipeline
