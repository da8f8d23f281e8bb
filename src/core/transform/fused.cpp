// Runs two kernels on one block of elements at a time.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/transform/fused.hpp"

#include <algorithm>
#include <numeric>

#include "core/transform/gather.hpp"

namespace weir::transform {
namespace {

constexpr size_t kBlock = 2048;  // elements: 16 KiB of the widest type

class FusedKernel final : public Kernel {
 public:
  FusedKernel(FusedPart first, FusedPart second, size_t count, size_t period)
      : first_(std::move(first)),
        second_(std::move(second)),
        count_(count),
        period_(period),
        block_(kBlock / period * period) {}

  Counters run(std::span<const std::byte> in, std::span<std::byte> out) const noexcept override {
    const size_t in_bytes = element_size(first_.from), between_bytes = element_size(first_.to),
                 out_bytes = element_size(second_.to);
    const size_t count = std::min({count_, in.size() / in_bytes, out.size() / out_bytes});
    alignas(64) std::byte between[kBlock * 8];
    Counters counters;
    for (size_t i = 0; i < count; i += block_) {
      const size_t length = std::min(block_, count - i);
      const std::span middle(between, length * between_bytes);
      const auto one = first_.kernel->run(in.subspan(i * in_bytes, length * in_bytes), middle);
      const auto two = second_.kernel->run(middle, out.subspan(i * out_bytes, length * out_bytes));
      counters.divisions_by_zero += one.divisions_by_zero + two.divisions_by_zero;
    }
    return counters;
  }
  bool in_place_possible() const noexcept override {
    return element_size(first_.from) == element_size(second_.to);
  }
  size_t period() const noexcept override { return period_; }

 private:
  FusedPart first_, second_;
  size_t count_, period_, block_;
};

}  // namespace

std::shared_ptr<const Kernel> make_fused_kernel(FusedPart first, FusedPart second, size_t count) {
  if (const auto* gather = dynamic_cast<const GatherKernel*>(first.kernel.get()))
    return gather->then(std::move(second), count);
  if (auto one = first.kernel->followed_by(*second.kernel)) return one;
  const size_t one = first.kernel->period(), two = second.kernel->period();
  if (one == 0 || two == 0 || one > kBlock || two > kBlock) return nullptr;
  const size_t period = std::lcm(one, two);
  if (period > kBlock) return nullptr;
  return std::make_shared<FusedKernel>(std::move(first), std::move(second), count, period);
}

}  // namespace weir::transform
