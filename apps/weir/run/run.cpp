// `weir run PIPELINE`: plays a pipeline, shows progress, and prints the ledger at the end.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>
#include <unistd.h>

#define GST_USE_UNSTABLE_API
#include <gst/gsttracer.h>
#include <gst/gsttracerfactory.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>
#include <optional>

#include "commands.hpp"
#include "launch/pipeline_text.hpp"
#include "report.hpp"
#include "run/crash_hint.hpp"
#include "run/diagnostics.hpp"
#include "run/ledger_table.hpp"
#include "run/pipeline_run.hpp"
#include "run/report_document.hpp"
#include "run/service_notifier.hpp"
#include "run/shared_clock.hpp"
#include "weir/join.hpp"
#include "weir/printable_text.hpp"

namespace weir::app {
namespace {

gst::Ref<GstObject> running_tracer(GType type) {
  gst::Ref<GstObject> found;
  GList* all = gst_tracing_get_active_tracers();
  for (GList* item = all; item; item = item->next)
    if (!found && G_OBJECT_TYPE(item->data) == type)
      found = gst::Ref<GstObject>::share(GST_OBJECT(item->data));
  g_list_free_full(all, gst_object_unref);
  return found;
}

// The tracer of Weir's plug-in, active in this process. It is found by its name, because a plug-in
// provides it.
class TraceSession {
 public:
  // Uses the tracer that GST_TRACERS started, or starts one that writes no file. It traces elements
  // created afterwards. FILE_NOT_FOUND when the plug-in is not found.
  static Result<TraceSession> start() {
    const auto feature = gst::Ref<GstPluginFeature>::adopt(
        gst_registry_find_feature(gst_registry_get(), "weir", GST_TYPE_TRACER_FACTORY));
    const auto loaded = gst::Ref<GstPluginFeature>::adopt(
        feature ? gst_plugin_feature_load(feature.get()) : nullptr);
    if (!loaded)
      return Error{.code = Code::FILE_NOT_FOUND,
                   .what = "the tracer weir is not found",
                   .needed = "the plug-in libgstweir.so of this version",
                   .fix = "weir doctor"};
    const GType type =
        gst_tracer_factory_get_tracer_type(reinterpret_cast<GstTracerFactory*>(loaded.get()));
    auto tracer = running_tracer(type);
    if (!tracer)
      tracer = gst::Ref<GstObject>::adopt(
          GST_OBJECT(g_object_ref_sink(g_object_new(type, "params", "file=", nullptr))));
    return TraceSession(std::move(tracer));
  }
  // The summary of the trace so far; see core/trace/summary.hpp.
  Json summary() const {
    char* raw = nullptr;
    g_object_get(tracer_.get(), "summary", &raw, nullptr);
    const gst::UniqueText text(raw);
    Json out = text ? Json::parse(text.get(), nullptr, false) : Json();
    return out.is_object() ? out : Json::object();
  }

 private:
  explicit TraceSession(gst::Ref<GstObject> tracer) : tracer_(std::move(tracer)) {}
  gst::Ref<GstObject> tracer_;
};

const char* get_unit(const SinkStatistics& statistics) {
  return statistics.is_frames ? "frames" : "buffers";
}

std::string count_text(const SinkStatistics& statistics) {
  return std::to_string(statistics.count) + " " + get_unit(statistics);
}

std::string decimals(const char* format, double number) {
  const gst::UniqueText text(g_strdup_printf(format, number));
  return text.get();
}

// "12.0 s  360 frames  30.0 frames/s  40 %  18 s left".
std::string progress_text(const PipelineRun& run) {
  constexpr double kPercent = 100;
  const double seconds = run.seconds();
  const auto total = run.sinks().total();
  std::string out = decimals("%.1f s  ", seconds) + count_text(total) +
                    decimals("  %.1f ", run.frame_rate()) + get_unit(total) + "/s";
  const auto played = run.played();
  if (!played) return out;
  out += decimals("  %.0f %%", *played * kPercent);
  if (*played > 0) out += decimals("  %.0f s left", seconds * (1 - *played) / *played);
  return out;
}

// One line on stderr that is overwritten, if stderr is a terminal.
class ProgressLine {
 public:
  void show(const PipelineRun& run) {
    if (!terminal_) return;
    const std::string line = progress_text(run);
    std::fprintf(stderr, "\r\033[K%s", line.c_str());
    std::fflush(stderr);
    shown_ = true;
  }
  void clear() {
    if (shown_) std::fputs("\r\033[K", stderr);
    shown_ = false;
  }
  void say(const std::string& text) {
    clear();
    std::fprintf(stderr, "%s\n", printable_text(text).c_str());
  }

 private:
  const bool terminal_ = isatty(STDERR_FILENO) == 1;
  bool shown_ = false;
};

const char* to_string(RunEnd end) {
  switch (end) {
    case RunEnd::Eos:
      return "eos";
    case RunEnd::Error:
      return "error";
    case RunEnd::Interrupted:
      return "interrupted";
    case RunEnd::TimeLimit:
      return "time-limit";
  }
  return "";
}

const char* get_verb(RunEnd end) {
  switch (end) {
    case RunEnd::Eos:
      return "Ended";
    case RunEnd::Error:
      return "Failed";
    case RunEnd::Interrupted:
      return "Interrupted";
    case RunEnd::TimeLimit:
      return "Stopped by --timeout";
  }
  return "";
}

int to_exit_status(RunEnd end) {
  if (end == RunEnd::Eos || end == RunEnd::TimeLimit) return kExitGood;
  return end == RunEnd::Error ? kExitError : kExitInterrupted;
}

Json to_json(const std::vector<Diagnostic>& diagnostics) {
  Json out = Json::array();
  for (const auto& diagnostic : diagnostics) {
    const Error& error = diagnostic.error;
    Json item{{"element", diagnostic.element}, {"what", error.what}};
    const auto add = [&item](const char* name, const std::string& text) {
      if (!text.empty()) item[name] = text;
    };
    add("path", diagnostic.path);
    add("id", get_id(diagnostic));
    add("offered", error.offered);
    add("needed", error.needed);
    add("difference", error.difference);
    add("fix", error.fix);
    add("debug", diagnostic.debug);
    out.push_back(std::move(item));
  }
  return out;
}

void print_text(const PipelineRun& run, RunEnd end) {
  const auto total = run.sinks().total();
  if (run.seconds_to_start() > 0)
    std::printf(
        "%s %.3f s after the first frame: %s, %.1f %s/s; the first frame came after %.3f s\n",
        get_verb(end), run.seconds(), count_text(total).c_str(), run.frame_rate(), get_unit(total),
        run.seconds_to_start());
  else
    std::printf("%s without a frame\n", get_verb(end));
  const auto sinks = run.sinks().statistics();
  if (sinks.size() > 1)
    for (const auto& sink : sinks)
      std::printf("  %s: %s\n", printable_text(sink.name).c_str(), count_text(sink).c_str());
  const Json all = ledgers(run.pipeline());
  const std::string filters = filter_table(all), ledger = ledger_table(all);
  if (!filters.empty()) std::printf("\nFilters\n%s", filters.c_str());
  if (const auto servers = server_rows(all); !servers.empty())
    std::printf("\nServers\n%s", table(servers, "  ").c_str());
  if (!ledger.empty()) std::printf("\nLedger\n%s", ledger.c_str());
}

Json outcome(const PipelineRun& run, RunEnd end) {
  Json out{{"result", to_string(end)},
           {"frames", uint64_t{0}},
           {"buffers", uint64_t{0}},
           {"seconds", run.seconds()},
           {"seconds_to_start", run.seconds_to_start()},
           {"frame_rate", run.frame_rate()}};
  out["sinks"] = Json::array();
  for (const auto& sink : run.sinks().statistics()) {
    out[get_unit(sink)] = out[get_unit(sink)].get<uint64_t>() + sink.count;
    out["sinks"].push_back({{"name", sink.name}, {get_unit(sink), sink.count}});
  }
  out["ledger"] = ledgers(run.pipeline());
  out["errors"] = to_json(run.errors());
  out["warnings"] = to_json(run.warnings());
  return out;
}

Error cannot_write_report(const std::string& file) {
  return Error{.code = Code::FILE_NOT_WRITTEN,
               .what = "the report cannot be written",
               .offered = file,
               .needed = "a writable path",
               .difference = std::strerror(errno),
               .fix = "weir run --report /tmp/report.html PIPELINE"};
}

// Runs before the pipeline plays, so that an unwritable file is reported at once and not at the
// end.
Status try_to_write(const std::string& file) {
  if (std::ofstream(file, std::ios::app)) return ok();
  return cannot_write_report(file);
}

// Returns the text of the verdict.
Result<std::string> write_report(const RunOptions& options, const Json& outcome,
                                 const TraceSession& session, GstElement* pipeline) {
  const Json document =
      report_document(outcome, session.summary(), join(options.pipeline, " "), pipeline);
  std::ofstream file(options.report);
  if (options.report.ends_with(".json"))
    file << document.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
  else
    file << report_page(document);
  file.close();
  if (!file) return cannot_write_report(options.report);
  return document["verdict"]["text"].get<std::string>();
}

// Null when none is asked for.
Result<std::unique_ptr<SharedClock>> open_clock(const RunOptions& options) {
  ClockOptions wanted{.address = options.clock, .serving_port = std::nullopt};
  if (options.serving_port >= 0) wanted.serving_port = options.serving_port;
  if (!wanted.wanted()) return std::unique_ptr<SharedClock>();
  auto clock = SharedClock::open(wanted);
  if (clock && !options.quiet) std::fprintf(stderr, "%s\n", (*clock)->state_text().c_str());
  return clock;
}

// Tells the watchdog of a service whether its cameras and microphones deliver. Reports once per
// outage that one does not.
class CameraCheck {
 public:
  CameraCheck(const SourceWatch& sources, ProgressLine* line) : sources_(sources), line_(line) {}
  bool operator()(gint64 max_us) {
    const std::string silent = sources_.find_silent(max_us);
    if (!silent.empty() && silent != reported_)
      line_->say(silent + " delivered nothing for " +
                 decimals("%.3g", static_cast<double>(max_us) / G_USEC_PER_SEC) +
                 " s: the watchdog is not fed until it does");
    reported_ = silent;
    return silent.empty();
  }

 private:
  const SourceWatch& sources_;
  ProgressLine* line_;
  std::string reported_;
};

RunEnd play(const RunOptions& options, ServiceNotifier* service, PipelineRun* pipeline) {
  ProgressLine line;
  RunEvents events;
  if (service) {
    events.playing = [service, check = CameraCheck(pipeline->sources(), &line)] {
      service->ready("playing", check);
    };
    events.stopping = [service] { service->stopping(); };
  }
  const CrashHint hint(pipeline->pipeline(), join(options.pipeline, " "));
  if (!options.quiet) events.progress = [&line](const PipelineRun& run) { line.show(run); };
  events.notice = [&line](const std::string& text) { line.say(text); };
  if (!options.json)
    events.warning = [&line](const Diagnostic& warning) {
      line.clear();
      print_warning(warning);
    };
  if (options.verbose) pipeline->show_properties();
  if (options.time_limit > 0) pipeline->stop_after(options.time_limit);
  const RunEnd end = pipeline->play(std::move(events));
  line.clear();
  return end;
}

// What a run needs besides its pipeline.
struct Prepared {
  std::optional<TraceSession> session;  // of --report
  gst::Ref<GstElement> pipeline;
  std::unique_ptr<SharedClock> clock;  // null: the pipeline plays by a clock of its own
};

Result<Prepared> prepare(const RunOptions& options) {
  Prepared out;
  if (!options.report.empty()) {  // before elements are created
    auto started = TraceSession::start();
    if (!started) return started.error();
    out.session = *std::move(started);
  }
  auto read = read_pipeline(options.pipeline);
  if (!read) return read.error();
  out.pipeline = *std::move(read);
  if (out.session)
    if (const Status writable = try_to_write(options.report); !writable) return writable.error();
  auto clock = open_clock(options);
  if (!clock) return clock.error();
  out.clock = *std::move(clock);
  return out;
}

void print_outcome(const RunOptions& options, const PipelineRun& run, RunEnd end, const Json& facts,
                   const SharedClock* clock) {
  if (options.json) {
    print(facts);
    return;
  }
  print_errors(run.errors());
  if (options.quiet) return;
  print_text(run, end);
  if (clock) std::printf("\n%s\n", clock->state_text().c_str());
}

// `service` may be null.
int run_prepared(const RunOptions& options, Prepared prepared, ServiceNotifier* service) {
  const SharedClock* clock = prepared.clock.get();
  auto played = PlayedPipeline::make(std::move(prepared.pipeline));
  if (!played) return report(played.error(), options.json);
  PipelineRun pipeline(*std::move(played));
  if (clock) clock->apply_to(pipeline.pipeline());
  const RunEnd end = play(options, service, &pipeline);
  Json facts = outcome(pipeline, end);
  if (clock) facts["clock"] = clock->state();
  print_outcome(options, pipeline, end, facts, clock);
  if (prepared.session) {
    const auto verdict = write_report(options, facts, *prepared.session, pipeline.pipeline());
    if (!verdict) {
      std::fprintf(stderr, "%s\n", verdict.error().message().c_str());
      return kExitError;
    }
    if (!options.json && !options.quiet)
      std::printf("\n%s\nReport: %s\n", verdict->c_str(), options.report.c_str());
  }
  return to_exit_status(end);
}

}  // namespace

int run(const RunOptions& options) {
  auto prepared = prepare(options);
  if (!prepared) return report(prepared.error(), options.json);
  return run_prepared(options, *std::move(prepared), nullptr);
}

int run_as_service(const RunOptions& options) {
  auto prepared = prepare(options);
  if (!prepared) return report(prepared.error(), options.json);
  const auto service = ServiceNotifier::open();
  if (!service) return report(service.error(), options.json);
  return run_prepared(options, *std::move(prepared), service->get());
}

}  // namespace weir::app
