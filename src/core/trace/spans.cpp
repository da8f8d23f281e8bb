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

}  // namespace

void for_each_span(const ThreadRecords& thread, const Graph& graph,
                   const std::function<void(const Span&)>& f) {
  std::vector<Open> stack;
  int64_t last_end = kNoTime;
  const auto close = [&](int64_t time, const Record* end) {
    Span span = span_of(stack.back(), graph, time);
    span.good = end && end->value == 0;
    if (end && span.kind == Kind::PullBegin) {  // the result of a pull is known at its end
      span.frames = end->frames;
      span.bytes = end->bytes;
    }
    stack.pop_back();
    if (stack.empty())
      last_end = time;
    else
      stack.back().inside += span.end - span.begin;
    f(span);
  };
  for (const Record& record : thread.records) {
    const auto kind = static_cast<Kind>(record.kind);
    if (kind == Kind::Level) continue;
    if (is_begin(kind)) {
      const bool outermost_push = stack.empty() && kind == Kind::PushBegin && last_end != kNoTime;
      stack.push_back({record, 0, outermost_push ? record.time - last_end : 0});
      continue;
    }
    const auto begin = std::find_if(stack.rbegin(), stack.rend(),
                                    [&](const Open& open) { return ends(open.record, record); });
    if (begin == stack.rend()) continue;
    while (!ends(stack.back().record, record)) close(record.time, nullptr);
    close(record.time, &record);
  }
  while (!stack.empty()) close(thread.records.back().time, nullptr);
}

}  // namespace weir::trace
