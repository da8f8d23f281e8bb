// SometimesPads: the source pads of an element with one input, each made on first use.
//
// Before its first buffer a pad gets its own stream-start, its caps and then the input's other
// sticky events; delayed links connect before its caps are chosen. Later events of the input are
// sent to all pads with caps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/base/gstflowcombiner.h>
#include <gst/gst.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "core/tensor/frame_spec.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::gst {

class SometimesPads {
 public:
  struct Output {
    Ref<GstPad> pad;
    bool started = false;            // stream-start was sent
    std::atomic<bool> open = false;  // has caps: buffers and events may be sent
    bool settled = false;            // the caps match the current stream
    bool begun_again = false;        // a new stream-start was sent since the caps
    Format format = Format::Static;  // from the pad's caps
    std::atomic<uint64_t> pushed = 0;
  };

  SometimesPads() : combiner_(gst_flow_combiner_new()) {}
  SometimesPads(const SometimesPads&) = delete;
  SometimesPads& operator=(const SometimesPads&) = delete;

  // Borrows both until destruction. `source_template`: the name of the pads' template.
  // `passes_tensors`: frames are pushed as they are; the pads get the input's model event, too.
  void attach(GstElement* element, GstPad* sink, const char* source_template, bool passes_tensors);

  // READY->PAUSED. Once `expected` pads exist, no-more-pads is emitted; fewer pads do not end the
  // stream with NOT_LINKED. 0: unknown.
  void start();
  void expect(size_t pads);
  // PAUSED->READY, after streaming has stopped: removes the pads.
  void clear();
  // The same for an element that keeps its pads and links: their streams start again.
  void keep();

  // Streaming thread:
  bool any() const noexcept { return made_ > 0; }
  // Returns src_<index>; makes it and adds it to the element if necessary.
  Output& output(size_t index);
  // New caps arrived: each pad gets its own caps with its next buffer.
  void unsettle() noexcept;
  // Sends the pad caps for `spec` by rule A, if it has none, the stream changed or its peer
  // changed, and then the pending events. True when the caps changed.
  Result<bool> settle(Output* output, const FrameSpec& spec);
  // Whether the peer of src_<index>, if any, accepts `spec`.
  Status takes(size_t index, const FrameSpec& spec) const;
  // Returns the combined flow of all pads after this buffer.
  GstFlowReturn push(Output* output, Ref<GstBuffer> buffer);
  // The same without a buffer, for a pad that is not linked.
  GstFlowReturn pass_over(Output* output) noexcept;
  static bool is_linked(const Output& output) noexcept {
    return gst_pad_is_linked(output.pad.get());
  }
  // Whether the rest of a frame need not be pushed.
  static bool stops(GstFlowReturn flow) noexcept {
    return flow == GST_FLOW_FLUSHING || flow < GST_FLOW_EOS;
  }
  // Forwards an event of the sink pad other than CAPS; non-serialized events from any thread. False
  // when no pad handled it.
  bool send(const Ref<GstEvent>& event);

  // The number of pushed buffers by pad; any thread.
  void add_stats(GstStructure* stats) const;

 private:
  using Combiner = Unique<GstFlowCombiner, gst_flow_combiner_free>;
  void make(size_t index);
  void begin(Output* output);
  Ref<GstEvent> stream_start(GstPad* pad, GstEvent* upstream) const;
  void send_sticky_events(GstPad* pad) const;
  GstFlowReturn combined(GstFlowReturn flow) const noexcept;

  GstElement* element_ = nullptr;
  GstPad* sink_ = nullptr;
  GstPadTemplate* template_ = nullptr;
  bool passes_tensors_ = false;
  size_t expected_ = 0, made_ = 0;
  bool reported_all_ = false;
  Combiner combiner_;
  mutable std::mutex mutex_;  // guards the vector; never held across a call that may wait
  std::vector<std::unique_ptr<Output>> outputs_;
};

}  // namespace weir::gst
