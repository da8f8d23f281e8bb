// InputFrame: a buffer of the stream as the input frame of an engine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <memory>
#include <span>
#include <vector>

#include "core/infer/module/held_frame.hpp"
#include "core/ledger/ledger.hpp"
#include "elements/tensor_filter/open_model.hpp"
#include "gstcpp/buffer/frame_layout.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"

namespace weir {

// Reads one buffer at a time and reuses its memory for the next. One thread at a time.
class InputFrame final : public infer::FrameOwner {
 public:
  using SharedFilterPlan = std::shared_ptr<const FilterPlan>;
  // All pointers are borrowed. `session`: resolves the shapes of flexible streams.
  InputFrame(const OpenModel* model, SharedFilterPlan plan, size_t session, Ledger* ledger);
  InputFrame(const InputFrame&) = delete;
  InputFrame& operator=(const InputFrame&) = delete;

  // Maps `buffer`, which must live until clear(). Copies tensors whose address or padding does not
  // suit the model. `use`: the model of this frame; null for a batch, whose shapes are fixed.
  Status read(GstBuffer* buffer, const infer::ModelLease::Frame* use,
              GstClockTime deadline = GST_CLOCK_TIME_NONE);
  // Sets the deadline by CLOCK_MONOTONIC of the frame that was read; 0 = none.
  void set_expiry(int64_t expires) noexcept { frame_.expires = expires; }
  void clear() noexcept { reader_.clear(); }

  // The plan of the last frame: a new one if its headers gave other shapes.
  const SharedFilterPlan& plan() const noexcept { return plan_; }
  GstBuffer* buffer() const noexcept { return buffer_; }
  // The tensors of the stream, and those that are inputs of the model.
  const std::vector<gst::TensorPlace>& views() const noexcept { return reader_.tensors(); }
  std::span<const weir_tensor> tensors() const noexcept { return tensors_; }
  const weir_frame& frame() const noexcept { return frame_; }

  // Maps the buffer again, for an engine that keeps it after the invoke. Null if a tensor is a
  // copy, or if its memory is mapped at another address.
  std::shared_ptr<const void> hold() override;

 private:
  void describe();
  Status follow_headers(const infer::ModelLease::Frame* use);
  Status place(size_t alignment, size_t padding);
  std::span<std::byte> suitable(size_t index, const gst::TensorPlace& view, size_t alignment,
                                size_t padding, size_t* capacity);

  const OpenModel* model_;
  SharedFilterPlan plan_;
  const size_t session_;
  Ledger* ledger_;
  GstBuffer* buffer_ = nullptr;
  uint64_t resolved_on_ = 0;  // the sessions that resolved the current shapes
  gst::FrameLayout reader_;
  std::vector<weir_tensor> tensors_;
  std::vector<std::vector<std::byte>> copies_;  // of tensors that the model cannot read in place
  gst::FrameMaps maps_;                         // frame_ points to it
  weir_frame frame_{};
};

}  // namespace weir
