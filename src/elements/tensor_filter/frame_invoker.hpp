// FrameInvoker: one buffer through one session of a model, into memory of a pool.
#pragma once
#include <gst/gst.h>

#include <array>
#include <atomic>
#include <vector>

#include "core/infer/invoke_statistics.hpp"
#include "core/infer/model.hpp"
#include "core/ledger/ledger.hpp"
#include "elements/tensor_filter/filter_plan.hpp"
#include "gstcpp/frame_pool.hpp"
#include "gstcpp/frame_reader.hpp"

namespace weir {

class FrameInvoker {
 public:
  FrameInvoker(FilterPlan plan, infer::Session* session, infer::InvokeStatistics* statistics,
               Ledger* ledger, std::atomic<uint64_t>* pool_allocated)
      : plan_(std::move(plan)),
        session_(session),
        statistics_(statistics),
        ledger_(ledger),
        pool_allocated_(pool_allocated) {}

  const FilterPlan& plan() const noexcept { return plan_; }
  // Makes the pool. After this, a stream whose output sizes are fixed allocates nothing per frame.
  Status prepare();
  // The output buffer, without time-stamps and metas; null = the engine dropped the frame.
  Result<gst::Ref<GstBuffer>> run(GstBuffer* in);
  // The ways back of the output's tensors: an input that is passed on has its own, a result that of
  // the model's first input. Regions stay as they are.
  void copy_maps(GstBuffer* in, GstBuffer* out) const;

 private:
  Status follow_headers();
  Status describe_inputs();
  std::span<std::byte> suitable(size_t index, const gst::TensorView& view, size_t* capacity);
  void describe_frame(GstBuffer* in) noexcept;
  size_t first_input() const noexcept {
    return plan_.input_choice.empty() ? 0 : plan_.input_choice[0];
  }
  Status adapt_to(const std::vector<ModelShape>& inputs);
  Result<bool> invoke();
  Result<gst::Ref<GstBuffer>> assemble(GstBuffer* in, gst::Ref<GstBuffer> pooled);
  Status append_input(GstBuffer* in, size_t index, GstBuffer* out);
  Status append_output(size_t index, GstBuffer* out);
  void release_engine_memory() noexcept;
  bool flexible() const noexcept { return plan_.output.format == Format::Flexible; }
  bool plain() const noexcept { return plan_.outputs_fixed && plan_.output_choice.empty(); }

  FilterPlan plan_;
  infer::Session* session_;                // borrowed, outlives this
  infer::InvokeStatistics* statistics_;    // borrowed
  Ledger* ledger_;                         // borrowed
  std::atomic<uint64_t>* pool_allocated_;  // borrowed; shown by stats
  gst::FramePool pool_;
  gst::FrameReader reader_;
  gst::FramePool::Writer writer_;
  std::vector<weir_tensor> inputs_, outputs_;
  std::vector<std::vector<std::byte>> copies_;  // of inputs in memory that the model cannot take
  weir_frame in_frame_{}, out_frame_{};
  std::array<float, 6> to_source_{};  // in_frame_ points to it
};

}  // namespace weir
