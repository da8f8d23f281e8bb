// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/trace/spans.hpp"

#include <algorithm>
#include <utility>

namespace weir::trace {
namespace {

struct Open {
  Record record;
  int64_t inside = 0;  // time of the nested spans
  int64_t between = 0, between_idle = 0;
  int64_t thread_time = kNoTime;  // at the begin
  int64_t inside_thread_time = 0;
};

bool is_begin(Kind kind) {
  return kind == Kind::PushBegin || kind == Kind::PullBegin || kind == Kind::EventBegin ||
         kind == Kind::StateBegin;
}

bool ends(const Record& begin, const Record& end) {
  return begin.object == end.object && begin.kind + 1 == end.kind;
}

Span make_span(const Open& open, const Graph& graph, int64_t end) {
  const Record& begin = open.record;
  Span span;
  span.kind = static_cast<Kind>(begin.kind);
  span.begin = begin.time;
  span.end = end;
  span.own = end - begin.time - open.inside;
  span.between = open.between;
  span.between_idle = open.between_idle;
  span.frames = begin.frames;
  span.bytes = begin.bytes;
  if (span.kind == Kind::StateBegin) {
    span.element = graph.element_at(begin.object, begin.time);
  } else {
    span.pad = graph.pad_at(begin.object, begin.time);
    span.element = graph.owner(graph.peer_at(span.pad, begin.time));
  }
  if (span.kind == Kind::StateBegin || span.kind == Kind::EventBegin)
    span.name = begin.name;
  else
    span.time_stamp = begin.value;
  return span;
}

class SpanStack {
 public:
  SpanStack(const Graph& graph, const std::function<void(const Span&)>& f) : graph_(graph), f_(f) {}

  // Comes before the begin or end that it belongs to.
  void set_thread_time(int64_t time) { thread_time_ = time; }

  void begin(const Record& record) {
    Open open{.record = record, .thread_time = take_thread_time()};
    const bool outermost_push =
        open_.empty() && static_cast<Kind>(record.kind) == Kind::PushBegin && last_end_ != kNoTime;
    if (outermost_push) {
      open.between = record.time - last_end_;
      if (open.thread_time != kNoTime && last_thread_time_ != kNoTime)
        open.between_idle = idle(open.between, open.thread_time - last_thread_time_);
    }
    open_.push_back(open);
  }
  // Ends the span that the record belongs to and those within it.
  void end(const Record& record) {
    const auto begin = std::find_if(open_.rbegin(), open_.rend(),
                                    [&](const Open& open) { return ends(open.record, record); });
    const int64_t thread_time = take_thread_time();
    if (begin == open_.rend()) return;
    while (!ends(open_.back().record, record)) close(record.time, nullptr);
    close(record.time, &record, thread_time);
  }
  void end_all(int64_t time) {
    while (!open_.empty()) close(time, nullptr);
  }

 private:
  static int64_t idle(int64_t time, int64_t thread_time) {
    return std::clamp<int64_t>(time - thread_time, 0, time);
  }
  int64_t take_thread_time() { return std::exchange(thread_time_, kNoTime); }

  void close(int64_t time, const Record* end, int64_t thread_time = kNoTime) {
    const Open open = open_.back();
    Span span = make_span(open, graph_, time);
    span.good = end && end->value == 0;
    if (end && span.kind == Kind::PullBegin) {  // the result of a pull is known at its end
      span.frames = end->frames;
      span.bytes = end->bytes;
    }
    int64_t ran = open.inside_thread_time;
    if (open.thread_time != kNoTime && thread_time != kNoTime) {
      span.own_idle = idle(span.own, thread_time - open.thread_time - ran);
      ran = thread_time - open.thread_time;
    }
    open_.pop_back();
    if (open_.empty()) {
      last_end_ = time;
      last_thread_time_ = thread_time;
    } else {
      open_.back().inside += span.end - span.begin;
      open_.back().inside_thread_time += ran;
    }
    f_(span);
  }

  const Graph& graph_;
  const std::function<void(const Span&)>& f_;
  std::vector<Open> open_;
  int64_t last_end_ = kNoTime, last_thread_time_ = kNoTime;
  int64_t thread_time_ = kNoTime;
};

}  // namespace

void for_each_span(const ThreadRecords& thread, const Graph& graph,
                   const std::function<void(const Span&)>& f) {
  SpanStack stack(graph, f);
  for (const Record& record : thread.records) {
    const auto kind = static_cast<Kind>(record.kind);
    if (kind == Kind::Level) continue;
    if (kind == Kind::ThreadTime)
      stack.set_thread_time(record.value);
    else if (is_begin(kind))
      stack.begin(record);
    else
      stack.end(record);
  }
  if (!thread.records.empty()) stack.end_all(thread.records.back().time);
}

}  // namespace weir::trace
