// A frame's batch in parts.
#include <mutex>

#include "core/infer/model_shapes.hpp"
#include "elements/tensor_filter/frame_invoker.hpp"
#include "elements/tensor_filter/output_size.hpp"

namespace weir {
namespace {

Error other_rows(const std::string& offered, const std::string& difference) {
  return {Code::BATCH_UNSUPPORTED,
          "the model's batch cannot be cut into parts",
          offered,
          "outputs with as many rows as the inputs, known before an invoke",
          difference,
          "tensor_filter invoke-rows=0 invoke-threads=1"};
}

}  // namespace

Result<bool> FrameInvoker::run_session() {
  if (plan_.rows.none()) return frame_->session(session_).invoke(in_frame_, out_frame_);
  if (!plan_.has_memory()) return other_rows("outputs of sizes that are not known", "");
  return run_in_parts();
}

Result<bool> FrameInvoker::run_in_parts() {
  if (!row_runner_) row_runner_ = std::make_unique<infer::RowRunner>(plan_.rows);
  if (session_rows_on_ != frame_->sessions_number()) session_rows_.clear();
  session_rows_on_ = frame_->sessions_number();
  session_rows_.resize(plan_.rows.threads, -1);
  // Sessions that are one and the same take turns, from being told the rows to the end.
  const bool alone =
      &frame_->session(session_) == &frame_->session(session_ + plan_.rows.threads - 1);
  std::mutex turn;
  return row_runner_->run(
      in_frame_, out_frame_, plan_.alignment,
      [&](size_t thread, const weir_frame& in, weir_frame& out) -> Result<bool> {
        const size_t told = alone ? 0 : thread;
        const auto lock = alone ? std::unique_lock(turn) : std::unique_lock<std::mutex>();
        if (auto status = adapt_session(told, in, out); !status) return status.error();
        return frame_->session(session_ + told).invoke(in, out);
      });
}

// Tells a session the rows of a part, where they are others than those before.
Status FrameInvoker::adapt_session(size_t thread, const weir_frame& in, const weir_frame& out) {
  const int64_t rows = in.tensors[0].info.shape[0];
  if (session_rows_[thread] == rows) return ok();
  session_rows_[thread] = -1;
  std::vector<weir_tensor_info> inputs;
  for (uint32_t i = 0; i < in.n_tensors; ++i) inputs.push_back(in.tensors[i].info);
  const auto outputs = frame_->session(session_ + thread).resolve(inputs);
  if (!outputs) return outputs.error();
  for (uint32_t i = 0; i < out.n_tensors; ++i)
    if (!same_shape((*outputs)[i], out.tensors[i].info))
      return other_rows(
          list_shapes({model_shape((*outputs)[i])}) + " for " + std::to_string(rows) + " rows",
          "output " + std::to_string(i));
  session_rows_[thread] = rows;
  return ok();
}

}  // namespace weir
