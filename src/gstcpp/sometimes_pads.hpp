// SometimesPads: the source pads of an element with one input, each made when it is first needed.
//
// A pad gets a stream-start of its own, its caps and then the input's other sticky events before
// its first buffer; delayed links join it before its caps are chosen. Later events of the input go
// to all pads that have caps.
#pragma once
#include <gst/base/gstflowcombiner.h>
#include <gst/gst.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "core/tensor/frame_spec.hpp"
#include "gstcpp/ref.hpp"

namespace weir::gst {

class SometimesPads {
 public:
  struct Output {
    Ref<GstPad> pad;
    bool started = false;            // its stream began
    std::atomic<bool> open = false;  // it has caps: buffers and events may go there
    bool settled = false;            // the caps are those of the stream as it is now
    bool begun_anew = false;         // a stream-start went there since the caps
    Format format = Format::Static;  // as the pad's caps say
    std::atomic<uint64_t> pushed = 0;
  };

  SometimesPads() : combiner_(gst_flow_combiner_new()) {}
  SometimesPads(const SometimesPads&) = delete;
  SometimesPads& operator=(const SometimesPads&) = delete;

  // Borrowed for as long as this lives. `source_template`: the name of the pads' template.
  void attach(GstElement* element, GstPad* sink, const char* source_template);

  // READY->PAUSED. With `expected` pads made, no-more-pads is told; fewer are no reason to end the
  // stream with NOT_LINKED. 0: not known.
  void start();
  void expect(size_t pads);
  // PAUSED->READY, when nothing streams any more: takes the pads away.
  void clear();
  // The same for an element whose pads stay, with their links: their streams begin again.
  void keep();

  // Streaming thread:
  bool any() const noexcept { return made_ > 0; }
  // src_<index>, made and added to the element if it is not there.
  Output& output(size_t index);
  // New caps came: each pad gets its own with its next buffer.
  void unsettle() noexcept;
  // Gives the pad caps for `spec` by rule A, where it has none or the stream changed or somebody
  // else was linked, and the events that are due. True when the caps are others than before.
  Result<bool> settle(Output* output, const FrameSpec& spec);
  // Whether the element behind src_<index>, where there is one, would take `spec`.
  Status takes(size_t index, const FrameSpec& spec) const;
  // The flow of all pads together after this buffer.
  GstFlowReturn push(Output* output, Ref<GstBuffer> buffer);
  // The same for a pad that is not linked, with no buffer: nobody would see it.
  GstFlowReturn pass_over(Output* output) noexcept;
  static bool is_linked(const Output& output) noexcept {
    return gst_pad_is_linked(output.pad.get());
  }
  // Whether the rest of a frame need not be pushed any more.
  static bool stops(GstFlowReturn flow) noexcept {
    return flow == GST_FLOW_FLUSHING || flow < GST_FLOW_EOS;
  }
  // An event of the sink pad other than CAPS; any thread for those that are not serialised.
  // False: nobody took it.
  bool send(Ref<GstEvent> event);

  // Buffers that left, by pad; any thread.
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
  size_t expected_ = 0, made_ = 0;
  bool told_all_ = false;
  Combiner combiner_;
  mutable std::mutex
      mutex_;  // guards the vector, for other threads; held for no call that may wait
  std::vector<std::unique_ptr<Output>> outputs_;
};

}  // namespace weir::gst
