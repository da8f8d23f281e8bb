// Summary: the totals of a recorded run.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "core/trace/graph.hpp"
#include "core/trace/latency.hpp"
#include "core/trace/queue_level.hpp"
#include "core/trace/recorder.hpp"

namespace weir::trace {

struct Trace {
  Graph graph;
  std::vector<ThreadRecords> threads;
};

// Frames and bytes in one direction, including rejected ones.
struct Flow {
  uint64_t frames = 0, bytes = 0;
  int64_t first = kNoTime, last = kNoTime;
  void add(uint64_t more_frames, uint64_t more_bytes, int64_t time);
  double rate() const;  // frames per second, without the first one; 0 if no time passed
};

// Times are in ns and exclusive: time in a downstream element belongs to that element.
struct ElementSummary {
  Flow in, out;
  uint64_t refused = 0;  // output frames that were not accepted: an error, a flush, the end
  int64_t work = 0;      // in its chain function, or providing what is pulled from it
  int64_t waiting = 0;   // there too, but waiting: see Waits
  int64_t longest = 0;   // the longest call of the two
  int64_t events = 0;    // handling events: caps, segments, ends
  int64_t states = 0;    // state changes
  // Between the pushes of a thread that starts here: a source that makes a frame, a demuxer.
  int64_t thread_work = 0;
  int64_t thread_waiting = 0;  // for a frame, the clock, a device, other threads
};

struct LinkSummary {
  size_t source_pad = kNone, sink_pad = kNone;
  Flow flow;
};

struct QueueSummary {
  size_t element = kNone;
  QueueLevel level;
  unsigned fullest = 0;        // thousandths of its limits in frames, bytes, time
  uint64_t not_passed_on = 0;  // arrived but never left: leaked, flushed, or still inside
};

struct Summary {
  int64_t begin = 0, end = 0;                        // times of the first and the last record
  int64_t flow_begin = kNoTime, flow_end = kNoTime;  // of the first and the last push or pull
  uint64_t records = 0, lost = 0;
  std::vector<ElementSummary> elements;  // in the order of the graph
  std::vector<LinkSummary> links;
  std::vector<QueueSummary> queues;
  std::vector<StreamLatency> latencies;
};

Summary summarise(const Trace& trace);

// {"seconds", "records", "lost", "elements": [...], "links", "queues", "latencies", "threads"};
// times are in seconds, and other parts refer to elements by index. docs/tracing.md lists the
// members.
std::string to_json(const Summary& summary, const Trace& trace);

}  // namespace weir::trace
