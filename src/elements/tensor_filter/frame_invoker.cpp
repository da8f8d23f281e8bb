// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/frame_invoker.hpp"

#include <algorithm>
#include <chrono>
#include <mutex>

#include "core/isolate/isolation.hpp"
#include "elements/tensor_filter/admission.hpp"
#include "elements/tensor_filter/model_report.hpp"

namespace weir {
namespace {

Error other_rows(const std::string& offered, const std::string& difference) {
  return {.code = Code::BATCH_UNSUPPORTED,
          .what = "the model's batch cannot be cut into parts",
          .offered = offered,
          .needed = "outputs with as many rows as the inputs, known before an invoke",
          .difference = difference,
          .fix = "tensor_filter invoke-rows=0 invoke-threads=1"};
}

// Adds the end of a part to that of its frame.
void add(const infer::InvokeEnd& part, infer::InvokeEnd* frame) {
  frame->reason = std::max(frame->reason, part.reason);
  if (part.answered_by.empty() || frame->answered_by.find(part.answered_by) != std::string::npos)
    return;
  if (!frame->answered_by.empty()) frame->answered_by += ',';
  frame->answered_by += part.answered_by;
}

}  // namespace

Result<gst::Ref<GstBuffer>> FrameInvoker::run(infer::ModelLease::Frame use, GstBuffer* in,
                                              GstClockTime deadline) {
  const struct Cleared {
    FrameInvoker* self;
    ~Cleared() {
      self->out_.clear();
      self->in_.clear();
    }
  } cleared{this};
  try {
    return make(use, in, deadline);
  } catch (const std::bad_alloc&) {
    return Error{.code = Code::OUT_OF_MEMORY, .what = "memory ran out"};
  } catch (const std::exception& e) {
    return Error{.code = Code::INTERNAL, .what = e.what()};
  }
}

Result<gst::Ref<GstBuffer>> FrameInvoker::make(const infer::ModelLease::Frame& use, GstBuffer* in,
                                               GstClockTime deadline) {
  if (auto status = in_.read(in, &use, deadline); !status) return status.error();
  const int64_t expires = monotonic_deadline(element_, deadline);
  Fallback* fallback = model_->fallback();
  in_.set_expiry(fallback ? fallback->latest_end(expires) : expires);
  if (in_.plan() != out_.plan()) {
    session_rows_.clear();
    if (auto status = prepare(); !status) return status.error();
  }
  if (auto status = out_.acquire(in_); !status) return status.error();
  auto kept = invoke(use);
  if (fallback && kept) {
    in_.set_expiry(expires);
    kept = *kept ? fallback->model_succeeded(element_) : run_fallback(*fallback);
  }
  if (!kept) return kept.error();
  if (!*kept) return gst::Ref<GstBuffer>{};
  auto made = out_.finish(in_);
  if (made) set_answered_by(made->get(), element_, end_.answered_by);
  return made;
}

Result<bool> FrameInvoker::invoke(const infer::ModelLease::Frame& use) {
  const infer::FrameOwnerScope scope(in_.frame(), &in_);
  const auto begin = std::chrono::steady_clock::now();
  end_ = {};
  auto kept = in_.plan()->rows.none()
                  ? use.session(session_).invoke(in_.frame(), out_.frame(), &end_)
                  : run_in_parts(use, &end_);
  if (end_.reason != isolate::kFrameLost)
    statistics_->record(std::chrono::steady_clock::now() - begin);
  return kept;
}

// Runs the fallback on a frame for which the model has no result.
Result<bool> FrameInvoker::run_fallback(Fallback& fallback) {
  if (drop_reason() == DropReason::Policy || !fallback.has_time(in_.frame().expires)) return false;
  out_.clear();  // what the model left
  if (auto status = out_.acquire(in_); !status) return status.error();
  auto kept = fallback.invoke(in_.frame(), out_.frame(), element_, drop_reason());
  if (kept && *kept) end_.answered_by = fallback.file();
  return kept;
}

Result<bool> FrameInvoker::run_in_parts(const infer::ModelLease::Frame& use,
                                        infer::InvokeEnd* end) {
  const auto& plan = *in_.plan();
  if (!plan.has_memory()) return other_rows("outputs of sizes that are not known", "");
  if (!row_runner_) row_runner_ = std::make_unique<infer::RowRunner>(plan.rows);
  if (session_rows_on_ != use.sessions_number()) session_rows_.clear();
  session_rows_on_ = use.sessions_number();
  session_rows_.resize(plan.rows.threads, -1);
  // If the threads share one session, each keeps it locked from resolving the rows to the end of
  // the invoke.
  const bool alone = &use.session(session_) == &use.session(session_ + plan.rows.threads - 1);
  std::mutex turn, ends;
  return row_runner_->run(
      in_.frame(), out_.frame(), use.model().info().alignment,
      [&](size_t thread, const weir_frame& in, weir_frame& out) -> Result<bool> {
        const size_t index = alone ? 0 : thread;
        const auto lock = alone ? std::unique_lock(turn) : std::unique_lock<std::mutex>();
        auto& session = use.session(session_ + index);
        if (auto status = adapt_session(session, index, in, out); !status) return status.error();
        infer::InvokeEnd part;
        auto kept = session.invoke(in, out, &part);
        std::lock_guard join(ends);
        add(part, end);
        return kept;
      });
}

// Resolves the session for the rows of a part if their number changed.
Status FrameInvoker::adapt_session(infer::Session& session, size_t thread, const weir_frame& in,
                                   const weir_frame& out) {
  const int64_t rows = in.tensors[0].info.shape[0];
  if (session_rows_[thread] == rows) return ok();
  session_rows_[thread] = -1;
  std::vector<weir_tensor_info> inputs;
  for (uint32_t i = 0; i < in.n_tensors; ++i) inputs.push_back(in.tensors[i].info);
  const auto outputs = session.resolve(inputs);
  if (!outputs) return outputs.error();
  for (uint32_t i = 0; i < out.n_tensors; ++i)
    if (!same_shape((*outputs)[i], out.tensors[i].info))
      return other_rows(
          list_tensors({model_tensor((*outputs)[i])}) + " for " + std::to_string(rows) + " rows",
          "output " + std::to_string(i));
  session_rows_[thread] = rows;
  return ok();
}

}  // namespace weir
