// OutputQueue: what leaves tensor_filter, buffers and serialized events, in the order of the
// stream.
#pragma once
#include <gst/gst.h>

#include <atomic>
#include <variant>

#include "core/infer/completion_queue.hpp"
#include "core/ledger/ledger.hpp"
#include "gstcpp/ref.hpp"

namespace weir {

class OutputQueue {
  // Work that failed or whose frame was dropped leaves std::monostate: its place is passed over.
  using Entry = std::variant<std::monostate, gst::Ref<GstBuffer>, gst::Ref<GstEvent>>;
  using Queue = infer::CompletionQueue<Entry>;

 public:
  // `ledger` is borrowed; `depth`: frames in work at a time.
  OutputQueue(Ledger* ledger, size_t depth) : ledger_(ledger), queue_(depth) {}
  void set_pad(GstPad* source) noexcept { source_ = source; }

  using Ticket = Queue::Ticket;
  // A place for a frame that begins now; nullopt while flushing.
  std::optional<Ticket> submit() { return queue_.submit(); }
  // Ends a frame: its output, in the ledger consumed and pushed. Returns the flow of the source
  // pad.
  GstFlowReturn finish(const Ticket& ticket, gst::Ref<GstBuffer> output);
  // Ends a frame that gives no output. The caller has entered it in the ledger.
  void skip(const Ticket& ticket);
  // A serialized event in its place. Returns what the source pad answered.
  bool send(gst::Ref<GstEvent> event);

  void flush();
  void resume();

 private:
  void push_finished();
  void push(Entry entry) noexcept;

  Ledger* ledger_;
  GstPad* source_ = nullptr;  // borrowed from the element
  Queue queue_;
  std::atomic<GstFlowReturn> flow_{GST_FLOW_OK};
  std::atomic<bool> event_taken_{true};
};

}  // namespace weir
