// OutputQueue: what leaves tensor_filter, buffers and serialized events, in the order of the
// stream. Frames may be ended on any thread.
#pragma once
#include <gst/gst.h>

#include <atomic>
#include <memory>
#include <variant>

#include "core/infer/completion_queue.hpp"
#include "core/infer/held_bytes.hpp"
#include "core/ledger/ledger.hpp"
#include "gstcpp/push_task.hpp"
#include "gstcpp/ref.hpp"

namespace weir {

class OutputQueue {
  struct Part {  // one of a frame's outputs
    gst::Ref<GstBuffer> buffer;
    uint64_t bytes;
  };
  struct Ended {};  // behind the last of them
  using Entry = std::variant<gst::Ref<GstBuffer>, gst::Ref<GstEvent>, Part, Ended>;
  using Queue = infer::CompletionQueue<Entry>;

 public:
  // `ledger` is borrowed.
  explicit OutputQueue(Ledger* ledger) : ledger_(ledger), queue_(1) {}
  void set_pad(GstPad* source);
  // Frames between their submission and their push, at a time; 1 at first. While no pad is active.
  void set_depth(size_t depth) { queue_.set_depth(depth); }

  // With a task the source pad's own thread pushes, so that whoever ends a frame does not wait for
  // the elements behind; else whoever ends the oldest pushes. Before the pads are activated.
  // `held` counts the bytes of what add() is given, until it has been pushed.
  void open(bool with_task, std::shared_ptr<infer::HeldBytes> held);
  // Before the pads are deactivated, and after.
  void stop() { task_.close(); }
  void close() { task_.join(); }

  using Ticket = Queue::Ticket;
  // A place for a frame that begins now; waits for it. nullopt while flushing.
  std::optional<Ticket> submit() { return queue_.submit(); }
  // The same without waiting: nullopt also when there is no room.
  std::optional<Ticket> try_submit() { return queue_.try_submit(); }
  // Ends a frame: its output, in the ledger consumed and pushed. Returns the flow of the source
  // pad.
  GstFlowReturn finish(const Ticket& ticket, gst::Ref<GstBuffer> output);
  // One of several outputs of a frame; in the ledger pushed. Nothing happens when it was flushed.
  // At the bound of the bytes it waits until outputs were pushed, or is dropped; Stuck: those that
  // are held wait for the end of an older frame.
  infer::HeldBytes::Room add(const Ticket& ticket, gst::Ref<GstBuffer> output);
  // Ends a frame whose outputs were added; in the ledger consumed, or dropped when it was flushed.
  void end(const Ticket& ticket);
  // Ends a frame that gives no output. False: it was flushed. The caller enters it in the ledger.
  bool skip(const Ticket& ticket);
  // False when the frame was flushed: what is said and counted of it before skip() is there before
  // the entries behind it leave.
  bool holds(const Ticket& ticket) const { return queue_.holds(ticket); }
  // A serialized event in its place. Returns what the source pad answered, TRUE when it is to be
  // pushed later.
  bool send(gst::Ref<GstEvent> event);

  // What the source pad returned last; OK after a flush.
  GstFlowReturn flow() const noexcept { return flow_; }
  // The same, to those who bring frames. A failure of which nobody heard is posted at the end of
  // the stream.
  GstFlowReturn tell_flow() noexcept {
    flow_is_told_ = true;
    return flow_;
  }
  // Waits until all frames have ended and have been pushed. False: they were flushed.
  bool wait_until_empty() { return queue_.wait_until_empty(); }

  void flush();
  // Waits until no thread pushes what is from before the flush.
  void resume();

 private:
  class Waiting;  // those outputs, as HeldBytes asks for them
  void push_finished();
  void drain();
  void push(Entry entry) noexcept;
  void post_flow() noexcept;

  Ledger* ledger_;
  gst::PushTask task_;
  bool with_task_ = false;
  std::shared_ptr<infer::HeldBytes> held_;  // replaced while no pad is active
  GstPad* source_ = nullptr;                // borrowed from the element
  Queue queue_;
  std::atomic<GstFlowReturn> flow_{GST_FLOW_OK};
  std::atomic<bool> flow_is_told_{false};
  std::atomic<bool> event_taken_{true};
};

}  // namespace weir
