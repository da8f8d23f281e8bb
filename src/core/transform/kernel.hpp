// Kernel: the work that a TransformPlan runs; one subclass per kind of work.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <span>

#include "core/transform/transform.hpp"

namespace weir::transform {

class Kernel {
 public:
  Kernel() = default;
  Kernel(const Kernel&) = delete;
  Kernel& operator=(const Kernel&) = delete;
  virtual ~Kernel() = default;

  // Never accesses memory beyond the spans. May be called from several threads at once.
  virtual Counters run(std::span<const std::byte> in, std::span<std::byte> out) const noexcept = 0;
  virtual bool in_place_possible() const noexcept { return false; }
  virtual bool is_copy() const noexcept { return false; }
  virtual bool is_gather() const noexcept { return false; }
  // The number of elements after which an element-wise kernel repeats; 0: the kernel is not
  // element-wise.
  virtual size_t period() const noexcept { return 0; }
  // One kernel of the same kind that does this and then `second`; nullptr if there is none.
  virtual std::shared_ptr<const Kernel> followed_by(const Kernel&) const { return nullptr; }
};

// Copies the bytes unchanged.
class CopyKernel final : public Kernel {
 public:
  explicit CopyKernel(size_t bytes, size_t element_bytes) noexcept
      : bytes_(bytes), element_bytes_(element_bytes) {}
  Counters run(std::span<const std::byte> in, std::span<std::byte> out) const noexcept override;
  bool in_place_possible() const noexcept override { return true; }
  bool is_copy() const noexcept override { return true; }
  size_t period() const noexcept override { return 1; }

 private:
  size_t bytes_, element_bytes_;
};

}  // namespace weir::transform
