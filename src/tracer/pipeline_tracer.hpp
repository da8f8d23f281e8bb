// PipelineTracer: records what GStreamer's tracing hooks report. Data-flow hooks take no lock.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <map>
#include <memory>
#include <mutex>

#include "core/trace/summary.hpp"
#include "tracer/queue_sampler.hpp"

namespace weir::tracer {

class PipelineTracer {
 public:
  // `max_records`: per thread.
  explicit PipelineTracer(size_t max_records) : recorder_(max_records) {}

  // Data flow. Times are in nanoseconds.
  void push_begins(int64_t time, GstPad* pad, GstBuffer* buffer);
  void push_begins(int64_t time, GstPad* pad, GstBufferList* list);
  void push_ends(int64_t time, GstPad* pad, GstFlowReturn result);
  void pull_begins(int64_t time, GstPad* pad);
  void pull_ends(int64_t time, GstPad* pad, GstBuffer* buffer, GstFlowReturn result);
  // Rare events.
  void event_begins(int64_t time, GstPad* pad, GstEvent* event);
  void event_ends(int64_t time, GstPad* pad, bool good);
  void state_begins(int64_t time, GstElement* element, GstStateChange change);
  void state_ends(int64_t time, GstElement* element, bool good);
  void element_is_new(int64_t time, GstElement* element);
  void pad_is_added(int64_t time, GstElement* element, GstPad* pad);
  void pads_are_linked(int64_t time, GstPad* source, GstPad* sink);
  void pads_are_unlinked(int64_t time, GstPad* source, GstPad* sink);
  void element_is_removed(int64_t time, GstElement* element);
  void object_is_destroyed(int64_t time, const void* object);

  // The records so far; may be called while pipelines play.
  trace::Trace trace() const;

 private:
  // Facts about the elements at both ends of a pad's link, cached per thread.
  struct Remembered {
    const void* pad = nullptr;
    uint64_t generation = 0;
    WatchedQueue* own = nullptr;   // set if the pad's element is a queue
    WatchedQueue* peer = nullptr;  // set if the peer's element is a queue
    // Whether to measure the time of the thread: with each push, with the outermost of the thread.
    bool is_timed = false, is_timed_outermost = false;
    bool is_timed_once = true;  // with the first push
  };
  Remembered& remembered(GstPad* pad);
  void begin_push(int64_t time, GstPad* pad, int64_t time_stamp, uint64_t frames, uint64_t bytes);
  Remembered look_up(GstPad* pad, uint64_t generation);
  void see_pad(int64_t time, GstPad* pad, GstElement* element);
  void name_element(int64_t time, GstElement* element);
  void forget_remembered();
  void append(trace::Kind kind, int64_t time, const void* object, int64_t value,
              uint64_t frames = 0, uint64_t bytes = 0);
  void append_named(trace::Kind kind, int64_t time, const void* object, const char* name);

  trace::Recorder recorder_;
  mutable std::mutex mutex_;  // guards graph_ and queues_
  trace::Graph graph_;
  std::map<size_t, std::unique_ptr<WatchedQueue>> queues_;  // by element; never removed
  std::atomic<uint64_t> generation_ = next_generation();    // changes with the graph
  static uint64_t next_generation();
};

}  // namespace weir::tracer
