// PreprocessPlan: a Preparation with its tables; runs over frames without allocating memory.
//
//   auto plan = preprocess::PreprocessPlan::make(preparation);
//   auto workspace = plan->workspace();
//   plan->run(planes, tensor_bytes, &workspace);
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "core/preprocess/placement.hpp"
#include "core/preprocess/preparation.hpp"
#include "core/preprocess/row_memory.hpp"

namespace weir::preprocess {

// Row r of a plane begins at byte offset + r * stride of `memory`, which is borrowed.
struct Plane {
  std::span<const std::byte> memory;
  size_t offset = 0;
  ptrdiff_t stride = 0;  // may be negative: bottom-up rows
};
using Planes = std::array<Plane, 3>;  // only the format's planes are read

// The row buffers of one thread, usable with every plan that created or grew it.
class Workspace {
 public:
  Workspace() = default;

 private:
  friend class PlanRun;
  friend class PreprocessPlan;
  RowMemory<float> blended;
  std::vector<RowMemory<float>> components;
  std::vector<RowMemory<std::byte>> numbers;
  std::vector<const uint8_t*> rows, next_rows;
};

struct RowOptions {
  // Writes with non-temporal stores if possible, for tensors that exceed the caches. The caller
  // calls flush_streamed() before another thread reads the tensor.
  bool streamed = false;
  bool checked = false;  // a call for zero rows checked the same planes and tensor
};

struct PlanTables;

// Copies share the tables until a copy gets another crop; it then makes its own.
class PreprocessPlan {
 public:
  // Returns the errors of check(preparation).
  static Result<PreprocessPlan> make(Preparation preparation);

  const Preparation& preparation() const noexcept;
  const Placement& placement() const noexcept;
  Workspace workspace() const;
  // Allocates nothing if the workspace is large enough.
  void grow(Workspace* workspace) const;

  // Errors: check_crop(). Rebuilds the tables in place unless another plan shares them.
  Status set_crop(const Rect& crop);
  // Selects a region, which may exceed the part `picture`. OPTION_VALUE if the tensor would show
  // nothing of that part (place()).
  Status set_region(const Rect& picture, const Roi& region);

  // Writes the rows [first, first + count) of the tensor. `out` is the whole tensor, at any
  // alignment. FRAME_SIZE if a plane is shorter than the picture or `out` differs from the tensor's
  // size.
  Status run_rows(const Planes& planes, std::span<std::byte> out, uint32_t first, uint32_t count,
                  Workspace* workspace, const RowOptions& options = {}) const;
  Status run(const Planes& planes, std::span<std::byte> out, Workspace* workspace) const {
    return run_rows(planes, out, 0, preparation().height, workspace);
  }

 private:
  explicit PreprocessPlan(std::shared_ptr<PlanTables> tables) : tables_(std::move(tables)) {}
  std::shared_ptr<PlanTables> tables_;
};

}  // namespace weir::preprocess
