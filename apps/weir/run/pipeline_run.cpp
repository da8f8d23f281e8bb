// Runs a main loop around a pipeline; pad probes count frames and bus messages end the run.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "run/pipeline_run.hpp"

#include <glib-unix.h>

#include <algorithm>
#include <csignal>
#include <string_view>

namespace weir::app {
namespace {

constexpr guint kProgressMs = 500;

std::string text_of(const char* text) {
  return text ? text : "";
}

std::string part(const GstStructure* details, const char* name) {
  return details ? text_of(gst_structure_get_string(details, name)) : "";
}

// Video sinks of X, GL and Wayland post this error when their window is closed.
bool is_closed_window(GstMessage* message, const GError* error) {
  if (!g_error_matches(error, GST_RESOURCE_ERROR, GST_RESOURCE_ERROR_NOT_FOUND)) return false;
  GstObject* source = GST_MESSAGE_SRC(message);
  if (!GST_IS_ELEMENT(source)) return false;
  const char* klass = gst_element_get_metadata(GST_ELEMENT(source), GST_ELEMENT_METADATA_KLASS);
  return klass && std::string_view(klass).find("Sink/Video") != std::string_view::npos;
}

}  // namespace

Complaint complaint_of(GstMessage* message) {
  GError* error = nullptr;
  char* debug = nullptr;
  const GstStructure* details = nullptr;
  if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR) {
    gst_message_parse_error(message, &error, &debug);
    gst_message_parse_error_details(message, &details);
  } else {
    gst_message_parse_warning(message, &error, &debug);
    gst_message_parse_warning_details(message, &details);
  }
  if (details && !gst_structure_has_name(details, "weir-error")) details = nullptr;
  Complaint out;
  out.element = GST_MESSAGE_SRC(message) ? text_of(GST_MESSAGE_SRC_NAME(message)) : "";
  out.id = part(details, "id");
  out.what = details ? part(details, "what") : error ? text_of(error->message) : "";
  out.offered = part(details, "offered");
  out.needed = part(details, "needed");
  out.difference = part(details, "difference");
  out.fix = part(details, "fix");
  out.debug = text_of(debug);
  out.is_closed_window =
      GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR && is_closed_window(message, error);
  g_clear_error(&error);
  g_free(debug);
  return out;
}

PipelineRun::PipelineRun(gst::Ref<GstElement> read)
    : pipeline_(std::move(read)), loop_(g_main_loop_new(nullptr, FALSE)) {
  GstElement* pipeline = pipeline_.get();
  g_signal_connect(pipeline, "deep-element-added",
                   G_CALLBACK(+[](GstBin*, GstBin*, GstElement* element, gpointer self) {
                     static_cast<PipelineRun*>(self)->count_at(element);
                   }),
                   this);
  gst::Unique<GstIterator, gst_iterator_free> all(gst_bin_iterate_recurse(GST_BIN(pipeline)));
  gst_iterator_foreach(
      all.get(),
      [](const GValue* item, gpointer self) {
        static_cast<PipelineRun*>(self)->count_at(GST_ELEMENT(g_value_get_object(item)));
      },
      this);
}

PipelineRun::~PipelineRun() {
  gst_element_set_state(pipeline_.get(), GST_STATE_NULL);
  g_signal_handlers_disconnect_by_data(pipeline_.get(), this);
}

// Only real sinks: a bin has the sink flag when a child has it.
void PipelineRun::count_at(GstElement* element) {
  if (!GST_OBJECT_FLAG_IS_SET(element, GST_ELEMENT_FLAG_SINK) || GST_IS_BIN(element)) return;
  const auto pad = gst::Ref<GstPad>::adopt(gst_element_get_static_pad(element, "sink"));
  if (!pad) return;
  auto count = std::make_unique<SinkCount>();
  const gst::UniqueText name(gst_element_get_name(element));
  count->name = name.get();
  count->first = &first_;
  gst_pad_add_probe(
      pad.get(),
      static_cast<GstPadProbeType>(GST_PAD_PROBE_TYPE_BUFFER | GST_PAD_PROBE_TYPE_BUFFER_LIST),
      on_data, count.get(), nullptr);
  std::lock_guard lock(mutex_);
  sinks_.push_back(std::move(count));
}

GstPadProbeReturn PipelineRun::on_data(GstPad*, GstPadProbeInfo* info, gpointer user) {
  auto* sink = static_cast<SinkCount*>(user);
  gint64 never = 0;
  if (sink->first->load(std::memory_order_relaxed) == 0)
    sink->first->compare_exchange_strong(never, g_get_monotonic_time());
  const bool list = info->type & GST_PAD_PROBE_TYPE_BUFFER_LIST;
  sink->frames += list ? gst_buffer_list_length(GST_PAD_PROBE_INFO_BUFFER_LIST(info)) : 1;
  return GST_PAD_PROBE_OK;
}

RunEnd PipelineRun::play(const std::function<void(const PipelineRun&)>& progress,
                         const std::function<void(const std::string&)>& say) {
  progress_ = progress;
  say_ = say;
  // Signals keep their default action during the state change: loading a large model can be
  // interrupted, which the main loop, not yet running, could not do.
  if (gst_element_set_state(pipeline_.get(), GST_STATE_PLAYING) == GST_STATE_CHANGE_FAILURE) {
    drain_bus();
    if (errors_.empty()) {
      Complaint complaint;
      complaint.what = "the pipeline cannot be started, and no element posted an error";
      errors_.push_back(std::move(complaint));
    }
    return RunEnd::Error;
  }
  const auto bus = gst::Ref<GstBus>::adopt(gst_element_get_bus(pipeline_.get()));
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
    if (run->progress_) run->progress_(*run);
    return G_SOURCE_CONTINUE;
  };
  const guint sources[] = {
      gst_bus_add_watch(bus.get(), on_bus, this), g_unix_signal_add(SIGINT, on_unix, this),
      g_unix_signal_add(SIGTERM, on_unix, this), g_timeout_add(kProgressMs, on_time, this)};
  g_main_loop_run(loop_.get());
  ended_ = g_get_monotonic_time();
  for (const guint source : sources) g_source_remove(source);
  if (end_ == RunEnd::Error) drain_bus();
  return end_;
}

// Collects the errors that came with the first one, because the last element of a chain is often
// not the cause.
void PipelineRun::drain_bus() {
  const auto bus = gst::Ref<GstBus>::adopt(gst_element_get_bus(pipeline_.get()));
  const auto kinds = static_cast<GstMessageType>(GST_MESSAGE_ERROR | GST_MESSAGE_WARNING);
  while (GstMessage* message = gst_bus_pop_filtered(bus.get(), kinds)) {
    on_message(message);
    gst_message_unref(message);
  }
}

void PipelineRun::on_message(GstMessage* message) {
  switch (GST_MESSAGE_TYPE(message)) {
    case GST_MESSAGE_ERROR:
      errors_.push_back(complaint_of(message));
      finish(RunEnd::Error);
      break;
    case GST_MESSAGE_WARNING:
      warnings_.push_back(complaint_of(message));
      break;
    case GST_MESSAGE_EOS:
      finish(signals_ > 0 ? RunEnd::Interrupted : RunEnd::Eos);
      break;
    case GST_MESSAGE_LATENCY:
      gst_bin_recalculate_latency(GST_BIN(pipeline_.get()));
      break;
    case GST_MESSAGE_CLOCK_LOST:  // GStreamer requires pausing and playing again to select a new
                                  // clock
      gst_element_set_state(pipeline_.get(), GST_STATE_PAUSED);
      gst_element_set_state(pipeline_.get(), GST_STATE_PLAYING);
      break;
    case GST_MESSAGE_REQUEST_STATE: {
      GstState state;
      gst_message_parse_request_state(message, &state);
      gst_element_set_state(pipeline_.get(), state);
      break;
    }
    default:
      break;
  }
}

void PipelineRun::on_signal() {
  // Before PLAYING there is no frame to wait for, and sending EOS to a starting source would block
  // on a lock that is held until the sinks have prerolled.
  GstState state;
  const bool playing =
      gst_element_get_state(pipeline_.get(), &state, nullptr, 0) == GST_STATE_CHANGE_SUCCESS &&
      state == GST_STATE_PLAYING;
  if (++signals_ > 1 || !playing || stops_at_first_signal_) {
    finish(RunEnd::Interrupted);
    return;
  }
  if (say_) say_("stopping: waiting for frames in flight (interrupt again to stop at once)");
  gst_element_send_event(pipeline_.get(), gst_event_new_eos());
}

void PipelineRun::finish(RunEnd end) {
  end_ = end;
  g_main_loop_quit(loop_.get());
}

std::vector<std::pair<std::string, uint64_t>> PipelineRun::sinks() const {
  std::vector<std::pair<std::string, uint64_t>> out;
  std::lock_guard lock(mutex_);
  for (const auto& sink : sinks_) out.emplace_back(sink->name, sink->frames);
  return out;
}

uint64_t PipelineRun::frames() const {
  uint64_t all = 0;
  for (const auto& sink : sinks()) all += sink.second;
  return all;
}

double PipelineRun::seconds() const {
  const gint64 first = first_;
  if (first == 0) return 0;
  const gint64 last = ended_ ? ended_ : g_get_monotonic_time();
  return static_cast<double>(std::max<gint64>(last - first, 0)) / G_USEC_PER_SEC;
}

double PipelineRun::frame_rate() const {
  uint64_t most = 0;
  for (const auto& sink : sinks()) most = std::max(most, sink.second);
  const double time = seconds();
  return most < 2 || time <= 0 ? 0 : static_cast<double>(most - 1) / time;
}

}  // namespace weir::app
