// Fallback: a second model of one tensor_filter. It computes the frames for which the first has no
// result because what computes them is late, refuses them or cannot be reached.
//
//   auto kept = session.invoke(in, out, &reason);
//   if (no result && fallback.has_time(in.expires)) kept = fallback.invoke(in, out, element, why);
//
// The model is tried with every frame, so it takes over again as soon as it succeeds.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/filter/fallback_budget.hpp"
#include "core/infer/model/shared_model.hpp"
#include "core/ledger/ledger.hpp"
#include "elements/tensor_filter/filter_settings.hpp"

namespace weir {

// Thread-safe. One frame runs at a time; others wait.
class Fallback {
 public:
  using Shapes = std::vector<ModelTensor>;
  // Opens the model of `settings.fallback`. OPTION_VALUE for properties that cannot be combined
  // with it; otherwise errors of the engine.
  static Result<std::unique_ptr<Fallback>> open(const FilterSettings& settings);

  // `settings` with the tensors of this model where the user declared none: for an engine that
  // cannot describe its model because no server answers.
  FilterSettings declare_tensors(FilterSettings settings) const;
  // SPEC_MISMATCH, naming both sides, unless the model's tensors, with -1 for what is open, can be
  // those of this one.
  Status check(const Shapes& inputs, const Shapes& outputs) const;
  // Prepares for frames of these shapes. Call while no frame is in progress. Errors as of check().
  Status prepare(const Shapes& inputs, const Shapes& outputs);
  weir_model_info info() const;
  const std::string& file() const noexcept { return file_; }

  // The time by CLOCK_MONOTONIC at which the model should end, so that this one can still run on a
  // frame that expires then; 0 = none.
  int64_t latest_end(int64_t expires) const;
  // Whether this model can end before the frame expires.
  bool has_time(int64_t expires) const;
  // Runs the frame. False if it has no time left after the wait for others. `reason`: why the model
  // has no result.
  Result<bool> invoke(const weir_frame& in, weir_frame& out, GstElement* element,
                      DropReason reason);
  // The model has computed a frame. Returns true.
  bool model_succeeded(GstElement* element);

  // Adds fallback-frames, the number of frames that this model computed.
  void add_stats(GstStructure* stats) const;

 private:
  Fallback(std::string file, std::unique_ptr<infer::ModelLease> lease)
      : file_(std::move(file)), lease_(std::move(lease)) {}
  Status resolve(const infer::ModelLease::Frame& use, const Shapes& inputs, const Shapes& outputs);

  const std::string file_;
  Shapes inputs_, outputs_;  // of the model
  const std::unique_ptr<infer::ModelLease> lease_;
  std::atomic<uint64_t> frames_{0};
  std::atomic<bool> is_active_{false};  // the last result came from this model
  FallbackBudget spare_;
  std::mutex mutex_;  // guards the rest, and serialises the invokes and FallbackBudget::add()
  Shapes resolved_;   // the inputs for which the session is resolved
};

}  // namespace weir
