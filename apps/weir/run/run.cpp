// `weir run PIPELINE`: plays a pipeline, shows progress, and prints the ledger at the end.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <optional>

#include "commands.hpp"
#include "launch/pipeline_text.hpp"
#include "report.hpp"
#include "run/complaints.hpp"
#include "run/ledger_table.hpp"
#include "run/pipeline_run.hpp"
#include "run/report_page.hpp"
#include "run/trace_session.hpp"
#include "weir/join.hpp"

namespace weir::app {
namespace {

// One line on stderr that is overwritten, if stderr is a terminal.
class ProgressLine {
 public:
  void show(const PipelineRun& run) {
    if (!terminal_) return;
    std::fprintf(stderr, "\r\033[K%.1f s  %llu frames  %.1f frames/s", run.seconds(),
                 static_cast<unsigned long long>(run.frames()), run.frame_rate());
    std::fflush(stderr);
    shown_ = true;
  }
  void clear() {
    if (shown_) std::fputs("\r\033[K", stderr);
    shown_ = false;
  }
  void say(const std::string& text) {
    clear();
    std::fprintf(stderr, "%s\n", text.c_str());
  }

 private:
  const bool terminal_ = isatty(STDERR_FILENO) == 1;
  bool shown_ = false;
};

const char* name_of(RunEnd end) {
  switch (end) {
    case RunEnd::Eos:
      return "eos";
    case RunEnd::Error:
      return "error";
    case RunEnd::Interrupted:
      return "interrupted";
  }
  return "";
}

int status_of(RunEnd end) {
  if (end == RunEnd::Eos) return kExitGood;
  return end == RunEnd::Error ? kExitError : kExitInterrupted;
}

Json to_json(const std::vector<Complaint>& complaints) {
  Json out = Json::array();
  for (const auto& complaint : complaints) {
    Json item{{"element", complaint.element}, {"what", complaint.what}};
    const auto add = [&item](const char* name, const std::string& text) {
      if (!text.empty()) item[name] = text;
    };
    add("id", complaint.id);
    add("offered", complaint.offered);
    add("needed", complaint.needed);
    add("difference", complaint.difference);
    add("fix", complaint.fix);
    add("debug", complaint.debug);
    out.push_back(std::move(item));
  }
  return out;
}

void print_text(const PipelineRun& run, RunEnd end) {
  print_complaints(run);
  std::printf("%s after %.3f s: %llu frames, %.1f frames/s\n",
              end == RunEnd::Eos     ? "Ended"
              : end == RunEnd::Error ? "Failed"
                                     : "Interrupted",
              run.seconds(), static_cast<unsigned long long>(run.frames()), run.frame_rate());
  const auto sinks = run.sinks();
  if (sinks.size() > 1)
    for (const auto& [name, frames] : sinks)
      std::printf("  %s: %llu frames\n", name.c_str(), static_cast<unsigned long long>(frames));
  const std::string ledger = ledger_table(ledgers(run.pipeline()));
  if (!ledger.empty()) std::printf("\nLedger\n%s", ledger.c_str());
}

Json outcome(const PipelineRun& run, RunEnd end) {
  Json out{{"result", name_of(end)},
           {"frames", run.frames()},
           {"seconds", run.seconds()},
           {"frame_rate", run.frame_rate()}};
  out["sinks"] = Json::array();
  for (const auto& [name, frames] : run.sinks())
    out["sinks"].push_back({{"name", name}, {"frames", frames}});
  out["ledger"] = ledgers(run.pipeline());
  out["errors"] = to_json(run.errors());
  out["warnings"] = to_json(run.warnings());
  return out;
}

Status cannot_write(const std::string& file) {
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
  return cannot_write(file);
}

Status write_report(const RunOptions& options, const Json& outcome, const TraceSession& session) {
  const std::string pipeline = join(options.pipeline, " ");
  std::ofstream file(options.report);
  file << report_page(outcome, session.summary(), pipeline);
  file.close();
  return file ? ok() : cannot_write(options.report);
}

}  // namespace

int run(const RunOptions& options) {
  std::optional<TraceSession> session;
  if (!options.report.empty()) {  // before elements are created
    auto started = TraceSession::start();
    if (!started) return report(started.error(), options.json);
    session = *std::move(started);
  }
  auto read = read_pipeline(options.pipeline);
  if (!read) return report(read.error(), options.json);
  if (session) {
    const Status writable = try_to_write(options.report);
    if (!writable) return report(writable.error(), options.json);
  }
  PipelineRun pipeline(*std::move(read));
  ProgressLine line;
  const RunEnd end = pipeline.play([&line](const PipelineRun& run) { line.show(run); },
                                   [&line](const std::string& text) { line.say(text); });
  line.clear();
  const Json facts = outcome(pipeline, end);
  if (options.json)
    print(facts);
  else
    print_text(pipeline, end);
  if (session) {
    const Status written = write_report(options, facts, *session);
    if (!written) {
      std::fprintf(stderr, "%s\n", written.error().message().c_str());
      return kExitError;
    }
    if (!options.json) std::printf("\nReport: %s\n", options.report.c_str());
  }
  return status_of(end);
}

}  // namespace weir::app
