// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/trace/summary.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "core/trace/spans.hpp"

namespace weir::trace {

void Flow::add(uint64_t more_frames, uint64_t more_bytes, int64_t time) {
  frames += more_frames;
  bytes += more_bytes;
  first = first == kNoTime ? time : std::min(first, time);
  last = std::max(last, time);
}

double Flow::rate() const {
  if (frames < 2 || last <= first) return 0;
  return static_cast<double>(frames - 1) * 1e9 / static_cast<double>(last - first);
}

namespace {

class Summing {
 public:
  explicit Summing(const Trace& trace) : trace_(trace), graph_(trace.graph) {
    const size_t count = graph_.elements().size();
    out_.elements.resize(count);
    for (size_t id = 0; id < count; ++id) {
      const bool inner = graph_.elements()[id].is_bin;
      ends_.push_back(!inner && !graph_.has_pads(id, true));
    }
  }
  Summary run() {
    for (const ThreadRecords& thread : trace_.threads) add_levels(thread);
    for (const ThreadRecords& thread : trace_.threads)
      for_each_span(thread, graph_, [this](const Span& span) { add(span); });
    add_links();
    add_queues();
    add_latencies();
    return std::move(out_);
  }

 private:
  void add_levels(const ThreadRecords& thread) {
    out_.records += thread.records.size();
    out_.lost += thread.lost;
    if (thread.records.empty()) return;
    const int64_t first = thread.records.front().time;
    out_.begin = out_.end == 0 ? first : std::min(out_.begin, first);
    out_.end = std::max(out_.end, thread.records.back().time);
    for (const Record& record : thread.records) {
      if (static_cast<Kind>(record.kind) != Kind::Level) continue;
      const size_t queue = graph_.element_at(record.object, record.time);
      if (queue == kNone) continue;
      changes_[queue].push_back({record.time, record.value, true});
      fullest_[queue] = std::max(fullest_[queue], static_cast<unsigned>(record.frames));
    }
  }

  void add(const Span& span) {
    if (span.kind == Kind::PushBegin || span.kind == Kind::PullBegin) {
      out_.flow_begin =
          out_.flow_begin == kNoTime ? span.begin : std::min(out_.flow_begin, span.begin);
      out_.flow_end = std::max(out_.flow_end, span.end);
    }
    if (span.element != kNone) add_time(span, out_.elements[span.element]);
    if (span.kind == Kind::PushBegin)
      add_frames(span, graph_.owner(span.pad), span.element, span.pad);
    if (span.kind == Kind::PullBegin && span.good)
      add_frames(span, span.element, graph_.owner(span.pad), graph_.peer_at(span.pad, span.begin));
    if (span.kind == Kind::PushBegin) add_between(span);
  }

  void add_time(const Span& span, ElementSummary& element) {
    if (span.kind == Kind::EventBegin) {
      element.events += span.own;
    } else if (span.kind == Kind::StateBegin) {
      element.states += span.own;
    } else {
      const int64_t waiting = waiting_in(span);
      element.waiting += waiting;
      element.work += span.own - waiting;
      element.longest = std::max(element.longest, span.own);
    }
  }

  int64_t waiting_in(const Span& span) {
    // With its first frame any element may wait for others: to be linked, or for a response to a
    // query.
    const bool is_first = started_.insert(span.pad).second;
    const Waits waits = graph_.elements()[span.element].waits;
    if (waits == Waits::Room) return span.own;
    return waits != Waits::Never || is_first ? span.own_idle : 0;
  }

  void add_between(const Span& span) {
    const size_t from = graph_.owner(span.pad);
    if (from == kNone) return;
    const int64_t waiting =
        graph_.elements()[from].waits == Waits::Room ? span.between : span.between_idle;
    out_.elements[from].thread_waiting += waiting;
    out_.elements[from].thread_work += span.between - waiting;
  }

  void add_frames(const Span& span, size_t from, size_t to, size_t source_pad) {
    const auto frames = static_cast<int64_t>(span.frames);
    if (from != kNone) {
      out_.elements[from].out.add(span.frames, span.bytes, span.begin);
      if (!span.good) out_.elements[from].refused += span.frames;
      if (changes_.contains(from)) passed_[from].push_back({span.begin, -frames, false});
    }
    if (to != kNone) {
      out_.elements[to].in.add(span.frames, span.bytes, span.begin);
      if (span.good && changes_.contains(to)) passed_[to].push_back({span.end, frames, false});
      if (ends_[to]) stamped_.arrivals[to].push_back({span.time_stamp, span.begin});
    }
    const size_t sink_pad = graph_.end_at(source_pad, span.begin);
    if (sink_pad == kNone) return;
    flows_[{source_pad, sink_pad}].add(span.frames, span.bytes, span.begin);
    if (span.time_stamp != kNoTime)
      stamped_.departures[source_pad].push_back({span.time_stamp, span.begin});
  }

  // Links that bins make while they look for what fits, and undo before a frame, are left out.
  void add_links() {
    for (const Edge& edge : graph_.edges()) {
      const Flow& flow = flows_[{edge.source, edge.sink}];
      if (edge.lasts || flow.frames > 0) out_.links.push_back({edge.source, edge.sink, flow});
    }
  }

  void add_queues() {
    for (auto& [queue, samples] : changes_) {
      const auto& passed = passed_[queue];
      int64_t rest = 0;
      for (const QueueChange& change : passed) rest += change.frames;
      samples.insert(samples.end(), passed.begin(), passed.end());
      out_.queues.push_back({queue, queue_level(std::move(samples), out_.end), fullest_[queue],
                             static_cast<uint64_t>(std::max<int64_t>(rest, 0))});
    }
  }

  void add_latencies() {
    std::vector<std::pair<size_t, size_t>> links;
    for (const LinkSummary& link : out_.links) links.emplace_back(link.source_pad, link.sink_pad);
    out_.latencies = stream_latencies(graph_, links, std::move(stamped_));
  }

  const Trace& trace_;
  const Graph& graph_;
  Summary out_;
  std::vector<bool> ends_;  // elements without source pads, except bins
  std::map<size_t, std::vector<QueueChange>> changes_, passed_;  // by element
  std::map<size_t, unsigned> fullest_;
  StreamRecords stamped_;
  std::set<size_t> started_;                         // pads that have pushed
  std::map<std::pair<size_t, size_t>, Flow> flows_;  // by source pad and sink pad
};

}  // namespace

Summary summarise(const Trace& trace) {
  return Summing(trace).run();
}

}  // namespace weir::trace
