// FrameInvoker: one buffer through one session of a model, into memory of a pool.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <atomic>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/infer/invoke_statistics.hpp"
#include "core/infer/model.hpp"
#include "core/ledger/ledger.hpp"
#include "elements/tensor_filter/filter_plan.hpp"
#include "elements/tensor_filter/opened_model.hpp"
#include "gstcpp/frame_pool.hpp"
#include "gstcpp/frame_reader.hpp"
#include "gstcpp/tensor_meta.hpp"
#include "gstcpp/tensor_pieces.hpp"

namespace weir {

class FrameInvoker {
 public:
  // Of one of the model's workers; one thread at a time.
  FrameInvoker(std::shared_ptr<const OpenedModel> model, size_t worker, FilterPlan plan,
               infer::InvokeStatistics* statistics, Ledger* ledger,
               std::atomic<uint64_t>* pool_allocated)
      : plan_(std::move(plan)),
        model_(std::move(model)),
        session_(worker * plan_.rows.threads),
        statistics_(statistics),
        ledger_(ledger),
        pool_allocated_(pool_allocated) {}

  const FilterPlan& plan() const noexcept { return plan_; }
  // Makes the pool. After this, a stream whose output sizes are fixed allocates nothing per frame.
  Status prepare();
  // The same with the pool of another worker for the same plan.
  void prepare_beside(const FrameInvoker& other);
  // The output buffer with the time-stamps and metas of `in`; null = the engine dropped the frame.
  // `frame` is of the model; its sessions may be other ones than those of the frame before.
  // `deadline`: the running time from which on it is worthless, or none; for the engine.
  Result<gst::Ref<GstBuffer>> run(const infer::ModelUse::Frame& frame, GstBuffer* in,
                                  GstClockTime deadline);
  const OpenedModel& model() const noexcept { return *model_; }

  // The same in parts, for a frame whose outputs come by and by. From open() to clear() the memory
  // of `in` is mapped, and in_frame() is what the engine gets.
  Status open(const infer::ModelUse::Frame& frame, GstBuffer* in, GstClockTime deadline);
  const weir_frame& in_frame() const noexcept { return in_frame_; }
  // A buffer of the tensors that the engine gave, with the time-stamps and metas of `in`. Memory
  // that it keeps is no longer the frame's.
  Result<gst::Ref<GstBuffer>> collect(GstBuffer* in, weir_frame& given);

  // The same in two steps, for a model that is invoked elsewhere. First the inputs: read where they
  // are, until end() or the next begin(); `in` must live as long.
  Status begin(GstBuffer* in);
  std::span<const weir_tensor> inputs() const noexcept { return inputs_; }
  // Then what became of them: one tensor for each output, in memory that `owner` keeps; it goes
  // into the buffer without a copy, but for headers and what is packed.
  Result<gst::Ref<GstBuffer>> end(GstBuffer* in, std::span<const weir_tensor> outputs,
                                  const std::shared_ptr<void>& owner);
  void clear() noexcept;  // in place of end(), when there are no outputs

 private:
  void use(const infer::ModelUse::Frame& frame) noexcept;
  Status read(GstBuffer* in, GstClockTime deadline);
  struct Cleared;  // calls clear() at the end of a scope
  void describe();
  Result<gst::Ref<GstBuffer>> make(GstBuffer* in, GstClockTime deadline);
  Result<gst::Ref<GstBuffer>> acquire();
  Result<gst::Ref<GstBuffer>> pack(std::span<const weir_tensor> outputs);
  void copy_metas(GstBuffer* in, GstBuffer* out) const;
  // The ways back of the output's tensors: an input that is passed on has its own, a result that of
  // the model's first input. Regions stay as they are.
  void copy_maps(GstBuffer* in, GstBuffer* out) const;
  Status follow_headers();
  Status describe_inputs();
  std::span<std::byte> suitable(size_t index, const gst::TensorView& view, size_t* capacity);
  void describe_frame(GstBuffer* in, GstClockTime deadline);
  size_t first_input() const noexcept {
    return plan_.input_choice.empty() ? 0 : plan_.input_choice[0];
  }
  Status adapt_to(const std::vector<ModelShape>& inputs);
  Result<bool> invoke(GstBuffer* in);
  Result<bool> run_session();
  Result<bool> run_in_parts();
  Status adapt_session(size_t thread, const weir_frame& in, const weir_frame& out);
  Result<gst::Ref<GstBuffer>> assemble(GstBuffer* in, gst::Ref<GstBuffer> pooled,
                                       std::span<weir_tensor> outputs);
  Status check_given_memory() const;
  // The memory of an input that is passed on, of what the engine made: with a header in a flexible
  // stream, and without a copy where it can be.
  Result<gst::TensorPiece> input_piece(GstBuffer* in, size_t index);
  Result<gst::TensorPiece> output_piece(size_t index, weir_tensor& tensor);
  void release_engine_memory() noexcept;
  std::optional<Format> header() const noexcept {
    return flexible() ? std::optional(plan_.header_format()) : std::nullopt;
  }
  bool flexible() const noexcept { return plan_.output.format == Format::Flexible; }
  bool plain() const noexcept { return plan_.has_memory() && plan_.output_choice.empty(); }

  FilterPlan plan_;
  std::shared_ptr<const OpenedModel> model_;
  const size_t session_;                           // the first of this worker
  const infer::ModelUse::Frame* frame_ = nullptr;  // of the frame in work
  uint64_t resolved_on_ = 0;                       // the sessions that know the present shapes
  infer::InvokeStatistics* statistics_;            // borrowed
  Ledger* ledger_;                                 // borrowed
  std::atomic<uint64_t>* pool_allocated_;          // borrowed; shown by stats
  gst::FramePool pool_;
  gst::FrameReader reader_;
  gst::FramePool::Writer writer_;
  std::vector<weir_tensor> inputs_, outputs_;
  std::vector<weir_tensor> described_;          // the outputs as every frame begins with them
  std::vector<std::vector<std::byte>> copies_;  // of inputs in memory that the model cannot take
  weir_frame in_frame_{}, out_frame_{};
  std::vector<gst::TensorPiece> pieces_;          // of the output, while it is put together
  std::unique_ptr<infer::RowRunner> row_runner_;  // where frames are run in parts
  std::vector<int64_t> session_rows_;  // of each thread's session, as it was told last; -1: others
  uint64_t session_rows_on_ = 0;       // the sessions that were told
  gst::FrameMaps maps_;                // in_frame_ points into it
};

}  // namespace weir
