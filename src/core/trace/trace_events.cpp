// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/trace/trace_events.hpp"

#include <unistd.h>

#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/trace/spans.hpp"

namespace weir::trace {
namespace {

std::string quoted(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

// Microseconds with all nanosecond digits, independent of the locale.
std::string microseconds(int64_t ns) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%lld.%03d", static_cast<long long>(ns / 1000),
                static_cast<int>(ns % 1000));
  return text.data();
}

class Writer {
 public:
  Writer(const Trace& trace, std::ostream& out) : trace_(trace), out_(out) {
    for (const auto& thread : trace.threads)
      if (!thread.records.empty() && (begin_ == kNoTime || thread.records.front().time < begin_))
        begin_ = thread.records.front().time;
    for (const auto& element : trace.graph.elements()) elements_.push_back(quoted(element.name));
    for (size_t id = 0; id < trace.graph.pads().size(); ++id) pads_.push_back(quoted(pad_name(id)));
  }

  void write() {
    out_ << "{\"displayTimeUnit\":\"ms\",\"traceEvents\":[";
    start() << R"({"name":"process_name","ph":"M","args":{"name":"GStreamer"},"pid":)" << pid_
            << '}';
    for (const auto& thread : trace_.threads) write(thread);
    out_ << "\n]}\n";
  }

 private:
  std::ostream& start() {
    out_ << (first_ ? "\n" : ",\n");
    first_ = false;
    return out_;
  }

  void write(const ThreadRecords& thread) {
    start() << R"({"name":"thread_name","ph":"M","args":{"name":)" << quoted(thread.name)
            << "},\"pid\":" << pid_ << ",\"tid\":" << thread.system_id << '}';
    for_each_span(thread, trace_.graph, [&](const Span& span) { write(span, thread.system_id); });
    for (const Record& record : thread.records)
      if (static_cast<Kind>(record.kind) == Kind::Level) write(record, thread.system_id);
  }

  void write(const Span& span, int64_t thread) {
    constexpr std::array<const char*, 4> kCategories{"push", "pull", "event", "state"};
    const auto* category = kCategories.at(static_cast<size_t>(span.kind) / 2);
    start() << "{\"name\":"
            << (span.element == kNone ? "\"(not linked)\"" : elements_[span.element])
            << ",\"cat\":\"" << category << R"(","ph":"X","ts":)"
            << microseconds(span.begin - begin_)
            << ",\"dur\":" << microseconds(span.end - span.begin) << ",\"pid\":" << pid_
            << ",\"tid\":" << thread << ",\"args\":{";
    if (span.pad != kNone) out_ << "\"from\":" << pads_[span.pad] << ',';
    if (span.kind == Kind::EventBegin || span.kind == Kind::StateBegin) {
      out_ << "\"what\":" << quoted(span.name);
    } else {
      out_ << "\"frames\":" << span.frames << ",\"bytes\":" << span.bytes;
      if (span.time_stamp != kNoTime) out_ << ",\"time_stamp_ns\":" << span.time_stamp;
    }
    out_ << ",\"good\":" << (span.good ? "true" : "false") << "}}";
  }

  void write(const Record& level, int64_t thread) {
    const size_t queue = trace_.graph.element_at(level.object, level.time);
    if (queue == kNone) return;
    start() << "{\"name\":" << elements_[queue] << R"(,"cat":"queue","ph":"C","ts":)"
            << microseconds(level.time - begin_) << ",\"pid\":" << pid_ << ",\"tid\":" << thread
            << ",\"args\":{\"frames\":" << level.value << "}}";
  }

  std::string pad_name(size_t id) const {
    const size_t element = trace_.graph.owner(id);
    const std::string& pad = trace_.graph.pads()[id].name;
    return element == kNone ? pad : trace_.graph.elements()[element].name + "." + pad;
  }

  const Trace& trace_;
  std::ostream& out_;
  const pid_t pid_ = getpid();
  int64_t begin_ = kNoTime;
  std::vector<std::string> elements_, pads_;  // names as JSON
  bool first_ = true;
};

}  // namespace

void write_trace_events(const Trace& trace, std::ostream& out) {
  Writer(trace, out).write();
}

}  // namespace weir::trace
