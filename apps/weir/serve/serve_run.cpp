// SPDX-License-Identifier: LGPL-2.1-or-later
#include "serve/serve_run.hpp"

#include <glib-unix.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <mutex>
#include <string_view>
#include <thread>

#include "commands.hpp"
#include "core/text/shell_quote.hpp"
#include "run/ledger_table.hpp"

namespace weir::app {
namespace {

using Clock = std::chrono::steady_clock;
constexpr guint kFirstWaitMs = 1000, kMaxWaitMs = 30000, kEndMs = 9000;
constexpr std::chrono::seconds kStopWait{10}, kHastyWait{1};
constexpr gint64 kSteadyUs = 60'000'000;  // after which a failure is a new one

gst::Ref<GstElement> find_element(const ServedPipeline& served, const char* suffix) {
  const std::string name = served.model.name + suffix;
  return gst::Ref<GstElement>::adopt(
      gst_bin_get_by_name(GST_BIN(served.played.element.get()), name.c_str()));
}

std::string text_property(GstElement* element, const char* name) {
  char* text = nullptr;
  g_object_get(element, name, &text, nullptr);
  const gst::UniqueText owned(text);
  return text ? text : "";
}

// Lets a model that cannot run in batches run each request alone, from its next start, and warns.
// False: `error` is another one.
bool leave_batches(const ServedPipeline& served, Diagnostic error) {
  constexpr std::string_view kProperty = "batch-size=";
  const auto filter = find_element(served, "-filter");
  guint batch = 1;
  g_object_get(filter.get(), "batch-size", &batch, nullptr);
  if (batch == 1 || !error.has_code || error.error.code != Code::BATCH_UNSUPPORTED) return false;
  g_object_set(filter.get(), "batch-size", 1u, nullptr);
  std::string& fix = error.error.fix;
  const std::string size = fix.starts_with(kProperty) ? fix.substr(kProperty.size()) : "";
  fix = "weir serve " + shell_word(served.model.name + "=" + served.model.file) +
        (size.empty() ? "" : " --batch " + size);
  error.error.what += "; " + served.model.name + " is served without batches";
  print_warning(error);
  return true;
}

// Opens the model. False: it cannot be opened.
bool open_model(const ServedPipeline& served) {
  const auto filter = find_element(served, "-filter");
  return gst_element_set_state(filter.get(), GST_STATE_PAUSED) != GST_STATE_CHANGE_FAILURE;
}

// Sets the caps of the requests, with the model open: a filter accepts any length of an open
// dimension, which is 1 in what it reports.
void set_request_caps(const ServedPipeline& served) {
  const auto filter = find_element(served, "-filter");
  const std::string shapes = text_property(filter.get(), "input");
  const std::string types = text_property(filter.get(), "inputtype");
  if (shapes.empty() || types.empty()) return;
  const auto count = static_cast<int>(std::count(shapes.begin(), shapes.end(), ',') + 1);
  const auto caps = gst::Ref<GstCaps>::adopt(gst_caps_new_simple(
      "other/tensors", "format", G_TYPE_STRING, "static", "num_tensors", G_TYPE_INT, count,
      "dimensions", G_TYPE_STRING, shapes.c_str(), "types", G_TYPE_STRING, types.c_str(),
      "framerate", GST_TYPE_FRACTION, 0, 1, nullptr));
  g_object_set(find_element(served, "-source").get(), "caps", caps.get(), nullptr);
}

// A free port is chosen once: clients know it.
void set_port(const ServedPipeline& served, unsigned port) {
  g_object_set(find_element(served, "-source").get(), "port", port, nullptr);
}

// Why a pipeline did not start.
std::vector<Diagnostic> get_errors(const ServedPipeline& served) {
  auto out = served.played.take_errors();
  if (out.empty())
    out.push_back({{.what = "the model " + served.model.name +
                            " cannot be started, and no element posted an error"}});
  return out;
}

// Opens the model before the source starts. Its errors; empty = open.
std::vector<Diagnostic> prepare(ServedPipeline& served) {
  if (!open_model(served)) {
    auto errors = get_errors(served);
    if (!leave_batches(served, errors.front())) return errors;
    (void)served.played.pipeline.stop();  // discards the error
    if (!open_model(served)) return get_errors(served);
  }
  set_request_caps(served);
  return {};
}

}  // namespace

ServeRun::ServeRun(std::vector<ServedPipeline> pipelines) : loop_(g_main_loop_new(nullptr, FALSE)) {
  for (auto& pipeline : pipelines)
    served_.push_back(std::make_shared<Served>(this, std::move(pipeline)));
}

ServeRun::~ServeRun() {
  for (const guint source : signal_sources_) g_source_remove(source);
  for (const auto& served : served_) {
    if (served->watch) g_source_remove(served->watch);
    if (served->restart) g_source_remove(served->restart);
  }
}

std::vector<Diagnostic> ServeRun::start() {
  for (const auto& served : served_) {
    PlayedPipeline& played = served->what.played;
    if (auto errors = prepare(served->what); !errors.empty()) return errors;
    // All share the free port that the first one chose.
    if (port_ != 0) set_port(served->what, port_);
    if (!played.pipeline.start()) return get_errors(served->what);
    served->watch = gst_bus_add_watch(
        played.bus.get(),
        [](GstBus*, GstMessage* message, gpointer user) -> gboolean {
          auto* one = static_cast<Served*>(user);
          one->run->on_message(one, message);
          return G_SOURCE_CONTINUE;
        },
        served.get());
    served->played_from = g_get_monotonic_time();
    port_ = port();
  }
  // Before callers learn that the models are served. Until here a signal has its default action: it
  // interrupts the loading of a large model.
  const auto on_signal = +[](gpointer self) -> gboolean {
    static_cast<ServeRun*>(self)->on_signal();
    return G_SOURCE_CONTINUE;
  };
  signal_sources_ = {g_unix_signal_add(SIGINT, on_signal, this),
                     g_unix_signal_add(SIGTERM, on_signal, this)};
  return {};
}

int ServeRun::play() {
  g_main_loop_run(loop_.get());
  return status_;
}

bool ServeRun::stop() {
  struct Stopping {
    std::mutex mutex;  // guards the rest
    std::condition_variable changed;
    bool is_done = false;
  };
  const auto stopping = std::make_shared<Stopping>();
  std::thread thread([this, stopping] {
    for (const auto& served : served_) (void)served->what.played.pipeline.stop();
    const std::lock_guard lock(stopping->mutex);
    stopping->is_done = true;
    stopping->changed.notify_all();
  });
  if (signals_ == 0) stop_by_ = Clock::now() + kStopWait;
  std::unique_lock lock(stopping->mutex);
  const bool is_done =
      stopping->changed.wait_until(lock, stop_by_, [&] { return stopping->is_done; });
  lock.unlock();
  if (is_done)
    thread.join();
  else
    thread.detach();
  return is_done;
}

void ServeRun::on_message(Served* served, GstMessage* message) {
  // What follows the first error.
  if (served->is_stopping || served->restart != 0) return;
  switch (GST_MESSAGE_TYPE(message)) {
    case GST_MESSAGE_ERROR:
      if (const auto error = parse_diagnostic(message); !leave_batches(served->what, error))
        print_errors({error});
      restart(served);
      break;
    case GST_MESSAGE_WARNING:
      print_warning(parse_diagnostic(message));
      break;
    case GST_MESSAGE_EOS:
      served->ended = true;
      end_if_all_ended(kExitGood);
      break;
    default:
      break;
  }
}

void ServeRun::end_if_all_ended(int status) {
  if (std::all_of(served_.begin(), served_.end(), [](const auto& one) { return one->ended; }))
    end(status);
}

// Stops the pipeline on another thread: its end waits for requests in work, for ever if a model
// hangs. Requests that the pipeline had end as aborted.
void ServeRun::restart(Served* served) {
  served->is_stopping = true;
  using Shared = std::shared_ptr<Served>;  // the call may last longer than this object
  gst_element_call_async(
      served->what.played.element.get(),
      [](GstElement*, gpointer user) {
        Served* stopped = static_cast<Shared*>(user)->get();
        (void)stopped->what.played.pipeline.stop();
        g_idle_add_once(
            [](gpointer one) {
              static_cast<Served*>(one)->run->on_stopped(static_cast<Served*>(one));
            },
            stopped);
      },
      new Shared(served->shared_from_this()),
      [](gpointer user) { delete static_cast<Shared*>(user); });
}

void ServeRun::on_stopped(Served* served) {
  served->is_stopping = false;
  if (signals_ > 0) {
    served->ended = true;
    return end_if_all_ended(kExitError);
  }
  if (g_get_monotonic_time() - served->played_from > kSteadyUs) served->wait_ms = 0;
  start_later(served);
}

void ServeRun::start_later(Served* served) {
  served->wait_ms = std::clamp(served->wait_ms * 2, kFirstWaitMs, kMaxWaitMs);
  std::fprintf(stderr, "weir: the model %s is started again in %u s\n",
               served->what.model.name.c_str(), served->wait_ms / 1000);
  served->restart = g_timeout_add_once(
      served->wait_ms,
      [](gpointer user) {
        auto* one = static_cast<Served*>(user);
        one->run->start_again(one);
      },
      served);
}

void ServeRun::start_again(Served* served) {
  served->restart = 0;
  set_port(served->what, port_);
  served->played_from = g_get_monotonic_time();
  if (served->what.played.pipeline.start()) return;
  print_errors(get_errors(served->what));
  served->played_from = g_get_monotonic_time();  // it did not play, however long that took
  restart(served);
}

void ServeRun::on_signal() {
  if (++signals_ > 1) {
    stop_by_ = Clock::now() + kHastyWait;
    end(kExitInterrupted);
    return;
  }
  stop_by_ = Clock::now() + kStopWait;
  g_timeout_add_once(
      kEndMs, [](gpointer self) { static_cast<ServeRun*>(self)->end(kExitError); }, this);
  for (const auto& served : served_) {
    if (served->restart != 0) {
      g_source_remove(std::exchange(served->restart, 0));
      served->ended = true;
    } else if (!served->is_stopping) {
      // It waits for the request in work.
      gst_element_call_async(
          served->what.played.element.get(),
          [](GstElement* pipeline, gpointer) {
            gst_element_send_event(pipeline, gst_event_new_eos());
          },
          nullptr, nullptr);
    }
  }
  end_if_all_ended(kExitGood);
}

void ServeRun::end(int status) {
  status_ = status;
  g_main_loop_quit(loop_.get());
}

Json ServeRun::describe_tensors(size_t pipeline) const {
  const auto filter = find_element(served_[pipeline]->what, "-filter");
  Json out = Json::object();
  for (const char* name : {"input", "inputtype", "output", "outputtype"})
    out[name] = text_property(filter.get(), name);
  return out;
}

Json ServeRun::statistics() const {
  Json out = Json::array();
  for (const auto& served : served_)
    for (const Json& ledger : ledgers(served->what.played.element.get())) out.push_back(ledger);
  return out;
}

unsigned ServeRun::port() const {
  guint port = 0;
  g_object_get(find_element(served_.front()->what, "-source").get(), "port", &port, nullptr);
  return port;
}

}  // namespace weir::app
