// OutputFrame: the output of an engine as a buffer of the stream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <atomic>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "elements/tensor_filter/input_frame.hpp"
#include "gstcpp/buffer/frame_builder.hpp"
#include "gstcpp/buffer/frame_pool.hpp"

namespace weir {

// Compares type, rank and every dimension.
bool same_shape(const weir_tensor_info& a, const weir_tensor_info& b) noexcept;

// Makes one buffer at a time, with the timestamps, metas and source maps of its input. One thread
// at a time.
class OutputFrame {
 public:
  using SharedFilterPlan = InputFrame::SharedFilterPlan;
  using Made = Result<gst::Ref<GstBuffer>>;
  // Both are borrowed; stats show `pool_allocated`.
  OutputFrame(Ledger* ledger, std::atomic<uint64_t>* pool_allocated)
      : ledger_(ledger), pool_allocated_(pool_allocated) {}
  ~OutputFrame() { clear(); }
  OutputFrame(const OutputFrame&) = delete;
  OutputFrame& operator=(const OutputFrame&) = delete;

  // Makes the pool. A stream with fixed output sizes then allocates nothing per frame.
  Status prepare(SharedFilterPlan plan);
  // The same, sharing the pool of `other` for its plan.
  void prepare_beside(const OutputFrame& other);
  const SharedFilterPlan& plan() const noexcept { return plan_; }

  // Prepares frame() for an engine that writes next: pooled memory, or none if the engine
  // allocates.
  Status acquire(const InputFrame& in);
  weir_frame& frame() noexcept { return frame_; }
  // Returns the buffer that the engine filled.
  Made finish(const InputFrame& in);
  // Makes a buffer of tensors that the engine returned. Moves the memory that the buffer keeps out
  // of `given`.
  Made collect(const InputFrame& in, const weir_frame& given);
  // Makes a buffer with one tensor for each output, in memory that `owner` keeps. Copies only
  // headers and packed tensors.
  Made collect(const InputFrame& in, std::span<const weir_tensor> outputs,
               const std::shared_ptr<void>& owner);
  // Unmaps and releases what was not moved out.
  void clear() noexcept;

 private:
  void describe(SharedFilterPlan plan);
  Status acquire_memory();
  Status check_given_memory() const;
  Made pack(std::span<const weir_tensor> outputs);
  Made assemble(const InputFrame& in, std::span<weir_tensor> outputs);
  Made with_metas(const InputFrame& in, Made made) const;
  void copy_maps(GstBuffer* in, GstBuffer* out) const;
  // The memory of a forwarded input or of an output, with a header in a flexible stream. Copies
  // only where necessary.
  Result<gst::TensorPiece> input_piece(const InputFrame& in, size_t index);
  Result<gst::TensorPiece> output_piece(size_t index, weir_tensor& tensor);
  std::optional<Format> header() const noexcept {
    return flexible() ? std::optional(plan_->header_format()) : std::nullopt;
  }
  bool flexible() const noexcept { return plan_->output.format == Format::Flexible; }
  bool plain() const noexcept { return plan_->has_memory() && plan_->output_choice.empty(); }

  Ledger* ledger_;
  std::atomic<uint64_t>* pool_allocated_;
  SharedFilterPlan plan_;
  gst::FramePool pool_;
  gst::Ref<GstBuffer> pooled_;  // must outlive writer_
  gst::FramePool::Writer writer_;
  std::vector<weir_tensor> tensors_;
  std::vector<weir_tensor> described_;  // the tensors at the start of every frame
  weir_frame frame_{};
  std::vector<gst::TensorPiece> pieces_;  // of the buffer that is being assembled
};

}  // namespace weir
