// Pairs records with a stack for each thread.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/trace/spans.hpp"

#include <algorithm>

namespace weir::trace {
namespace {

struct Open {
  Record record;
  int64_t inside = 0;  // time of the nested spans
  int64_t between = 0;
};

bool is_begin(Kind kind) {
  return kind == Kind::PushBegin || kind == Kind::PullBegin || kind == Kind::EventBegin ||
         kind == Kind::StateBegin;
}

bool ends(const Record& begin, const Record& end) {
  return begin.object == end.object && begin.kind + 1 == end.kind;
}

Span span_of(const Open& open, const Graph& graph, int64_t end) {
  const Record& begin = open.record;
  Span span;
  span.kind = static_cast<Kind>(begin.kind);
  span.begin = begin.time;
  span.end = end;
  span.own = end - begin.time - open.inside;
  span.between = open.between;
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

  void begin(const Record& record) {
    const bool outermost_push =
        open_.empty() && static_cast<Kind>(record.kind) == Kind::PushBegin && last_end_ != kNoTime;
    open_.push_back({record, 0, outermost_push ? record.time - last_end_ : 0});
  }
  // Ends the span that the record belongs to and those within it.
  void end(const Record& record) {
    const auto begin = std::find_if(open_.rbegin(), open_.rend(),
                                    [&](const Open& open) { return ends(open.record, record); });
    if (begin == open_.rend()) return;
    while (!ends(open_.back().record, record)) close(record.time, nullptr);
    close(record.time, &record);
  }
  void end_all(int64_t time) {
    while (!open_.empty()) close(time, nullptr);
  }

 private:
  void close(int64_t time, const Record* end) {
    Span span = span_of(open_.back(), graph_, time);
    span.good = end && end->value == 0;
    if (end && span.kind == Kind::PullBegin) {  // the result of a pull is known at its end
      span.frames = end->frames;
      span.bytes = end->bytes;
    }
    open_.pop_back();
    if (open_.empty())
      last_end_ = time;
    else
      open_.back().inside += span.end - span.begin;
    f_(span);
  }

  const Graph& graph_;
  const std::function<void(const Span&)>& f_;
  std::vector<Open> open_;
  int64_t last_end_ = kNoTime;
};

}  // namespace

void for_each_span(const ThreadRecords& thread, const Graph& graph,
                   const std::function<void(const Span&)>& f) {
  SpanStack stack(graph, f);
  for (const Record& record : thread.records) {
    const auto kind = static_cast<Kind>(record.kind);
    if (kind == Kind::Level) continue;
    if (is_begin(kind))
      stack.begin(record);
    else
      stack.end(record);
  }
  if (!thread.records.empty()) stack.end_all(thread.records.back().time);
}

}  // namespace weir::trace
