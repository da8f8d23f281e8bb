// Summary: what the records of a run come to.
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

// Frames and bytes that went one way, refused ones too.
struct Flow {
  uint64_t frames = 0, bytes = 0;
  int64_t first = kNoTime, last = kNoTime;
  void add(uint64_t more_frames, uint64_t more_bytes, int64_t time);
  double rate() const;  // frames after the first per second; 0 where no time passed
};

// Times are in ns and exclusive: what an element spends in the one behind it is that one's. Waiting
// counts too: a sink for the clock, a full queue for room.
struct ElementSummary {
  Flow in, out;
  uint64_t refused = 0;    // frames out that were not taken: an error, a flush, the end
  int64_t work = 0;        // in its chain function, or in giving what is pulled from it
  int64_t longest = 0;     // the most of `work` in one call
  int64_t events = 0;      // handling events: caps, segments, ends
  int64_t states = 0;      // changing its state
  int64_t own_thread = 0;  // between the pushes of a thread that starts here: a source's work, a
                           // queue's waiting
};

struct LinkSummary {
  size_t source_pad = kNone, sink_pad = kNone;
  Flow flow;
};

struct QueueSummary {
  size_t element = kNone;
  QueueLevel level;
  unsigned fullest = 0;        // thousandths of its limits in frames, bytes, time
  uint64_t not_passed_on = 0;  // came and never left: leaked, flushed, or still inside
};

struct LatencySummary {
  size_t source = kNone, sink = kNone;  // elements
  Latency latency;
};

struct Summary {
  int64_t begin = 0, end = 0;  // of the first and the last record
  uint64_t records = 0, lost = 0;
  std::vector<ElementSummary> elements;  // as in the graph
  std::vector<LinkSummary> links;
  std::vector<QueueSummary> queues;
  std::vector<LatencySummary> latencies;
};

Summary summarise(const Trace& trace);

// {"seconds", "records", "lost", "elements": [...], "links", "queues", "latencies", "threads"};
// times in seconds, elements elsewhere by their index. docs/tracing.md has the members.
std::string to_json(const Summary& summary, const Trace& trace);

}  // namespace weir::trace
