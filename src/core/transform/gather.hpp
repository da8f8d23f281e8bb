// GatherKernel: reads a tensor with gaps in the order of its elements.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/tensor/strided_layout.hpp"
#include "core/transform/fused.hpp"

namespace weir::transform {

// Copies the runs of a strided tensor to dense memory, or applies element-wise work to them
// directly, so that the dense tensor is never in memory as a whole.
class GatherKernel final : public Kernel {
 public:
  explicit GatherKernel(Runs runs) : runs_(std::move(runs)) {}
  Counters run(std::span<const std::byte> in, std::span<std::byte> out) const noexcept override;
  bool is_gather() const noexcept override { return !work_.kernel; }
  // This kernel followed by `next` on its `count` elements; nullptr if `next` is not element-wise.
  std::shared_ptr<const Kernel> then(FusedPart next, size_t count) const;

 private:
  GatherKernel(Runs runs, FusedPart work);
  Counters run_each(std::span<const std::byte> in, std::span<std::byte> out) const noexcept;
  Counters run_blocks(std::span<const std::byte> in, std::span<std::byte> out) const noexcept;
  // The run at `offset`; empty if it is not completely in `in`.
  std::span<const std::byte> run_at(uint64_t offset, std::span<const std::byte> in) const noexcept;

  Runs runs_;
  FusedPart work_{};  // no kernel: the elements are copied
};

}  // namespace weir::transform
