// Runs a main loop around a pipeline; bus messages end the run.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "run/pipeline_run.hpp"

#include <glib-unix.h>

#include <algorithm>
#include <csignal>
#include <set>
#include <utility>

#include "gstcpp/element/posted_error.hpp"

namespace weir::app {
namespace {

constexpr guint kProgressMs = 500;
constexpr double kMaxSecondsToEnd = 5, kMsPerSecond = 1000;
constexpr gulong kPollUs = 10'000;

std::string string_or_empty(const char* text) {
  return text ? text : "";
}

// "videotestsrc0.src: caps = video/x-raw, ...".
std::string property_line(GstMessage* message) {
  GstObject* object = nullptr;
  const char* property = nullptr;
  const GValue* value = nullptr;
  gst_message_parse_property_notify(message, &object, &property, &value);
  const gst::UniqueText path(gst_object_get_path_string(object));
  const bool is_caps = value && GST_VALUE_HOLDS_CAPS(value) && gst_value_get_caps(value);
  const gst::UniqueText text(is_caps ? gst_caps_to_string(gst_value_get_caps(value))
                             : value ? gst_value_serialize(value)
                                     : nullptr);
  std::string name = string_or_empty(path.get());
  // "/GstPipeline:pipeline0/GstVideoTestSrc:videotestsrc0.GstPad:src" without the types.
  name.erase(0, name.rfind('/') + 1);
  for (size_t begin = 0; begin != std::string::npos && begin < name.size();) {
    if (const size_t colon = name.find(':', begin); colon != std::string::npos)
      name.erase(begin, colon + 1 - begin);
    begin = name.find('.', begin);
    if (begin != std::string::npos) ++begin;
  }
  return name + ": " + string_or_empty(property) + " = " + string_or_empty(text.get());
}

// Sources and sinks post this error after the one with the reason.
bool is_failed_state_change(GstMessage* message) {
  const auto original = gst::read_posted_error(message).original;
  return g_error_matches(original.get(), GST_CORE_ERROR, GST_CORE_ERROR_STATE_CHANGE);
}

}  // namespace

PipelineRun::PipelineRun(PlayedPipeline played)
    : played_(std::move(played)),
      sinks_(std::make_unique<SinkCounter>(pipeline())),
      sources_(std::make_unique<SourceWatch>(pipeline())),
      loop_(g_main_loop_new(nullptr, FALSE)) {}

// Before the probes' data go.
PipelineRun::~PipelineRun() {
  (void)played_.pipeline.stop();
}

RunEnd PipelineRun::play(RunEvents events) {
  events_ = std::move(events);
  if (shows_properties_) gst_element_add_property_deep_notify_watch(pipeline(), nullptr, TRUE);
  started_ = g_get_monotonic_time();
  // Signals keep their default action during the state change: loading a large model can be
  // interrupted, which the main loop, not yet running, could not do.
  if (const auto started = played_.pipeline.start(); !started) {
    drain_bus();
    if (errors_.empty()) errors_.push_back({started.error()});
    return RunEnd::Error;
  }
  const auto on_bus = +[](GstBus*, GstMessage* message, gpointer self) -> gboolean {
    static_cast<PipelineRun*>(self)->on_message(message);
    return G_SOURCE_CONTINUE;
  };
  const auto on_unix = +[](gpointer self) -> gboolean {
    static_cast<PipelineRun*>(self)->on_signal();
    return G_SOURCE_CONTINUE;
  };
  const auto on_time = +[](gpointer self) -> gboolean {
    auto* run = static_cast<PipelineRun*>(self);
    if (run->events_.progress) run->events_.progress(*run);
    return G_SOURCE_CONTINUE;
  };
  const auto on_limit = +[](gpointer self) -> gboolean {
    static_cast<PipelineRun*>(self)->on_time_limit();
    return G_SOURCE_CONTINUE;
  };
  std::vector<guint> sources{
      gst_bus_add_watch(played_.bus.get(), on_bus, this), g_unix_signal_add(SIGINT, on_unix, this),
      g_unix_signal_add(SIGTERM, on_unix, this), g_timeout_add(kProgressMs, on_time, this)};
  if (time_limit_ > 0)
    sources.push_back(
        g_timeout_add(static_cast<guint>(time_limit_ * kMsPerSecond), on_limit, this));
  g_main_loop_run(loop_.get());
  ended_ = g_get_monotonic_time();
  if (end_ == RunEnd::Error) drain_bus();
  if (!is_eos_) complete_files();
  if (end_timer_ != 0) sources.push_back(end_timer_);
  for (const guint source : sources) g_source_remove(source);
  return *end_;
}

// Collects the errors that came with the first one, because the last element of a chain is often
// not the cause.
void PipelineRun::drain_bus() {
  const auto kinds = static_cast<GstMessageType>(GST_MESSAGE_ERROR | GST_MESSAGE_WARNING);
  while (GstMessage* message = gst_bus_pop_filtered(played_.bus.get(), kinds)) {
    on_message(message);
    gst_message_unref(message);
  }
}

// An error and a second signal leave data on the way to muxers. The sources end first, so that
// encoders deliver what they hold.
void PipelineRun::complete_files() {
  files_.emplace(pipeline());
  const bool was_sent = is_eos_sent_;
  if (wait_for_files(0).empty()) return;
  send_eos();
  if (!was_sent && wait_for_files(kMaxSecondsToEnd / 2).empty()) return;
  files_->send_eos();
  for (const auto& sink : wait_for_files(kMaxSecondsToEnd / 2))
    if (events_.notice)
      events_.notice(sink + ": the stream did not end, so what the muxer wrote is incomplete");
}

// Waits until EOS has passed the sinks that it can reach, until a signal, or for so long. Returns
// the paths of those that it has not passed.
std::vector<std::string> PipelineRun::wait_for_files(double seconds) {
  const gint64 begin = g_get_monotonic_time();
  for (const int signals = signals_;;) {
    std::set<std::string> failed;
    for (const auto& error : errors_) failed.insert(error.path);
    auto out = files_->unfinished(failed);
    const auto waited = static_cast<double>(g_get_monotonic_time() - begin) / G_USEC_PER_SEC;
    if (out.empty() || signals_ != signals || waited >= seconds) return out;
    if (!g_main_context_iteration(nullptr, FALSE)) g_usleep(kPollUs);
  }
}

void PipelineRun::on_error(GstMessage* message) {
  auto error = parse_diagnostic(message);
  // EOS makes other branches that have failed say so again.
  if (files_ && !files_->contain(error.path)) return;
  if (errors_.empty() || !is_failed_state_change(message)) errors_.push_back(std::move(error));
  finish(RunEnd::Error);
}

void PipelineRun::on_eos() {
  is_eos_ = true;
  if (end_) return;
  if (signals_ > 0) return finish(RunEnd::Interrupted);
  if (is_time_over_) return finish(RunEnd::TimeLimit);
  auto lost = sources_->find_lost();
  if (!lost) return finish(RunEnd::Eos);
  errors_.push_back(*std::move(lost));
  finish(RunEnd::Error);
}

void PipelineRun::on_message(GstMessage* message) {
  switch (GST_MESSAGE_TYPE(message)) {
    case GST_MESSAGE_ERROR:
      on_error(message);
      break;
    case GST_MESSAGE_WARNING:
      warnings_.push_back(parse_diagnostic(message));
      sources_->on_warning(message);
      if (events_.warning) events_.warning(warnings_.back());
      break;
    case GST_MESSAGE_EOS:
      on_eos();
      break;
    case GST_MESSAGE_PROPERTY_NOTIFY:
      if (events_.notice) events_.notice(property_line(message));
      break;
    case GST_MESSAGE_STATE_CHANGED: {
      GstState state;
      gst_message_parse_state_changed(message, nullptr, &state, nullptr);
      const bool is_ours = GST_MESSAGE_SRC(message) == GST_OBJECT(pipeline());
      if (is_ours && state == GST_STATE_PLAYING && events_.playing) events_.playing();
      break;
    }
    default:
      break;
  }
}

bool PipelineRun::is_playing() const {
  GstState state;
  return gst_element_get_state(pipeline(), &state, nullptr, 0) == GST_STATE_CHANGE_SUCCESS &&
         state == GST_STATE_PLAYING;
}

void PipelineRun::on_signal() {
  // Before PLAYING there is no frame to wait for, and sending EOS to a starting source would block
  // on a lock that is held until the sinks have prerolled.
  if (++signals_ > 1 || end_ || !is_playing() || stops_at_first_signal_) {
    finish(RunEnd::Interrupted);
    return;
  }
  stop();
  if (events_.notice)
    events_.notice("stopping: waiting for frames in flight (interrupt again to stop at once)");
  send_eos();
}

// In another thread, because a source may hold its locks while it waits for a peer.
void PipelineRun::send_eos() {
  if (std::exchange(is_eos_sent_, true)) return;
  const auto send = +[](GstElement* pipeline, gpointer) {
    gst_element_send_event(pipeline, gst_event_new_eos());
  };
  gst_element_call_async(pipeline(), send, nullptr, nullptr);
}

void PipelineRun::on_time_limit() {
  if (end_ || std::exchange(is_time_over_, true)) return;  // the timer repeats
  if (!is_playing()) {
    errors_.push_back(
        {{.what = "the pipeline did not reach PLAYING within the time of --timeout",
          .needed = "a first buffer at each sink: check the sources, and set async=false at sinks "
                    "whose first buffer comes late"}});
    finish(RunEnd::Error);
    return;
  }
  stop();
  send_eos();
  const auto on_end = +[](gpointer self) -> gboolean {
    static_cast<PipelineRun*>(self)->on_end_limit();
    return G_SOURCE_CONTINUE;
  };
  end_timer_ = g_timeout_add(static_cast<guint>(kMaxSecondsToEnd * kMsPerSecond), on_end, this);
}

// The stream takes long to end.
void PipelineRun::on_end_limit() {
  finish(signals_ > 0 ? RunEnd::Interrupted : RunEnd::TimeLimit);
}

void PipelineRun::stop() {
  if (const auto stopping = std::exchange(events_.stopping, nullptr)) stopping();
}

void PipelineRun::finish(RunEnd end) {
  stop();
  if (!end_) end_ = end;
  g_main_loop_quit(loop_.get());
}

double PipelineRun::seconds() const {
  const gint64 first = sinks_->first();
  if (first == 0) return 0;
  const gint64 last = ended_ ? ended_ : g_get_monotonic_time();
  return static_cast<double>(std::max<gint64>(last - first, 0)) / G_USEC_PER_SEC;
}

double PipelineRun::seconds_to_start() const {
  const gint64 first = sinks_->first();
  return first == 0 ? 0 : static_cast<double>(first - started_) / G_USEC_PER_SEC;
}

double PipelineRun::frame_rate() const {
  const uint64_t max = sinks_->busiest();
  const double time = seconds();
  return max < 2 || time <= 0 ? 0 : static_cast<double>(max - 1) / time;
}

std::optional<double> PipelineRun::played() const {
  gint64 position = 0, duration = 0;
  if (!gst_element_query_duration(pipeline(), GST_FORMAT_TIME, &duration) || duration <= 0 ||
      !gst_element_query_position(pipeline(), GST_FORMAT_TIME, &position) || position < 0)
    return std::nullopt;
  return std::min(static_cast<double>(position) / static_cast<double>(duration), 1.0);
}

}  // namespace weir::app
