// FrameInvoker: runs one buffer through one session of a model, on the calling thread.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <memory>
#include <vector>

#include "elements/tensor_filter/filter_output.hpp"
#include "elements/tensor_filter/input_frame.hpp"
#include "elements/tensor_filter/open_model.hpp"
#include "elements/tensor_filter/output_frame.hpp"

namespace weir {

class FrameInvoker {
 public:
  // For one worker of the model; one thread at a time. `output` is borrowed.
  FrameInvoker(std::shared_ptr<const OpenModel> model, size_t worker,
               const InputFrame::SharedFilterPlan& plan, FilterOutput* output)
      : model_(std::move(model)),
        session_(worker * plan->rows.threads),
        element_(output->element()),
        statistics_(output->statistics()),
        in_(model_.get(), plan, session_, output->ledger()),
        out_(output->ledger(), output->pool_allocated()) {}

  Status prepare() { return out_.prepare(in_.plan()); }
  // The same, sharing the pool of another worker with the same plan.
  void prepare_beside(const FrameInvoker& other) { out_.prepare_beside(other.out_); }
  // Returns the output with the timestamps and metas of `in`; null = the engine dropped the frame.
  // `use` must be of model(); it is released before the return, so that replacing the model does
  // not wait for the push. `deadline` is passed to the engine: the running time after which the
  // result is useless, or none.
  Result<gst::Ref<GstBuffer>> run(infer::ModelLease::Frame use, GstBuffer* in,
                                  GstClockTime deadline);
  const OpenModel& model() const noexcept { return *model_; }
  // Why the last run() returned null.
  DropReason drop_reason() const noexcept { return to_drop_reason(end_.reason); }

 private:
  Result<gst::Ref<GstBuffer>> make(const infer::ModelLease::Frame& use, GstBuffer* in,
                                   GstClockTime deadline);
  Result<bool> invoke(const infer::ModelLease::Frame& use);
  Result<bool> run_in_parts(const infer::ModelLease::Frame& use, infer::InvokeEnd* end);
  Result<bool> run_fallback(Fallback& fallback);
  Status adapt_session(infer::Session& session, size_t thread, const weir_frame& in,
                       const weir_frame& out);

  std::shared_ptr<const OpenModel> model_;
  const size_t session_;  // the first session of this worker
  GstElement* element_;   // borrowed: its clock
  infer::InvokeStatistics* statistics_;
  InputFrame in_;
  OutputFrame out_;
  std::unique_ptr<infer::RowRunner> row_runner_;  // only if frames run in parts
  std::vector<int64_t> session_rows_;  // last resolved by the session of each thread; -1: unknown
  uint64_t session_rows_on_ = 0;       // the sessions to which session_rows_ applies
  infer::InvokeEnd end_;               // of the last invoke of the model
};

}  // namespace weir
