// CollectorPads: the pads of an element with many inputs and one output, on a sync::Collector.
//
// A buffer is handled on the thread that brings it, see core/sync/collector.hpp. The output has its
// own stream-start, caps and segment; SEEK is rejected. The caps of each input are kept with its
// frames, so that caps may change while earlier frames are still in use.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

#include "core/sync/collector.hpp"
#include "core/tensor/frame_spec.hpp"
#include "gstcpp/element/ref.hpp"
#include "gstcpp/pads/early_events.hpp"

namespace weir::gst {

struct Input {
  Ref<GstBuffer> buffer;
  std::shared_ptr<const FrameSpec> spec;  // fixed, valid
  std::optional<uint64_t> running_time;
};
using Inputs = sync::Emission<Input>;  // one frame per pad

// Combines inputs to one output. Called on streaming threads, one call at a time.
struct Combiner {
  virtual ~Combiner() = default;
  // The output spec for these inputs; rule A of docs/compatibility/types-and-caps.md 1.5 chooses
  // its caps.
  virtual Result<FrameSpec> combine_specs(const std::vector<const FrameSpec*>& inputs) = 0;
  // Called when caps were chosen; `output` includes the format.
  virtual Status configure(const FrameSpec& output) = 0;
  // Returns a buffer complete except for its PTS. Null: nothing to push; a GAP event is sent
  // downstream.
  virtual Result<Ref<GstBuffer>> combine(const Inputs& inputs) = 0;
  // Whether combine() also sets the PTS, from one of the inputs.
  virtual bool gives_time() const { return false; }
};

class CollectorPads final : private sync::Consumer<Input> {
 public:
  // All arguments must outlive it; sets the functions of `source`, a pad of `element`.
  CollectorPads(GstElement* element, GstPad* source, Ledger* ledger, Combiner* combiner);
  ~CollectorPads() override;

  // Adds a pad, in the order of requests. `wanted` (may be null) is its name; null is returned if
  // that name is taken.
  GstPad* request(GstPadTemplate* pad_template, const char* wanted);
  // Pushes no buffer and no EOS itself, so it returns even while downstream blocks.
  void release(GstPad* pad);
  // Makes a permanent pad of the element one of the inputs.
  void attach(GstPad* pad);

  void configure(const sync::Options& options, OnBackwardsTime backwards, uint64_t max_wait_ns,
                 uint64_t max_bytes);
  // Call before READY->PAUSED. GRAPH_STALLS when a pad waits for this element's own output; the
  // order in which a bin starts such a loop is undefined, so the loop may also stall without an
  // error.
  Status start();
  void stop();  // call before PAUSED->READY: wakes every thread
  // Call after PAUSED->READY: clears the inputs' caps and segments for the next streams.
  void forget_streams();
  void add_stats(GstStructure* stats) const;
  GstPad* source() const noexcept { return source_; }

 private:
  struct Pad {
    CollectorPads* owner;
    GstPad* pad;
    sync::QueueId queue;
    std::shared_ptr<const FrameSpec> spec;  // streaming thread
    GstSegment segment;                     // streaming thread
    sync::Stamp last_time;                  // streaming thread
    std::atomic<GThread*> fed_by{nullptr};  // thread that last sent data since start or flush
  };

  int emit(Inputs inputs) override;
  void end() override;
  void refused(const Error& error) override;
  Status may_wait(sync::QueueId waiting, const std::vector<sync::QueueId>& empty) override;
  void waits_for_gap_only_pads(sync::QueueId waiting,
                               const std::vector<sync::QueueId>& gaps) override;
  bool waits_for_silent_pads(sync::QueueId waiting,
                             const std::vector<sync::QueueId>& silent) override;
  struct WaitNames {
    std::string waiting, others;  // pads; empty: removed meanwhile
  };
  WaitNames wait_names(sync::QueueId waiting, const std::vector<sync::QueueId>& others);

  GstFlowReturn chain(Pad& pad, Ref<GstBuffer> buffer);
  void watch_time(Pad& pad, const sync::Stamp& time);
  gboolean sink_event(Pad& pad, Ref<GstEvent> event);
  gboolean caps(Pad& pad, GstEvent* event);
  gboolean pass_on(Pad& pad, Ref<GstEvent> event);
  bool send_flush(Ref<GstEvent> event);
  void proceed_later();
  gboolean latency(GstQuery* query);
  void begin_stream();
  // `time` is the PTS of the first output; its running time matches that of the input.
  void begin_segment(uint64_t start, uint64_t time, std::optional<uint64_t> running_time);
  void push_gap(const Inputs& inputs);
  // Leaves specs_ empty if the output flushes.
  Status negotiate(const Inputs& inputs);
  Pad* find_pad(sync::QueueId queue);
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
  unsigned counter_ = 0;  // pads made so far
  EarlyEvents pending_;   // sticky events until the stream starts

  // Used only by the thread that makes an output.
  std::vector<std::shared_ptr<const FrameSpec>> specs_;  // the combiner is configured for them
  std::atomic<bool> begun_{false}, segment_due_{true};
  std::atomic<bool> time_reported_{false};
};

}  // namespace weir::gst
