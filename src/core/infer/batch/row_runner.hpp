// RowRunner: splits a batch into parts of fewer rows and runs several of them concurrently.
//
// Rows are the outermost dimension of each tensor. Parts point into the memory of the whole batch;
// nothing is copied.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <vector>

#include "core/infer/queue/thread_team.hpp"
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::infer {

struct RowLimits {
  size_t rows = 0;     // per invoke; 0 = no limit
  size_t threads = 1;  // concurrent invokes
  // The model takes one row and no other number: parts never have more, whatever the alignment.
  bool single = false;
  bool none() const noexcept { return rows == 0 && threads == 1; }
};

// BATCH_UNSUPPORTED for a stateful model, one with dynamic outputs, and one with a tensor whose
// outermost dimension is not open. `flags` and shapes are those of weir_model_info.
Status check_rows(uint32_t flags, const std::vector<weir_tensor_info>& inputs,
                  const std::vector<weir_tensor_info>& outputs);

// Whether the model runs one row at a time because the outermost dimension of each of its tensors
// is 1: a network for one picture. Such a model needs RowLimits{.rows = 1, .single = true}. False
// for a stateful model and one with dynamic outputs.
bool has_single_row(uint32_t flags, const std::vector<weir_tensor_info>& inputs,
                    const std::vector<weir_tensor_info>& outputs);

// Used by one thread at a time.
class RowRunner {
 public:
  // Runs one part; `thread` is 0 to limits.threads - 1. Returns false if the engine drops the
  // frame.
  using Invoke = std::function<Result<bool>(size_t thread, const weir_frame& in, weir_frame& out)>;

  explicit RowRunner(const RowLimits& limits) : limits_(limits), team_(limits.threads) {}

  // Runs all parts of a frame. `out` has memory. Parts begin at multiples of `alignment` bytes if
  // the whole does. BATCH_UNSUPPORTED if the tensors differ in their number of rows, or if the
  // rows of a model of one row are not aligned; otherwise the error of the first part that failed.
  // Returns false if a part is dropped.
  Result<bool> run(const weir_frame& in, weir_frame& out, size_t alignment, const Invoke& invoke);

 private:
  struct Part {
    std::vector<weir_tensor> inputs, outputs;
    weir_frame in{}, out{};
    Status status = ok();
    bool kept = true;
  };
  static void run_part(size_t thread, const Invoke& invoke, Part* part);
  size_t rows_of_a_part(const weir_frame& in, size_t rows, size_t alignment) const;

  const RowLimits limits_;
  ThreadTeam team_;
  std::vector<Part> parts_;  // kept to reuse their memory
};

}  // namespace weir::infer
