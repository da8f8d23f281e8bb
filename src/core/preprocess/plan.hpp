// Plan: a Preparation with its tables made; runs over frames and allocates nothing for them.
//
//   auto plan = preprocess::Plan::make(preparation);
//   auto workspace = plan->workspace();
//   plan->run(planes, tensor_bytes, &workspace);
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "core/preprocess/block_sums.hpp"
#include "core/preprocess/placement.hpp"
#include "core/preprocess/preparation.hpp"
#include "core/preprocess/row_memory.hpp"

namespace weir::preprocess {

// Row r of a plane begins at byte offset + r * stride of `memory`, which is borrowed.
struct Plane {
  std::span<const std::byte> memory;
  size_t offset = 0;
  ptrdiff_t stride = 0;  // may be negative
};
using Planes = std::array<Plane, 3>;  // as many as the format has; the others are not looked at

// What the plans of one frame share, made as far as they have come.
class FrameSums {
 public:
  // Nothing is wanted any more. Memory is kept, for other crops too.
  void clear() {
    for (auto& of : all) of.clear();
  }
  void reserve() {
    for (auto& of : all) of.reserve();
  }

 private:
  friend class Plan;
  friend class PlanRun;
  std::vector<BlockSums> all;
};

// Memory for the rows in work, one for each thread; for all plans that it was made or grown for.
class Workspace {
 public:
  Workspace() = default;

 private:
  friend class PlanRun;
  friend class Plan;
  RowMemory<float> blended;
  std::vector<RowMemory<float>> lanes;  // the last one for what is not used
  RowMemory<std::byte> pairs[2];
  std::vector<RowMemory<int16_t>> samples;  // of each band
  std::vector<RowMemory<std::byte>> numbers;
  std::vector<const uint8_t*> rows, next_rows;
  FrameSums sums;
};

struct RowOptions {
  // Past the caches where it can be done, for tensors that do not stay there. The caller calls
  // flush_streamed() before another thread reads.
  bool streamed = false;
  bool checked = false;  // by a call for no rows, of the same planes and tensor
  // Cleared for these planes, then wanted and reserved for all rows to come, each tensor's from the
  // first on; null: they are made in the workspace.
  FrameSums* sums = nullptr;
};

struct PlanTables;

// Copies share the tables; one that gets another crop leaves them and has its own from then on.
class Plan {
 public:
  // Errors: check(preparation).
  static Result<Plan> make(Preparation preparation);

  const Preparation& preparation() const noexcept;
  const Placement& placement() const noexcept;
  Workspace workspace() const;
  // Allocates nothing where the workspace is big enough.
  void grow(Workspace* workspace) const;

  // Errors: check_crop(). Tables that no other plan shares are made again in their own memory.
  Status set_crop(const Rect& crop);
  // A region of the part `picture`, which it may reach beyond. OPTION_VALUE where the tensor would
  // show nothing of that part (place()).
  Status set_region(const Rect& picture, const Box& region);

  // What run_rows() of these rows reads of `sums`, which several plans share.
  void want_sums(uint32_t first, uint32_t count, FrameSums* sums) const;

  // Writes the rows [first, first + count) of the tensor. `out` is the whole tensor, any alignment.
  // FRAME_SIZE when a plane is shorter than the picture needs or `out` is not the tensor's size.
  Status run_rows(const Planes& planes, std::span<std::byte> out, uint32_t first, uint32_t count,
                  Workspace* workspace, const RowOptions& options = {}) const;
  Status run(const Planes& planes, std::span<std::byte> out, Workspace* workspace) const {
    return run_rows(planes, out, 0, preparation().height, workspace);
  }

 private:
  template <class F>
  void for_sums(uint32_t first, uint32_t count, FrameSums* sums, F&& f) const;
  explicit Plan(std::shared_ptr<PlanTables> tables) : tables_(std::move(tables)) {}
  std::shared_ptr<PlanTables> tables_;
};

}  // namespace weir::preprocess
