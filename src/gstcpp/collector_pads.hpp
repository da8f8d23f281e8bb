// CollectorPads: the pads of an element of many inputs and one output, on a sync::Collector.
//
// A buffer is handled on the thread that brings it, see core/sync/collector.hpp. Stream-start, caps
// and segment of the output are its own; SEEK is refused; what each input's caps were goes with its
// frames, so that caps may change while a frame from before is still in use.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

#include "core/sync/collector.hpp"
#include "core/tensor/frame_spec.hpp"
#include "gstcpp/early_events.hpp"
#include "gstcpp/ref.hpp"

namespace weir::gst {

struct Input {
  Ref<GstBuffer> buffer;
  std::shared_ptr<const FrameSpec> spec;  // fixed, valid
  std::optional<uint64_t> running_time;
};
using Inputs = sync::Emission<Input>;  // one of each pad

// What the element makes of it. Called on streaming threads, one call at a time.
struct Combiner {
  virtual ~Combiner() = default;
  // The output for these inputs; its caps are chosen by rule A of the specification, 1.5.
  virtual Result<FrameSpec> combine_specs(const std::vector<const FrameSpec*>& inputs) = 0;
  // Caps were chosen: format and all.
  virtual Status configure(const FrameSpec& output) = 0;
  // A buffer with everything but its PTS. Null: nothing to push; who is behind gets a GAP.
  virtual Result<Ref<GstBuffer>> combine(const Inputs& inputs) = 0;
  // Whether combine() gives the PTS too, as one of the inputs has it.
  virtual bool gives_time() const { return false; }
};

class CollectorPads final : private sync::Consumer<Input> {
 public:
  // All must outlive it; `source` is a pad of `element`, which gets its functions here.
  CollectorPads(GstElement* element, GstPad* source, Ledger* ledger, Combiner* combiner);
  ~CollectorPads() override;

  // A new pad, in the order of requests; `wanted` (may be null) is its name if that is free. Null
  // when it is not.
  GstPad* request(GstPadTemplate* pad_template, const char* wanted);
  // Pushes no buffer and no EOS itself: returns also while downstream blocks.
  void release(GstPad* pad);
  // Makes a pad that the element owns for its life one of the inputs.
  void attach(GstPad* pad);

  void configure(const sync::Options& options, OnBackwardsTime backwards, uint64_t max_wait_ns,
                 uint64_t max_bytes);
  // Before READY becomes PAUSED. GRAPH_STALLS when a pad waits for this element: the order in
  // which a bin starts such a loop is open, so that it may stop without a word.
  Status start();
  void stop();  // before PAUSED becomes READY: wakes every thread
  // After PAUSED became READY: caps and segments of the inputs are not those of the next streams.
  void forget_streams();
  void add_stats(GstStructure* stats) const;
  GstPad* source() const noexcept { return source_; }

 private:
  struct Pad {
    CollectorPads* owner;
    GstPad* pad;
    sync::LaneId lane;
    std::shared_ptr<const FrameSpec> spec;  // streaming thread
    GstSegment segment;                     // streaming thread
    sync::Stamp last_time;                  // streaming thread
    std::atomic<GThread*> fed_by{nullptr};  // the last to bring something since start or flush
  };

  int emit(Inputs inputs) override;
  void end() override;
  void refused(const Error& error) override;
  Status may_wait(sync::LaneId waiting, const std::vector<sync::LaneId>& empty) override;
  void waits_behind_gaps(sync::LaneId waiting, const std::vector<sync::LaneId>& gaps) override;

  GstFlowReturn chain(Pad& pad, Ref<GstBuffer> buffer);
  void watch_time(Pad& pad, const sync::Stamp& time);
  gboolean sink_event(Pad& pad, Ref<GstEvent> event);
  gboolean caps(Pad& pad, GstEvent* event);
  gboolean pass_on(Pad& pad, Ref<GstEvent> event);
  bool send_flush(Ref<GstEvent> event);
  void proceed_later();
  gboolean latency(GstQuery* query);
  void begin_stream();
  // `time` of the first output; its running time follows that of the input.
  void begin_segment(uint64_t start, uint64_t time, std::optional<uint64_t> running_time);
  void push_gap(const Inputs& inputs);
  Status negotiate(const Inputs& inputs);
  Result<Ref<GstBuffer>> made_of(const Inputs& inputs);
  Pad* pad_of(sync::LaneId lane);
  std::vector<Ref<GstPad>> sink_pads();

  static GstFlowReturn on_chain(GstPad*, GstObject*, GstBuffer*);
  static gboolean on_sink_event(GstPad*, GstObject*, GstEvent*);
  static gboolean on_sink_query(GstPad*, GstObject*, GstQuery*);
  static gboolean on_activate(GstPad*, GstObject*, GstPadMode, gboolean);
  static gboolean on_source_event(GstPad*, GstObject*, GstEvent*);
  static gboolean on_source_query(GstPad*, GstObject*, GstQuery*);

  GstElement* const element_;
  GstPad* const source_;
  Ledger* const ledger_;
  Combiner* const combiner_;
  sync::Collector<Input> collector_;
  std::atomic<uint64_t> max_wait_{0};  // nanoseconds
  std::atomic<OnBackwardsTime> backwards_{OnBackwardsTime::Pass};

  std::mutex pads_mutex_;  // guards pads_, counter_, pending_
  std::vector<std::shared_ptr<Pad>> pads_;
  unsigned counter_ = 0;  // of pads since the element was made
  EarlyEvents pending_;   // sticky, until the stream begins

  // Of the thread that makes an output.
  std::vector<std::shared_ptr<const FrameSpec>> specs_;  // the caps on the source pad stand for
  std::atomic<bool> begun_{false}, segment_due_{true};
  std::atomic<bool> told_of_time_{false};
};

}  // namespace weir::gst
