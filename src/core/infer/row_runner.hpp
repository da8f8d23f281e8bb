// RowRunner: a batch through a model in parts of fewer rows, several of them at once.
//
// Rows are the outermost dimension of each tensor. Nothing is copied: a part's tensors lie within
// those of the whole.
#pragma once
#include <functional>
#include <vector>

#include "core/infer/crew.hpp"
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::infer {

struct RowLimits {
  size_t rows = 0;     // of one invoke at most; 0 = any number
  size_t threads = 1;  // invokes at once
  bool none() const noexcept { return rows == 0 && threads == 1; }
};

// BATCH_UNSUPPORTED for a model with state, one that decides its outputs' sizes, and one whose
// tensors do not all begin with an open dimension. `flags` and shapes as weir_model_info has them.
Status check_rows(uint32_t flags, const std::vector<weir_tensor_info>& inputs,
                  const std::vector<weir_tensor_info>& outputs);

// One thread at a time.
class RowRunner {
 public:
  // Runs one part; `thread` counts from 0 to limits.threads - 1. False: the engine drops the frame.
  using Invoke = std::function<Result<bool>(size_t thread, const weir_frame& in, weir_frame& out)>;

  explicit RowRunner(const RowLimits& limits) : limits_(limits), crew_(limits.threads) {}

  // All parts of a frame. `out` has memory. Parts begin at multiples of `alignment` bytes where the
  // whole does. BATCH_UNSUPPORTED when tensors have not as many rows as the first input; else the
  // error of the first part that has one. False when a part is dropped.
  Result<bool> run(const weir_frame& in, weir_frame& out, size_t alignment, const Invoke& invoke);

 private:
  struct Part {
    std::vector<weir_tensor> inputs, outputs;
    weir_frame in{}, out{};
    Status status = ok();
    bool kept = true;
  };
  size_t rows_of_a_part(const weir_frame& in, size_t rows, size_t alignment) const;

  const RowLimits limits_;
  Crew crew_;
  std::vector<Part> parts_;  // kept for their memory
};

}  // namespace weir::infer
