// AsyncFrames: frames given to an engine that answers on its own threads, with any number of
// outputs each.
//
// Outputs leave in the order of the frames, those of the oldest frame as they come, each with the
// time-stamps and metadata of its frame. A frame is consumed with the engine's last word. What a
// flush finds in work is cancelled and counted as dropped; the engine's places are free again when
// it has ended it (core/infer/async_request.hpp).
#pragma once
#include <gst/gst.h>

#include <chrono>
#include <memory>
#include <mutex>

#include "core/infer/held_bytes.hpp"
#include "core/timer/idle_watch.hpp"
#include "elements/tensor_filter/filter_plan.hpp"
#include "elements/tensor_filter/opened_model.hpp"
#include "elements/tensor_filter/output_queue.hpp"
#include "gstcpp/ref.hpp"

namespace weir {

class FrameFlow;

class AsyncFrames {
 public:
  // `flow` is borrowed: it hears of outputs and ends, on any thread.
  explicit AsyncFrames(FrameFlow* flow) : flow_(flow) {}

  // How long the engine may say nothing while somebody waits for its word; 0 = any time. Beyond
  // that all frames in work end with an error. Until close().
  void limit_silence(std::chrono::milliseconds limit);
  // An output or an end came, a frame went. Any thread.
  void heard() {
    if (silence_) silence_->touch();
  }

  // Streaming thread: the frames that follow.
  Status begin(std::shared_ptr<const OpenedModel> model, FilterPlan plan);
  // How many frames may be in work.
  size_t depth() const;
  using Answer = infer::HeldBytes::Answer;
  using Share = infer::HeldBytes::Share;
  // Streaming thread: whether there is room for a frame of `bytes`, which `share` then has: in the
  // engine, and below the bound of bytes; where the model was replaced, only when the one before
  // has answered all frames. With `waits` never Full.
  Result<Answer> make_room(bool waits, const std::shared_ptr<infer::HeldBytes>& held,
                           uint64_t bytes, Share* share);
  // Streaming thread. False while flushing: the frame was not begun, and its ticket is still the
  // caller's; so it is with an error.
  Result<bool> submit(gst::Ref<GstBuffer> buffer, GstClockTime deadline,
                      const OutputQueue::Ticket& ticket, Share share);

  // Gives up what is in work: how many frames nobody will hear of.
  size_t flush();
  // Waits until all that ended before is in the ledger.
  void resume();
  // Waits until the flow is told of nothing any more. Behind a flush; no pad is active.
  void close();

 private:
  using Frame = infer::ModelUse::Frame;
  std::shared_ptr<const Frame> frame() const;
  Result<Answer> follow_model(bool waits);
  // False: it is not the engine that is waited for.
  bool end_of_patience(std::chrono::milliseconds limit);

  FrameFlow* flow_;
  std::shared_ptr<const OpenedModel> model_;  // streaming thread only; and so is plan_
  FilterPlan plan_;
  mutable std::mutex mutex_;  // guards frame_ against flushes
  // Held from frame to frame: the model is in use while the engine may answer.
  std::shared_ptr<const Frame> frame_;
  std::unique_ptr<IdleWatch> silence_;  // null: no limit. Made and freed while no pad is active
};

}  // namespace weir
